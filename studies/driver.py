"""Drives of `popsteer.Driver` around a plant of its own: healthy ones, and planted faults.

    python -m studies.driver [--runs N] [--healthy N] [--worn]

Each drive draws a car of 0.16 to 12 m, a road with bends that it can take, and noise. The table
has, for each planted fault, how often it is named right and the vehicle stands, how often it is
said within a second or before the vehicle is half a metre off, after how long (median) and how far
off the path (largest) it is said, and how far off the vehicle is until it stands (largest).

With --worn nothing is as told: noise to 5 cm and 0.02 rad whatever the size, play to 2 degrees, a
steering offset to 3 degrees, periods that differ by up to half, slopes to 8 %, wheels that slip to
10 %.
"""

from __future__ import annotations

import argparse
import math
from typing import NamedTuple

import numpy as np

import popsteer

RUNS = 40
DT = 0.05
SUBSTEPS = 5
WHEELBASES = (0.16, 0.33, 1.0, 2.7, 7.5, 12.0)
TUNINGS = (popsteer.PreviewPopParams(), popsteer.StanleyParams(), popsteer.PurePursuitParams())
# What is planted: the faults that may be said for it, the first the one that is right.
FAULTS = {
    "inputs die (nan)": ("input",),
    "position dies (nan)": ("position",),
    "heading dies (nan)": ("heading",),
    "speed dies (nan)": ("speed",),
    "pose freezes": ("position",),
    "speed reads 0": ("speed",),
    "speed reads half": ("speed",),
    "heading reads 0.3 rad more": ("heading",),
    "heading freezes": ("heading",),
    "wheels stick": ("steering",),
    "steering has the wrong sign": ("steering",),
}


class Outcome(NamedTuple):
    """How a drive went."""

    fault: str | None
    after: float  # from the planted fault to what was said [s]
    said_off: float  # how far off the path it was then [m]
    off: float  # how far off it was at most, until it stood [m]
    stands: bool


class Wear(NamedTuple):
    """What nobody told the driver, drawn for each drive."""

    noise: tuple[float, float] = (0.0, 0.0)  # of the position [m] and of the heading [rad]
    play: float = 0.0  # of the steering [rad]
    offset: float = 0.0  # of the steering [rad]
    slip: float = 0.0  # of the wheels that measure the speed
    slope: float = 0.0
    jitter: float = 0.0  # of the periods


def wear_of(car: popsteer.Vehicle, draw: np.random.Generator, *, worn: bool) -> Wear:
    """A vehicle as told with little noise, or a worn one."""
    if not worn:
        return Wear((draw.uniform(0.0, 0.004) * car.wheelbase, draw.uniform(0.0, 0.004)))
    return Wear(
        noise=(draw.uniform(0.0, 0.05), draw.uniform(0.0, 0.02)),
        play=math.radians(draw.uniform(0.0, 2.0)),
        offset=math.radians(draw.uniform(-3.0, 3.0)),
        slip=draw.uniform(0.0, 0.1),
        slope=draw.uniform(-0.08, 0.08),
        jitter=draw.uniform(0.0, 0.5),
    )


def car_of(draw: np.random.Generator) -> popsteer.Vehicle:
    """A car of one of the sizes, as quick as such cars are."""
    length = float(draw.choice(WHEELBASES))
    return popsteer.Vehicle(
        wheelbase=length,
        rear_axle=-0.5 * length,
        max_steer=0.5,
        max_steer_rate=0.6 if length > 0.5 else 2.0,
        steer_lag=float(draw.uniform(0.05, 0.15)),
        dead_time=float(draw.choice([0.0, 0.05, 0.15])),
        max_lateral_acceleration=3.0,
        max_speed=float(min(draw.uniform(3.0, 5.0) * length, draw.uniform(8.0, 16.0))),
        max_deceleration=1.5,
        max_acceleration=1.5,
    )


def road_of(car: popsteer.Vehicle, draw: np.random.Generator) -> popsteer.Path:
    """Bends to both sides, with a radius of 8 wheelbases and more."""
    speed = car.max_speed or 1.0
    length = 40.0 * speed
    spacing = max(0.05 * length / 40.0, 0.1 * car.wheelbase)
    s = np.arange(0.0, length, spacing)
    bend = draw.uniform(0.3, 1.0) / (8.0 * car.wheelbase)
    curvature = bend * np.sin(s / (draw.uniform(8.0, 14.0) * car.wheelbase) + draw.uniform(0, 6.0))
    yaw = np.cumsum(curvature) * spacing
    return popsteer.Path(np.c_[np.cumsum(np.cos(yaw)), np.cumsum(np.sin(yaw))] * spacing)


class Plant:
    """A bicycle with a lag, a dead time and a rate of its wheels, and a drive with a lag."""

    def __init__(self, car: popsteer.Vehicle, path: popsteer.Path, wear: Wear) -> None:
        self.car, self.wear = car, wear
        self.x, self.y = float(path.x[0]), float(path.y[0])
        self.yaw = math.atan2(path.y[1] - path.y[0], path.x[1] - path.x[0])
        self.speed = self.column = self.wheel = self.pull = 0.0
        step = DT / SUBSTEPS
        self.steers = [0.0] * round(car.dead_time / step)
        self.pulls = [0.0] * round(car.drive_delay / step)
        self.sign, self.sticks = 1.0, False

    def sensed(self) -> list[float]:
        """The pose of the car's point, and the speed."""
        ahead = -self.car.rear_axle
        x, y = self.x + ahead * math.cos(self.yaw), self.y + ahead * math.sin(self.yaw)
        return [x, y, self.yaw, self.speed * (1.0 + self.wear.slip)]

    def go(self, drive: popsteer.Drive, substeps: int) -> None:
        """Move on by a period."""
        car, step, wear = self.car, DT / SUBSTEPS, self.wear
        rate = (car.max_steer_rate or math.inf) * step
        for _ in range(substeps):
            self.steers.append(self.sign * drive.steer + wear.offset)
            gap = self.steers.pop(0) - self.column
            if not self.sticks:
                gap *= 1.0 - math.exp(-step / car.steer_lag)
                self.column += max(-rate, min(rate, gap))
            half = 0.5 * wear.play
            self.wheel = max(self.column - half, min(self.column + half, self.wheel))
            self.pulls.append(drive.acceleration)
            self.pull += (self.pulls.pop(0) - self.pull) * min(step / 0.1, 1.0)
            downhill = 0.0 if self.speed == 0.0 and self.pull <= 0.0 else -9.81 * wear.slope
            if self.pull >= 0.0 and not drive.hold:
                self.speed += (self.pull + downhill) * step * (-1.0 if drive.reverse else 1.0)
            else:
                slower = max(abs(self.speed) + (min(self.pull, 0.0) + downhill) * step, 0.0)
                self.speed = math.copysign(slower, self.speed)
            self.x += step * self.speed * math.cos(self.yaw)
            self.y += step * self.speed * math.sin(self.yaw)
            self.yaw += step * self.speed * math.tan(self.wheel) / car.wheelbase


def spoiled(sensed: list[float], last: list[float], planted: str) -> list[float]:
    """What comes of a pose and a speed once a fault is planted."""
    x, y, yaw, speed = sensed
    nan = math.nan
    return {
        "inputs die (nan)": [nan] * 4,
        "position dies (nan)": [nan, nan, yaw, speed],
        "heading dies (nan)": [x, y, nan, speed],
        "speed dies (nan)": [x, y, yaw, nan],
        "pose freezes": [*last[:3], speed],
        "speed reads 0": [x, y, yaw, 0.0],
        "speed reads half": [x, y, yaw, 0.5 * speed],
        "heading reads 0.3 rad more": [x, y, yaw + 0.3, speed],
        "heading freezes": [x, y, last[2], speed],
    }.get(planted, sensed)


def drive(
    draw: np.random.Generator,
    planted: str | None,
    trace: list[tuple[float, float, float, str | None]] | None = None,
    *,
    worn: bool = False,
) -> Outcome:
    """One drive, to its end or until the vehicle stands for its fault.

    A `trace` takes time [s], distance from the path [m], speed [m/s] and the fault of each step.
    """
    car = car_of(draw)
    path = road_of(car, draw)
    tuning = TUNINGS[0] if draw.uniform() < 0.6 else TUNINGS[int(draw.integers(len(TUNINGS)))]
    wear = wear_of(car, draw, worn=worn)
    driver, plant = popsteer.Driver(path, car, tuning), Plant(car, path, wear)
    noise = wear.noise
    begins = float(draw.uniform(8.0, 16.0)) if planted else math.inf
    last = plant.sensed()
    after, said_off, off, stood = math.inf, 0.0, 0.0, 0
    now = before = 0.0
    for k in range(round(100.0 / DT)):
        sensed = plant.sensed()
        sensed[0] += draw.normal(0.0, noise[0])
        sensed[1] += draw.normal(0.0, noise[0])
        sensed[2] += draw.normal(0.0, noise[1])
        if planted and now >= begins:
            plant.sign = -1.0 if planted == "steering has the wrong sign" else 1.0
            plant.sticks = planted == "wheels stick"
            sensed = spoiled(sensed, last, planted)
        else:
            last = sensed
        x, y, yaw, speed = sensed
        answer = driver.step(x, y, yaw, speed, now - before if k else DT)
        substeps = round(SUBSTEPS * (1.0 + draw.uniform(-1.0, 1.0) * wear.jitter))
        plant.go(answer, substeps)
        before, now = now, now + substeps * DT / SUBSTEPS
        aside = abs(path.project(plant.x, plant.y).cross_track_error)
        if now >= begins - 1.0 or planted is None:
            off = max(off, aside)
        if trace is not None:
            trace.append((now, aside, plant.speed, answer.fault))
        if answer.fault and math.isinf(after):
            after, said_off = now - begins, aside
        stood = stood + 1 if plant.speed == 0.0 else 0
        if stood > 60 and k > 100:
            break
    return Outcome(driver.fault, after, said_off, off, stood > 0)


def fault_lines(runs: int = RUNS, healthy: int = RUNS, *, worn: bool = False) -> list[str]:
    """Rows of the table: each planted fault, and healthy drives."""
    rows = []
    for planted, names in FAULTS.items():
        outcomes = [drive(np.random.default_rng([7, k]), planted, worn=worn) for k in range(runs)]
        right = sum(outcome.fault in names and outcome.stands for outcome in outcomes)
        heard = [outcome for outcome in outcomes if outcome.fault]
        soon = sum(
            each.after >= 0.0 and (each.after <= 1.0 or each.said_off <= 0.5) for each in heard
        )
        after = sorted(outcome.after for outcome in heard)
        rows.append(
            f"| {planted} | {right} of {runs} | {soon} of {runs} | {after[len(after) // 2]:.2f} "
            f"| {max(outcome.said_off for outcome in heard):.2f} "
            f"| {max(outcome.off for outcome in outcomes):.2f} |"
        )
    whole = [drive(np.random.default_rng([8, k]), None, worn=worn) for k in range(healthy)]
    quiet = sum(outcome.fault is None and outcome.stands for outcome in whole)
    off = max(outcome.off for outcome in whole)
    rows.append(
        f"| nothing: to the end without a fault | {quiet} of {healthy} | - | - | - | {off:.2f} |"
    )
    return rows


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=RUNS, help="drives of each kind")
    parser.add_argument("--healthy", type=int, default=RUNS, help="drives without a fault")
    parser.add_argument("--worn", action="store_true", help="vehicles that are not as told")
    wanted = parser.parse_args()
    print(
        "| planted | named right | in 1 s or 0.5 m | said after [s] | off then [m] "
        "| off until at rest [m] |"
    )
    print("|---|--:|--:|--:|--:|--:|")
    print("\n".join(fault_lines(wanted.runs, wanted.healthy, worn=wanted.worn)))
