"""A localisation that is slower than the loop: nothing is learnt of poses that nobody measured.

The vehicles are those of `studies.driver`, whose bicycle is not popsteer's: worn ones, whose offset
and play would be faults of the steering if all that they turn between two poses came at once.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest

import popsteer
from studies.driver import DT, SUBSTEPS, Plant, car_of, road_of, wear_of

PERIOD = DT / SUBSTEPS  # 0.01 s
BEGINS = 10.0
GIVEN = ["missing", "repeated", "aged"]


class Drove(NamedTuple):
    """How a drive went."""

    fault: str | None
    off: float  # how far off its path it was at most, in wheelbases
    believed: float  # how long after a jump the position was believed [s]
    gain: float


def drive(
    seed: int, given: str, every: int, *, speed: float = 1.0, jump: float = 0.0, worn: bool = True
) -> Drove:
    """Drive for 30 s at 100 Hz with a pose in `every` few steps.

    After 10 s the speed signal is multiplied by `speed`, and poses have a `jump` in wheelbases.
    """
    draw = np.random.default_rng([11, seed])
    car = car_of(draw)
    path = road_of(car, draw)
    wear = wear_of(car, draw, worn=worn)._replace(slip=0.0, slope=0.0, jitter=0.0)
    noise = min(wear.noise[0], 0.02 * car.wheelbase), 0.4 * wear.noise[1]
    driver, plant = popsteer.Driver(path, car), Plant(car, path, wear)
    last, age, off, believed = [0.0] * 4, 0.0, 0.0, math.inf
    for k in range(round(30.0 / PERIOD)):
        begun = k * PERIOD - BEGINS
        scale, aside = (speed, jump * car.wheelbase) if begun >= 0.0 else (1.0, 0.0)
        sensed = plant.sensed()
        now = scale * sensed[3]
        age += PERIOD
        if k % every == 0:
            noises = draw.normal(0.0, [noise[0], noise[0], noise[1]])
            x, y, yaw = np.add(sensed[:3], noises).tolist()
            last = [x, y + aside, yaw, now]
            age = 0.0
        if given == "aged":
            answer = driver.step(last[0], last[1], last[2], last[3], PERIOD, pose_age=age)
        elif given == "missing" and age > 0.0:
            answer = driver.step(None, None, None, now, PERIOD)
        else:
            answer = driver.step(last[0], last[1], last[2], now, PERIOD)
        if aside:
            where = driver.state.signals.believed
            if math.hypot(where.x - sensed[0], where.y - sensed[1] - aside) < 0.15 * aside:
                believed = begun
                break
        elif k % SUBSTEPS == 0:
            off = max(off, abs(path.project(plant.x, plant.y).cross_track_error))
        plant.go(answer, 1)
        if answer.fault:
            break
    estimate = driver.estimate
    assert estimate is not None
    return Drove(driver.fault, off / car.wheelbase, believed, estimate.gain)


@pytest.mark.parametrize("given", GIVEN)
def test_worn_vehicles_with_slow_poses_are_healthy(given: str) -> None:
    for seed in range(10):
        drove = drive(seed, given, every=8 + 4 * (seed % 5))
        assert drove.fault is None, seed
        assert drove.off < 0.35, seed
        assert drove.gain == pytest.approx(1.0, abs=0.2), seed


@pytest.mark.parametrize("given", GIVEN)
def test_half_a_speed_is_named_with_slow_poses(given: str) -> None:
    said = [drive(seed, given, every=8 + 4 * (seed % 4), speed=0.5).fault for seed in range(8)]
    assert None not in said
    assert said.count("speed") >= 7


@pytest.mark.parametrize("given", GIVEN)
def test_a_jump_is_believed_after_a_time_however_seldom_poses_come(given: str) -> None:
    for seed in range(8):
        drove = drive(seed, given, every=8 + 4 * (seed % 4), jump=0.6, worn=False)
        # 0.15 s, 0.35 s a wheelbase, and two poses that agree.
        assert drove.believed < 0.15 + 0.35 * 0.6 + 2.0 * 0.2 + 0.01, seed
