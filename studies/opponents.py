"""Searches the weights of each controller for the suite, forty sets each, preview POP's like all.

    python -m studies.opponents        # all of them, ten minutes or more; writes docs/results.md
    python -m studies.opponents Lqr    # one of them

The score is the geometric mean of the mean error in all scenarios on the suite's car, as told and
in noise. The first set is the defaults; the others, an eighth to eight times of them, are proposed
by a tree-structured Parzen estimator: J. Bergstra et al., *Algorithms for Hyper-Parameter
Optimization*, 2011.
"""

from __future__ import annotations

import sys
import warnings
from dataclasses import replace
from functools import partial
from typing import Any

import optuna

from popsteer import controllers, lab, own
from popsteer.lab import opponents
from popsteer.lab.common.names import title_of
from popsteer.lab.suite import suite_car
from popsteer.lab.suite.runs import Cell, mean_error
from studies.layout import cells, line, table, write_table

SEARCHED = {
    "preview-pop": ("steer_rate_cost", "heading_cost"),
    "Mpc": ("heading", "change"),
    "Lqr": ("heading", "change"),
    "RearWheelFeedback": ("decay", "damping"),
    "AutowarePurePursuit": ("velocity_ratio", "least"),
    "AccelerationPursuit": ("time", "least"),
    "stanley": ("cross_track_gain", "speed_gain"),
    "pure-pursuit": ("lookahead_gain", "min_lookahead"),
    "pop": ("lookahead_gain", "min_lookahead"),
    "pid": ("kp", "kd"),
}
SETS, WIDTH = 40, 8.0
UNDER = ("as told", "noise")


class Searched:
    """A controller with the two of its parameters that are searched."""

    def __init__(self, key: str) -> None:
        self.fields = SEARCHED[key]
        self.usual: Any  # as the suite's car resolves what is given
        self.given: Any
        if key in controllers.names():
            self.name, self.given = key, controllers.get(key).params()
            self.usual = self.given.resolved(suite_car().vehicle)
        else:
            (self.name,) = [each for each in opponents.names() if each.endswith(f":{key}")]
            self.usual = self.given = own.load("controller", self.name).Params()

    def values(self, params: Any) -> dict[str, float]:
        """Give what is searched."""
        return {field: getattr(params, field) for field in self.fields}

    def drive(self, values: dict[str, float], **which: Any) -> list[Cell]:
        """Drive the suite, or a part of it, with values of what is searched."""
        known = self.given
        if values != self.values(self.usual):
            is_ours = self.name in controllers.names()
            known = (self.usual.replace if is_ours else partial(replace, self.usual))(**values)
        return list(lab.suite.run({self.name: known}, **which).cells)

    def search(self) -> list[tuple[float, dict[str, float]]]:
        """Give the sets that were tried with their scores [m], the best last."""
        begin = self.values(self.usual)
        ranges = getattr(self.usual, "RANGES", {})

        def score(trial: optuna.Trial) -> float:
            values = {}
            for field, value in begin.items():
                low, high = ranges.get(field, (0.0, float("inf")))
                ends = max(value / WIDTH, low), min(value * WIDTH, high)
                values[field] = trial.suggest_float(field, *ends, log=True)
            return mean_error(self.drive(values, plants=["suite-car"], conditions=UNDER))

        optuna.logging.set_verbosity(optuna.logging.ERROR)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
            sampler = optuna.samplers.TPESampler(seed=0, multivariate=True)
        study = optuna.create_study(sampler=sampler)
        study.enqueue_trial(begin)
        study.optimize(score, SETS)
        tried = [(each.value or 0.0, dict(each.params)) for each in study.trials]
        return sorted(tried, key=lambda each: -each[0])


def worded(values: dict[str, float]) -> str:
    """Word a set."""
    return ", ".join(f"{name} {value:.2g}" for name, value in values.items())


def weights_line(key: str) -> str:
    """Search a controller's weights; give scores, whole suites and efforts, before and after."""
    each = Searched(key)
    tried = each.search()
    for score, values in tried:
        print(f"{key}: {worded(values)}: {score:.4f} m", flush=True)
    row = [title_of(each.name)]
    begin = each.values(each.usual)
    for values in (begin, tried[-1][1]):
        driven = each.drive(values)
        searched = [
            cell for cell in driven if cell.plant == "suite-car" and cell.condition in UNDER
        ]
        effort = sum(cell.steer_rate for cell in driven) / len(driven)
        figures = (f"{mean_error(searched):.4f}", f"{mean_error(driven):.4f}", f"{effort:.2f}")
        row += [worded(values), *figures]
    found = line(*row)
    print(found, flush=True)
    return found


def main() -> None:
    """Search all or some; write their rows of the page's table."""
    rows = {cells(row)[0]: row for row in table("results.md", "weights")}
    for key in SEARCHED:
        if key in (sys.argv[1:] or SEARCHED):
            found = weights_line(key)
            rows[cells(found)[0]] = found
    write_table("results.md", "weights", list(rows.values()))


if __name__ == "__main__":
    main()
