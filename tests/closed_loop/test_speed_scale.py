"""A speed signal that is off by a factor: learnt by the poses, or said to be wrong."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pytest

import popsteer

if TYPE_CHECKING:
    from numpy.typing import NDArray

DT = 0.05


class Driven(NamedTuple):
    off: float
    """Largest distance from the waypoints [m]."""
    lateral: float
    """Largest lateral acceleration [m/s²]."""
    speed: float
    """Largest speed [m/s]."""
    fault: str | None
    scale: float


def _bends(size: float) -> NDArray[np.float64]:
    """Bends to both sides of at least 40 m for a car of 2.7 m."""
    yaw = np.cumsum(np.sin(np.arange(0.0, 400.0) / 30.0) / 40.0)
    return np.array([np.cumsum(np.cos(yaw)), np.cumsum(np.sin(yaw))]).T * size


def _u_turns() -> NDArray[np.float64]:
    """Rows of 60 m that are 12 m apart, for a tractor."""
    rows = []
    for row in range(4):
        x = np.arange(0.0, 60.0, 0.5)
        x = x if row % 2 == 0 else 60.0 - x
        rows.append(np.c_[x, np.full(len(x), 12.0 * row)])
        side = 1.0 if row % 2 == 0 else -1.0
        angle = np.arange(0.0, math.pi, 0.5 / 6.0)
        end = 60.0 if row % 2 == 0 else 0.0
        rows.append(np.c_[end + side * 6.0 * np.sin(angle), 12.0 * row + 6.0 - 6.0 * np.cos(angle)])
    return np.concatenate(rows[:-1])


def _drive(
    waypoints: NDArray[np.float64], car: popsteer.Vehicle, told: float, seconds: float
) -> Driven:
    rng, noise = np.random.default_rng(1), 0.004 * car.wheelbase
    path, segment = popsteer.Path(waypoints), 0
    driver = popsteer.Driver(path, car)
    (x, y), (dx, dy) = waypoints[0].tolist(), (waypoints[1] - waypoints[0]).tolist()
    yaw, speed, wheel = math.atan2(dy, dx), 0.0, 0.0
    off = lateral = top = 0.0
    fault = None
    for _ in range(int(seconds / DT)):
        at_x, at_y = x + noise * rng.normal(), y + noise * rng.normal()
        drive = driver.step(at_x, at_y, yaw + 0.002 * rng.normal(), told * speed, DT)
        fault = fault or (None if drive.fault is None else str(drive.fault))
        for _ in range(10):
            wheel += (drive.steer - wheel) * DT / 10.0 / 0.1
            speed = max(0.0, speed + drive.acceleration * DT / 10.0)
            x += speed * DT / 10.0 * math.cos(yaw)
            y += speed * DT / 10.0 * math.sin(yaw)
            yaw += speed * DT / 10.0 * math.tan(wheel) / car.wheelbase
        found = path.locate(x, y, yaw, segment, 2.0 * car.wheelbase)
        segment, off = found.segment, max(off, abs(found.cross_track_error))
        lateral = max(lateral, speed**2 * abs(math.tan(wheel)) / car.wheelbase)
        top = max(top, speed)
    return Driven(off, lateral, top, fault, driver.estimate.speed_scale)


@pytest.mark.parametrize("wheelbase", [0.3, 2.9, 6.5])
@pytest.mark.parametrize("told", [0.7, 0.85, 1.2, 1.45])
def test_scale_of_the_speed_is_learnt_before_it_leads_off_the_path(
    wheelbase: float, told: float
) -> None:
    size = wheelbase / 2.7
    car = popsteer.Vehicle(wheelbase=wheelbase, max_steer=0.6, max_lateral_acceleration=4.0)
    car = car.replace(max_speed=14.0 * math.sqrt(size))
    found = _drive(_bends(size), car, told, 30.0)
    assert found.fault is None
    assert found.scale * told == pytest.approx(1.0, abs=0.03)
    assert found.off < 0.03 + 0.01 * wheelbase
    assert found.lateral < 1.05 * 4.0
    assert found.speed < 1.05 * 14.0 * math.sqrt(size)


@pytest.mark.parametrize("told", [0.2778, 0.5, 2.0, 3.6])
def test_speed_in_another_unit_is_said_within_metres(told: float) -> None:
    car = popsteer.Vehicle(wheelbase=2.9, max_steer=0.6, max_speed=14.0)
    found = _drive(_bends(1.0), car, told, 30.0)
    assert found.fault == "speed"
    assert found.off < 0.1


def test_tractor_whose_wheels_slip_by_a_third_holds_its_u_turns() -> None:
    car = popsteer.Vehicle(wheelbase=2.8, max_steer=0.7, max_speed=3.0, dead_time=0.1)
    found = _drive(_u_turns(), car, 1.0 / 0.7, 80.0)
    assert (found.fault, found.off < 0.1) == (None, True), found
