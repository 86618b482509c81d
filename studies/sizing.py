"""Runs a second of a sweep by number of workers, for the table of docs/sweep.md.

    python -m studies.sizing [RUNS]

Drives RUNS (2,000) laps of the race track by preview POP, noise and vehicle drawn as `popsteer
sweep` does by default, on threads of the core; and a twentieth of them on a plant in Python, by
processes. Run it on a machine that does nothing else.
"""

from __future__ import annotations

import os
import sys
import time
from typing import TYPE_CHECKING, Any

from popsteer import PreviewPopParams, sim
from popsteer.lab.common.varied import distribution, usual
from popsteer.lab.sweep import Job, run
from popsteer.plants import get
from studies.layout import track

if TYPE_CHECKING:
    from collections.abc import Mapping


def job(plant: sim.Plant, runs: int, vary: Mapping[str, str] | None = None, **options: Any) -> Job:
    """Set up a sweep of a plant by preview POP, with what usually varies changed by `vary`."""
    texts = usual(sim.vehicle_of(plant), plant) | dict(vary or {})
    drawn = {name: distribution(name, text) for name, text in texts.items()}
    path, params = track("racetrack"), PreviewPopParams()
    return Job(path, "preview-pop", params, plant, drawn, runs, **options)


def main() -> None:
    """Print the table."""
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
    cores = len(os.sched_getaffinity(0))
    counts = [count for count in (1, 2, 4, 8, 16) if count <= cores]
    print(f"| runs a second, by number of workers | {' | '.join(map(str, counts))} |")
    print("|---|" + "---:|" * len(counts))
    plant = sim.CarlaIdentified()
    run(job(plant, 4))  # loads what it needs
    wall, busy = zip(*(_rates(plant, runs, count) for count in counts), strict=True)
    print(f"| carla-identified, threads | {' | '.join(wall)} |")
    print(f"| the same, for each second of CPU time | {' | '.join(busy)} |")
    other = get("commonroad-st-2")
    wall, _ = zip(*(_rates(other, max(runs // 20, 4), count) for count in counts), strict=True)
    print(f"| commonroad-st-2, processes | {' | '.join(wall)} |")


def _rates(plant: sim.Plant, runs: int, workers: int) -> tuple[str, str]:
    """Runs for each second of the clock, and of this process's CPU time."""
    sweep = job(plant, runs)
    begin, used = time.perf_counter(), time.process_time()
    run(sweep, workers=workers)
    passed, used = time.perf_counter() - begin, time.process_time() - used
    return f"{runs / passed:.3g}", f"{runs / used:.3g}"


if __name__ == "__main__":
    main()
