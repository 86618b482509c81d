"""Preview POP behind wheels that turn slowly: what docs/preview_pop.md shows."""

from __future__ import annotations

import math

import pytest

from studies.layout import table
from studies.limits import (
    SLALOMS,
    STRAIGHTS,
    Slalom,
    Straight,
    allowed,
    join,
    straight_lines,
    sweep,
)

MOST = {
    ("commonroad-mb-2", 0.4): 0.05,
    ("carla-identified", 0.4): 0.01,
    ("carla-identified", 0.2): 0.03,
    ("mujoco-car", 0.15): 0.015,
}
"""Mean error after 5 s [m], by plant and rate of its wheels."""


# The speeds between are the page's alone: the multi-body car takes seconds a lap.
@pytest.mark.parametrize(
    "case", [case for case in SLALOMS if case[:2] in MOST and case.speed % 1.0 == 0.0], ids=str
)
def test_slalom_behind_slow_wheels_is_kept(case: Slalom) -> None:
    found = case.drive("preview-pop")
    error = found.settled_mean_abs_cross_track_error
    assert error <= MOST[case.plant, case.rate]
    if case.plant == "commonroad-mb-2":
        assert math.degrees(found.rms_steer_rate) <= 6.5
        assert error <= 1.25 * case.drive("mpc").settled_mean_abs_cross_track_error


def test_page_table_of_straights_is_what_is_driven() -> None:
    assert table("preview_pop.md", "limits, straight") == straight_lines()


@pytest.mark.parametrize("case", STRAIGHTS, ids=str)
def test_straight_is_joined_within_a_tenth_of_the_offset(case: Straight) -> None:
    found = join(case)
    assert found.overshoot <= 0.1 * case.offset
    assert found.late <= 0.02


@pytest.mark.parametrize("wheelbase", [0.33, 2.7, 6.0])
@pytest.mark.parametrize("dead_time", [0.0, 0.2])
@pytest.mark.parametrize(("rate", "lag"), [(0.2, 0.3), (0.4, 0.15), (1.0, 0.05)])
@pytest.mark.parametrize("speed", [3.0, 8.0, 15.0])
def test_straight_is_joined_for_good_whatever_the_start(
    wheelbase: float, dead_time: float, rate: float, lag: float, speed: float
) -> None:
    for offset, heading in ((0.5, 20.0), (0.5, -20.0), (1.0, 10.0), (3.0, 0.0)):
        case = Straight(rate, speed, offset, heading, wheelbase, dead_time, lag)
        assert join(case).late <= 0.02


# Wheels that stand wide have to be back in time.
WIDE = Straight(1.0, 15.0, 0.5, 20.0, 0.33, 0.0, 0.3)


@pytest.mark.parametrize("case", [*list(sweep())[5::61], WIDE], ids=str)
def test_straight_is_joined_with_hardly_more_overshoot_than_the_optimum(case: Straight) -> None:
    assert join(case).overshoot <= allowed(case)


# At high speed the lateral acceleration bounds the way back: from 3 m beside, and turned away.
@pytest.mark.parametrize(("wheelbase", "speed"), [(2.7, 20.0), (2.7, 25.0), (6.0, 15.0)])
@pytest.mark.parametrize("rate", [0.2, 1.0])
def test_straight_is_joined_without_overshoot_where_the_lateral_acceleration_binds(
    wheelbase: float, speed: float, rate: float
) -> None:
    for heading in (0.0, 10.0, 20.0):
        case = Straight(rate, speed, 3.0, heading, wheelbase, 0.2)
        assert join(case).overshoot <= 0.05
