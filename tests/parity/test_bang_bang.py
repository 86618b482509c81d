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
from tests.parity.laws import BANG_BANG
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
    "BangBang", "BangBang.step", "BangBang.steer", "BangBang.state", "BangBang.reset"
)
@pytest.mark.parametrize("drive", CASES.values(), ids=CASES)
@pytest.mark.parametrize(
    ("params", "vehicle"),
    [({}, {}), ({"deadband": 0.2, "amplitude": 1.5}, {"dead_time": 0.2, "max_steer_rate": 0.5})],
    ids=str,
)
def test_bang_bang_matches_reference_cases(
    drive: Rollout, params: dict[str, Any], vehicle: dict[str, Any]
) -> None:
    check_rollout(BANG_BANG, drive, params, most=5000, vehicle=vehicle)


@pytest.mark.covers(
    "BangBangParams", "BangBangState", "BangBang.step", "BangBang.steer", "BangBang.state"
)
def test_bang_bang_matches_reference_edges() -> None:
    check_params(BANG_BANG)
    check_bad_steps(BANG_BANG)
    check_zeros(BANG_BANG)
    check_bad_states(BANG_BANG, good={}, bad=[])


@pytest.mark.covers(
    *("BangBang.params", "BangBang.path", "BangBang.vehicle", "BangBang.vehicle_given"),
    *(
        "BangBang.adapt",
        "BangBang.estimate",
        "BangBang.tracked_point",
        "BangBang.monitor",
        "Command.steer",
    ),
)
@given(
    shape=shapes(),
    params=BANG_BANG.params(),
    vehicle=st.none() | VEHICLES,
    adapt=ADAPTS,
    spots=st.lists(SPOTS, min_size=1, max_size=6),
)
def test_bang_bang_matches_reference_random(
    shape: Shape,
    params: dict[str, Any],
    vehicle: dict[str, Any] | None,
    adapt: Any,
    spots: list[Spot],
) -> None:
    check_random(BANG_BANG, shape, params, spots, vehicle, adapt)


@pytest.mark.covers("BangBang.step", "BangBang.steer", "BangBang.state", "BangBang.reset")
@long_drives()
@given(drive=drives(), params=BANG_BANG.params(), vehicle=CALM_VEHICLES, adapt=ADAPTS)
def test_bang_bang_matches_reference_rollout(
    drive: Rollout, params: dict[str, Any], vehicle: dict[str, Any], adapt: Any
) -> None:
    check_rollout(BANG_BANG, drive, params, vehicle=vehicle, adapt=adapt)
