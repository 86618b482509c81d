"""The page of a matrix: a map for each plant and track, and the error over the time of a step."""

from __future__ import annotations

import math
from itertools import cycle
from typing import TYPE_CHECKING, Any

from popsteer.lab.common.names import counted, title_of
from popsteer.lab.matrix.runs import rows
from popsteer.lab.matrix.table import matrix_caption, matrix_notes, matrix_tables
from popsteer.lab.report.colours import colours_of, dots, figure, log_axis
from popsteer.lab.report.compare import scene_of, verdict
from popsteer.lab.report.markup import escape, html_table, paragraphs, table
from popsteer.lab.report.origin import Origin, settings_block, tuning, vehicles
from popsteer.lab.report.page import Page

if TYPE_CHECKING:
    from popsteer.lab.matrix import Matrix

_MARKERS = ("circle", "square", "diamond", "triangle-up", "cross", "star", "hexagon", "x")


def of_matrix(found: Matrix, origin: Origin | None = None) -> bytes:
    """Make the page of a matrix.

    The page is one HTML file, which needs nothing from the network. `origin` is the command and the
    parameters that made it. Raises ConfigError where the runs kept no records, and
    ModuleNotFoundError where plotly is not installed; the extra ``lab`` brings it.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer.lab import matrix
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> page = of_matrix(matrix.run({"straight": path}, ["pop"], ["kinematic-bicycle"]))
    >>> page.startswith(b"<!doctype html>")
    True
    """
    origin = Origin() if origin is None else origin
    first = found.comparisons[0]
    plants = dict.fromkeys(each.plant for each in found.comparisons)
    tracks = dict.fromkeys(each.track for each in found.comparisons)
    results = "".join(table(each, "Error and step time") for each in matrix_tables(found))
    return Page(
        title=(
            f"{counted(len(first.runs), 'controller')} on {counted(len(plants), 'plant')} and"
            f" {counted(len(tracks), 'track')}"
        ),
        lead=matrix_caption(found),
        command=origin.command,
        results=verdict(found.comparisons)
        + _pivot(found)
        + paragraphs(matrix_notes(found))
        + f"<details><summary>All figures</summary>{results}</details>",
        scenes=[scene_of(each) for each in found.comparisons],
        choice="Plant, track",
        figures=[_figure(found, plant) for plant in plants],
        roles=colours_of(first.runs),
        sections=[
            vehicles(
                {each.plant: each.vehicle for each in found.comparisons},
                {each.plant: each.believed for each in found.comparisons},
            ),
            tuning(origin, settings_block(first.first.settings)),
        ],
    ).content()


def _pivot(found: Matrix) -> str:
    """Set out the errors after settling: a row for each plant and track, which leads to its map."""
    names = list(found.comparisons[0].runs)
    settling = found.comparisons[0].first.settings.settling_time
    rows = []
    for place, each in enumerate(found.comparisons):
        errors = [run.metrics.settled_mean_abs_cross_track_error for run in each.runs.values()]
        ended = [run.metrics.finished for run in each.runs.values()]
        best = min((error for error, good in zip(errors, ended, strict=True) if good), default=None)
        cells = []
        for error, good in zip(errors, ended, strict=True):
            text = f"{error:.4f}" if math.isfinite(error) else "–"
            text = text if good else f"({text})"
            cells.append(f"<strong>{text}</strong>" if error == best else text)
        link = f'<a href="#drive" data-scene="{place}">{escape(each.track)}</a>'
        rows.append([escape(each.plant), link, *cells])
    return html_table(
        f"Mean |cross-track error| after {settling:g} s [m]",
        ["plant", "track", *map(title_of, names)],
        rows,
        [False, False, *[True] * len(names)],
    ) + paragraphs(["In brackets: did not finish. A track leads to its map."])


def _figure(found: Matrix, plant: str) -> dict[str, Any]:
    """Draw the error over the time of a step on one plant; a marker for each track."""
    shown = [row for row in rows(found) if row.plant == plant]
    tracks = dict.fromkeys(row.track for row in shown)
    symbols = dict(zip(tracks, cycle(_MARKERS), strict=False))
    traces = []
    for law in dict.fromkeys(row.law for row in shown):
        own = [
            (row, row.metrics.settled_mean_abs_cross_track_error, row.metrics.finished)
            for row in shown
            if row.law == law and row.metrics.settled_mean_abs_cross_track_error > 0.0
        ]
        ends = ["" if good else ", did not finish" for _, _, good in own]
        marker = {
            "color": f"@{law}",
            "size": 11,
            "symbol": [f"{symbols[row.track]}{'' if good else '-open'}" for row, _, good in own],
        }
        traces.append(
            dots(
                title_of(law),
                [1e6 * row.step_time for row, _, _ in own],
                [error for _, error, _ in own],
                [row.track + end for (row, _, _), end in zip(own, ends, strict=True)],
                marker,
                "%{text}: %{y:.4f} m, %{x:.2f} µs",
            )
        )
    marks = ", ".join(f"{track}: {symbol}" for track, symbol in symbols.items())
    settling = found.comparisons[0].first.settings.settling_time
    title = f"mean |cross-track error| after {settling:g} s [m]"
    return figure(
        f"Error over the time of a step, {plant}",
        f"Marks by track: {marks}; open where the run did not finish.",
        traces,
        log_axis("step, median [µs]", *_ends(traces, "x")),
        log_axis(title, *_ends(traces, "y")),
        hovermode="closest",
    )


def _ends(traces: list[dict[str, Any]], axis: str) -> tuple[float, float]:
    values = [value for trace in traces for value in trace[axis]] or [1.0]
    return min(values), max(values)
