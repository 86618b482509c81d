"""Dead time, and the prediction through it: what its tables in docs/edges.md promise."""

from __future__ import annotations

import pytest

from popsteer import AdaptParams, Vehicle, presets, sim, vehicles
from popsteer.sim import Noise, Settings
from studies import dead_time
from studies.dead_time import NAMES, RUNS, DeadTimeRow, dead_time_lines, dead_time_rows
from studies.layout import table
from studies.theory import Given
from tests.closed_loop.paths import track
from tests.helpers import authors_data

Rows = dict[str, DeadTimeRow]


@pytest.fixture(scope="module", params=["racetrack", "authors"])
def rows(request: pytest.FixtureRequest) -> tuple[str, Rows]:
    if request.param == "authors":
        authors_data()
    return request.param, {row.law: row for row in dead_time_rows(request.param)}


@pytest.mark.parametrize("law", NAMES)
def test_dead_time_predicted_costs_at_most_a_twentieth(rows: tuple[str, Rows], law: str) -> None:
    row = rows[1][law]
    assert row.prompt.finished
    assert row.ratio(row.predicted) <= 1.05


@pytest.mark.parametrize("law", NAMES)
@pytest.mark.parametrize("model", ["short", "long", "early", "later"])
def test_dead_time_predicted_of_a_wrong_vehicle_costs_at_most_a_quarter(
    rows: tuple[str, Rows], law: str, model: str
) -> None:
    row = rows[1][law]
    assert row.ratio(getattr(row, model)) <= 1.25


@pytest.mark.parametrize("law", NAMES)
def test_dead_time_with_nothing_done_costs_more(rows: tuple[str, Rows], law: str) -> None:
    row = rows[1][law]
    # With no limit of the lateral acceleration POP never comes back.
    assert row.late.finished is (law != "pop")
    if law == "preview-pop":  # it finds the dead time by itself
        assert row.ratio(row.late) <= 1.1
    else:
        assert row.ratio(row.late) > max(1.02, row.ratio(row.predicted))


def test_page_table_of_dead_times_is_what_is_driven(rows: tuple[str, Rows]) -> None:
    name, found = rows
    assert table("edges.md", f"dead time, {name}") == dead_time_lines(found.values())


def test_dead_time_without_adapting_costs_more_where_the_vehicle_is_wrong() -> None:
    adapting = {row.law: row for row in dead_time.run(track("racetrack"), ["preview-pop"])}
    for row in dead_time.run(track("racetrack"), adapt=None):
        assert row.ratio(row.predicted) <= 1.1
        if row.law == "preview-pop":
            worst = max(row.ratio(getattr(row, model)) for model in RUNS[2:])
            assert worst > 1.25
            assert row.ratio(row.short) > 1.1 * adapting[row.law].ratio(adapting[row.law].short)


@pytest.mark.parametrize("preset", ["default", "paper"])
def test_dead_time_with_other_presets_costs_as_little(preset: str) -> None:
    for row in dead_time.run(track("racetrack"), ["pop", "stanley", "pid"], preset=preset):
        assert row.ratio(row.predicted) <= 1.05
        assert max(row.ratio(getattr(row, model)) for model in RUNS[2:]) <= 1.25


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
    assert row.ratio(row.predicted) <= 1.1
    assert row.ratio(row.late) <= 1.1  # also where nobody tells it
