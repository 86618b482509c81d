from __future__ import annotations

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
from tests.parity.laws import STANLEY
from tests.parity.scenes import CASES, drives
from tests.parity.strategies import SPOTS, Shape, Spot, shapes


@pytest.mark.covers("Stanley", "Stanley.step", "Stanley.steer", "Stanley.state", "Stanley.reset")
@pytest.mark.parametrize("drive", CASES.values(), ids=CASES)
@pytest.mark.parametrize("params", [{}, {"heading_behind": True, "softening": 1.0}], ids=str)
def test_stanley_matches_reference_cases(drive: Drive, params: dict[str, Any]) -> None:
    check_rollout(STANLEY, drive, params, most=5000)


@pytest.mark.covers(
    "StanleyParams", "StanleyState", "Stanley.step", "Stanley.steer", "Stanley.state"
)
def test_stanley_matches_reference_edges() -> None:
    check_params(STANLEY)
    check_bad_steps(STANLEY)
    check_zeros(STANLEY)
    check_bad_states(STANLEY, good={}, bad=[])


@pytest.mark.covers("Stanley.params", "Stanley.path", "Stanley.reference_offset", "Command.steer")
@given(shape=shapes(), params=STANLEY.params(), spots=st.lists(SPOTS, min_size=1, max_size=6))
def test_stanley_matches_reference_random(
    shape: Shape, params: dict[str, Any], spots: list[Spot]
) -> None:
    check_random(STANLEY, shape, params, spots)


@pytest.mark.covers("Stanley.step", "Stanley.steer", "Stanley.state", "Stanley.reset")
@given(drive=drives(), params=STANLEY.params())
def test_stanley_matches_reference_rollout(drive: Drive, params: dict[str, Any]) -> None:
    check_rollout(STANLEY, drive, params)
