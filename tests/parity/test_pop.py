from __future__ import annotations

from math import inf, nan, pi
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
from tests.parity.laws import POP
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


@pytest.mark.covers("Pop", "Pop.step", "Pop.steer", "Pop.state", "Pop.reset")
@pytest.mark.parametrize("drive", CASES.values(), ids=CASES)
@pytest.mark.parametrize(
    ("params", "vehicle"),
    [
        ({}, {}),
        ({"candidate_count": 5, "steer_span": 0.3}, {"rear_axle": -1.94}),
        ({}, {"dead_time": 0.2, "wheelbase": 2.7, "max_steer_rate": 0.4}),
    ],
    ids=str,
)
def test_pop_matches_reference_cases(
    drive: Rollout, params: dict[str, Any], vehicle: dict[str, Any]
) -> None:
    check_rollout(POP, drive, params, most=5000, vehicle=vehicle)


@pytest.mark.covers("PopParams", "PopState", "Pop.step", "Pop.steer", "Pop.state")
def test_pop_matches_reference_edges() -> None:
    check_params(POP)
    check_bad_steps(POP)
    check_zeros(POP)
    check_bad_states(
        POP,
        good={"previous_steer": 0.5},
        bad=[{"previous_steer": value} for value in (nan, inf, -inf, 1.2200000000000002, -1.3)],
    )


@pytest.mark.covers(
    *("Pop.params", "Pop.path", "Pop.vehicle", "Pop.vehicle_given"),
    *("Pop.adapt", "Pop.estimate", "Pop.tracked_point", "Pop.monitor", "Command.steer"),
)
@given(
    shape=shapes(),
    params=POP.params(),
    vehicle=st.none() | VEHICLES,
    adapt=ADAPTS,
    spots=st.lists(SPOTS, min_size=1, max_size=6),
)
# Wheels that steer a wheelbase of 1 mm for 10 s at 10,000 m/s: no digit is left.
@example(
    shape=Shape(count=2),
    params={},
    vehicle={"turning_wheelbase": 0.001, "dead_time": 10.0, "steer_offset": 0.03125},
    adapt="auto",
    spots=[Spot(speed=1.0, dt=0.125), Spot(turned=pi, speed=-1e4, dt=0.125)],
)
def test_pop_matches_reference_random(
    shape: Shape,
    params: dict[str, Any],
    vehicle: dict[str, Any] | None,
    adapt: Any,
    spots: list[Spot],
) -> None:
    check_random(POP, shape, params, spots, vehicle, adapt)


@pytest.mark.covers("Pop.step", "Pop.steer", "Pop.state", "Pop.reset")
@long_drives()
@given(drive=drives(), params=POP.params(), vehicle=CALM_VEHICLES, adapt=ADAPTS)
def test_pop_matches_reference_rollout(
    drive: Rollout, params: dict[str, Any], vehicle: dict[str, Any], adapt: Any
) -> None:
    check_rollout(POP, drive, params, vehicle=vehicle, adapt=adapt)
