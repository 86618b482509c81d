"""Drives with planted faults, and healthy ones of vehicles that are not as told.

The vehicles, their sensors and their faults are those of `studies.driver`, whose bicycle is not
popsteer's.
"""

from __future__ import annotations

import numpy as np
import pytest

from studies.driver import FAULTS, drive


def test_worn_vehicles_drive_to_their_end_without_a_fault() -> None:
    for k in range(60):
        outcome = drive(np.random.default_rng([9, k]), None, worn=True)
        assert outcome.fault is None, k
        assert outcome.stands, k


@pytest.mark.parametrize("worn", [False, True])
@pytest.mark.parametrize("planted", FAULTS)
def test_a_planted_fault_is_said_and_named(planted: str, *, worn: bool) -> None:
    outcomes = [drive(np.random.default_rng([7, k]), planted, worn=worn) for k in range(8)]
    for k, outcome in enumerate(outcomes):
        assert outcome.fault, k
        assert outcome.after >= 0.0, k
        assert outcome.stands, k
    named = sum(outcome.fault in FAULTS[planted] for outcome in outcomes)
    assert named >= 7
    if planted != "wheels stick":
        # Sticking wheels show once they should turn.
        soon = [each.after <= 1.0 or each.said_off <= 0.5 for each in outcomes]
        least = 7 if planted == "heading reads 0.3 rad more" else 8
        assert sum(soon) >= (5 if worn else least)
