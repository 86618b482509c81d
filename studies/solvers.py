"""Times the MPC's quadratic problem as daqp itself does, beside the call and preview POP's step.

python -m studies.solvers
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np

import popsteer
from popsteer.lab.bench.states import DT, at_hand
from popsteer.lab.opponents.mpc import Mpc, Weights
from studies.layout import ROOT, line, write_blocks

if TYPE_CHECKING:
    from collections.abc import Sequence


def measure() -> dict[str, list[float]]:
    """Drive the recorded states; give the times of each step [s]."""
    drive = at_hand()
    mpc = Mpc(drive.path, drive.vehicle, Weights())
    ours = popsteer.PreviewPop(drive.path, drive.vehicle)
    times: dict[str, list[float]] = {"daqp, its own": [], "daqp, called": [], "preview POP": []}
    for state in drive.states:
        mpc.update(*state, DT)
        begun = time.perf_counter()
        mpc.solve()
        middle = time.perf_counter()
        ours.steer(*state, DT)
        times["preview POP"].append(time.perf_counter() - middle)
        times["daqp, called"].append(middle - begun)
        times["daqp, its own"].append(mpc.said["solve_time"])
    return times


def solver_lines(times: dict[str, list[float]]) -> list[str]:
    """Set out medians and tails [us]."""

    def cells(name: str, values: Sequence[float]) -> str:
        found = 1e6 * np.quantile(values, (0.5, 0.99))
        return line(name, *(f"{each:.2f}" for each in found))

    return [
        line("call", "p50 [µs]", "p99 [µs]"),
        "|---|--:|--:|",
        cells("the quadratic problem by daqp, its own `solve_time`", times["daqp, its own"]),
        cells("the same, as called from Python", times["daqp, called"]),
        cells("preview POP's whole step, as called from Python", times["preview POP"]),
    ]


if __name__ == "__main__":
    lines = solver_lines(measure())
    print("\n".join(lines))
    write_blocks(ROOT / "benches" / "README.md", {"solvers": "\n".join(lines)})
