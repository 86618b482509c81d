"""Figures of comparisons, drawn without a screen and without pyplot's global state."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from popsteer.lab.common.draw import (
    headline,
    limit,
    logarithmic,
    nice_limit,
    plot_settling,
    starting,
)
from popsteer.lab.common.names import counted, title_of
from popsteer.lab.common.theme import Theme
from popsteer.lab.compare.comparison import Comparison
from popsteer.lab.compare.paper import PAPER, is_authors_path
from popsteer.lab.compare.table import WHERE, caption, notes
from popsteer.sim import Run

_COLUMN = 4.1  # inches
_ROW = 1.75
_MARGIN = 0.12  # of the track's extent


class _Series(NamedTuple):
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
_LABELS = tuple(each.label for each in _SERIES)


def results_figure(comparison: Comparison, theme: Theme) -> Figure:
    """Draw what each controller did: a column each, with the track and a row for each series.

    The limits of a row are the same in all columns, and fit what the controllers do once the start
    has died out; a note in each panel gives its extremes.
    """
    runs = comparison.runs
    extent = _extent(comparison)
    track_row = _track_height(extent)
    height = 1.2 + track_row + len(_SERIES) * _ROW
    figure = Figure(
        figsize=(max(_COLUMN * len(runs) + 0.4, 6.4), height),
        layout=ConstrainedLayoutEngine(w_pad=0.08, h_pad=0.07),
    )
    ratios = [track_row, *[_ROW] * len(_SERIES)]
    axes = figure.subplots(len(ratios), len(runs), squeeze=False, height_ratios=ratios)
    colours = theme.colours(runs)
    bounds = {
        each.record: nice_limit([limit(run, each.record) * each.scale for run in runs.values()])
        for each in _SERIES
    }
    error = ScalarMappable(Normalize(0.0, bounds["cross_track_error"]), _errors(theme))
    end = max(run.metrics.time for run in runs.values())
    for column, (name, run) in enumerate(runs.items()):
        track, *panels = axes[:, column]
        _draw_track(track, run, extent, error, theme)
        track.set_title(title_of(name, runs), color=colours[name], pad=10)
        track.set_xlabel("x [m]")
        for panel, series in zip(panels, _SERIES, strict=True):
            bound = bounds[series.record]
            _draw_series(panel, run, series, colours[name], bound, theme)
            panel.set(xlim=(0.0, end), ylim=(-bound, bound))
            panel.tick_params(labelbottom=panel is panels[-1])
        panels[-1].set_xlabel("time [s]")
        for panel, label in zip(axes[:, column], ("y [m]", *_LABELS), strict=True):
            if column == 0:
                panel.set_ylabel(label)
            else:
                panel.tick_params(labelleft=False)
    bar = figure.colorbar(error, ax=axes[0, -1], location="right", fraction=0.05, extend="max")
    bar.set_label("|cross-track error| [m]", fontsize=8.5)
    bar.outline.set_visible(False)
    figure.align_ylabels(list(axes[:, 0]))
    headline(figure, caption(comparison), theme)
    return figure


def _extent(comparison: Comparison) -> NDArray[np.float64]:
    """Lower left and upper right corner of the maps [m], around all that is driven or followed."""
    records = [run.records for run in comparison.runs.values()]
    x = np.concatenate([comparison.path.x, *(each["reference_x"] for each in records)])
    y = np.concatenate([comparison.path.y, *(each["reference_y"] for each in records)])
    corners = np.array([[x.min(), y.min()], [x.max(), y.max()]])
    size = corners[1] - corners[0]
    # A straight one gets a third of its length to the sides, so that it can be seen.
    half = (0.5 + _MARGIN) * np.maximum(size, 0.3 * size[::-1])
    middle = corners.mean(axis=0)
    return np.array([middle - half, middle + half])


def _track_height(extent: NDArray[np.float64]) -> float:
    """Height of the row of tracks [inch] that lets a track fill its column."""
    width, height = extent[1] - extent[0]
    return float(min(0.5 + 0.9 * _COLUMN * height / width, 1.35 * _COLUMN))


def _errors(theme: Theme) -> LinearSegmentedColormap:
    """Give the colours of errors: from that of the path to a red that the eye goes to."""
    return LinearSegmentedColormap.from_list("errors", [theme.path, theme.laws["pid"]])


def _draw_track(
    panel: Axes, run: Run, extent: NDArray[np.float64], error: ScalarMappable, theme: Theme
) -> None:
    """Draw the path, and where it was driven: coloured by the error there."""
    path = run.path
    x, y = path.x, path.y
    if path.closed:
        x, y = np.append(x, x[0]), np.append(y, y[0])
    panel.plot(x, y, color=theme.faint, linewidth=0.7, linestyle=":")
    driven = np.column_stack((run.records["reference_x"], run.records["reference_y"]))
    line = LineCollection(
        list(np.stack((driven[:-1], driven[1:]), axis=1)),
        cmap=error.cmap,
        norm=error.norm,
        linewidths=3.0,
        capstyle="round",
    )
    line.set_array(np.abs(run.records["cross_track_error"][1:]))
    panel.add_collection(line)
    edge: dict[str, Any] = {"markeredgecolor": theme.text, "markeredgewidth": 1.3}
    panel.plot(*driven[:1].T, "o", markersize=6, color=theme.background, zorder=3, **edge)
    panel.set(xlim=extent[:, 0], ylim=extent[:, 1], aspect="equal")  # alike for all controllers
    panel.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    panel.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))


def _draw_series(
    panel: Axes, run: Run, series: _Series, colour: str, bound: float, theme: Theme
) -> None:
    values: NDArray[np.float64] = run.records[series.record] * series.scale
    panel.axhline(0.0, color=theme.path, linewidth=0.9)
    time, first = run.records["time"], starting(run)
    plot_settling(panel, time, values, first, bound, color=colour, linewidth=1.1)
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


_BAR = 0.42  # of the distance between controllers


def overview_figure(comparison: Comparison, theme: Theme) -> Figure:
    """Draw the cross-track errors of all along the path, and mean errors beside the paper's."""
    figure = Figure(figsize=(13.4, 8.0), layout=ConstrainedLayoutEngine(w_pad=0.12, h_pad=0.1))
    panels = figure.subplot_mosaic([["all", "all"], ["cross-track", "heading"]])
    colours = theme.colours(comparison.runs)
    _draw_all(panels["all"], comparison, colours, theme)
    for place, label, quantity in (
        ("cross-track", "mean |cross-track error| [m]", "mean_abs_cross_track_error"),
        ("heading", "mean |heading error| [rad]", "mean_abs_heading_error"),
    ):
        _draw_bars(panels[place], comparison, quantity, theme)
        panels[place].set_title(label, fontsize=10.5)
    if is_authors_path(comparison.path):
        said = [each for each in notes(comparison) if each not in (comparison.begins, WHERE)]
        figure.supxlabel("\n".join(said), fontsize=8.5, color=theme.faint)
    headline(figure, caption(comparison), theme)
    return figure


def _draw_all(panel: Axes, comparison: Comparison, colours: dict[str, str], theme: Theme) -> None:
    panel.axhline(0.0, color=theme.path, linewidth=0.9)
    bound = nice_limit([limit(run, "cross_track_error") for run in comparison.runs.values()])
    styles = theme.styles(comparison.runs)
    for name, run in comparison.runs.items():
        plot_settling(
            panel,
            _distance(run),
            run.records["cross_track_error"],
            starting(run),
            bound,
            color=colours[name],
            linestyle=styles[name],
            linewidth=1.8 if name == "pop" else 1.2,
            # A run that left the road is drawn behind those that can be compared.
            alpha=1.0 if run.metrics.finished else 0.4,
            zorder=2.0 if run.metrics.finished else 1.5,
            label=title_of(name, comparison.runs),
        )
    panel.set(xlim=(0.0, comparison.path.length), ylim=(-bound, bound))
    panel.set(xlabel="distance along the path [m]", ylabel="cross-track error [m]")
    panel.set_title("cross-track error at each controller's tracked point", fontsize=10.5)
    panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=9, handlelength=3.2)


def _distance(run: Run) -> NDArray[np.float64]:
    """Distance along the path of each record [m]."""
    path = run.path
    reach = 2.0 * run.plant_vehicle.wheelbase
    segment: int | None = None
    along = np.empty(len(run.records["time"]))
    columns = (run.records[name] for name in ("reference_x", "reference_y", "yaw"))
    for index, (x, y, yaw) in enumerate(zip(*columns, strict=True)):
        # Near the last one, which keeps to the branch where a path crosses itself: as far as the
        # controllers search, two wheelbases.
        if segment is None:
            segment = path.relocalise(x, y, yaw)
        backwards = path.reverse is not None and path.reverse[segment]
        projection = path.locate(x, y, yaw + np.pi if backwards else yaw, segment, reach)
        segment, along[index] = projection.segment, projection.arc_length
    # A gap in the line where a closed path begins again.
    along[1:][np.diff(along) < -0.5 * path.length] = np.nan
    return along


def _draw_bars(panel: Axes, comparison: Comparison, quantity: str, theme: Theme) -> None:
    """Draw two bars a controller: the whole run, and the paper's figure or what settles."""
    runs = comparison.runs
    whole = [getattr(run.metrics, quantity) for run in runs.values()]
    if is_authors_path(comparison.path):
        labels = ("measured", "paper")
        second = [getattr(PAPER.get(run.law), quantity, math.nan) for run in runs.values()]
    else:
        labels = ("whole run", f"after {comparison.first.settings.settling_time:g} s")
        second = [getattr(run.metrics, f"settled_{quantity}") for run in runs.values()]
    # A controller that left the road must not dwarf the others; its bars are cut off.
    pairs = list(zip(whole, second, strict=True))
    ended = [run.metrics.finished for run in runs.values()]
    kept = [value for good, pair in zip(ended, pairs, strict=True) if good for value in pair]
    top = max((value for value in kept or whole if math.isfinite(value)), default=0.0) or 1.0

    colours = theme.colours(runs).values()
    for place, (colour, pair) in enumerate(zip(colours, pairs, strict=True)):
        shown = [value for value in pair if math.isfinite(value)]
        for number, value in enumerate(shown):
            _draw_bar(
                panel,
                place + _BAR * (number - 0.5 * (len(shown) - 1)),
                value,
                top,
                facecolor=theme.background if number else colour,
                edgecolor=colour,
                hatch="////" if number else "",
            )
    names = [
        title_of(name, runs) + ("" if good else "\n(not finished)")
        for name, good in zip(runs, ended, strict=True)
    ]
    panel.set_xticks(range(len(runs)), names)
    panel.tick_params(axis="x", length=0, labelcolor=theme.text)
    panel.set_xlim(-0.6, len(runs) - 0.4)
    panel.set_ylim(0.0, 1.32 * top)
    panel.grid(visible=False, axis="x")
    looks = (theme.faint, ""), (theme.background, "////")
    handles = [
        Patch(facecolor=fill, edgecolor=theme.faint, linewidth=1.2, hatch=hatch, label=text)
        for text, (fill, hatch) in zip(labels, looks, strict=True)
    ]
    panel.legend(handles=handles, loc="upper right", ncols=2, fontsize=9)


def _draw_bar(panel: Axes, place: float, value: float, top: float, **style: str) -> None:
    """Draw one bar with its number above; one that is too tall ends at the top."""
    height = min(value, 1.1 * top)
    panel.bar(place, height, _BAR - 0.05, linewidth=1.2, zorder=2, **style)  # type: ignore[arg-type]
    panel.annotate(
        f"{value:.4f}" if height == value else f"{value:.2g} ↑",
        (place, height),
        xytext=(0, 3),
        textcoords="offset points",
        ha="center",
        va="bottom",
        fontsize=8,
    )


_MARKERS = "osD^vP*X"


def effort_figure(comparisons: Sequence[Comparison], theme: Theme) -> Figure:
    """Draw a panel for each plant: a colour for each controller, a marker for each track."""
    first = comparisons[0]
    plants = list(dict.fromkeys(each.plant for each in comparisons))
    tracks = list(dict.fromkeys(each.track for each in comparisons))
    colours = theme.colours(first.runs)
    markers = {track: _MARKERS[k % len(_MARKERS)] for k, track in enumerate(tracks)}
    across = len(plants) if len(plants) <= 3 else math.ceil(len(plants) / 2)
    down = math.ceil(len(plants) / across)
    figure = Figure(figsize=(max(4.2 * across, 7.0), 3.1 * down + 1.2), layout="constrained")
    grid = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True)
    for spare in grid.flat[len(plants) :]:
        spare.set_visible(False)
    runs = [(each, law, run.metrics) for each in comparisons for law, run in each.runs.items()]
    # What is 0 has no place on logarithmic axes.
    shown = [
        (each, law, metrics)
        for each, law, metrics in runs
        if metrics.settled_mean_abs_cross_track_error > 0.0 and metrics.rms_steer_rate > 0.0
    ]
    for panel, plant in zip(grid.flat, plants, strict=False):
        for each, law, metrics in shown:
            if each.plant != plant:
                continue
            # Hollow: the error of a run that did not finish says little.
            inside, edge = colours[law], theme.background
            if not metrics.finished:
                inside, edge = edge, inside
            look: dict[str, Any] = {"markerfacecolor": inside, "markeredgecolor": edge}
            effort = math.degrees(metrics.rms_steer_rate)
            error = metrics.settled_mean_abs_cross_track_error
            panel.plot(effort, error, markers[each.track], markersize=8.5, **look)
        logarithmic(panel, "xy")
        panel.margins(0.12)
        panel.set_title(plant, fontsize=10.5)
    for panel in grid.flat[max(len(plants) - across, 0) : len(plants)]:
        panel.tick_params(labelbottom=True)
        panel.set_xlabel("rate of the command, rms [deg/s]")
    settling = first.first.settings.settling_time
    for panel in grid[:, 0]:
        panel.set_ylabel(f"mean |cross-track error|\nafter {settling:g} s [m]")
    handles = [
        Line2D([], [], linestyle="", marker="o", color=colour, label=title_of(law, first.runs))
        for law, colour in colours.items()
    ] + [
        Line2D([], [], linestyle="", marker=marker, color=theme.faint, label=track)
        for track, marker in markers.items()
    ]
    if not all(metrics.finished for _, _, metrics in runs):
        hollow = Line2D([], [], linestyle="", marker="o", color=theme.faint, label="not finished")
        hollow.set_markerfacecolor(theme.background)
        handles.append(hollow)
    figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), 5))
    speed = first.constant_speed
    pace = "" if speed is None else f", constant {speed:g} m/s"
    title = f"Tracking error against the effort of steering{pace}"
    if left_out := len(runs) - len(shown):
        title += f"; not drawn: {counted(left_out, 'run')} without an error or an effort"
    figure.suptitle(title, fontsize=11, wrap=True)
    return figure
