"""The records of a run as a CSV file."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from popsteer.lab.common.layout import csv_text
from popsteer.status import Status

if TYPE_CHECKING:
    from popsteer.sim import Run

_UNITS = {
    "time": "s",
    "x": "m",
    "y": "m",
    "yaw": "rad",
    "speed": "m/s",
    "steer": "rad",
    "throttle": "0 to 1",
    "brake": "0 to 1",
    "reference_x": "m",
    "reference_y": "m",
    "cross_track_error": "m",
    "heading_error": "rad",
    "rear_cross_track_error": "m",
    "rear_heading_error": "rad",
    "target_x": "m",
    "target_y": "m",
    "status": "bits: " + " | ".join(f"{int(each)} {each}" for each in Status if each),
}


def run_csv(run: Run) -> str:
    """Write the records of a run as CSV, a row for each control step.

    Two comments above say what was run, and the units. The numbers read back to the same bits; one
    that is not finite is ``nan``.
    """
    units = ", ".join(f"{name} [{_UNITS[name]}]" for name in run.records)
    head = f"{' '.join(run.law.split())} on {run.plant}, dt = {run.dt:g} s"
    columns = [np.asarray(column).tolist() for column in run.records.values()]
    rows = (map(repr, row) for row in zip(*columns, strict=True))
    return csv_text([head, units], run.records, rows)
