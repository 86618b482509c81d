"""What a table says, cell by cell, and rows of a sweep whose right answers are known by hand."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rich.text import Text

import popsteer
from popsteer.lab import sweep
from popsteer.lab.common.distributions import distribution
from popsteer.lab.sweep.summary import ERROR

if TYPE_CHECKING:
    from rich.table import Table

STRAIGHT = popsteer.Path([(float(x), 0.0) for x in range(81)], speed=[5.0] * 81)


def cells(table: Table) -> list[list[str]]:
    """Give the head and the rows of a table as plain text."""
    columns = [[column.header, *column.cells] for column in table.columns]
    plain = [[each.plain if isinstance(each, Text) else str(each) for each in c] for c in columns]
    return [list(row) for row in zip(*plain, strict=True)]


def job(**changes: Any) -> sweep.Job:
    """A sweep of four that nobody drives: its rows are `row`'s."""
    texts = {"steer_lag": "uniform(0,1)", "start_offset": "uniform(-1,1)"}
    vary = {name: distribution(name, text) for name, text in texts.items()}
    given: dict[str, Any] = {"vary": vary, "runs": 4, "seed": 3, "label": "car", **changes}
    return sweep.Job(STRAIGHT, "pop", popsteer.PopParams(), "kinematic-bicycle", **given)


def row(run: int, error: float, **changes: Any) -> dict[str, Any]:
    """A run with this greatest error after settling, ten times as much before."""
    good = {
        "run": run,
        "seed": 1000 + run,
        "success": True,
        "finished": True,
        "faults": 0,
        "steer_lag": 0.1 * run,
        "start_offset": 0.0,
        "start_yaw": 0.0,
        "time": 20.0,
        "steps": 400,
        ERROR: error,
        "max_abs_cross_track_error": 10.0 * error,
        "settled_mean_abs_cross_track_error": 0.5 * error,
        "settled_max_abs_heading_error": 0.1 * error,
        "rms_steer_rate": 2.0 * error,
    }
    return {**good, **changes}
