"""Limits of axes that several runs share."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable

    from popsteer.sim import Run


def limit(run: Run, record: str) -> float:
    """Bound what a record does once the start has died out.

    The start, metres beside the path, would leave the rest a flat line; and a run that leaves the
    road would do so to the other controllers. The bound is the largest absolute value after the
    settling time, and at least a fifth of the largest of all; 0 of a run that did not finish.
    """
    if not run.metrics.finished:
        return 0.0
    values = np.abs(run.records[record])
    settled = values[run.records["time"] >= run.settings.settling_time]
    return float(max(settled.max(initial=0.0), 0.2 * values.max(initial=0.0)))


def nice_limit(limits: Iterable[float]) -> float:
    """Round the largest of some bounds up, with room for a note.

    It is at least 1.35 times the largest, in steps of two digits; 1 where all are 0.
    """
    largest = 1.35 * max(limits)
    if largest <= 0.0:
        return 1.0
    step = 10.0 ** (math.floor(math.log10(largest)) - 1)
    return round(math.ceil(largest / step) * step, 12)
