"""An antenna beside the centre line and above a side slope, by vehicles of this file's own."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import reference, sim
from popsteer.logs import Log

BESIDE, HEIGHT = 0.25, 1.2  # in wheelbases
SLOPE = 0.08  # [rad], the right side lower


def _path(wheelbase: float) -> popsteer.Path:
    arc = np.arange(0.0, 60.0, 0.2) * wheelbase
    return popsteer.Path(np.column_stack((arc, 3.0 * wheelbase * np.sin(arc / (8.0 * wheelbase)))))


def _errors(step: Any, wheelbase: float, roll: float) -> list[float]:
    """Drive a bicycle whose antenna is aside; tell how far its rear axle is off the sine [m]."""
    left = wheelbase * (BESIDE * math.cos(roll) - HEIGHT * math.sin(roll))
    x, y, yaw, speed, dt = 0.0, 0.0, math.atan(3.0 / 8.0), 1.5 * wheelbase, 0.05
    errors = []
    for _ in range(600):
        antenna = (x - left * math.sin(yaw), y + left * math.cos(yaw))
        steer = step(*antenna, yaw, speed, dt, roll=roll)
        for _ in range(10):
            yaw += 0.1 * dt * speed * math.tan(steer) / wheelbase
            x += 0.1 * dt * speed * math.cos(yaw)
            y += 0.1 * dt * speed * math.sin(yaw)
        slope = math.atan(3.0 / 8.0 * math.cos(x / (8.0 * wheelbase)))
        off = (y - 3.0 * wheelbase * math.sin(x / (8.0 * wheelbase))) * math.cos(slope)
        errors.append(abs(off))
    return errors[100:]


def _car(wheelbase: float) -> popsteer.Vehicle:
    return popsteer.Vehicle(
        wheelbase=wheelbase,
        steer_lag=0.0,
        max_steer=0.6,
        antenna_left=BESIDE * wheelbase,
        antenna_height=HEIGHT * wheelbase,
    )


@pytest.mark.parametrize("wheelbase", [0.33, 2.7, 7.5])
@pytest.mark.parametrize("roll", [0.0, SLOPE, -SLOPE])
def test_vehicle_with_its_antenna_aside_keeps_to_the_path(wheelbase: float, roll: float) -> None:
    path, car = _path(wheelbase), _car(wheelbase)
    driver = popsteer.Driver(path, car)
    for step in (
        popsteer.PreviewPop(path, car).steer,
        lambda *numbers, roll: driver.step(*numbers, roll=roll).steer,
    ):
        assert max(_errors(step, wheelbase, roll)) < 0.005 * wheelbase


def test_untold_antenna_and_untold_roll_are_as_far_off_as_they_are() -> None:
    """The test above would see a field that does nothing, and one of the wrong sign."""
    path, car = _path(2.7), _car(2.7)
    centred = popsteer.PreviewPop(path, car.replace(antenna_left=0.0, antenna_height=0.0))
    assert min(_errors(centred.steer, 2.7, 0.0)) > 0.9 * BESIDE * 2.7
    level = popsteer.PreviewPop(path, car)
    errors = _errors(lambda *numbers, roll: level.steer(*numbers, roll=0.0 * roll), 2.7, SLOPE)
    assert min(errors) > 0.9 * HEIGHT * 2.7 * SLOPE


def test_batch_and_reference_take_the_roll_as_a_controller_does() -> None:
    path, car = _path(2.7), _car(2.7).replace(max_lateral_acceleration=None)
    rolls = [0.0, SLOPE, -SLOPE]
    batch = popsteer.Batch([popsteer.Stanley(path, car, adapt=None, monitor=None)] * 3)
    law = reference.Stanley(reference.Vehicle(**car.as_dict()))
    trackers = [
        reference.Tracker(law, reference.Path(list(zip(path.x, path.y, strict=True))))
        for _ in rolls
    ]
    singles = [popsteer.Stanley(path, car, adapt=None, monitor=None) for _ in rolls]
    for k in range(20):
        pose = (0.3 * k, 0.2 + 0.1 * k, 0.3)
        x, y, yaw = (np.full(3, each) for each in pose)
        together = batch.steer(x, y, yaw, np.full(3, 3.0), 0.05, roll=rolls)
        alone = [
            each.steer(*pose, 3.0, 0.05, roll=r) for each, r in zip(singles, rolls, strict=True)
        ]
        plain = [
            each.step(*pose, 3.0, 0.05, roll=r) for each, r in zip(trackers, rolls, strict=True)
        ]
        assert together.tolist() == alone
        assert alone == pytest.approx([each.steer for each in plain], abs=1e-12)
    assert len(set(alone)) == 3


def test_simulated_vehicle_is_measured_at_its_antenna() -> None:
    path = _path(2.7)
    car = _car(2.7)
    run = sim.run(popsteer.PreviewPop(path, car), sim.KinematicBicycle(car), constant_speed=4.0)
    untold = popsteer.PreviewPop(path, car.replace(antenna_left=0.0))
    off = sim.run(untold, sim.KinematicBicycle(car), constant_speed=4.0)
    assert run.metrics.mean_abs_cross_track_error < 0.02
    assert off.metrics.mean_abs_cross_track_error == pytest.approx(BESIDE * 2.7, rel=0.1)


@pytest.mark.parametrize("roll", [2.0, -2.0, math.nan, math.inf])
def test_roll_that_is_none_is_refused_by_a_controller_and_level_to_a_driver(roll: float) -> None:
    path, car = _path(2.7), _car(2.7)
    with pytest.raises(popsteer.InputError, match="roll"):
        popsteer.PreviewPop(path, car).step(0.0, 0.0, 0.3, 1.0, 0.05, roll=roll)
    told, level = popsteer.Driver(path, car), popsteer.Driver(path, car)
    pose = (0.0, 0.5, 0.3, 1.0, 0.05)
    assert told.step(*pose, roll=roll) == level.step(*pose)


def test_driver_without_a_heading_places_its_antenna_by_the_last_one() -> None:
    path, car = _path(2.7), _car(2.7)
    driver = popsteer.Driver(path, car)
    left, yaw = BESIDE * 2.7, math.atan(3.0 / 8.0)
    antenna = (-left * math.sin(yaw), left * math.cos(yaw))
    first = driver.step(*antenna, yaw, 0.0, 0.05)
    blind = driver.step(*antenna, math.nan, 0.0, 0.05)
    assert abs(first.cross_track_error) < 2e-3
    assert blind.cross_track_error == pytest.approx(first.cross_track_error, abs=1e-3)


def test_log_of_an_antenna_aside_identifies_the_car_below_it() -> None:
    time = np.arange(0.0, 60.0, 0.05)
    steer = 0.05 * np.sin(0.9 * time) + 0.04 * np.sign(np.sin(0.5 * time))
    speed = 8.0 + 3.0 * np.sin(0.2 * time)
    yaw = np.cumsum(0.05 * speed * np.tan(steer) / 2.7)
    x, y = np.cumsum(0.05 * speed * np.cos(yaw)), np.cumsum(0.05 * speed * np.sin(yaw))
    told = popsteer.Vehicle(wheelbase=2.7, antenna_left=0.6)
    centre = popsteer.identify(Log(time, x, y, yaw, speed, steer), told.replace(antenna_left=0.0))
    aside = Log(time, x - 0.6 * np.sin(yaw), y + 0.6 * np.cos(yaw), yaw, speed, steer)
    found = popsteer.identify(aside, told)
    assert found.vehicle.antenna_left == 0.6
    assert found.vehicle.rear_axle == pytest.approx(centre.vehicle.rear_axle, abs=1e-6)
    assert found.turning_length == pytest.approx(centre.turning_length, abs=1e-6)
