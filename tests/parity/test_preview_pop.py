from __future__ import annotations

from math import inf, nan, nextafter, pi
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.parity.checks import (
    Drive,
    check_bad_states,
    check_bad_steps,
    check_params,
    check_random,
    check_rollout,
    check_zeros,
)
from tests.parity.laws import PREVIEW_POP
from tests.parity.scenes import CASES, drives
from tests.parity.strategies import SPOTS, Shape, Spot, shapes


@pytest.mark.covers(
    "PreviewPop", "PreviewPop.step", "PreviewPop.steer", "PreviewPop.state", "PreviewPop.reset"
)
@pytest.mark.parametrize("drive", CASES.values(), ids=CASES)
@pytest.mark.parametrize(
    "params",
    [
        {},
        {"turn_learning_time": 0.5, "slip_learning_time": 2.0, "steer_lag": 0.0},
        {"horizon": 2.0, "reference_offset": -1.94, "understeer": 0.002, "smoothing_length": 0.0},
    ],
    ids=str,
)
def test_preview_pop_matches_reference_cases(drive: Drive, params: dict[str, Any]) -> None:
    check_rollout(PREVIEW_POP, drive, params, most=5000)


@pytest.mark.covers(
    "PreviewPopParams",
    "PreviewPopState",
    "PreviewPop.step",
    "PreviewPop.steer",
    "PreviewPop.state",
)
def test_preview_pop_matches_reference_edges() -> None:
    check_params(PREVIEW_POP)
    check_bad_steps(PREVIEW_POP)
    check_zeros(PREVIEW_POP)
    fields = {
        "previous_steer": 1.22,
        "curvature": 1e7,
        "previous_x": 1e9,
        "previous_y": 1e9,
        "previous_yaw": 1e6 + pi,
        "turn": 1e15,
        "turn_offset": 0.05,
        "slip": 0.15,
        "slip_length": 3.0,
        "travel": 1e7,
    }
    bad = [
        {field: value}
        for field, bound in fields.items()
        for value in (nan, inf, -inf, nextafter(bound, inf), -nextafter(bound, inf))
    ]
    good = {"previous_steer": 0.5, "curvature": 0.01, "travel": 0.4, "turn": 0.01, "slip": -0.1}
    check_bad_states(PREVIEW_POP, good=good, bad=[*bad, {"travel": -1e-9}])


@pytest.mark.covers(
    "PreviewPop.params", "PreviewPop.path", "PreviewPop.reference_offset", "Command.steer"
)
@given(shape=shapes(), params=PREVIEW_POP.params(), spots=st.lists(SPOTS, min_size=1, max_size=6))
def test_preview_pop_matches_reference_random(
    shape: Shape, params: dict[str, Any], spots: list[Spot]
) -> None:
    check_random(PREVIEW_POP, shape, params, spots)


@pytest.mark.covers("PreviewPop.step", "PreviewPop.steer", "PreviewPop.state", "PreviewPop.reset")
@given(drive=drives(), params=PREVIEW_POP.params())
def test_preview_pop_matches_reference_rollout(drive: Drive, params: dict[str, Any]) -> None:
    check_rollout(PREVIEW_POP, drive, params)
