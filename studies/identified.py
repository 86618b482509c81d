"""Whether the standard errors of an identification are honest: the table of docs/identify.md.

    python -m studies.identified [SEEDS]

Two minutes of four cars, logged with new noise each time: how far the estimates scatter, over what
is stated. One is the model itself; the others have another structure, which no error can know of.
"""

from __future__ import annotations

import os
import sys
from concurrent.futures import ProcessPoolExecutor
from typing import TYPE_CHECKING, Any

import numpy as np

import popsteer
from popsteer.logs import Log
from studies.layout import line, write_table
from tests.closed_loop import drives

if TYPE_CHECKING:
    from collections.abc import Sequence

CARS = ("kinematic-bicycle", "carla-identified", "commonroad-mb-2", "mujoco-car")
NAMES = (
    *("wheelbase", "understeer", "steer_offset", "steer_lag", "dead_time", "delay"),
    *("rear_axle", "no_slip_point"),
)


def estimates(car: str, seeds: Sequence[int]) -> dict[str, np.ndarray[Any, np.dtype[np.float64]]]:
    """Give values and stated errors by parameter, (N, 2): of the seeds that state one."""
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in NAMES}
    for seed in seeds:
        each = popsteer.identify(Log(**drives.drive(car, seed=seed), name=car))
        for name, error in each.errors.items():
            if name in found:
                found[name].append((getattr(each.vehicle, name), error))
        found["delay"].append((each.delay, each.delay_error))
    return {name: np.array(pairs).reshape(-1, 2) for name, pairs in found.items()}


def error_line(car: str, seeds: Sequence[int]) -> str:
    """Set out spread over stated error of each parameter that has one, as a line of the table."""
    cells = []
    for pairs in estimates(car, seeds).values():
        if len(pairs) < max(2, len(seeds) // 2):
            cells.append("–")
            continue
        stated = float(np.sqrt(np.mean(pairs[:, 1] ** 2)))
        cells.append(f"{float(np.std(pairs[:, 0], ddof=1)) / stated:.2f}")
    return line(car, *cells)


def main() -> None:
    """Drive and identify all, two at a time, and put the table onto its page."""
    seeds = range(int(sys.argv[1]) if len(sys.argv) > 1 else 30)
    with ProcessPoolExecutor(min(2, os.cpu_count() or 1)) as pool:
        rows = []
        for row in pool.map(error_line, CARS, [seeds] * len(CARS)):
            print(row, flush=True)
            rows.append(row)
    write_table("identify.md", "errors", rows)


if __name__ == "__main__":
    main()
