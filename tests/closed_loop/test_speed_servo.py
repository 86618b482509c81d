"""The speed command, on a servo with a delay, a lag and a scale of its own."""

from __future__ import annotations

import random

import pytest

import popsteer
from tests.helpers import looped

STEP = 0.005


def driven(
    lag: float, scale: float, *, glitches: float, dt: float = 0.02, wheelbase: float = 2.7
) -> tuple[float, float, float, popsteer.SpeedCommand]:
    """Where it ends past the end, the largest command, the largest speed, and the last command."""
    draw = random.Random(3)
    size = wheelbase / 2.7
    path = popsteer.Path([(size * k, 0.0) for k in range(201)])
    car = popsteer.Vehicle(
        wheelbase=wheelbase,
        max_speed=12.0 * size,
        max_acceleration=2.0 * size,
        max_deceleration=2.0 * size,
        drive_lag=lag,
    )
    tracker = popsteer.SpeedTracker(path, car)
    flight = [0.0] * round(car.drive_delay / STEP)
    x = speed = most = fastest = 0.0
    for step in range(round(60.0 / dt)):
        heard = draw.choice([-50.0, 50.0, 5000.0]) if draw.random() < glitches and step else speed
        command = tracker.step(x, 0.0, 0.0, heard, dt)
        most = max(most, command.speed)
        for _ in range(round(dt / STEP)):
            flight.append(command.speed)
            wanted = scale * flight.pop(0)
            speed = wanted if lag == 0.0 else speed + (wanted - speed) * STEP / lag
            x += STEP * speed
        fastest = max(fastest, speed)
    return (x - 200.0 * size) / size, most / size, fastest / size, command


@looped("lag", [0.0, 0.5, 1.0])
@looped("scale", [0.8, 1.0, 1.2])
@looped("glitches", [0.0, 0.01])
def test_speed_command_stays_within_the_top_speed_and_stops_at_the_end(
    lag: float, scale: float, glitches: float
) -> None:
    for wheelbase in (2.7, 9.0):
        past, most, fastest, last = driven(lag, scale, glitches=glitches, wheelbase=wheelbase)
        assert most <= 12.0 + 1e-9, (wheelbase, most)
        assert fastest <= 12.1, (wheelbase, fastest)
        assert past <= 0.3, (wheelbase, past)
        assert last.standing, wheelbase
        assert last.speed == 0.0, wheelbase


def test_speed_command_learns_the_scale_of_the_servo() -> None:
    path = popsteer.Path([(float(k), 0.0) for k in range(400)], speed=[8.0] * 400)
    for scale in (0.8, 1.2):
        tracker = popsteer.SpeedTracker(path, popsteer.Vehicle(wheelbase=2.7, drive_lag=0.3))
        x = speed = 0.0
        for _ in range(1000):
            command = tracker.step(x, 0.0, 0.0, speed, 0.02)
            speed += (scale * command.speed - speed) * 0.02 / 0.3
            x += 0.02 * speed
        assert speed == pytest.approx(8.0, abs=0.05)
        assert command.speed == pytest.approx(8.0 / scale, abs=0.05)


def test_speed_command_of_a_vehicle_that_does_not_move_stays_small() -> None:
    path = popsteer.Path([(float(k), 0.0) for k in range(400)])
    tracker = popsteer.SpeedTracker(path, popsteer.Vehicle(wheelbase=2.7))
    commands = [tracker.step(5.0, 0.0, 0.0, 0.0, 0.02).speed for _ in range(500)]
    # What 2 m/s² give in the drive's delay of 0.1 s and half a second.
    assert max(commands) == pytest.approx(1.2)
