"""What a controller estimates of its vehicle beside numpy's least squares over the whole drive.

The model of the turn y of a period is gain (a + offset b - later c): a is the turn that the
vehicle's parameters predict, b its derivative by the steering offset, c by the dead time. The rows
are sums over the last 2 s, each of which weighs dt exp(-age / T), and the parameters themselves
count as further rows, which do not age.
"""

from __future__ import annotations

import math
import random
from typing import Any, NamedTuple

import numpy as np
import pytest

import popsteer

DT, TURN_TIME, SLIP_TIME, SPAN = 0.05, 4.0, 3.0, 2.0
ADAPT = popsteer.AdaptParams(turn_time=TURN_TIME, slip_time=SLIP_TIME, min_speed=1.0)
STRAIGHT = popsteer.Path([(10.0 * k, 0.0) for k in range(200)])
PRIOR = np.array([3e-3, 1.0, 2e-3])
"""Weights of the gain 1, of the offset 0 and of the given dead time."""
DOUBT = np.array([0.1, 0.03, 0.1])
"""Their standard deviations, which the noise is weighed against."""


class Record(NamedTuple):
    """A drive: what was expected of each period, and what was measured."""

    regressors: list[tuple[float, float, float]]
    turns: list[float]
    noises: list[float]
    """Variance of the noise that each fit was weighed by."""


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
    car, record = controller.vehicle, Record([], [], [])
    x, y, yaw, speed = 5.0, 1.0, 0.05, 8.0
    for k in range(steps):
        state = controller.state
        longer = state.estimator.estimate.longer_dead_time
        reached = _during(state, state.steer, DT)
        share = speed / car.turning_length(speed)
        wheels = [(steer + car.steer_offset, time) for steer, time in reached]
        # The last one is reached at the end: without a lag the wheels are where they are told.
        before = state.in_flight.wheel
        if k > 0:  # of the first pose nothing is known before
            a = share * sum(time * math.tan(wheel) for wheel, time in wheels)
            b = share * sum(time / math.cos(wheel) ** 2 for wheel, time in wheels)
            c = share * (math.tan(wheels[-1][0]) - math.tan(before))
            turn = gain * (a + offset * b) + rng.gauss(0.0, 2e-4)
            record.regressors.append((a + longer * c, b, -c))
            record.turns.append(turn)
            middle = yaw + 0.5 * turn
            x, y = x + speed * DT * math.cos(middle), y + speed * DT * math.sin(middle)
            yaw += turn
        record.noises.append(controller.state.estimator.turning.noise)
        controller.step(x, y, yaw, speed, DT)
    return record


def _summed(record: Record, time: float) -> tuple[Any, Any]:
    """The rows of the fit, weighed by their age, and what they explain."""
    changes = np.column_stack((record.regressors, record.turns))
    sums, total = [], np.zeros(4)
    for change in changes:
        total = math.exp(-DT / SPAN) * total + change
        sums.append(total)
    ages = DT * np.arange(len(sums))[::-1]
    weighed = np.sqrt(DT * np.exp(-ages / time))[:, None] * np.array(sums)
    return weighed[:, :3], weighed[:, 3]


def _fit(rows: Any, right: Any, prior: Any, given: Any) -> Any:
    weights = np.sqrt(prior)
    solution, *_ = np.linalg.lstsq(
        np.vstack((rows, np.diag(weights))), np.append(right, weights * given), rcond=None
    )
    return solution


@pytest.mark.parametrize("law", ["Pop", "PurePursuit", "Stanley", "Pid", "PreviewPop"])
def test_estimated_turning_is_the_least_squares_of_the_whole_drive(law: str) -> None:
    for seed, dead_time in enumerate((0.0, 0.15, 0.1)):
        gain, offset = (1.2, 0.02) if seed else (0.85, -0.03)
        car = popsteer.Vehicle(steer_lag=0.0, dead_time=dead_time, steer_offset=0.01)
        controller = getattr(popsteer, law)(STRAIGHT, car, adapt=ADAPT, monitor=None)
        record = _drive(controller, gain, offset, seed, steps=150)
        rows, right = _summed(record, TURN_TIME)
        noise = record.noises[-1]
        # Each turn is 2e-4 rad off; at first it is not known that the parameters are wrong.
        assert 0.3 * 0.5 * 2e-4**2 < noise < 2.5e-5
        prior = PRIOR + noise * 0.5 * SPAN / DOUBT**2
        # For the gain, offset and dead time are free but for a thousandth.
        free = np.array([prior[0], *(1e-3 * PRIOR[1:])])
        fitted = _fit(rows, right, free, [1.0, 0.0, 0.0])[0]
        found = controller.estimate
        assert found.gain == pytest.approx(fitted, abs=1e-6)
        beside, _ = _fit(rows[:, 1:], right / fitted - rows[:, 0], prior[1:], [0.0, 0.0])
        assert found.steer_offset - car.steer_offset == pytest.approx(beside, abs=1e-6)
        # The record says enough of the vehicle to be worth comparing.
        assert abs(fitted - 1.0) > 0.01


def test_estimated_slip_is_the_least_squares_and_the_acceleration_low_passed() -> None:
    slip, acceleration, steps = 0.03, 1.5, 120
    car = popsteer.Vehicle(dead_time=0.1, wheelbase=2.7)
    adapt = ADAPT.replace(turn_time=0.0)
    controller = popsteer.Stanley(STRAIGHT, car, adapt=adapt, monitor=None)
    x, y, speed = 5.0, 0.0, 5.0
    record = Record([], [], [])
    for _ in range(steps + 1):
        bend = math.tan(controller.state.in_flight.wheel) / car.turning_length(speed)
        controller.step(x, y, 0.0, speed, DT)
        # The speed of a period is the mean of those at its ends.
        mean = speed + 0.5 * acceleration * DT
        travel = mean * DT
        x, y = x + travel * math.cos(slip), y + travel * math.sin(slip)
        speed += acceleration * DT
        share = mean * DT / car.wheelbase
        by_acceleration = share * mean * mean / car.wheelbase
        record.regressors.append((share, by_acceleration, bend))
        record.turns.append(travel * math.sin(slip) / car.wheelbase)
    # The curvature is that when a period began: the last one has not been measured.
    bends = [bend for *_, bend in record.regressors[1:]]
    rows = [(a, b * bend, 0.0) for (a, b, _), bend in zip(record.regressors, bends, strict=False)]
    rows, right = _summed(Record(rows, record.turns[:-1], []), SLIP_TIME)
    noise = controller.state.estimator.sliding.noise
    # The doubt of the slip is one of its length, at the mean speed of the last measured period.
    pace = speed - 1.5 * acceleration * DT
    doubt = np.array([0.02, 0.1 * (car.wheelbase / pace) ** 2])
    prior = np.array([0.25, 0.04]) + noise * 0.5 * SPAN / doubt**2
    fitted, _ = _fit(rows[:, :2], right, prior, [0.0, 0.0])
    found = controller.estimate
    assert found.slip == pytest.approx(fitted, rel=1e-6)
    assert found.slip == pytest.approx(slip, rel=0.1)
    assert found.acceleration == pytest.approx(
        acceleration * (1.0 - math.exp(-steps * DT / 0.1)), rel=1e-9
    )
