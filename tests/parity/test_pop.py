from __future__ import annotations

from math import inf, nan
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
from tests.parity.laws import POP
from tests.parity.scenes import CASES, drives
from tests.parity.strategies import SPOTS, Shape, Spot, shapes


@pytest.mark.covers("Pop", "Pop.step", "Pop.steer", "Pop.state", "Pop.reset")
@pytest.mark.parametrize("drive", CASES.values(), ids=CASES)
@pytest.mark.parametrize(
    "params", [{}, {"candidate_count": 5, "steer_span": 0.3}, {"reference_offset": 1.06}], ids=str
)
def test_pop_matches_reference_cases(drive: Drive, params: dict[str, Any]) -> None:
    check_rollout(POP, drive, params, most=5000)


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


@pytest.mark.covers("Pop.params", "Pop.path", "Pop.reference_offset", "Command.steer")
@given(shape=shapes(), params=POP.params(), spots=st.lists(SPOTS, min_size=1, max_size=6))
def test_pop_matches_reference_random(
    shape: Shape, params: dict[str, Any], spots: list[Spot]
) -> None:
    check_random(POP, shape, params, spots)


@pytest.mark.covers("Pop.step", "Pop.steer", "Pop.state", "Pop.reset")
@given(drive=drives(), params=POP.params())
def test_pop_matches_reference_rollout(drive: Drive, params: dict[str, Any]) -> None:
    check_rollout(POP, drive, params)
