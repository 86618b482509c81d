"""Whether the standard errors of an identification are honest: the table of docs/identify.md.

    python -m studies.identified [SEEDS]

Two minutes of four cars, of which one is the model itself. The same drive, logged again with new
noise: how far the estimates scatter, over the stated error of noise. And drives that differ, as the
noise steers: the scatter over both stated errors together.
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
FIRST_LOG = 1000
"""The noise of a log is not what Stanley was given."""
NAMES = (
    *("wheelbase", "understeer", "steer_offset", "steer_lag", "dead_time", "delay"),
    *("rear_axle", "no_slip_point"),
)


def estimates(
    car: str, seeds: Sequence[int], *, again: bool
) -> dict[str, np.ndarray[Any, np.dtype[np.float64]]]:
    """Give values and stated errors by parameter, (N, 2): of the seeds that state one."""
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in NAMES}
    for seed in seeds:
        which = {"logged": FIRST_LOG + seed} if again else {"seed": seed}
        each = popsteer.identify(Log(**drives.drive(car, **which), name=car))
        noise = {**each.errors, "delay": each.delay_error}
        stated = noise if again else drives.whole_errors(each)
        for name in noise.keys() & found.keys():
            value = each.delay if name == "delay" else getattr(each.vehicle, name)
            found[name].append((value, stated[name]))
    return {name: np.array(pairs).reshape(-1, 2) for name, pairs in found.items()}


def error_line(car: str, seeds: Sequence[int], again: bool) -> str:  # noqa: FBT001 - for map
    """Set out spread over stated error of each parameter that has one, as a line of the table."""
    cells = []
    for pairs in estimates(car, seeds, again=again).values():
        if len(pairs) < max(2, len(seeds) // 2):
            cells.append("–")
            continue
        stated = float(np.sqrt(np.mean(pairs[:, 1] ** 2)))
        cells.append(f"{float(np.std(pairs[:, 0], ddof=1)) / stated:.2f}")
    return line(car, "logged again" if again else "driven anew", *cells)


def main() -> None:
    """Drive and identify all, two at a time, and put the table onto its page."""
    seeds = range(int(sys.argv[1]) if len(sys.argv) > 1 else 60)
    with ProcessPoolExecutor(min(2, os.cpu_count() or 1)) as pool:
        rows, count = [], 2 * len(CARS)
        cars, which = np.repeat(CARS, 2).tolist(), [True, False] * len(CARS)
        for row in pool.map(error_line, cars, [seeds] * count, which):
            print(row, flush=True)
            rows.append(row)
    write_table("identify.md", "errors", rows)


if __name__ == "__main__":
    main()
