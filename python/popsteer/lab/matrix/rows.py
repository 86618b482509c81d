"""The rows of a matrix: one for each controller on each plant and track."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterator

    from popsteer.lab.matrix.runs import Matrix
    from popsteer.sim import Metrics


class Row(NamedTuple):
    """One controller on one plant and track."""

    plant: str
    track: str
    law: str
    metrics: Metrics
    step_time: float
    ending: str


def rows(found: Matrix) -> Iterator[Row]:
    """Give the rows in the order of the comparisons: plant by plant, track by track."""
    for comparison in found.comparisons:
        for name, run in comparison.runs.items():
            time = comparison.step_times.get(name, math.nan)
            yield Row(comparison.plant, comparison.track, name, run.metrics, time, run.ending)
