"""The table of dead times, for people and for programs."""

from __future__ import annotations

import math
from dataclasses import asdict, fields
from typing import TYPE_CHECKING

from popsteer._core import __version__
from popsteer.lab.common.layout import (
    WIDE,
    add_names,
    add_numbers,
    blank_table,
    csv_text,
    json_text,
)
from popsteer.lab.common.names import title_of
from popsteer.lab.delay.runs import DEAD_TIME_PLANT, DeadTimeRow
from popsteer.sim import plant_name

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.table import Table

    from popsteer.sim import CarlaIdentified, KinematicBicycle, Metrics, Plant

__all__ = ["delay_caption", "delay_csv", "delay_json", "delay_tables", "error_text"]

SCHEMA = 2
"""Version of the document's layout."""
_RUNS = tuple(field.name for field in fields(DeadTimeRow) if field.name not in ("law", "dead_time"))
_ERRORS = ("mean_abs_cross_track_error", "max_abs_cross_track_error")
_HEADS = {
    "prompt": "no dead\ntime [m]",
    "late": "not\npredicted [m]",
    "predicted": "\npredicted [m]",
    "short": "wheelbase\n−15 % [m]",
    "long": "wheelbase\n+15 % [m]",
    "early": "dead time\n−50 ms [m]",
    "later": "dead time\n+50 ms [m]",
}


def delay_caption(rows: Sequence[DeadTimeRow], track: str, plant: Plant = DEAD_TIME_PLANT) -> str:
    """Say in one line what was driven, on which track and plant, and what the figures are.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer.lab import delay
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> delay_caption(delay.run(path, ["pop"]), "straight")
    'straight, plant carla-identified, dead time 0.2 s; mean |cross-track error| of the whole run, \
and its ratio to that without dead time'
    """
    return (
        f"{track}, plant {plant_name(plant)}, dead time {rows[0].dead_time:g} s; mean |cross-track"
        " error| of the whole run, and its ratio to that without dead time"
    )


def error_text(row: DeadTimeRow, found: Metrics) -> str:
    """Say the error of one of a row's runs, and its ratio to that without dead time.

    Such as "0.173 (1.00)"; "off the road" where the run did not finish.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer.lab import delay
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> row = delay.run(path, ["pop"])[0]
    >>> error_text(row, row.prompt).endswith("(1.00)")
    True
    """
    if not found.finished:
        return "off the road"
    return f"{found.mean_abs_cross_track_error:.3f} ({row.ratio(found):.2f})"


def delay_tables(rows: Sequence[DeadTimeRow], width: int = WIDE) -> list[Table]:
    """Set out the runs, a row for each controller.

    Where one table would not fit into `width` characters, there are two.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer.lab import delay
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> [table.row_count for table in delay_tables(delay.run(path, ["pop"]), width=80)]
    [1, 1]
    """
    right, wrong = _RUNS[:3], _RUNS[3:]
    groups = [_RUNS] if width >= WIDE else [right, wrong]
    return [_table(rows, runs) for runs in groups]


def _table(rows: Sequence[DeadTimeRow], runs: Sequence[str]) -> Table:
    """Set out some of the runs."""
    table = blank_table()
    add_names(table, "controller", (title_of(row.law) for row in rows))
    add_numbers(table, *(_HEADS[run] for run in runs))
    for row in rows:
        cells = [
            f"{row.prompt.mean_abs_cross_track_error:.3f}"
            if run == "prompt"
            else error_text(row, getattr(row, run))
            for run in runs
        ]
        table.add_row(title_of(row.law), *cells)
    return table


def delay_csv(rows: Sequence[DeadTimeRow]) -> str:
    """Write the runs as CSV, a row for each controller and run.

    The ratio is empty where the run did not finish.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer.lab import delay
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> len(delay_csv(delay.run(path, ["pop"])).splitlines())
    9
    """
    lines = []
    for row in rows:
        for run in _RUNS:
            found = getattr(row, run)
            ratio = row.ratio(found)
            errors = (getattr(found, name) for name in _ERRORS)
            cells = (row.law, repr(row.dead_time), run, str(found.finished).lower())
            shown = repr(ratio) if math.isfinite(ratio) else ""
            lines.append((*cells, *map(repr, errors), shown))
    names = ("law", "dead_time", "run", "finished", *_ERRORS, "ratio")
    return csv_text(["dead_time in s, errors in m"], names, lines)


def delay_json(
    rows: Sequence[DeadTimeRow],
    track: str,
    plant: CarlaIdentified | KinematicBicycle = DEAD_TIME_PLANT,
) -> str:
    """Write the runs as JSON with all their metrics, in SI units and radians.

    What is no number is null.

    Examples
    --------
    >>> import json
    >>> import popsteer
    >>> from popsteer.lab import delay
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> json.loads(delay_json(delay.run(path, ["pop"]), "straight"))["laws"][0]["law"]
    'pop'
    """
    document = {
        "schema": SCHEMA,
        "version": __version__,
        "track": track,
        "plant": plant_name(plant),
        "plant_vehicle": plant.vehicle.as_dict(),
        "laws": [
            {
                "law": row.law,
                "dead_time": row.dead_time,
                "runs": {run: _figures(row, getattr(row, run)) for run in _RUNS},
            }
            for row in rows
        ],
    }
    return json_text(document)


def _figures(row: DeadTimeRow, found: Metrics) -> dict[str, float | int | bool | None]:
    figures = {**asdict(found), "ratio": row.ratio(found)}
    return {name: value if math.isfinite(value) else None for name, value in figures.items()}
