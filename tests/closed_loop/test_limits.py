"""Preview POP behind wheels that turn slowly: what docs/preview_pop.md shows."""

from __future__ import annotations

import math

import pytest

from popsteer import AdaptParams, Vehicle, presets, sim, vehicles
from popsteer.sim import Noise, Settings
from studies import dead_time
from studies.dead_time import NAMES, RUNS, DeadTimeRow, dead_time_lines, dead_time_rows
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
from studies.theory import Given
from tests.closed_loop.paths import track
from tests.helpers import authors_data

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
    # The optimum is a quadratic program, solved only where its bound does not do.
    overshoot = join(case).overshoot
    assert overshoot <= max(0.1 * case.offset, 0.05) or overshoot <= allowed(case)


# At high speed the lateral acceleration bounds the way back: from 3 m beside, and turned away.
@pytest.mark.parametrize(("wheelbase", "speed"), [(2.7, 20.0), (2.7, 25.0), (6.0, 15.0)])
@pytest.mark.parametrize("rate", [0.2, 1.0])
def test_straight_is_joined_without_overshoot_where_the_lateral_acceleration_binds(
    wheelbase: float, speed: float, rate: float
) -> None:
    for heading in (0.0, 10.0, 20.0):
        case = Straight(rate, speed, 3.0, heading, wheelbase, 0.2)
        assert join(case).overshoot <= 0.05


Rows = dict[str, DeadTimeRow]


@pytest.fixture(scope="module", params=["racetrack", "authors"])
def rows(request: pytest.FixtureRequest) -> tuple[str, Rows]:
    if request.param == "authors":
        authors_data()
    return request.param, {row.law: row for row in dead_time_rows(request.param)}


@pytest.mark.parametrize("law", NAMES)
def test_dead_time_predicted_costs_at_most_a_twentieth(rows: tuple[str, Rows], law: str) -> None:
    row = rows[1][law]
    assert row.runs["prompt"].finished
    assert row.ratio("predicted") <= 1.05


@pytest.mark.parametrize("law", NAMES)
@pytest.mark.parametrize("model", ["short", "long", "early", "later"])
def test_dead_time_predicted_of_a_wrong_vehicle_costs_at_most_a_quarter(
    rows: tuple[str, Rows], law: str, model: str
) -> None:
    row = rows[1][law]
    assert row.ratio(model) <= 1.25


@pytest.mark.parametrize("law", NAMES)
def test_dead_time_with_nothing_done_costs_more(rows: tuple[str, Rows], law: str) -> None:
    row = rows[1][law]
    # With no limit of the lateral acceleration POP never comes back.
    assert row.runs["late"].finished is (law != "pop")
    if law == "preview-pop":  # it finds the dead time by itself
        assert row.ratio("late") <= 1.1
    else:
        assert row.ratio("late") > max(1.02, row.ratio("predicted"))


def test_page_table_of_dead_times_is_what_is_driven(rows: tuple[str, Rows]) -> None:
    name, found = rows
    assert table("edges.md", f"dead time, {name}") == dead_time_lines(found.values())


def test_dead_time_without_adapting_costs_more_where_the_vehicle_is_wrong() -> None:
    adapting = {row.law: row for row in dead_time.run(track("racetrack"), ["preview-pop"])}
    for row in dead_time.run(track("racetrack"), adapt=None):
        assert row.ratio("predicted") <= 1.1
        if row.law == "preview-pop":
            worst = max(row.ratio(model) for model in RUNS[2:])
            assert worst > 1.25
            assert row.ratio("short") > 1.1 * adapting[row.law].ratio("short")


@pytest.mark.parametrize("preset", ["default", "paper"])
def test_dead_time_with_other_presets_costs_as_little(preset: str) -> None:
    for row in dead_time.run(track("racetrack"), ["pop", "stanley", "pid"], preset=preset):
        assert row.ratio("predicted") <= 1.05
        assert max(row.ratio(model) for model in RUNS[2:]) <= 1.25


@pytest.mark.parametrize("name", ["pop", "stanley", "preview-pop"])
def test_adapting_in_noise_costs_little(name: str) -> None:
    """What is estimated from a noisy pose is no worse than what is not."""
    path = track("racetrack")
    car = vehicles.get("carla-identified").replace(dead_time=0.2)
    errors = []
    for adapt in (AdaptParams(turn_time=0.0), AdaptParams()):
        given = Given(name, presets.get(name, "default"), car, adapt)
        done = sim.run(
            given.on(path),
            sim.CarlaIdentified(car),
            noise=Noise(position=0.1, yaw=0.005, speed=0.05),
            seed=7,
            settings=Settings(keep_records=False),
        )
        errors.append(done.metrics.mean_abs_cross_track_error)
    assert errors[1] <= 1.03 * errors[0]


def test_dead_time_of_another_plant_is_added_to_its_own_vehicle() -> None:
    car = Vehicle(rear_axle=-1.35, steer_lag=0.15, dead_time=0.3, max_lateral_acceleration=None)
    (row,) = dead_time.run(
        track("slalom"), ["preview-pop"], plant=sim.KinematicBicycle(car), dead_time=0.15
    )
    assert row.ratio("predicted") <= 1.1
    assert row.ratio("late") <= 1.1  # also where nobody tells it
