"""The PID's derivative, against what breaks a difference of two errors."""

from __future__ import annotations

import math

import numpy as np
import pytest

import popsteer

NOISE = 0.01


def _mean_error(wheelbase: float, periods: tuple[float, float], lag: float) -> float:
    """Drive a slalom in noisy poses that come in turn after each of `periods`; give mean |e|."""
    rng, size = np.random.default_rng(3), wheelbase / 2.7
    arc = np.arange(0.0, 300.0, 0.5)
    path = popsteer.Path(size * np.c_[arc, 2.5 * np.sin(arc / 14.0)])
    law = popsteer.Pid(path, popsteer.Vehicle(wheelbase=wheelbase, max_steer=0.6))
    speed, errors = 7.0 * math.sqrt(size), []
    x, y, yaw, wheel = 0.0, 0.0, math.atan(2.5 / 14.0), 0.0
    for k in range(int(250.0 * size / speed / np.mean(periods))):
        at_x, at_y, looks = (rng.normal(size=3) * NOISE).tolist()
        command = law.step(x + at_x, y + at_y, yaw + 0.3 * looks, speed, periods[k % 2])
        errors.append(abs(command.cross_track_error))
        time = periods[(k + 1) % 2]
        parts = max(1, round(time / 0.002))
        for _ in range(parts):
            step = time / parts
            wheel = command.steer if lag == 0.0 else wheel + (command.steer - wheel) * step / lag
            x, y = x + speed * step * math.cos(yaw), y + speed * step * math.sin(yaw)
            yaw += speed * step * math.tan(wheel) / wheelbase
    return float(np.mean(errors[40:]))


@pytest.mark.parametrize("wheelbase", [0.5, 2.7, 6.0])
@pytest.mark.parametrize("periods", [(0.058, 0.002), (0.035, 0.005), (0.0399, 0.0001)])
def test_pid_in_uneven_periods_drives_as_in_even_ones(
    wheelbase: float, periods: tuple[float, float]
) -> None:
    even = _mean_error(wheelbase, (float(np.mean(periods)),) * 2, 0.15)
    assert _mean_error(wheelbase, periods, 0.15) < 1.3 * even + 2.0 * NOISE


def test_pid_of_wheels_that_turn_at_once_does_not_oscillate() -> None:
    assert _mean_error(2.7, (0.05, 0.05), 0.0) < 0.15
