"""The page of a matrix: a map for each plant and track, and the error over the time of a step."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from popsteer.lab.common.names import title_of
from popsteer.lab.matrix.runs import rows
from popsteer.lab.matrix.table import matrix_caption, matrix_notes, matrix_tables
from popsteer.lab.report.colours import colours_of, log_axis, rounded
from popsteer.lab.report.compare import scene_of
from popsteer.lab.report.markup import escape, paragraphs, table
from popsteer.lab.report.origin import Origin, settings_block, tuning, vehicles
from popsteer.lab.report.page import Page, page_bytes
from popsteer.lab.report.verdict import of_runs

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
    return page_bytes(
        Page(
            title=(
                f"{_count(len(first.runs), 'controller')} on {_count(len(plants), 'plant')} and"
                f" {_count(len(tracks), 'track')}"
            ),
            lead=matrix_caption(found),
            command=origin.command,
            results=of_runs(found.comparisons)
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
        )
    )


def _pivot(found: Matrix) -> str:
    """Set out the errors after settling: a row for each plant and track, which leads to its map."""
    names = list(found.comparisons[0].runs)
    settling = found.comparisons[0].first.settings.settling_time
    lines = []
    for place, each in enumerate(found.comparisons):
        errors = {
            name: run.metrics.settled_mean_abs_cross_track_error for name, run in each.runs.items()
        }
        best = min(
            (errors[name] for name, run in each.runs.items() if run.metrics.finished), default=None
        )
        cells = []
        for name, run in each.runs.items():
            text = f"{errors[name]:.4f}" if math.isfinite(errors[name]) else "–"
            text = text if run.metrics.finished else f"({text})"
            strong = f"<strong>{text}</strong>" if errors[name] == best else text
            cells.append(f'<td class="number">{strong}</td>')
        link = f'<a href="#drive" data-scene="{place}">{escape(each.track)}</a>'
        lines.append(
            f'<tr><th scope="row">{escape(each.plant)}</th><td>{link}</td>{"".join(cells)}</tr>'
        )
    heads = "".join(
        f'<th scope="col" class="number">{escape(title_of(name))}</th>' for name in names
    )
    label = f"Mean |cross-track error| after {settling:g} s [m]"
    return (
        f'<div class="scroll" tabindex="0" role="region" aria-label="{escape(label)}"><table>'
        f"<caption>{escape(label)}</caption><thead><tr>"
        f'<th scope="col">plant</th><th scope="col">track</th>{heads}</tr></thead>'
        f"<tbody>{''.join(lines)}</tbody></table></div>"
        + paragraphs(["In brackets: did not finish. A track leads to its map."])
    )


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def _figure(found: Matrix, plant: str) -> dict[str, Any]:
    """Draw the error over the time of a step on one plant; a marker for each track."""
    shown = [row for row in rows(found) if row.plant == plant]
    tracks = list(dict.fromkeys(row.track for row in shown))
    traces = []
    for law in dict.fromkeys(row.law for row in shown):
        own = [
            row
            for row in shown
            if row.law == law and row.metrics.settled_mean_abs_cross_track_error > 0.0
        ]
        symbols = [_MARKERS[tracks.index(row.track) % len(_MARKERS)] for row in own]
        traces.append(
            {
                "type": "scatter",
                "mode": "markers",
                "name": title_of(law),
                "x": rounded(1e6 * row.step_time for row in own),
                "y": rounded(row.metrics.settled_mean_abs_cross_track_error for row in own),
                "text": [
                    f"{row.track}{'' if row.metrics.finished else ', did not finish'}"
                    for row in own
                ],
                "marker": {
                    "color": f"@{law}",
                    "size": 11,
                    "symbol": [
                        symbol if row.metrics.finished else f"{symbol}-open"
                        for symbol, row in zip(symbols, own, strict=True)
                    ],
                },
                "hovertemplate": "%{text}: %{y:.4f} m, %{x:.2f} µs",
            }
        )
    marks = ", ".join(
        f"{track}: {_MARKERS[place % len(_MARKERS)]}" for place, track in enumerate(tracks)
    )
    settling = found.comparisons[0].first.settings.settling_time
    return {
        "title": f"Error over the time of a step, {plant}",
        "note": f"Marks by track: {marks}; open where the run did not finish.",
        "traces": traces,
        "layout": {
            "xaxis": log_axis("step, median [µs]", *_ends(traces, "x")),
            "yaxis": log_axis(
                f"mean |cross-track error| after {settling:g} s [m]", *_ends(traces, "y")
            ),
            "hovermode": "closest",
        },
    }


def _ends(traces: list[dict[str, Any]], axis: str) -> tuple[float, float]:
    values = [value for trace in traces for value in trace[axis]] or [1.0]
    return min(values), max(values)
