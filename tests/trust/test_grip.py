"""Lateral acceleration: limits that the vehicles survive, and a status before they are passed."""

from __future__ import annotations

import numpy as np
import pytest

import popsteer
from studies.grip import PLANTS, drive

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
    # Planned at 9 and 10 m/s², beyond the vehicle's 8.2: the multi-body model lifts a wheel.
    lifts = [
        drive("commonroad-mb-2", seed, asked) for seed, asked in ((0, 9.0), (2, 10.0), (3, 10.0))
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
