"""Lateral acceleration: limits that the vehicles survive, and a status before they are passed."""

from __future__ import annotations

import numpy as np
import pytest

import popsteer
from studies.grip import PLANTS, drive
from tests.trust.car import Car

TOO_FAST = popsteer.Status.TOO_FAST
CAR = popsteer.Vehicle(wheelbase=2.7, max_lateral_acceleration=4.0, max_deceleration=3.0)


def bend(straight: float, radius: float) -> popsteer.Path:
    """Return a straight that ends in half a circle, with a waypoint every half metre."""
    x = np.arange(0.0, straight, 0.5)
    angle = np.arange(0.0, np.pi, 0.5 / radius)
    arc = np.column_stack((straight + radius * np.sin(angle), radius - radius * np.cos(angle)))
    return popsteer.Path(np.vstack((np.column_stack((x, 0.0 * x)), arc)))


@pytest.mark.parametrize("name", PLANTS)
def test_own_limit_is_survived_with_all_wheels_on_the_road(name: str) -> None:
    for seed in range(2):
        driven = drive(name, seed)
        assert driven.finished
        assert driven.least > 0.0
        assert driven.ahead is None
        assert driven.said == 0


def test_too_much_grip_asked_is_said_before_a_wheel_lifts() -> None:
    # Planned at 10 and 11 m/s², beyond the vehicle's 8.2: the multi-body model lifts a wheel.
    lifts = [
        drive("commonroad-mb-2", seed, asked) for seed, asked in ((3, 10.0), (4, 10.0), (3, 11.0))
    ]
    assert [each.ahead is not None and each.ahead >= 0.3 for each in lifts] == [True] * 3


def test_limit_of_4_is_kept_on_each_plant() -> None:
    for name in PLANTS:
        driven = drive(name, 10, told=4.0)
        assert driven.finished
        assert driven.lateral <= 4.4
        assert driven.said == 0


def test_bend_ahead_is_too_fast_only_if_comfortable_braking_does_not_do() -> None:
    # 20 m of radius at 4 m/s² is 8.9 m/s; from 20 m/s, braking at 3 m/s² to that takes 53 m.
    path = bend(100.0, 20.0)
    for x, speed, too_fast in ((20.0, 20.0, False), (80.0, 20.0, True), (80.0, 8.5, False)):
        command = popsteer.PreviewPop(path, CAR).step(x, 0.0, 0.0, speed, 0.05)
        assert (TOO_FAST in command.status) is too_fast, (x, speed, command.status)


def test_chicane_ahead_is_too_fast_as_a_bend_is() -> None:
    # 15 m to one side and 15 m to the other, of 20 m radius: in all it turns by nothing.
    x = np.arange(0.0, 300.0, 0.5)
    turn = np.where(x < 100.0, 0.0, np.where(x < 115.0, 0.025, np.where(x < 130.0, -0.025, 0.0)))
    yaw = np.cumsum(turn)
    path = popsteer.Path(np.cumsum(0.5 * np.c_[np.cos(yaw), np.sin(yaw)], axis=0))
    for at, speed, too_fast in ((85.0, 18.0, True), (85.0, 8.0, False), (20.0, 18.0, False)):
        command = popsteer.PreviewPop(path, CAR).step(at, 0.0, 0.0, speed, 0.05)
        assert (TOO_FAST in command.status) is too_fast, (at, speed, command.status)


@pytest.mark.parametrize(
    "law", [popsteer.Pop, popsteer.Stanley, popsteer.Pid, popsteer.PreviewPop, popsteer.PurePursuit]
)
def test_join_that_wheels_cannot_end_is_said_before_it_begins(law: type) -> None:
    # From there Stanley, POP and PID limit-cycle about the straight; the others settle.
    path = popsteer.Path([(float(k), 0.0) for k in range(0, 500, 2)])
    limited = law in (popsteer.Pop, popsteer.Stanley, popsteer.Pid)
    for wheelbase, rate in ((0.5, 0.8), (2.9, 0.3), (6.0, 0.25)):
        car = popsteer.Vehicle(wheelbase=wheelbase, max_steer=0.6, max_steer_rate=rate)
        speed = 5.0 * np.sqrt(wheelbase / 2.7)
        for aside, steep in ((1.7, limited), (0.02, False)):
            y = aside * wheelbase
            command = law(path, car).step(20.0, y, 0.0, speed, 0.05)
            assert (TOO_FAST in command.status) is steep, (wheelbase, aside, command.status)
        freely = law(path, car.replace(max_steer_rate=None))
        assert TOO_FAST not in freely.step(20.0, 2.0 * wheelbase, 0.0, speed, 0.05).status


def test_measured_turn_beyond_the_limit_is_too_fast_for_every_controller() -> None:
    # On a circle, at 4.6 and at 3.8 m/s².
    for law in (popsteer.Pop, popsteer.Stanley, popsteer.PurePursuit, popsteer.Pid):
        for lateral, too_fast in ((4.6, True), (3.8, False)):
            rate = lateral / 10.0
            steering = law(bend(0.0, 10.0 / rate), CAR)
            for k in range(40):
                yaw = 0.05 * rate * k
                x, y = 10.0 / rate * np.sin(yaw), 10.0 / rate * (1.0 - np.cos(yaw))
                command = steering.step(x, y, yaw, 10.0, 0.05)
            assert (TOO_FAST in command.status) is too_fast, (law, lateral)


@pytest.mark.parametrize("controller", [popsteer.PreviewPop, popsteer.Stanley])
@pytest.mark.parametrize(
    ("wheelbase", "understeer", "speed", "radius"),
    [(0.33, 0.004, 4.0, 4.5), (2.7, 0.003, 25.0, 190.0), (2.7, 0.004, 20.0, 110.0)],
)
def test_limit_is_kept_and_used_by_a_vehicle_that_understeers_more_than_told(
    controller: type, wheelbase: float, understeer: float, speed: float, radius: float
) -> None:
    """The limit is 4 m/s²; the bend needs less, and then more."""
    for factor in (1.0, 0.7):
        step = 0.2 * speed / 25.0
        along = np.arange(0.0, 17.0 * speed, step)
        inside = (along > 6.0 * speed) & (along < 14.0 * speed)
        width = round(speed / step)
        curvature = np.convolve(inside / (factor * radius), np.ones(width) / width, "same")
        yaw = np.cumsum(curvature) * step
        xy = np.cumsum(np.column_stack((np.cos(yaw), np.sin(yaw))), axis=0) * step
        told = popsteer.Vehicle(
            wheelbase=wheelbase, steer_lag=0.15, dead_time=0.1, max_steer_rate=0.6, max_steer=0.6
        )
        steering = controller(popsteer.Path(xy[::4]), told)
        real = Car(wheelbase, 0.15, 0.1, 0.6, understeer=understeer, centre=0.0, speed=speed)
        real.x, real.y = xy[0]
        largest, off = 0.0, 0.0
        for _ in range(260):
            real.command(steering.step(*real.pose(), 0.05).steer)
            before = real.yaw
            real.advance(0.05, speed)
            largest = max(largest, abs(real.yaw - before) / 0.05 * speed)
            off = max(off, float(np.min(np.hypot(*(xy - [real.x, real.y]).T))))
        assert largest <= 4.2
        if factor < 1.0:
            assert largest >= 3.8
        else:
            assert off < (0.5 if controller is popsteer.Stanley else 0.3)
