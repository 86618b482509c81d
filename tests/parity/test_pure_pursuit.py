from __future__ import annotations

from math import inf, nan
from typing import Any

import pytest
from hypothesis import given
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
from tests.parity.laws import PURE_PURSUIT
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


@pytest.mark.covers(
    "PurePursuit", "PurePursuit.step", "PurePursuit.steer", "PurePursuit.state", "PurePursuit.reset"
)
@pytest.mark.parametrize("drive", CASES.values(), ids=CASES)
@pytest.mark.parametrize(
    ("params", "vehicle"),
    [
        ({}, {}),
        ({"alpha_by_arccos": True}, {"dead_time": 0.15}),
        ({"min_lookahead": 0.0}, {"rear_axle": -1.94}),
    ],
    ids=str,
)
def test_pure_pursuit_matches_reference_cases(
    drive: Rollout, params: dict[str, Any], vehicle: dict[str, Any]
) -> None:
    check_rollout(PURE_PURSUIT, drive, params, most=5000, vehicle=vehicle)


@pytest.mark.covers(
    "PurePursuitParams",
    "PurePursuitState",
    "PurePursuit.step",
    "PurePursuit.steer",
    "PurePursuit.state",
)
def test_pure_pursuit_matches_reference_edges() -> None:
    check_params(PURE_PURSUIT)
    check_bad_steps(PURE_PURSUIT)
    check_zeros(PURE_PURSUIT)
    check_bad_states(
        PURE_PURSUIT,
        good={"previous_alpha": 0.5},
        bad=[{"previous_alpha": value} for value in (nan, inf, -inf, 3.1415926535897936, -4.0)],
    )


@pytest.mark.covers(
    *("PurePursuit.params", "PurePursuit.path", "PurePursuit.vehicle", "PurePursuit.vehicle_given"),
    *(
        "PurePursuit.adapt",
        "PurePursuit.estimate",
        "PurePursuit.tracked_point",
        "PurePursuit.monitor",
        "Command.steer",
    ),
)
@given(
    shape=shapes(),
    params=PURE_PURSUIT.params(),
    vehicle=st.none() | VEHICLES,
    adapt=ADAPTS,
    spots=st.lists(SPOTS, min_size=1, max_size=6),
)
def test_pure_pursuit_matches_reference_random(
    shape: Shape,
    params: dict[str, Any],
    vehicle: dict[str, Any] | None,
    adapt: Any,
    spots: list[Spot],
) -> None:
    check_random(PURE_PURSUIT, shape, params, spots, vehicle, adapt)


@pytest.mark.covers(
    "PurePursuit.step", "PurePursuit.steer", "PurePursuit.state", "PurePursuit.reset"
)
@long_drives()
@given(drive=drives(), params=PURE_PURSUIT.params(), vehicle=CALM_VEHICLES, adapt=ADAPTS)
def test_pure_pursuit_matches_reference_rollout(
    drive: Rollout, params: dict[str, Any], vehicle: dict[str, Any], adapt: Any
) -> None:
    check_rollout(PURE_PURSUIT, drive, params, vehicle=vehicle, adapt=adapt)
