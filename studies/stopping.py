"""Stops, many at random: vehicles of 0.16 to 12 m whose drives are as told, or are not.

    python -m studies.stopping 3000

The plant is of this file: a delay, a lag, brakes that hold and do not push back. Each row says how
many stops were driven through, came to rest too far beyond, or did not come to stand.
"""

from __future__ import annotations

import math
import random
import sys
from typing import NamedTuple

import popsteer

STEP = 0.005
"""Step of the plant [s]."""


class Case(NamedTuple):
    """A stop: what is told, and what is true."""

    wheelbase: float
    """[m]"""
    delay: float
    lag: float
    """Of the drive, as told [s]."""
    speed: float
    """Before the stop [m/s]."""
    braking: float
    """Planned deceleration [m/s²]."""
    period: float
    """Of the loop [s]."""
    line: bool
    """Whether it is a stop line, not the end of the path."""
    true_delay: float
    true_lag: float
    share: float
    """Of the commanded braking that the brakes give."""
    age: float
    """Of pose and speed [s], told."""
    noise: float
    """Of the position, along and across [m]."""


class Stopped(NamedTuple):
    """How a stop ended."""

    through: bool
    """Whether the vehicle drove on."""
    beyond: float
    """Where it came to rest, past the stop [m]."""
    stands: bool
    """Whether it stands in the end."""
    warned: bool
    """Whether it said that it cannot stop, before the stop."""


def draw(seed: int, *, told: bool) -> Case:
    """A case at random; the drive is as told, or not."""
    r = random.Random(seed)
    wheelbase = 0.16 * (12.0 / 0.16) ** r.random()
    delay, lag = r.uniform(0.0, 0.4), r.uniform(0.0, 0.8)
    case = Case(
        wheelbase=wheelbase,
        delay=delay,
        lag=lag,
        speed=0.5 * 30.0 ** r.random(),
        braking=r.uniform(0.8, 4.0),
        period=1.0 / r.uniform(10.0, 100.0),
        line=r.random() < 0.5,
        true_delay=delay,
        true_lag=lag,
        share=1.0,
        age=0.0,
        noise=0.0,
    )
    if told:
        return case
    return case._replace(
        true_delay=delay * r.uniform(0.5, 1.5),
        true_lag=lag * r.uniform(0.5, 1.5),
        share=r.uniform(0.7, 1.0),
        age=r.uniform(0.0, 0.3),
        noise=0.02,
    )


def stop(case: Case, seed: int = 0) -> Stopped:
    """Drive a case."""
    r = random.Random(seed)
    room = 2.0 * case.speed**2 / (2.0 * case.braking) + 4.0 * case.speed + 2.0
    spacing = max(0.1, min(1.0, 0.3 * case.wheelbase), room / 400.0)
    at = math.ceil(room / spacing)
    count = 2 * at + 2 if case.line else at + 1
    speeds = [case.speed] * count
    if case.line:
        speeds[at] = 0.0
    path = popsteer.Path([(spacing * k, 0.0) for k in range(count)], speed=speeds)
    car = popsteer.Vehicle(
        wheelbase=case.wheelbase,
        drive_delay=case.delay,
        drive_lag=case.lag,
        max_speed=case.speed,
        max_acceleration=min(2.0, case.braking),
        max_deceleration=case.braking,
    )
    tracker = popsteer.SpeedTracker(path, car)
    line = spacing * at
    flight = [0.0] * max(round(case.true_delay / STEP), 0)
    x, v, a, time = 0.0, case.speed, 0.0, 0.0
    past = [(x, v)]
    stood, warned, told = 0.0, False, 0.0
    limit = room / case.speed * 3.0 + 45.0
    while time < limit and x < line + 20.0:
        told += case.period
        steps = max(round((told - time) / STEP), 1)
        old = min(round(case.age / STEP), len(past) - 1)
        xm, vm = past[len(past) - 1 - old]
        heard = (xm + r.gauss(0.0, case.noise), r.gauss(0.0, case.noise))
        command = tracker.step(*heard, 0.0, vm, steps * STEP, pose_age=old * STEP)
        warned = warned or (command.cannot_stop and x < line)
        for _ in range(steps):
            flight.append(command.acceleration)
            u = flight.pop(0)
            u = u * case.share if u < 0.0 else u
            a = u + (a - u) * math.exp(-STEP / case.true_lag) if case.true_lag > 0.0 else u
            v = max(v + STEP * a, 0.0)
            x += STEP * v
            past.append((x, v))
        time += steps * STEP
        stood = stood + steps * STEP if command.standing and v == 0.0 else 0.0
        if stood > 5.0:
            break
    return Stopped((x > line + 10.0 and v > 0.0) or x >= line + 20.0, x - line, stood > 1.0, warned)


def fails(case: Case, found: Stopped) -> list[str]:
    """What is not as it has to be."""
    told = case.share == 1.0 and case.age == 0.0
    most = 0.05 + 0.01 * case.speed**2 / (2.0 * case.braking) if told else 0.3
    return [
        name
        for name, holds in (
            ("through", found.through),
            ("beyond", found.beyond > most and not (found.warned and not told)),
            ("never stands", not found.stands),
            ("short", found.stands and found.beyond < -(0.1 + 0.05 * case.wheelbase)),
            ("warned in vain", told and found.warned),
        )
        if holds
    ]


def count(number: int, *, told: bool) -> dict[str, list[int]]:
    """Which of so many cases fail, by how."""
    found: dict[str, list[int]] = {}
    for seed in range(number):
        case = draw(seed, told=told)
        for name in fails(case, stop(case, seed)):
            found.setdefault(name, []).append(seed)
    return found


if __name__ == "__main__":
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    for as_told in (True, False):
        failed = count(runs, told=as_told)
        sums = ", ".join(f"{name} {len(seeds)}" for name, seeds in failed.items()) or "none"
        print(f"{'as told' if as_told else 'not as told'}: {runs} stops, failed: {sums}")
        for name, seeds in failed.items():
            print("  ", name, seeds[:12])
