from __future__ import annotations

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
from tests.parity.laws import STANLEY
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


@pytest.mark.covers("Stanley", "Stanley.step", "Stanley.steer", "Stanley.state", "Stanley.reset")
@pytest.mark.parametrize("drive", CASES.values(), ids=CASES)
@pytest.mark.parametrize(
    ("params", "vehicle"),
    [
        ({}, {}),
        ({"smoothing_length": 0.0}, {}),
        ({"heading_behind": True, "softening": 1.0}, {"dead_time": 0.2, "steer_offset": -0.03}),
    ],
    ids=str,
)
def test_stanley_matches_reference_cases(
    drive: Rollout, params: dict[str, Any], vehicle: dict[str, Any]
) -> None:
    check_rollout(STANLEY, drive, params, most=5000, vehicle=vehicle)


@pytest.mark.covers(
    "StanleyParams", "StanleyState", "Stanley.step", "Stanley.steer", "Stanley.state"
)
def test_stanley_matches_reference_edges() -> None:
    check_params(STANLEY)
    check_bad_steps(STANLEY)
    check_zeros(STANLEY)
    check_bad_states(STANLEY, good={}, bad=[])


@pytest.mark.covers(
    *("Stanley.params", "Stanley.path", "Stanley.vehicle", "Stanley.vehicle_given"),
    *(
        "Stanley.adapt",
        "Stanley.estimate",
        "Stanley.tracked_point",
        "Stanley.monitor",
        "Command.steer",
    ),
)
@given(
    shape=shapes(),
    params=STANLEY.params(),
    vehicle=st.none() | VEHICLES,
    adapt=ADAPTS,
    spots=st.lists(SPOTS, min_size=1, max_size=6),
)
def test_stanley_matches_reference_random(
    shape: Shape,
    params: dict[str, Any],
    vehicle: dict[str, Any] | None,
    adapt: Any,
    spots: list[Spot],
) -> None:
    check_random(STANLEY, shape, params, spots, vehicle, adapt)


@pytest.mark.covers("Stanley.step", "Stanley.steer", "Stanley.state", "Stanley.reset")
@long_drives()
@given(drive=drives(), params=STANLEY.params(), vehicle=CALM_VEHICLES, adapt=ADAPTS)
def test_stanley_matches_reference_rollout(
    drive: Rollout, params: dict[str, Any], vehicle: dict[str, Any], adapt: Any
) -> None:
    check_rollout(STANLEY, drive, params, vehicle=vehicle, adapt=adapt)
