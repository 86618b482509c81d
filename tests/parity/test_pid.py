from __future__ import annotations

from math import inf, nan
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from tests.helpers import long_drives
from tests.parity.checks import (
    Rollout,
    check_bad_states,
    check_bad_steps,
    check_params,
    check_random,
    check_rollout,
    check_zeros,
)
from tests.parity.laws import PID
from tests.parity.scenes import CASES, drives
from tests.parity.strategies import (
    ADAPTS,
    CALM_VEHICLES,
    SPOTS,
    VEHICLES,
    Shape,
    Spot,
    shapes,
)


@pytest.mark.covers("Pid", "Pid.step", "Pid.steer", "Pid.state", "Pid.reset")
@pytest.mark.parametrize("drive", CASES.values(), ids=CASES)
@pytest.mark.parametrize(
    ("params", "vehicle"),
    [
        ({}, {}),
        ({"smoothing_length": 0.0}, {}),
        ({"buffer_length": 7, "integral_with_dt": False}, {"max_steer": 0.5, "dead_time": 0.1}),
    ],
    ids=str,
)
def test_pid_matches_reference_cases(
    drive: Rollout, params: dict[str, Any], vehicle: dict[str, Any]
) -> None:
    check_rollout(PID, drive, params, most=5000, vehicle=vehicle)


@pytest.mark.covers("PidParams", "PidState", "Pid.step", "Pid.steer", "Pid.state")
def test_pid_matches_reference_edges() -> None:
    check_params(PID)
    check_bad_steps(PID)
    check_zeros(PID)
    check_bad_states(
        PID,
        good={
            "previous_error": 0.5,
            "previous_position": (1.0, -2.0),
            "terms": (0.1, 0.2),
            "next": 2,
            "sum": 0.3,
        },
        bad=[
            *({"previous_error": value} for value in (nan, inf, -inf, 1.0000000000000002e16)),
            *({"previous_position": (0.0, value)} for value in (nan, inf, -inf, 4.000000001e9)),
            *({"sum": value} for value in (nan, inf, -inf, -1.0000000000000002e16)),
            *({"terms": (value, 1.0)} for value in (nan, inf, -inf, 1.0000000000000002e16)),
            *({"next": value} for value in (0, 1, 3, 500, 501)),
            *({"terms": (0.0,) * 500, "next": value} for value in (500, 501)),
            *({"terms": (0.0,) * count, "next": 0} for count in (501, 1001)),
            # The first in the order of the check is the one named.
            {"waypoint": 99, "previous_error": nan, "terms": (nan,), "next": 9, "sum": nan},
            {"waypoint": 99, "previous_error": nan, "terms": (nan,), "next": 1, "sum": nan},
            {"waypoint": 99, "previous_error": nan, "sum": nan},
            {"waypoint": 99, "previous_error": nan},
        ],
    )


@pytest.mark.covers(
    *("Pid.params", "Pid.path", "Pid.vehicle", "Pid.vehicle_given"),
    *("Pid.adapt", "Pid.estimate", "Pid.tracked_point", "Pid.monitor", "Command.steer"),
)
@given(
    shape=shapes(),
    params=PID.params(),
    vehicle=st.none() | VEHICLES,
    adapt=ADAPTS,
    spots=st.lists(SPOTS, min_size=1, max_size=6),
)
# Near a right angle the wheels' tangent turns the rounding of the learnt gain into 5e-8 m.
@example(
    shape=Shape(count=2),
    params={},
    vehicle={"wheelbase": 1.0, "rear_axle": 0.0, "max_steer": 1.57, "dead_time": 0.0625},
    adapt="auto",
    spots=[Spot(turned=turned, speed=1.0, dt=0.125) for turned in (0.0, 0.5, 0.0)],
)
def test_pid_matches_reference_random(
    shape: Shape,
    params: dict[str, Any],
    vehicle: dict[str, Any] | None,
    adapt: Any,
    spots: list[Spot],
) -> None:
    check_random(PID, shape, params, spots, vehicle, adapt)


@pytest.mark.covers("Pid.step", "Pid.steer", "Pid.state", "Pid.reset")
@long_drives()
@given(drive=drives(), params=PID.params(), vehicle=CALM_VEHICLES, adapt=ADAPTS)
def test_pid_matches_reference_rollout(
    drive: Rollout, params: dict[str, Any], vehicle: dict[str, Any], adapt: Any
) -> None:
    check_rollout(PID, drive, params, vehicle=vehicle, adapt=adapt)
