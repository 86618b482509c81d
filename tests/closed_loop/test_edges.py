"""Pathological paths: what the table in docs/edges.md promises; and the last metres of a path."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest

import popsteer
from popsteer import InputError, Status, sim, vehicles
from popsteer.errors import PathError
from popsteer.sim import Simulation
from studies import edges
from studies.edges import (
    CUT,
    NAMES,
    PLANT,
    TOP_SPEED,
    TURNING_SPEED,
    EdgeRun,
    angles_by_arc,
    controller,
    edge_controller,
    edge_lines,
    edge_tracks,
    end_lines,
    shortened,
)
from studies.layout import course, table
from tests.helpers import authors_data

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from popsteer.sim import Pose

Runs = dict[tuple[str, str], EdgeRun]

TRACKS = {track.name: track for track in edge_tracks()}
# A PID on the cross-track error alone does not see which way the vehicle looks.
UNFINISHED = {("out-and-back", "pid"), ("start-180-deg-off", "pid")}
SMOOTH = ("figure-eight", "spiral", "touching", "duplicates", "near-duplicates", "spacing-0.01")
CUSPS = ("three-point-turn", "parallel-parking")
# Largest error of the rear axle [m] and largest jump [deg] on the smooth tracks and at cusps.
ERROR = {
    "pop": (1.8, 1.5),
    "pure-pursuit": (0.12, 0.3),
    "stanley": (0.6, 0.8),
    "pid": (1.0, 1.4),
    "preview-pop": (0.05, 0.4),
}
JUMP = {
    "pop": (3.0, 3.0),
    "pure-pursuit": (1.1, 51.0),
    "stanley": (6.0, 45.0),
    "pid": (1.0, 34.0),
    "preview-pop": (2.0, 3.0),
}


@pytest.fixture(scope="module")
def runs() -> Runs:
    return {(run.track, run.law): run for run in edges.run()}


def test_edges_all_laws_on_all_tracks_finish(runs: Runs) -> None:
    assert runs.keys() == {(track, law) for track in TRACKS for law in NAMES}
    unfinished = {where for where, run in runs.items() if not run.finished}
    assert unfinished == UNFINISHED
    assert not {law for _, law in unfinished} & {"pop", "pure-pursuit", "stanley"}


def test_edges_no_law_leaves_out_a_part_of_the_path(runs: Runs) -> None:
    for (name, _), run in runs.items():
        top = TURNING_SPEED if name == "out-and-back" else TOP_SPEED
        # Less the bends that are cut, and where the run starts and stops.
        assert run.time > 0.8 * (TRACKS[name].path.length - 10.0) / top


@pytest.mark.parametrize("law", NAMES)
def test_edges_errors_and_jumps_keep_within_their_bounds(runs: Runs, law: str) -> None:
    for place, tracks in enumerate((SMOOTH, CUSPS)):
        for track in tracks:
            run = runs[track, law]
            assert run.max_error <= ERROR[law][place], track
            assert math.degrees(run.max_jump) <= JUMP[law][place] + 1e-9, track


@pytest.mark.parametrize("law", NAMES)
def test_edges_the_rear_axle_turns_round_at_the_cusp(law: str) -> None:
    track = TRACKS["parallel-parking"]
    controller = edge_controller(law, track.path, PLANT.vehicle)
    pedals = popsteer.SpeedPid(popsteer.SpeedPidParams(kp=1.0, ki=0.5))
    done = sim.run(controller, PLANT, start=track.start, start_at="rear", longitudinal=pedals)
    assert done.metrics.finished
    # Forward along x to the first cusp at 10 m; from there on backwards, to the slot.
    x, speed = done.records["x"], done.records["speed"]
    assert 9.8 < x.max() < 10.1
    backwards = np.flatnonzero(speed < -0.01)
    assert backwards[0] <= x.argmax() + 10
    assert np.all(speed[backwards[0] : backwards[-1]] < 0.01)


@pytest.mark.parametrize("law", ["pop", "preview-pop"])
def test_edges_laws_with_a_neighbourhood_never_jump(runs: Runs, law: str) -> None:
    assert max(math.degrees(runs[track, law].max_jump) for track in TRACKS) <= 3.0 + 1e-9


@pytest.mark.parametrize("law", NAMES)
def test_edges_duplicates_that_are_dropped_change_nothing(runs: Runs, law: str) -> None:
    dropped, single = runs["duplicates", law], runs["touching", law]
    assert dropped.time == single.time
    assert dropped.max_error == pytest.approx(single.max_error, abs=1e-9)


@pytest.mark.parametrize("law", NAMES)
def test_edges_statuses_are_of_all_steps_and_none_is_a_fault(runs: Runs, law: str) -> None:
    for track in TRACKS:
        run = runs[track, law]
        assert run.steps == round(run.time / 0.05)
        assert sum(run.statuses.values()) >= run.steps
        assert all(0 < count <= run.steps for count in run.statuses.values())
        assert list(run.statuses.values()) == sorted(run.statuses.values(), reverse=True)
        assert not run.statuses.keys() & {Status.OFF_PATH, Status.INPUT_HELD, Status.INPUT_LOST}


def test_edges_conditions_that_hold_side_by_side_are_counted_each(runs: Runs) -> None:
    # Where it turns round POP sees no point at its lookahead, and steers as far as it can.
    run = runs["out-and-back", "pop"]
    assert run.statuses[Status.SATURATED] + run.statuses[Status.LOOKAHEAD_LOST] > 0.3 * run.steps
    assert sum(run.statuses.values()) > 1.1 * run.steps


def test_edges_of_another_car_are_those_of_its_plant() -> None:
    track = TRACKS["parallel-parking"]
    car = vehicles.get("kinematic-bicycle").replace(max_steer=0.6, steer_lag=0.15)
    (given,) = edges.run(["preview-pop"], [track], plant=sim.KinematicBicycle(car))
    (misled,) = edges.run(
        ["preview-pop"],
        [track],
        plant=sim.KinematicBicycle(car),
        vehicle=car.replace(steer_lag=0.0),
    )
    assert given.finished
    assert given.max_error != misled.max_error
    with pytest.raises(PathError, match="carla-identified does not reverse"):
        edges.run(["preview-pop"], [track], plant="carla-identified")


def test_page_table_of_edges_is_what_is_driven(runs: Runs) -> None:
    assert table("edges.md", "edges") == edge_lines(runs.values())


def test_simulation_told_to_reverse_a_plant_that_does_not_refuses() -> None:
    path = popsteer.Path([(0.0, 0.0), (50.0, 0.0)])
    simulation = Simulation(path, start=(3.0, 0.0, 0.0))
    said = "reverse must be False, as carla-identified does not reverse, got True"
    with pytest.raises(InputError, match=said):
        simulation.step(0.0, 0.5, reverse=True)
    assert simulation.time == 0.0
    backwards = Simulation(path, "kinematic-bicycle", start=(3.0, 0.0, 0.0))
    backwards.step(0.0, 0.5, reverse=True)
    assert backwards.state[3] < 0.0


LAWS = ("pop", "pure-pursuit", "stanley", "pid", "preview-pop")


def courses(name: str) -> tuple[popsteer.Path, Pose | None]:
    if name == "authors":
        authors_data()
    return course(name)


def in_the_last_over_rms_before(
    arc: NDArray[np.float64], steer: NDArray[np.float64], end: float
) -> float:
    """Largest angle in the last 10 m before `end` [m] and beyond, over the rms before."""
    last = arc > end - 10.0
    assert last.sum() > 10
    return float(np.abs(steer[last]).max() / np.sqrt(np.mean(steer[~last] ** 2)))


@pytest.mark.parametrize("place", ["authors", "racetrack", "slalom", "double-lane-change"])
@pytest.mark.parametrize("name", LAWS)
def test_angle_in_the_last_10_m_keeps_within_twice_its_rms(name: str, place: str) -> None:
    path, start = courses(place)
    arc, steer = angles_by_arc(controller(name, path, "default"), path, start)
    assert in_the_last_over_rms_before(arc, steer, path.length) <= 2.0


@pytest.mark.parametrize("place", ["authors", "racetrack"])
@pytest.mark.parametrize("name", LAWS)
def test_angle_past_the_end_keeps_within_twice_its_rms(name: str, place: str) -> None:
    path, start = courses(place)
    arc, steer = angles_by_arc(shortened(name, path, "default"), path, start)
    assert arc[-1] > path.length - 0.5 * CUT
    assert in_the_last_over_rms_before(arc, steer, path.length - CUT) <= 2.0


def test_page_table_of_the_end_is_what_is_driven() -> None:
    assert table("edges.md", "end") == end_lines()


@pytest.mark.parametrize("place", ["authors", "racetrack"])
def test_angle_of_the_published_pure_pursuit_swings_at_the_end(place: str) -> None:
    """The search stops at the last waypoint; its bearing runs through 90° as that is passed."""
    path, start = courses(place)
    arc, steer = angles_by_arc(controller("pure-pursuit", path, "published-code"), path, start)
    assert in_the_last_over_rms_before(arc, steer, path.length) > 5.0
    assert np.degrees(np.abs(steer[arc > path.length - 10.0]).max()) == pytest.approx(22.0, abs=0.5)
