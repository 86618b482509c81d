"""The authors' track, start and vehicle, against what their own laws do there."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

import popsteer
from popsteer import lab
from tests.helpers import authors_data

if TYPE_CHECKING:
    from popsteer.lab.compare import Comparison

START = (-183.8, 78.7, -1.574)
# The authors' laws on the identified plant: mean absolute cross-track error [m], as the exact
# distance to the path, and heading error [rad].
EXPECTED = {
    "pop": (0.175, 0.0087),
    "stanley": (0.332, 0.0147),
    "pure-pursuit": (0.371, 0.0219),
}


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    path = popsteer.Path.from_csv(authors_data() / "waypoints.csv")
    return lab.compare.run(path, start=START, start_at="front")


def test_authors_start_is_that_of_the_front_axle(comparison: Comparison) -> None:
    """The first record says so; the figures would hardly notice a start that is 1 m off."""
    for run in comparison.runs.values():
        first = {name: column[0] for name, column in run.records.items()}
        assert (first["x"], first["y"], first["yaw"]) == run.start
        assert run.start == pytest.approx((-183.797, 79.760, -1.574), abs=5e-4)
    pop = comparison.runs["pop"].records
    assert (pop["reference_x"][0], pop["reference_y"][0]) == pytest.approx(START[:2], abs=1e-9)


def test_authors_path_from_their_file_is_recognised(comparison: Comparison) -> None:
    assert lab.compare.paper.is_authors_path(comparison.path)
    assert comparison.path.speed is not None
    assert comparison.path.speed[0] == 1.5


@pytest.mark.parametrize("law", EXPECTED)
def test_law_on_authors_track_tracks_as_closely_as_theirs(comparison: Comparison, law: str) -> None:
    metrics = comparison.runs[law].metrics
    cross_track, heading = EXPECTED[law]
    assert metrics.finished
    assert metrics.mean_abs_cross_track_error == pytest.approx(cross_track, rel=0.05)
    assert metrics.mean_abs_heading_error == pytest.approx(heading, rel=0.10)


@pytest.mark.parametrize("law", EXPECTED)
def test_law_on_authors_track_is_within_a_tenth_of_the_paper(
    comparison: Comparison, law: str
) -> None:
    metrics = comparison.runs[law].metrics
    assert metrics.mean_abs_cross_track_error == pytest.approx(
        lab.compare.paper.PAPER[law].mean_abs_cross_track_error, rel=0.05
    )
    assert metrics.mean_abs_heading_error == pytest.approx(
        lab.compare.paper.PAPER[law].mean_abs_heading_error, rel=0.10
    )


def test_pid_on_authors_track_is_not_the_papers_row(comparison: Comparison) -> None:
    pid = comparison.runs["pid"].metrics
    pop = comparison.runs["pop"].metrics
    assert pid.finished
    assert (
        pid.mean_abs_cross_track_error
        < 0.5 * lab.compare.paper.PAPER["pid"].mean_abs_cross_track_error
    )
    assert pid.mean_abs_cross_track_error == pytest.approx(pop.mean_abs_cross_track_error, rel=0.1)


def test_cross_track_error_of_recorded_positions_agrees_with_the_log() -> None:
    data = authors_data()
    path = popsteer.Path.from_csv(data / "waypoints.csv")
    # Row 0 of the trajectory is the pose before the shift to the reference point.
    positions = np.loadtxt(data / "trajectory.csv", delimiter=",")[1:, 1:3]
    logged = np.loadtxt(data / "tracking_error.csv", delimiter=",")[:, 0]
    assert len(positions) == len(logged)
    exact = np.array([path.project(x, y).cross_track_error for x, y in positions])
    difference = np.abs(np.abs(exact) - np.abs(logged))
    assert np.median(difference) <= 0.006
    assert np.abs(exact).mean() == pytest.approx(0.167, abs=0.001)
