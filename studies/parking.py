"""Parking on defaults, by a car of its own: the table of docs/planning.md."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from popsteer import Path, PreviewPop, SpeedTracker, Vehicle
from popsteer.lab.suite.scenarios import arcs
from studies.layout import line
from studies.slopes import PERIOD, Moved, OwnCar, Shipped

LAG = 0.15
"""Of the wheels and of the drive, and the dead time [s]."""
RATE = 0.4
"""Of the wheels [rad/s]."""
CAR: dict[str, Any] = {
    "wheelbase": 2.7,
    "max_steer": 0.6,
    "max_steer_rate": RATE,
    **dict.fromkeys(("steer_lag", "dead_time", "drive_lag"), LAG),
}
PLAY = 0.01
"""Of its steering [rad]."""
SEEDS = range(4)

Piece = tuple[bool, float, float]
"""Whether it is driven backwards, its curvature to the left [1/m], its length [m]."""


class Parked(NamedTuple):
    """What a manoeuvre came to; a row has the largest of several."""

    aside: float
    """Largest distance from the leg that was driven [m]."""
    place: float
    """Distance from the end [m]."""
    heading: float
    """Error of the heading there [°]."""
    time: float
    """When it stood [s]; infinite if it did not."""


def bays(radius: float) -> dict[str, list[Piece]]:
    """Manoeuvres with bends of one radius [m], up to three cusps."""
    bend, eighth = 1.0 / radius, math.pi / 4.0 * radius
    ahead, into = (False, 0.0, 6.0), (True, 0.0, 4.0)
    found = {
        "there and back": [ahead, (False, bend, eighth), (True, bend, eighth), (True, 0.0, 6.0)]
    }
    for degrees, arc in ((45, eighth), (90, 2.0 * eighth)):
        half, third = arc / 2.0, arc / 3.0
        back_and_on: list[Piece] = [(True, -bend, third), (False, bend, third)]
        found |= {
            f"{degrees}°, 1 cusp": [ahead, (True, bend, arc), into],
            f"{degrees}°, out of a bend": [ahead, (False, -bend, half), (True, bend, half), into],
            f"{degrees}°, 3 cusps": [ahead, (False, bend, half), *back_and_on, into],
        }
    return found


def park(pieces: list[Piece], seed: int, plant: str = "", **told: Any) -> Parked:
    """Drive one manoeuvre with 2 cm and 0.003 rad of noise; `told` is what controllers are told."""
    drawn, reverse = arcs(pieces)
    poses = np.array(drawn)
    path = Path(poses[:, :2], reverse=reverse)
    car: Moved = OwnCar(Vehicle(**CAR), play=PLAY)
    if plant:
        car = Shipped(plant, path)
    vehicle = car.vehicle.replace(**{"steers_at_rest": True, **told})
    steering, pace = PreviewPop(path, vehicle), SpeedTracker(path, vehicle)
    noise = np.random.default_rng(seed)
    cusps = [k for k in range(1, len(reverse)) if reverse[k] != reverse[k - 1]]
    legs = [0, *cusps, len(poses) - 1]
    aside = 0.0
    leg = standing = 0
    time = math.inf
    for count in range(round(60.0 / PERIOD)):
        dx, dy, turned = noise.normal(0.0, (0.02, 0.02, 0.003))
        x, y, yaw, speed = car.state
        measured = (x + dx, y + dy, yaw + turned, speed, PERIOD)
        drive = pace.step(*measured)
        gear = -1.0 if drive.reverse else 1.0
        car.advance(steering.steer(*measured), drive.acceleration, reverse=drive.reverse)
        x, y, yaw, speed = car.state
        is_turned = leg + 2 < len(legs) and drive.reverse == reverse[legs[leg + 1]]
        if is_turned and gear * speed >= 0.0:
            leg += 1
        start = poses[legs[leg] : legs[leg + 1], :2]
        along = poses[legs[leg] + 1 : legs[leg + 1] + 1, :2] - start
        to = np.array([x, y]) - start
        share = np.clip((to * along).sum(1) / (along**2).sum(1), 0.0, 1.0)
        aside = max(aside, float(np.hypot(*(to - share[:, None] * along).T).min()))
        is_there = leg + 2 == len(legs) and drive.standing and drive.distance_to_stop < 0.2
        standing = standing + 1 if is_there else 0
        if standing > 10:
            time = count * PERIOD
            break
    end = poses[-1]
    heading = math.degrees(abs(math.remainder(yaw - end[2], math.tau)))
    return Parked(aside, math.hypot(x - end[0], y - end[1]), heading, time)


def row(pieces: list[Piece], plant: str = "", **told: Any) -> Parked:
    """Give the largest of each number over the seeds."""
    runs = [park(pieces, seed, plant, **told) for seed in SEEDS]
    return Parked(*(max(each) for each in zip(*runs, strict=True)))


def parking_lines() -> list[str]:
    """Word a row for each bay and radius: the study's car, one in MuJoCo, and others."""
    lines: list[str] = []
    for radius in (5.0, 7.0, 9.0):
        for name, pieces in bays(radius).items():
            found, kept = row(pieces), row(pieces, steers_at_rest=False)
            cells = [
                f"{each.aside:.2f}, {each.place:.3f} m, {each.heading:.1f}°"
                for each in (found, row(pieces, "mujoco-car"), row(pieces, drive_lag=0.0))
            ]
            others = f"{kept.aside:.2f}, {kept.place:.2f} m, {kept.heading:.0f}°"
            bay = f"{name}, {radius:.0f} m"
            lines.append(line(bay, f"{found.time:.0f}", *cells, others))
    return lines
