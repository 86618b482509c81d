"""The paper's figure of results: a column for each controller."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import MaxNLocator

from popsteer.lab.common.draw import limit, nice_limit, wrapped
from popsteer.lab.common.names import title_of
from popsteer.lab.compare.table import caption

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from popsteer.lab.common.theme import Theme
    from popsteer.lab.compare import Comparison
    from popsteer.sim import Run

_COLUMN = 4.1  # inches
_ROW = 1.75
_MARGIN = 0.12  # of the track's extent


class _Series(NamedTuple):
    """A row of the figure: what is drawn over time."""

    record: str
    label: str
    scale: float
    note: str


_SERIES = (
    _Series(
        "cross_track_error", "cross-track error [m]", 1.0, "mean |e| {mean:.3f} m, max {max:.2f} m"
    ),
    _Series(
        "heading_error",
        "heading error [deg]",
        math.degrees(1.0),
        "mean |ψe| {mean:.2f}°, max {max:.1f}°",
    ),
    _Series("steer", "steering command [deg]", math.degrees(1.0), "max |δ| {max:.1f}°"),
)


def results_figure(comparison: Comparison, theme: Theme) -> Figure:
    """Draw what each controller did: a column for each.

    The rows are the path driven against the path, and cross-track error, heading error and steering
    command over time. The limits of a row are the same in all columns, and fit what the controllers
    do once the start has died out; a note in each panel gives its extremes.
    """
    runs = comparison.runs
    extent = _extent(comparison)
    track_row = _track_height(extent)
    height = 1.2 + track_row + len(_SERIES) * _ROW
    figure = Figure(
        figsize=(max(_COLUMN * len(runs) + 0.4, 6.4), height),
        layout=ConstrainedLayoutEngine(w_pad=0.08, h_pad=0.07),
    )
    axes = figure.subplots(
        1 + len(_SERIES),
        len(runs),
        squeeze=False,
        height_ratios=[track_row, *[_ROW] * len(_SERIES)],
    )
    colours = theme.colours(runs)
    end = max(run.metrics.time for run in runs.values())
    for column, (name, run) in enumerate(runs.items()):
        _draw_track(axes[0, column], run, extent, colours[name], theme)
        axes[0, column].set_title(title_of(name), color=colours[name], pad=10)
        for row, series in enumerate(_SERIES, start=1):
            panel = axes[row, column]
            _draw_series(panel, run, series, colours[name], theme)
            panel.set_xlim(0.0, end)
            bound = nice_limit(
                [limit(other, series.record) * series.scale for other in runs.values()]
            )
            panel.set_ylim(-bound, bound)
            if column == 0:
                panel.set_ylabel(series.label)
            else:
                panel.tick_params(labelleft=False)
            if row < len(_SERIES):
                panel.tick_params(labelbottom=False)
            else:
                panel.set_xlabel("time [s]")
        axes[0, column].set_xlabel("x [m]")
        if column == 0:
            axes[0, column].set_ylabel("y [m]")
        else:
            axes[0, column].tick_params(labelleft=False)
    figure.align_ylabels(list(axes[:, 0]))
    title = wrapped(caption(comparison), figure, 10.0)
    figure.suptitle(title, fontsize=10, color=theme.faint)
    return figure


def _extent(comparison: Comparison) -> NDArray[np.float64]:
    """Lower left and upper right corner of all that is driven and to be followed [m]."""
    path = comparison.path
    tracks = [np.column_stack((path.x, path.y))]
    for run in comparison.runs.values():
        records = run.records
        tracks.append(np.column_stack((records["reference_x"], records["reference_y"])))
    points = np.concatenate(tracks)
    return np.array([points.min(axis=0), points.max(axis=0)])


def _track_height(extent: NDArray[np.float64]) -> float:
    """Height of the row of tracks [inch] that lets a track fill its column."""
    width, height = extent[1] - extent[0]
    # A straight one gets a third of its length to the sides, so that it can be seen.
    slope = max(height, 0.3 * width) / max(width, 0.3 * height)
    return float(min(0.5 + 0.9 * _COLUMN * slope, 1.35 * _COLUMN))


def _draw_track(
    panel: Axes, run: Run, extent: NDArray[np.float64], colour: str, theme: Theme
) -> None:
    path = run.path
    x, y = path.x, path.y
    if path.closed:
        x, y = np.append(x, x[0]), np.append(y, y[0])
    panel.plot(x, y, color=theme.path, linewidth=5.0, solid_capstyle="round", label="path")
    driven_x, driven_y = run.records["reference_x"], run.records["reference_y"]
    panel.plot(driven_x, driven_y, color=colour, linewidth=1.4, label="driven")
    panel.plot(
        driven_x[:1],
        driven_y[:1],
        "o",
        markersize=6,
        color=theme.background,
        markeredgecolor=colour,
        markeredgewidth=1.6,
        label="start",
    )
    panel.update_datalim(extent)  # the same limits for all controllers
    panel.margins(_MARGIN)
    panel.set_aspect("equal", adjustable="datalim")
    panel.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    panel.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    panel.legend(loc="best", fontsize=8.5, handlelength=1.6)


def _draw_series(panel: Axes, run: Run, series: _Series, colour: str, theme: Theme) -> None:
    values: NDArray[np.float64] = run.records[series.record] * series.scale
    panel.axhline(0.0, color=theme.path, linewidth=0.9)
    panel.plot(run.records["time"], values, color=colour, linewidth=1.1)
    note = run.ending  # where code of one's own raised in its first step
    if len(values):
        note = series.note.format(mean=np.abs(values).mean(), max=np.abs(values).max())
    panel.text(
        0.98,
        0.96,
        note,
        transform=panel.transAxes,
        ha="right",
        va="top",
        fontsize=8.5,
        color=theme.faint,
        bbox={"facecolor": theme.background, "edgecolor": "none", "alpha": 0.9, "pad": 1.5},
    )
    panel.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10], symmetric=True))
    panel.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
