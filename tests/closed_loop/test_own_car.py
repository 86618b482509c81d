"""Cars of one's own: small ones on the defaults, crooked wheels that nobody told of."""

from __future__ import annotations

import math

import numpy as np
import pytest

import popsteer
from popsteer import sim, tracks
from tests.helpers import authors_data

SMALL = popsteer.Vehicle(wheelbase=0.33, max_steer=0.42, steer_lag=0.05, max_steer_rate=3.0)


def bends(radius: float, transition: float, spacing: float) -> popsteer.Path:
    """S-bends of a radius, joined by curvatures that change evenly over a length [m]."""
    arc = 2.0 * radius
    pattern = [1.0, -1.0] * 8
    curvature = [0.0] * 40
    for sign in pattern:
        start = curvature[-1] * radius
        ramp = np.linspace(start, sign, round(transition / spacing * abs(sign - start) / 2))
        curvature += (ramp / radius).tolist() + [sign / radius] * round(arc / spacing)
    yaw = np.cumsum(np.array(curvature) * spacing)
    x, y = np.cumsum(np.cos(yaw) * spacing), np.cumsum(np.sin(yaw) * spacing)
    return popsteer.Path(np.column_stack((x, y)))


@pytest.mark.parametrize(
    ("controller", "mean", "largest"),
    [
        (popsteer.PreviewPop, 0.003, 0.02),
        (popsteer.Stanley, 0.03, 0.06),
        (popsteer.PurePursuit, 0.3, 0.5),
        (popsteer.Pop, 0.3, 0.5),
        (popsteer.Pid, 0.06, 0.12),
    ],
)
def test_small_car_on_the_defaults_stays_on_its_path(
    controller: type[popsteer.PreviewPop], mean: float, largest: float
) -> None:
    path = bends(1.5, 1.0, 0.02)
    run = sim.run(
        controller(path),
        sim.KinematicBicycle(SMALL),
        constant_speed=2.0,
        settings=sim.Settings(dt=0.02, settling_time=3.0),
    )
    assert run.ending == "finished"
    assert run.metrics.settled_mean_abs_cross_track_error <= mean
    assert run.metrics.settled_max_abs_cross_track_error <= largest


def drive(
    path: popsteer.Path, start: tuple[float, float, float], offset: float
) -> tuple[list[popsteer.Estimate], float]:
    """What preview POP knows at each step, and its mean error after 5 s [m].

    The identified plant's wheels stand at `offset` at the command 0, which nobody told.
    """
    given = popsteer.vehicles.get("carla-identified")
    plant = sim.CarlaIdentified(given.replace(steer_offset=offset))
    controller = popsteer.PreviewPop(path, given)
    pedals = popsteer.CoupledLongitudinal()
    simulation = sim.Simulation(path, plant, start=start, tracked_point=controller.tracked_point)
    known = []
    while not simulation.is_over:
        x, y, yaw, speed = simulation.state
        command = controller.step(x, y, yaw, speed, simulation.settings.dt)
        known.append(controller.estimate)
        simulation.step(command.steer, *pedals.step(speed, command.steer))
    assert simulation.is_finished
    return known, simulation.metrics()["settled_mean_abs_cross_track_error"]


def check_offset(path: popsteer.Path, start: tuple[float, float, float]) -> None:
    offset = math.radians(1.0)
    straight, error = drive(path, start, 0.0)
    known, crooked_error = drive(path, start, offset)
    after = round(10.0 / 0.05)
    for estimate in known[after:]:
        assert abs(estimate.steer_offset - offset) < math.radians(0.1)
    for estimate in straight[after:]:
        assert abs(estimate.steer_offset) < math.radians(0.1)
    assert crooked_error <= 2.0 * error


def test_steering_offset_that_nobody_told_is_found_in_ten_seconds_of_bends() -> None:
    track = tracks.get("racetrack")
    path = popsteer.Path(track.xy, speed=track.speed)
    check_offset(path, sim.default_start(path, vehicle=popsteer.vehicles.get("carla-identified")))


def test_steering_offset_is_found_on_the_authors_track() -> None:
    path = popsteer.Path.from_csv(authors_data() / "waypoints.csv")
    check_offset(path, (-183.797, 79.760, -1.574))
