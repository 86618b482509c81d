"""The table, the files and the figure of laws × plants × tracks."""

from __future__ import annotations

import io
import math
from statistics import median
from typing import TYPE_CHECKING, NamedTuple

from popsteer._core import __version__
from popsteer.bench.machine import describe
from popsteer.report.layout import blank_table, json_text
from popsteer.report.metrics_json import SCHEMA, metrics_document
from popsteer.report.table import title_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from matplotlib.figure import Figure
    from rich.table import Table

    from popsteer.report.figures.theme import Theme
    from popsteer.sim import Metrics
    from popsteer.study.matrix import Matrix

__all__ = ["matrix_files", "matrix_table"]

_COLUMNS = (
    "mean_abs_cross_track_error",
    "settled_mean_abs_cross_track_error",
    "settled_max_abs_cross_track_error",
)
_MARKERS = "osD^vP*X"


class _Row(NamedTuple):
    """One law on one plant and track."""

    plant: str
    track: str
    law: str
    metrics: Metrics
    step_time: float
    ending: str


def _rows(found: Matrix) -> Iterator[_Row]:
    for comparison in found.comparisons:
        for name, run in comparison.runs.items():
            time = comparison.step_times[name]
            yield _Row(comparison.plant, comparison.track, name, run.metrics, time, run.ending)


def matrix_table(found: Matrix) -> Table:
    """Set out what was found, a row for each law on each plant and track.

    Parameters
    ----------
    found : Matrix
        What was measured.

    Returns
    -------
    rich.table.Table
        To be printed.
    """
    table = blank_table()
    for head in ("plant", "track", "law"):
        table.add_column(head, no_wrap=True)
    for head in ("mean |e|\n[m]", "after 5 s\n[m]", "max after\n[m]", "step p50\n[µs]"):
        table.add_column(head, justify="right", no_wrap=True)
    table.add_column("ending", overflow="fold")
    for row in _rows(found):
        figures = row.metrics
        table.add_row(
            row.plant,
            row.track,
            title_of(row.law),
            f"{figures.mean_abs_cross_track_error:.4f}",
            f"{figures.settled_mean_abs_cross_track_error:.4f}",
            f"{figures.settled_max_abs_cross_track_error:.3f}",
            f"{1e6 * row.step_time:.2f}",
            row.ending,
        )
    return table


def matrix_files(found: Matrix) -> dict[str, bytes]:
    """Compute the files.

    Parameters
    ----------
    found : Matrix
        What was measured.

    Returns
    -------
    dict
        The content of each file by its name: ``matrix.csv`` (a row for each law on each plant and
        track), ``matrix.json`` (all their metrics), ``matrix.md`` (the errors after settling, a
        column for each law; of runs that did not finish in brackets), and ``matrix`` as ``.png``
        and ``.svg``, the figure of error against step time, for a light and, as ``-dark``, for a
        dark background.
    """
    from popsteer.report.figures.theme import THEMES

    content = {
        f"matrix{'' if name == 'light' else f'-{name}'}.{kind}": data
        for name, theme in THEMES.items()
        for kind, data in _drawn(found, theme).items()
    }
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
    lines = [
        "# errors in m, step_time in s",
        ",".join(("plant", "track", "law", *_COLUMNS, "step_time", "ending")),
    ]
    for row in _rows(found):
        figures = row.metrics
        numbers = (*(getattr(figures, column) for column in _COLUMNS), row.step_time)
        ending = row.ending.replace('"', '""')
        cells = [row.plant, row.track, row.law, *map(repr, numbers), f'"{ending}"']
        lines.append(",".join(cells))
    return "\n".join(lines) + "\n"


def _markdown(found: Matrix) -> str:
    """Set out the errors after settling, and what a step takes on an average plant and track."""
    names = list(found.comparisons[0].runs)
    lines = [
        ["plant", "track", *map(title_of, names)],
        ["---", "---", *["--:"] * len(names)],
    ]
    for each in found.comparisons:
        cells = [_error(run.metrics) for run in each.runs.values()]
        lines.append([each.plant, each.track, *cells])
    times = [median(each.step_times[name] for each in found.comparisons) for name in names]
    lines.append(["step, median [µs]", "", *(f"{1e6 * time:.2f}" for time in times)])
    on = describe()
    table = "".join(f"| {' | '.join(line)} |\n" for line in lines)
    return f"{table}\n{on['cpu']}, {on['cores']} cores; {on['python']}.\n"


def _error(metrics: Metrics) -> str:
    """Show the mean error after settling; of a run that did not finish in brackets."""
    error = metrics.settled_mean_abs_cross_track_error
    if not math.isfinite(error):
        return "–"
    return f"{error:.4f}" if metrics.finished else f"({error:.4f})"


def _drawn(found: Matrix, theme: Theme) -> dict[str, bytes]:
    import matplotlib as mpl

    content = {}
    with mpl.rc_context(theme.settings):
        figure = _figure(found, theme)
        for kind, metadata in (("png", {"Software": None}), ("svg", {"Date": None})):
            stream = io.BytesIO()
            figure.savefig(stream, format=kind, dpi=150, metadata=metadata)
            content[kind] = stream.getvalue()
    return content


def _figure(found: Matrix, theme: Theme) -> Figure:
    """Draw a panel for each plant: a colour for each law, a marker for each track."""
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    rows = list(_rows(found))
    plants = list(dict.fromkeys(row.plant for row in rows))
    tracks = list(dict.fromkeys(row.track for row in rows))
    colours = theme.colours(dict.fromkeys(row.law for row in rows))
    markers = {track: _MARKERS[k % len(_MARKERS)] for k, track in enumerate(tracks)}
    across = len(plants) if len(plants) <= 3 else math.ceil(len(plants) / 2)
    down = math.ceil(len(plants) / across)
    figure = Figure(figsize=(max(4.2 * across, 7.0), 3.1 * down + 1.2), layout="constrained")
    grid = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True)
    for spare in grid.flat[len(plants) :]:
        spare.set_visible(False)
    for panel, plant in zip(grid.flat, plants, strict=False):
        for row in rows:
            error = row.metrics.settled_mean_abs_cross_track_error
            if row.plant != plant or not error > 0.0:
                continue
            colour = colours[row.law]
            panel.plot(
                1e6 * row.step_time,
                error,
                markers[row.track],
                color=colour,
                # Hollow: what it did until it came to an end tells little.
                markerfacecolor=colour if row.metrics.finished else theme.background,
                markeredgecolor=theme.background if row.metrics.finished else colour,
                markersize=8.5,
            )
        panel.set_xscale("log")
        panel.set_yscale("log")
        panel.margins(0.12)
        panel.set_title(plant, fontsize=10.5)
        panel.xaxis.set_major_formatter("{x:g}")
        panel.yaxis.set_major_formatter("{x:g}")
    for panel in grid.flat[max(len(plants) - across, 0) : len(plants)]:
        panel.tick_params(labelbottom=True)
        panel.set_xlabel("step, median [µs]")
    for panel in grid[:, 0]:
        panel.set_ylabel("mean |cross-track error|\nafter 5 s [m]")
    handles = [
        Line2D([], [], linestyle="", marker="o", color=colour, label=title_of(law))
        for law, colour in colours.items()
    ] + [
        Line2D([], [], linestyle="", marker=marker, color=theme.faint, label=track)
        for track, marker in markers.items()
    ]
    if not all(row.metrics.finished for row in rows):
        hollow = Line2D([], [], linestyle="", marker="o", color=theme.faint, label="not finished")
        hollow.set_markerfacecolor(theme.background)
        handles.append(hollow)
    figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), 5))
    pedals = "the paper's pedals"
    if found.constant_speed is not None:
        pedals = f"constant {found.constant_speed:g} m/s"
    figure.suptitle(f"Tracking error against the time of a control step, {pedals}", fontsize=11)
    return figure
