"""Preview POP in the loop: the authors' track, wrong vehicles, noise, starts that could do harm."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
import pytest

import popsteer
from popsteer import AdaptParams, PreviewPop, Vehicle, sim, tracks
from popsteer.lab.opponents.mpc import Mpc, Weights
from popsteer.sim import CarlaIdentified, Noise, Settings
from studies.layout import table
from studies.preview_pop import CAR, START, Misinformed, preview_lines, slip_lines
from tests.helpers import authors_data

PLANT = "carla-identified"
QUICK = AdaptParams(turn_time=0.5)
CONSTANT = AdaptParams(turn_time=0.0)
LINE = popsteer.Path([(float(x), 0.0) for x in range(800)])


@pytest.fixture(scope="module")
def path() -> popsteer.Path:
    return popsteer.Path.from_csv(authors_data() / "waypoints.csv", columns="x,y,speed")


def _metrics(
    path: popsteer.Path, adapt: AdaptParams | Literal["auto"] = "auto", **given: Any
) -> sim.Metrics:
    law = PreviewPop(path, CAR.replace(**given), adapt=adapt)
    metrics = sim.run(law, start=START).metrics
    assert metrics.finished
    return metrics


def test_preview_pop_on_authors_track_stays_within_the_figures(path: popsteer.Path) -> None:
    metrics = _metrics(path)
    assert metrics.mean_abs_cross_track_error <= 0.050
    assert metrics.settled_mean_abs_cross_track_error <= 0.006
    assert metrics.settled_max_abs_cross_track_error <= 0.06
    pop = sim.run(popsteer.Pop(path), start=START).metrics
    assert metrics.rms_steer_rate <= pop.rms_steer_rate


def test_page_table_of_preview_pop_is_what_is_driven() -> None:
    pytest.importorskip("daqp")
    authors_data()  # one of the paths of the table
    assert table("preview_pop.md", "preview") == list(preview_lines())


def test_page_table_of_the_slip_is_what_is_driven() -> None:
    for module in ("mujoco", "vehiclemodels"):
        pytest.importorskip(module)
    authors_data()
    assert table("preview_pop.md", "slip") == list(slip_lines())


def test_preview_pop_on_authors_track_comes_near_the_mpc_with_a_third_of_its_steering(
    path: popsteer.Path,
) -> None:
    pytest.importorskip("daqp")
    mpc = Mpc(path, CAR, Weights())
    best, found = sim.run(mpc, start=START).metrics, _metrics(path)
    most = 1.25 * best.settled_mean_abs_cross_track_error
    assert found.settled_mean_abs_cross_track_error <= most
    assert found.rms_steer_rate <= best.rms_steer_rate / 3.0


@pytest.mark.parametrize(
    "given",
    [
        {"turning_wheelbase": 0.85 * 3.553},
        {"turning_wheelbase": 1.15 * 3.553},
        {"steer_lag": 0.05},
        {"steer_lag": 0.2},
    ],
    ids=str,
)
@pytest.mark.parametrize("adapt", [AdaptParams(), CONSTANT])
def test_preview_pop_of_a_wrong_vehicle_stays_on_authors_track(
    path: popsteer.Path, given: dict[str, float], adapt: AdaptParams
) -> None:
    assert _metrics(path, adapt, **given).settled_mean_abs_cross_track_error <= 0.03


@pytest.mark.parametrize("lag", [0.15, 0.2, 0.3])
def test_preview_pop_that_is_told_too_long_a_lag_finds_that_out(
    path: popsteer.Path, lag: float
) -> None:
    # As exact as with the right one, 0.1 s; with 0.3 s the error was 0.0195 m.
    metrics = _metrics(path, AdaptParams(), steer_lag=lag)
    assert metrics.settled_mean_abs_cross_track_error <= 0.003


def test_preview_pop_in_noise_stays_on_authors_track(path: popsteer.Path) -> None:
    noise = Noise(position=0.1, yaw=0.005)
    for adapt in (AdaptParams(), QUICK):
        laws = [PreviewPop(path, CAR, adapt=adapt)] * 4
        runs = sim.run_many(laws, start=START, noise=noise, seed=1)
        assert runs["finished"].all()
        assert runs["settled_mean_abs_cross_track_error"].max() <= 0.03


@pytest.mark.parametrize("factor", [0.85, 1.15])
def test_preview_pop_that_adapts_corrects_a_wrong_wheelbase(
    path: popsteer.Path, factor: float
) -> None:
    metrics = _metrics(path, AdaptParams(), turning_wheelbase=factor * 3.553)
    assert metrics.settled_mean_abs_cross_track_error <= 0.0025


def test_preview_pop_on_a_circle_with_a_wrong_wheelbase_adapts_the_offset_away() -> None:
    angles = np.linspace(0.0, 2.0 * math.pi, 800, endpoint=False)
    circle = popsteer.Path(60.0 * np.column_stack([np.cos(angles), np.sin(angles)]), closed=True)
    wrong = CAR.replace(turning_wheelbase=0.85 * 3.553)
    errors = [
        sim.run(PreviewPop(circle, wrong, adapt=adapt)).metrics.settled_mean_abs_cross_track_error
        for adapt in (CONSTANT, QUICK)
    ]
    assert errors[1] < 0.2 * errors[0]


@pytest.mark.parametrize("given", [{"yaw": 0.01}, {"ahead": 1.4}, {"ahead": -1.4}], ids=str)
def test_preview_pop_told_a_wrong_heading_or_point_finds_it(
    path: popsteer.Path, given: dict[str, float]
) -> None:
    without, adapting = (
        sim.run(Misinformed(PreviewPop(path, CAR, adapt=adapt), **given), start=START).metrics
        for adapt in (AdaptParams(slip_time=0.0), AdaptParams())
    )
    assert without.settled_mean_abs_cross_track_error >= 0.06
    assert adapting.settled_mean_abs_cross_track_error <= 0.02


def _drive(vehicle: Vehicle, start: tuple[float, float, float], speed: float) -> dict[str, Any]:
    """From `start`, rolling at a constant speed along a straight line."""
    time_limit = 45.0 * max(1.0, 5.0 / speed)
    simulation = sim.Simulation(
        LINE,
        CarlaIdentified(),
        start=start,
        speed=speed,
        settings=Settings(time_limit=time_limit, give_up_distance=500.0),
    )
    law = PreviewPop(LINE, vehicle)
    while not simulation.is_over:
        x, y, yaw, now = simulation.state
        steer = law.steer(x, y, yaw, now, 0.05)
        error = speed - now
        throttle = min(max(speed * (0.28 + 0.001 * speed) / 6.0 + 0.5 * error, 0.0), 1.0)
        simulation.step(steer, throttle, min(max(-0.3 * error, 0.0), 1.0))
    return simulation.records()


@pytest.mark.parametrize("speed", [1.0, 5.0, 12.0, 20.0])
@pytest.mark.parametrize(
    ("aside", "yaw"),
    [
        *((aside, 0.0) for aside in (3.0, -3.0, 30.0, -30.0)),
        *((1.0, yaw) for yaw in (0.5 * math.pi, -0.5 * math.pi, math.pi)),
        *((30.0, yaw) for yaw in (0.5 * math.pi, math.pi)),
    ],
)
def test_preview_pop_from_afar_or_facing_the_wrong_way_converges_without_spinning(
    aside: float, yaw: float, speed: float
) -> None:
    vehicle = CAR.replace(max_lateral_acceleration=15.0)
    records = _drive(vehicle, (150.0, aside, yaw), speed)
    assert abs(records["cross_track_error"][-1]) < 0.05
    assert abs(math.remainder(records["yaw"][-1], math.tau)) < 0.02
    # It turns round once at most, and by no more than the approach beyond.
    turned = np.abs(records["yaw"] - yaw).max()
    assert turned <= abs(yaw) + 1.2
    lateral = np.abs(np.diff(records["yaw"]) / 0.05 * records["speed"][:-1])
    assert lateral.max() <= 1.05 * 15.0


@pytest.mark.parametrize("dt", [0.01, 0.02, 0.1, 0.2])
def test_preview_pop_at_another_control_period_tracks_as_well(
    path: popsteer.Path, dt: float
) -> None:
    metrics = sim.run(PreviewPop(path), start=START, settings=Settings(dt=dt)).metrics
    assert metrics.finished
    assert metrics.settled_mean_abs_cross_track_error <= 0.012


@pytest.mark.parametrize("every", [2, 5, 10])
def test_preview_pop_on_coarse_waypoints_tracks_on(path: popsteer.Path, every: int) -> None:
    coarse = popsteer.Path(np.column_stack([path.x, path.y])[::every])
    metrics = _metrics(coarse)
    # Off the fine path, the chords of 10 m themselves are up to 0.5 m.
    assert metrics.settled_mean_abs_cross_track_error <= 0.05


@pytest.mark.parametrize("track", ["racetrack", "circle", "figure-eight", "slalom"])
@pytest.mark.parametrize("plant", ["carla-identified", "kinematic-bicycle"])
def test_preview_pop_on_every_track_is_a_tenth_of_pop(track: str, plant: str) -> None:
    found = tracks.get(track)
    course = popsteer.Path(found.xy, closed=found.closed)
    preview = sim.run(PreviewPop(course), plant).metrics
    pop = sim.run(popsteer.Pop(course), plant).metrics
    assert preview.finished
    assert (
        preview.settled_mean_abs_cross_track_error <= 0.1 * pop.settled_mean_abs_cross_track_error
    )
