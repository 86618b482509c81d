"""What a controller estimates of its vehicle beside numpy's least squares over the whole drive.

The model of the turn y of a period is gain (a + offset b): a is the turn that the vehicle's
parameters predict, b its derivative by the steering offset. An old period counts exp(-age / T), and
the parameters themselves count as two more rows, which do not age.
"""

from __future__ import annotations

import math
import random
from typing import Any, NamedTuple

import numpy as np
import pytest

import popsteer

DT, TURN_TIME, SLIP_TIME = 0.05, 4.0, 3.0
ADAPT = popsteer.AdaptParams(turn_time=TURN_TIME, slip_time=SLIP_TIME, min_speed=1.0)
PRIOR = np.diag([1e-4, 0.1])
"""Weights of the gain 1 and of the offset 0."""
STRAIGHT = popsteer.Path([(10.0 * k, 0.0) for k in range(200)])


class Record(NamedTuple):
    """A drive: what was expected of each period, and what was measured."""

    regressors: list[tuple[float, float]]
    turns: list[float]


def _during(state: Any, last: float, dt: float) -> list[tuple[float, float]]:
    """The commands that reach the wheels in a period after a state, and for how long each."""
    found, remaining = [], dt
    for steer, duration in (*state.in_flight.commands, (last, dt)):
        part = min(duration, remaining)
        if part > 0.0:
            found.append((steer, part))
            remaining -= part
    return found


def _drive(controller: Any, gain: float, offset: float, seed: int, steps: int) -> Record:
    """Swing about with a vehicle that turns otherwise than it is said to, and record it."""
    rng = random.Random(seed)
    car, record = controller.vehicle, Record([], [])
    x, y, yaw, speed = 5.0, 1.0, 0.05, 8.0
    for k in range(steps):
        state = controller.state
        reached = _during(state, state.steer, DT)
        length = car.turning_length(speed)
        wheels = [(steer + car.steer_offset, time) for steer, time in reached]
        if k > 0:  # of the first pose nothing is known before
            a = speed / length * sum(time * math.tan(wheel) for wheel, time in wheels)
            b = speed / length * sum(time / math.cos(wheel) ** 2 for wheel, time in wheels)
            turn = gain * (a + offset * b) + rng.gauss(0.0, 2e-4)
            record.regressors.append((a, b))
            record.turns.append(turn)
            middle = yaw + 0.5 * turn
            x, y = x + speed * DT * math.cos(middle), y + speed * DT * math.sin(middle)
            yaw += turn
        controller.step(x, y, yaw, speed, DT)
    return record


def _fitted(record: Record) -> tuple[float, float, Any]:
    """Gain and offset of the whole record; and its rows, weighed, for another fit."""
    ages = DT * np.arange(len(record.turns))[::-1]
    weights = np.sqrt(np.exp(-ages / TURN_TIME))
    rows = np.vstack((weights[:, None] * np.array(record.regressors), np.sqrt(PRIOR)))
    right = np.append(weights * np.array(record.turns), np.sqrt(PRIOR) @ [1.0, 0.0])
    solution, *_ = np.linalg.lstsq(rows, right, rcond=None)
    return float(solution[0]), float(solution[1] / solution[0]), (rows, right)


@pytest.mark.parametrize("law", ["Pop", "PurePursuit", "Stanley", "Pid", "PreviewPop"])
def test_estimated_turning_is_the_least_squares_of_the_whole_drive(law: str) -> None:
    for seed, dead_time in enumerate((0.0, 0.15, 0.1)):
        gain, offset = (1.2, 0.02) if seed else (0.85, -0.03)
        car = popsteer.Vehicle(steer_lag=0.0, dead_time=dead_time, steer_offset=0.01)
        controller = getattr(popsteer, law)(STRAIGHT, car, adapt=ADAPT)
        record = _drive(controller, gain, offset, seed, steps=150)
        fitted, beside, (rows, right) = _fitted(record)
        found = controller.estimate
        assert found.gain == pytest.approx(fitted, abs=1e-8)
        if dead_time == 0.0:
            # Nothing is predicted: controllers use the gain 1, and the offset that fits it.
            beside = np.linalg.lstsq(rows[:, 1:], right - rows[:, 0], rcond=None)[0][0]
        assert found.steer_offset - car.steer_offset == pytest.approx(beside, abs=1e-8)
        # The record says enough of the vehicle to be worth comparing.
        assert abs(fitted - 1.0) > 0.01


def test_estimated_slip_and_acceleration_are_low_passed() -> None:
    slip, acceleration, steps = 0.03, 1.5, 120
    car = popsteer.Vehicle(dead_time=0.1)
    controller = popsteer.Stanley(STRAIGHT, car, adapt=ADAPT)
    x, y, speed = 5.0, 0.0, 5.0
    for _ in range(steps + 1):
        controller.step(x, y, 0.0, speed, DT)
        # The speed of a period is the mean of those at its ends.
        travel = DT * (speed + 0.5 * acceleration * DT)
        x, y = x + travel * math.cos(slip), y + travel * math.sin(slip)
        speed += acceleration * DT
    found = controller.estimate
    assert found.slip == pytest.approx(
        math.sin(slip) * (1.0 - (1.0 - DT / SLIP_TIME) ** steps), rel=1e-9
    )
    assert found.slip_length == pytest.approx(0.0, abs=1e-12)
    assert found.acceleration == pytest.approx(
        acceleration * (1.0 - math.exp(-steps * DT / 0.1)), rel=1e-9
    )
