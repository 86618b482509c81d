"""Tunes the opponents for the suite: every pair of a grid, over all scenarios on its car.

    python -m studies.opponents        # all of them: five minutes
    python -m studies.opponents Lqr

The score is the geometric mean of the mean error, as told and in noise; the least of a grid is the
default of the opponent's parameters.
"""

from __future__ import annotations

import itertools
import sys
from dataclasses import replace
from typing import Any

from popsteer import lab, own
from popsteer.lab import opponents
from popsteer.lab.suite.runs import mean_error

GRIDS: dict[str, dict[str, tuple[float, ...]]] = {
    "Mpc": {"heading": (0.3, 1.0, 3.0, 10.0), "change": (1.0, 3.0, 10.0, 30.0)},
    "Lqr": {"heading": (10.0, 30.0, 100.0, 300.0), "change": (10.0, 30.0, 100.0)},
    "RearWheelFeedback": {"decay": (0.45, 0.6, 0.75, 0.9), "damping": (0.5, 0.7, 1.0)},
    "AccelerationPursuit": {"time": (0.2, 0.35, 0.5, 0.7), "least": (0.8, 1.2, 1.8)},
}
"""Autoware's pure pursuit keeps Autoware's parameters."""
UNDER = ("as told", "noise")


def score(name: str, params: Any) -> float:
    """Drive all scenarios, and give the geometric mean of their errors [m]."""
    return mean_error(lab.suite.run({name: params}, ["suite-car"], conditions=UNDER).cells)


def main() -> None:
    """Print each grid, the least last."""
    for name in opponents.names():
        kind = own.load("controller", name)
        if kind.__name__ not in (sys.argv[1:] or GRIDS) or kind.__name__ not in GRIDS:
            continue
        grid = GRIDS[kind.__name__]
        found = {
            pair: score(name, replace(kind.Params(), **dict(zip(grid, pair, strict=True))))
            for pair in itertools.product(*grid.values())
        }
        for pair in sorted(found, key=lambda each: -found[each]):
            chosen = ", ".join(f"{n} {v:g}" for n, v in zip(grid, pair, strict=True))
            print(f"{kind.__name__}: {chosen}: {found[pair]:.4f} m", flush=True)


if __name__ == "__main__":
    main()
