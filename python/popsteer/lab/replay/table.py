"""What controllers would have done along a log, as tables and for programs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from popsteer.lab.common.layout import (
    BAD,
    add_numbers,
    blank_table,
    csv_columns,
    csv_text,
    figure_names,
)
from popsteer.lab.common.names import title_of
from popsteer.lab.replay.runs import Replay, Shadow
from popsteer.status import Status

if TYPE_CHECKING:
    from rich.table import Table

FILES = (*figure_names("replay"), "replay.csv", "summary.csv")
"""The names of the files: the figure, a row for each row of the log, and the table."""
NOTE = (
    "differs: the controller's angle less the driver's, mean absolute and largest; rate: of the"
    " angle, rms; error: the cross-track error of the controller's tracked point as the driver"
    " drove. Degraded and fault: shares of the rows."
)
"""What a reader of the table has to know."""


def caption(found: Replay) -> str:
    """Say in one line what was replayed: the log, what was to be followed, and the vehicle."""
    log = found.log
    vehicle = f", vehicle {found.called}" if found.called else ""
    return (
        f"{log.name}: {log.duration:.1f} s, {len(log)} rows every {1e3 * log.period:.0f} ms, along"
        f" {found.course}{vehicle}"
    )


def replay_table(found: Replay) -> Table:
    """Set out what the controllers would have done, a row for each."""
    from rich.text import Text

    table = blank_table()
    table.add_column("", no_wrap=True)
    add_numbers(table, "differs\n[deg]", "max\n[deg]", "rate\n[deg/s]", "error\n[m]", "max\n[m]")
    add_numbers(table, "degraded\n[%]", "fault\n[%]")
    rate = f"{_rate(found, found.log.steer):.2f}"
    table.add_row("driver", "", "", rate, *[""] * 4, end_section=True)
    for shadow in found.shadows.values():
        figures = _figures(found, shadow)
        cells = (
            Text(f"{figures[key]:.{places}f}", _COLOURS.get(key, "") if figures[key] else "")
            for key, places in _SHOWN.items()
        )
        table.add_row(title_of(shadow.name, found.shadows), *cells)
    return table


_COLOURS = {"degraded_percent": "yellow", "fault_percent": BAD}
_SHOWN = {
    "mean_abs_difference_deg": 2,
    "max_abs_difference_deg": 2,
    "rms_rate_deg": 2,
    "mean_abs_cross_track_error": 3,
    "max_abs_cross_track_error": 3,
    "degraded_percent": 1,
    "fault_percent": 1,
}


def statuses(found: Replay) -> list[str]:
    """Say which conditions held how often, for each controller that was not always ok."""
    lines = []
    for name, shadow in found.shadows.items():
        held = (f"{each} {100.0 * share:.1f} %" for each, share in shadow.conditions().items())
        if said := ", ".join(held):
            lines.append(f"{title_of(name, found.shadows)}: {said}")
    return lines


def summary_csv(found: Replay) -> str:
    """Write the table as CSV: a row of names, and a row for each controller."""
    rows = (
        [name, *(f"{value:.9g}" for value in _figures(found, shadow).values())]
        for name, shadow in found.shadows.items()
    )
    return csv_text([], ["controller", *_SHOWN], rows)


def replay_csv(found: Replay) -> str:
    """Write what the controllers would have done as CSV, a row for each row of the log."""
    bits = " | ".join(f"{int(each)} {each}" for each in Status if each)
    columns = dict(found.log.as_dict())
    for shadow in found.shadows.values():
        for quantity in ("steer", "cross_track_error", "heading_error", "status"):
            columns[f"{shadow.name}.{quantity}"] = getattr(shadow, quantity)
    comment = f"SI units and radians; steer: the driver's; status: bits: {bits}"
    return csv_columns([comment], columns)


def _figures(found: Replay, shadow: Shadow) -> dict[str, float]:
    difference = np.degrees(np.abs(shadow.steer - found.log.steer))
    error = np.abs(shadow.cross_track_error)
    return {
        "mean_abs_difference_deg": float(difference.mean()),
        "max_abs_difference_deg": float(difference.max()),
        "rms_rate_deg": _rate(found, shadow.steer),
        "mean_abs_cross_track_error": float(error.mean()),
        "max_abs_cross_track_error": float(error.max()),
        "degraded_percent": 100.0 * shadow.share("degraded"),
        "fault_percent": 100.0 * shadow.share("fault"),
    }


def _rate(found: Replay, steer: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> float:
    """Rms rate of an angle, gaps left out [deg/s]."""
    keep = np.ones(len(steer) - 1, dtype=np.bool_)
    keep[np.array(found.log.gaps, dtype=np.int64) - 1] = False
    rate = (np.diff(steer) / np.diff(found.log.t))[keep]
    return math.degrees(float(np.sqrt(np.mean(rate**2)))) if len(rate) else 0.0
