"""Drives vehicles that are what controllers were told, and counts the faults that are reported.

    python -m studies.alarms              # all of them
    python -m studies.alarms --laps 60    # fewer noisy laps

The matrix, the edges, noisy laps; and in a loop of its own (tests/trust): 200 cars that are as told
within 10 % with noise, losses and jitter, play of the steering, paths that begin ahead, small cars;
then twelve circuits with hairpins, planned at 4 m/s² with 4 m/s² of braking, on each plant. The
conditions are counted over all steps. No run may be
`implausible`, and none `deviating` whose error kept its limit; the exit code is 1 where one is.
"""

from __future__ import annotations

import argparse
import math
import random
import sys
from collections import Counter
from typing import TYPE_CHECKING

import numpy as np

from popsteer import Path, SpeedTracker, Status, Vehicle, controllers, sim
from popsteer.lab import compare
from popsteer.sim.closed_loop import START_OFFSET
from studies import edges
from studies.grip import LIMITS
from studies.layout import track
from tests.trust.car import TOLD, Car, Drive, bends, circuit, drive, jitter, somebody

if TYPE_CHECKING:
    from collections.abc import Iterator


NAMES = ("pop", "preview-pop", "pure-pursuit", "stanley", "pid")
PLANTS = ("carla-identified", "kinematic-bicycle", "commonroad-mb-2", "mujoco-car")
TRACKS = ("racetrack", "double-lane-change", "slalom")
LAP_PLANTS = ("carla-identified", "kinematic-bicycle")
HEALTHY, CIRCUITS = 200, 12
SMALL = Vehicle(
    wheelbase=0.33,
    rear_axle=-0.165,
    max_steer=0.5,
    max_steer_rate=3.0,
    steer_lag=0.05,
    dead_time=0.05,
)
NOISE = sim.Noise(position=0.1, yaw=0.005, speed=0.05)


def is_false(faults: Status, error: float, limit: float) -> bool:
    """Whether what was reported is not so: the vehicle is as told, and its error this large [m]."""
    return bool(faults & Status.IMPLAUSIBLE) or bool(faults & Status.DEVIATING and error <= limit)


def matrix() -> Iterator[bool]:
    """Drive what `make matrix` drives."""
    for plant in PLANTS:
        limit = 0.5 * sim.vehicle_of(plant).wheelbase
        for name in TRACKS:
            path = track(name)
            start = sim.default_start(path, 1.0, sim.vehicle_of(plant))
            found = compare.run(path, NAMES, plant, start=start, constant_speed=10.0)
            for run in found.runs.values():
                metrics = run.metrics
                yield is_false(metrics.faults, metrics.max_abs_cross_track_error, limit)


def pathological() -> Iterator[bool]:
    """Drive the pathological paths of docs/edges.md."""
    for run in edges.run():
        # Its errors are those of the rear axle, so they say nothing of `deviating`.
        yield any(Status.IMPLAUSIBLE & status for status in run.statuses)


def laps(count: int) -> Iterator[bool]:
    """Drive noisy laps of the race track, the same number with each controller on each plant."""
    path = track("racetrack")
    names = controllers.names()
    each = math.ceil(count / (len(names) * len(LAP_PLANTS)))
    for plant in LAP_PLANTS:
        limit = 0.5 * sim.vehicle_of(plant).wheelbase
        for seed, name in enumerate(names):
            driven = [controllers.get(name).controller(path)] * each
            found = sim.run_many(driven, plant, noise=NOISE, seed=seed)
            # The noise of the measured position may carry the error over the limit.
            errors = found["max_abs_cross_track_error"] + 5.0 * NOISE.position
            for faults, error in zip(found["faults"], errors, strict=True):
                yield is_false(Status(int(faults)), float(error), limit)


def is_wrong(driven: Drive, limit: float) -> bool:
    """Whether a drive of a car that is as told has a fault that is not so."""
    seen.update(status for _, status in driven.statuses)
    faults = Status.OK
    for _, status in driven.statuses:
        faults |= status
    return is_false(faults, driven.tracked, limit)


def healthy() -> Iterator[bool]:
    """Drive cars as told within 10 %, through noise, losses and jitter, by each controller."""
    for seed in range(HEALTHY):
        rng = random.Random(seed)
        car, speed = somebody(rng), rng.uniform(3.0, 9.0)
        law = controllers.get(NAMES[seed % len(NAMES)]).controller
        noise, periods = (0.05, 0.01, 0.05), jitter(0.5)
        # The largest of some hundred noisy measurements is farther off than the car.
        limit = 0.5 * TOLD.wheelbase - 0.2
        loop = drive(
            law, car=car, speed=speed, periods=periods, noise=noise, fresh=True, loss=0.2, seed=seed
        )
        yield is_wrong(loop, limit)


def others() -> Iterator[bool]:
    """Drive with play of the steering, onto paths that begin 8 m ahead, and small cars."""
    ahead = bends()[17:]
    xy = np.arange(0.0, 40.0, 0.05)
    narrow = np.column_stack((xy, 0.5 * np.sin(xy)))
    for name in NAMES:
        law = controllers.get(name).controller
        for degrees in (1.0, 2.0, 3.0):
            yield is_wrong(drive(law, car=Car(play=math.radians(degrees)), fresh=True), 1.35)
        yield is_wrong(drive(law, waypoints=ahead, seconds=10.0), 1.35)
        for speed in (1.0, 2.0, 3.0):
            car = Car(0.33, 0.05, 0.05, 3.0, 0.5, centre=0.165)
            loop = drive(
                law, car=car, told=SMALL, course=narrow, speed=speed, seconds=15.0, fresh=True
            )
            yield is_wrong(loop, 0.165)


def circuits() -> Iterator[bool]:
    """Drive closed splines with hairpins at 4 m/s²; the largest lateral acceleration is kept."""
    for plant in PLANTS:
        car = sim.vehicle_of(plant).replace(max_lateral_acceleration=4.0, **LIMITS)
        for seed in range(CIRCUITS):
            path = Path(circuit(seed, 1.0), closed=True)
            controller = controllers.get("preview-pop").controller(path, car)
            start = sim.default_start(path, -START_OFFSET, car)
            pedals = SpeedTracker(path, car)
            run = sim.run(controller, plant, start=start, speed=4.0, longitudinal=pedals)
            rate = np.gradient(np.unwrap(run.records["yaw"]), run.records["time"])
            # Over 0.15 s, as a gyroscope would be read; not of the start beside the path.
            lateral = np.abs(np.convolve(rate, np.ones(3) / 3.0, "same") * run.records["speed"])
            most[plant] = max(most.get(plant, 0.0), float(lateral[100:-5].max()))
            seen.update(map(Status, map(int, run.records["status"])))
            yield not run.metrics.finished or Status.IMPLAUSIBLE in run.metrics.faults


seen: Counter[Status] = Counter()
"""In how many steps each status was seen, of the drives that count them."""
most: dict[str, float] = {}
"""The largest lateral acceleration on the circuits, by plant [m/s^2]."""


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--laps", type=int, default=1000, help="noisy laps, at least")
    wanted = parser.parse_args().laps
    wrong = 0
    groups = {
        "matrix": matrix(),
        "edges": pathological(),
        "laps": laps(wanted),
        "healthy": healthy(),
        "others": others(),
        "circuits": circuits(),
    }
    for title, runs in groups.items():
        seen.clear()
        found = list(runs)
        wrong += sum(found)
        print(f"{title:8} {len(found):5} runs, {sum(found)} false alarms", flush=True)
        if seen:
            print(f"{'':8} steps: {', '.join(f'{each} {n}' for each, n in seen.most_common())}")
    print("lateral acceleration, told 4 m/s²:", {each: round(a, 2) for each, a in most.items()})
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
