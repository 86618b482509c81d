"""The table and the files of controllers × plants × tracks."""

from __future__ import annotations

import math
from functools import partial
from statistics import median
from typing import TYPE_CHECKING

from popsteer._core import __version__
from popsteer.lab.common.layout import (
    SIGN,
    WIDE,
    add_names,
    add_numbers,
    blank_table,
    csv_text,
    figure_names,
    fits,
    json_text,
    outcome,
)
from popsteer.lab.common.machine import describe
from popsteer.lab.common.names import title_of
from popsteer.lab.compare.files import SCHEMA, metrics_document
from popsteer.lab.matrix.runs import Matrix, Row, rows

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.table import Table

    from popsteer.sim import Metrics

FILES = ("matrix.csv", "matrix.md", "matrix.json", *figure_names("matrix"))
"""The names of the files that `matrix_files` gives."""

_REAR = "rear_axle_settled_mean_abs_cross_track_error"
_COLUMNS = (
    "mean_abs_cross_track_error",
    "settled_mean_abs_cross_track_error",
    "settled_max_abs_cross_track_error",
    _REAR,
)


def matrix_caption(found: Matrix) -> str:
    """Say in one line what was driven: control period, and what the figures are."""
    first = found.comparisons[0]
    return (
        f"dt {first.dt:g} s; |cross-track error| at the point that each controller tracks, of the"
        f" whole run and after {first.first.settings.settling_time:g} s, and then at the rear axle,"
        " one point for all; median time of a step"
    )


def matrix_tables(found: Matrix, width: int = WIDE) -> list[Table]:
    """Set out a row for each combination, in one table of `width` or else one a plant and track."""
    shown = list(rows(found))
    whole = _table(shown)
    if fits(whole, width):
        return [whole]
    courses = dict.fromkeys((row.plant, row.track) for row in shown)
    return [
        _table([row for row in shown if (row.plant, row.track) == course], course)
        for course in courses
    ]


def _table(shown: Sequence[Row], course: tuple[str, str] | None = None) -> Table:
    """Set out some rows: with columns for plant and track, or with both as the title."""
    table = blank_table(2 if course is None else 0)
    if course is None:
        add_names(table, "plant", (row.plant for row in shown))
        add_names(table, "track", (row.track for row in shown))
    else:
        table.title = "plant {} | track {}".format(*course)
        table.title_justify, table.title_style = "left", "bold"
    add_names(table, "controller", (title_of(row.law) for row in shown))
    table.add_column("outcome", overflow="fold")
    add_names(table, "tuning", (row.tuning for row in shown))
    add_names(table, "errors\nat", (row.point for row in shown))
    heads = (
        "mean\n[m]",
        "after\n[m]",
        "max\nafter\n[m]",
        "rear\naxle\n[m]",
        "step\n[µs]",
    )
    add_numbers(table, *heads)
    for row in shown:
        figures = row.metrics
        table.add_row(
            *((row.plant, row.track) if course is None else ()),
            title_of(row.law),
            outcome(figures.faults, finished=figures.finished),
            row.tuning,
            row.point,
            f"{figures.mean_abs_cross_track_error:.4f}",
            f"{figures.settled_mean_abs_cross_track_error:.4f}",
            f"{figures.settled_max_abs_cross_track_error:.3f}",
            f"{getattr(figures, _REAR):.4f}",
            f"{1e6 * row.step_time:.2f}",
        )
    return table


def matrix_notes(found: Matrix) -> list[str]:
    """Say where the runs start, and of each that did not reach the end why."""
    return [
        f"{SIGN} {title_of(row.law)} on {row.plant}, {row.track}, ended after"
        f" {row.metrics.time:.1f} s: {row.ending}."
        for row in rows(found)
        if not row.metrics.finished
    ] + [*dict.fromkeys(each.begins for each in found.comparisons)]


def matrix_files(found: Matrix) -> dict[str, bytes]:
    """Compute the files, by the names of `FILES`."""
    from popsteer.lab.common.draw import files_of
    from popsteer.lab.matrix.figures import matrix_figure

    content = files_of({"matrix": partial(matrix_figure, found)})
    content["matrix.csv"] = _csv(found).encode()
    content["matrix.md"] = _markdown(found).encode()
    document = {
        "schema": SCHEMA,
        "version": __version__,
        "machine": describe(),
        "constant_speed": found.constant_speed,
        "comparisons": [metrics_document(each) for each in found.comparisons],
    }
    content["matrix.json"] = json_text(document).encode()
    return content


def _csv(found: Matrix) -> str:
    lines = []
    for row in rows(found):
        numbers = (*(getattr(row.metrics, column) for column in _COLUMNS), row.step_time)
        lines.append(
            [
                row.plant,
                row.track,
                row.law,
                row.tuning,
                row.point,
                *map(repr, numbers),
                row.ending,
            ]
        )
    names = ("plant", "track", "law", "tuning", "errors_at", *_COLUMNS, "step_time", "ending")
    return csv_text(["errors in m, step_time in s"], names, lines)


def _markdown(found: Matrix) -> str:
    """Set out a table for each track: errors after settling, where measured / at the rear axle."""
    plants = list(dict.fromkeys(each.plant for each in found.comparisons))
    shown = list(rows(found))
    tables = []
    for track in dict.fromkeys(row.track for row in shown):
        rules = ["--:"] * (len(plants) + 1)
        lines = [[track, "errors at", *plants, "step [µs]"], ["---", "---", *rules]]
        for law in dict.fromkeys(row.law for row in shown):
            own = [row for row in shown if (row.track, row.law) == (track, law)]
            errors = ([_error(row.metrics, name) for name in (_COLUMNS[1], _REAR)] for row in own)
            points = ", ".join(dict.fromkeys(row.point for row in own))
            time = f"{1e6 * median(row.step_time for row in own):.2f}"
            lines.append([title_of(law), points, *map(" / ".join, errors), time])
        tables.append("".join(f"| {' | '.join(line)} |\n" for line in lines))
    on = describe()
    return "\n".join([*tables, f"{on['cpu']}, {on['cores']} cores; {on['python']}.\n"])


def _error(metrics: Metrics, name: str) -> str:
    """Show a mean error after settling; of a run that did not finish in brackets."""
    error = getattr(metrics, name)
    if not math.isfinite(error):
        return "–"
    return f"{error:.4f}" if metrics.finished else f"({error:.4f})"
