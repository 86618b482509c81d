"""Runs a second of a sweep by number of workers, for the table of docs/sweep.md.

    python -m benches.sizing [RUNS]

Drives RUNS (2,000) laps of the race track by preview POP, noise and vehicle drawn as `popsteer
sweep` does by default, on threads of the core; and a twentieth of them on a plant in Python, by
processes. Run it on a machine that does nothing else.
"""

from __future__ import annotations

import os
import sys
import time

from popsteer import Path, PreviewPopParams, sim, tracks
from popsteer.lab.common.distributions import distribution
from popsteer.lab.common.varied import usual
from popsteer.lab.sweep import Job, run
from popsteer.plants import get


def job(plant: object, runs: int) -> Job:
    """Set up the sweep of a plant."""
    track = tracks.get("racetrack")
    vary = usual(sim.vehicle_of(plant), plant)
    return Job(
        Path(track.xy, speed=track.speed),
        "preview-pop",
        PreviewPopParams(),
        plant,
        {name: distribution(name, text) for name, text in vary.items()},
        runs,
    )


def main() -> None:
    """Print the table."""
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
    cores = len(os.sched_getaffinity(0))
    counts = [count for count in (1, 2, 4, 8, 16) if count <= cores]
    print(f"| runs a second | {' | '.join(map(str, counts))} |")
    print("|---|" + "---:|" * len(counts))
    for name, plant, some in (
        ("threads: carla-identified", sim.CarlaIdentified(), runs),
        ("processes: commonroad-st-2", get("commonroad-st-2"), max(runs // 20, 4)),
    ):
        rates = []
        for workers in counts:
            sweep = job(plant, some)
            begin = time.perf_counter()
            run(sweep, workers=workers)
            rates.append(some / (time.perf_counter() - begin))
        print(f"| {name} | {' | '.join(f'{rate:.3g}' for rate in rates)} |")


if __name__ == "__main__":
    main()
