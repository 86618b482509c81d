"""Searches the weights of each controller for the suite: sixteen sets each, on its car.

    python -m studies.opponents        # all of them, a quarter of an hour; writes docs/results.md
    python -m studies.opponents Lqr    # prints its grid, the least last

The score is the geometric mean of the mean error, as told and in noise. The least of an opponent's
grid is its default. popsteer's own keep their defaults, which are for other plants, too.
"""

from __future__ import annotations

import itertools
import sys
from dataclasses import replace
from typing import Any

from popsteer import controllers, lab, own
from popsteer.lab import opponents
from popsteer.lab.common.names import title_of
from popsteer.lab.suite import suite_car
from popsteer.lab.suite.runs import mean_error
from studies.layout import line, write_table

_L = suite_car().vehicle.wheelbase
GRIDS: dict[str, dict[str, tuple[float, ...]]] = {
    "preview-pop": {
        "steer_rate_cost": tuple(_L / each for each in (3.0, 6.0, 12.0, 24.0)),
        "heading_cost": tuple(_L * each for each in (0.25, 0.5, 1.0, 2.0)),
    },
    "Mpc": {"heading": (10.0, 30.0, 100.0, 300.0), "change": (0.1, 0.3, 1.0, 3.0)},
    "Lqr": {"heading": (3.0, 10.0, 30.0, 100.0), "change": (3.0, 10.0, 30.0, 100.0)},
    "RearWheelFeedback": {"decay": (0.6, 0.75, 0.9, 1.1), "damping": (0.7, 0.85, 1.0, 1.2)},
    "AutowarePurePursuit": {
        "velocity_ratio": (0.15, 0.3, 0.6, 1.2),
        "least": (2.2, 3.0, 4.35, 6.0),
    },
    "AccelerationPursuit": {"time": (0.07, 0.1, 0.2, 0.4), "least": (0.8, 1.2, 1.5, 1.8)},
    "stanley": {"cross_track_gain": (0.12, 0.25, 0.5, 1.0), "speed_gain": (1.3, 2.6, 5.0, 10.0)},
    "pure-pursuit": {
        "lookahead_gain": (0.15, 0.3, 0.6, 0.9),
        "min_lookahead": tuple(_L * each for each in (1.0, 1.5, 2.2, 3.3)),
    },
    "pop": {
        "lookahead_gain": (0.0, 0.025, 0.05, 0.1),
        "min_lookahead": tuple(_L * each for each in (0.35, 0.5, 0.7, 1.0)),
    },
    "pid": {"kp": (0.25, 0.5, 1.0, 2.0), "kd": (0.05, 0.1, 0.2, 0.5)},
}
UNDER = ("as told", "noise")


def score(name: str, params: Any) -> float:
    """Drive all scenarios, and give the geometric mean of their errors [m]."""
    return mean_error(lab.suite.run({name: params}, ["suite-car"], conditions=UNDER).cells)


def search(name: str, usual: Any) -> tuple[dict[tuple[float, ...], float], float]:
    """Score the sets of a controller's grid, and its defaults."""
    grid = GRIDS[name.rpartition(":")[2]]
    found = {}
    for pair in itertools.product(*grid.values()):
        given = dict(zip(grid, pair, strict=True))
        known = usual.replace(**given) if name in GRIDS else replace(usual, **given)
        found[pair] = score(name, known)
    return found, score(name, usual)


def main() -> None:
    """Search the grids of all or of some; print them, and write the page's table of all."""
    kinds = {name: controllers.get(name).params for name in GRIDS if name in controllers.names()}
    kinds |= {name: own.load("controller", name).Params for name in opponents.names()}
    lines = []
    for key, grid in GRIDS.items():
        if sys.argv[1:] and key not in sys.argv[1:]:
            continue
        name = next(each for each in kinds if each.rpartition(":")[2] == key)
        found, usual = search(name, kinds[name]())
        for pair in sorted(found, key=lambda each: -found[each]):
            chosen = ", ".join(f"{n} {v:.4g}" for n, v in zip(grid, pair, strict=True))
            print(f"{key}: {chosen}: {found[pair]:.4f} m", flush=True)
        lines.append(line(title_of(name), f"{usual:.4f}", f"{found[pair]:.4f}", chosen))
    if not sys.argv[1:]:
        write_table("results.md", "weights", lines)


if __name__ == "__main__":
    main()
