"""Drives vehicles that are what controllers were told, and counts the faults that are reported.

    python -m studies.alarms              # the matrix, the edges, and 1,000 noisy laps
    python -m studies.alarms --laps 60    # fewer laps

No run may be `implausible`, and none `deviating` whose error kept its limit; the exit code is 1
where one is.
"""

from __future__ import annotations

import argparse
import math
import sys
from typing import TYPE_CHECKING

from popsteer import Status, controllers, sim
from popsteer.lab import compare
from studies import edges
from studies.layout import track

if TYPE_CHECKING:
    from collections.abc import Iterator

NAMES = ("pop", "preview-pop", "pure-pursuit", "stanley", "pid")
PLANTS = ("carla-identified", "kinematic-bicycle", "commonroad-mb-2", "mujoco-car")
TRACKS = ("racetrack", "double-lane-change", "slalom")
LAP_PLANTS = ("carla-identified", "kinematic-bicycle")
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


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--laps", type=int, default=1000, help="noisy laps, at least")
    wanted = parser.parse_args().laps
    wrong = 0
    for title, runs in (("matrix", matrix()), ("edges", pathological()), ("laps", laps(wanted))):
        found = list(runs)
        wrong += sum(found)
        print(f"{title:8} {len(found):5} runs, {sum(found)} false alarms", flush=True)
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
