"""What README and the paper promise, and the presets."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import controllers, lab, presets, sim, vehicles
from popsteer.errors import ConfigError
from tests.closed_loop.paths import track
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
    path = popsteer.Path.from_csv(authors_data() / "waypoints.csv", columns="x,y,speed")
    return lab.compare.paper.run(path)


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
    path = popsteer.Path.from_csv(data / "waypoints.csv", columns="x,y,speed")
    # Row 0 of the trajectory is the pose before the shift to the reference point.
    positions = np.loadtxt(data / "trajectory.csv", delimiter=",")[1:, 1:3]
    logged = np.loadtxt(data / "tracking_error.csv", delimiter=",")[:, 0]
    assert len(positions) == len(logged)
    exact = np.array([path.project(x, y).cross_track_error for x, y in positions])
    difference = np.abs(np.abs(exact) - np.abs(logged))
    assert np.median(difference) <= 0.006
    assert np.abs(exact).mean() == pytest.approx(0.167, abs=0.001)


PAPER = vehicles.get("paper")
NAMES = ("default", "paper", "published-code", "reproduction")


@pytest.mark.parametrize("law", controllers.names())
def test_presets_of_each_law_are_of_its_class(law: str) -> None:
    assert presets.names(law) == NAMES
    for name in NAMES:
        assert type(presets.get(law, name)) is controllers.get(law).params


def test_presets_where_paper_and_code_differ_hold_both() -> None:
    def held(law: str, name: str, params: Any) -> bool:
        given: dict[str, Any] = presets.get(law, name).as_dict()
        return given == pytest.approx(params.resolved(PAPER).as_dict(), rel=1e-15)

    printed = popsteer.PidParams(smoothing_length=0.0, derivative_filter=0.0)
    assert held("pid", "paper", printed.replace(integral_with_dt=False))
    assert held("pid", "published-code", printed.replace(kp=0.12, ki=0.01, kd=0.48))
    assert held("pop", "paper", popsteer.PopParams(exact_lookahead=False))
    assert presets.get("pop", "default") == popsteer.PopParams(exact_lookahead=True)
    paper = popsteer.PurePursuitParams(min_lookahead=0.0, exact_lookahead=False)
    assert held("pure-pursuit", "paper", paper)
    code = popsteer.PurePursuitParams(alpha_by_arccos=True, exact_lookahead=False)
    assert held("pure-pursuit", "published-code", code)
    assert held(
        "stanley",
        "published-code",
        popsteer.StanleyParams(heading_behind=True, smoothing_length=0.0, softening=1e-5),
    )


def test_preset_or_law_unknown_is_refused_with_the_known_ones() -> None:
    with pytest.raises(ConfigError, match="unknown preset 'mine'; known: default, paper"):
        presets.get("pop", "mine")
    with pytest.raises(ConfigError, match="unknown controller 'mpc'; known: pid"):
        presets.get("mpc", "paper")


@pytest.mark.parametrize("law", ["pid", "pure-pursuit", "stanley", "pop"])
def test_presets_of_the_paper_are_absolute_numbers(law: str) -> None:
    small = popsteer.Vehicle(wheelbase=0.3)
    for name in NAMES[1:]:
        params = presets.get(law, name)
        assert params.resolved(small) == params
    default = presets.get(law, "default")
    assert default.resolved(small) != default.resolved(PAPER)


def test_vehicle_of_each_plant_is_the_one_that_is_named_so() -> None:
    for name in sim.plant_names():
        assert sim.vehicle_of(name) == vehicles.get(name)
    assert sim.vehicle_of(sim.KinematicBicycle(popsteer.Vehicle())) == popsteer.Vehicle()


def test_comparison_by_mapping_drives_the_params_given() -> None:
    slow = popsteer.PopParams(lookahead_gain=0.8)
    path = track("slalom")
    given = lab.compare.run(path, {"pop": slow}).runs["pop"]
    assert given.params["lookahead_gain"] == 0.8
    assert given.metrics != lab.compare.run(path, ["pop"]).runs["pop"].metrics


@pytest.mark.parametrize("name", ["no-such-law", "pop,pid"])
def test_comparison_with_unknown_law_drives_nothing(name: str) -> None:
    driven: list[str] = []
    with pytest.raises(ConfigError, match="unknown controller"):
        lab.compare.run(
            track("slalom"), ["pop", name], progress=lambda law, share: driven.append(law)
        )
    assert not driven
