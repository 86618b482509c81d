"""Figures of comparisons, drawn without a screen and without pyplot's global state."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from textwrap import fill
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

from popsteer.errors import printable
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
from popsteer.lab.compare.comparison import Comparison, arcs
from popsteer.lab.compare.paper import PAPER, is_authors_path
from popsteer.lab.compare.table import WHERE, caption, notes
from popsteer.sim import Run

_COLUMN = 4.1  # inches
_ROW = 1.75
_MARGIN = 0.12  # of the track's extent
_ticks = partial(MaxNLocator, steps=[1, 2, 5, 10])


class _Series(NamedTuple):
    record: str
    label: str
    scale: float
    note: str


_DEGREES = math.degrees(1.0)
_SERIES = (
    _Series(
        "cross_track_error", "cross-track error [m]", 1.0, "mean |e| {mean:.3f} m, max {max:.2f} m"
    ),
    _Series(
        "heading_error", "heading error [deg]", _DEGREES, "mean |ψe| {mean:.2f}°, max {max:.1f}°"
    ),
    _Series("steer", "steering command [deg]", _DEGREES, "max |δ| {max:.1f}°"),
)
_LABELS = tuple(each.label for each in _SERIES)


def results_figure(comparison: Comparison, theme: Theme) -> Figure:
    """Draw what each controller did: a column each, with the track and a row for each series.

    The limits of a row are the same in all columns, and fit what the controllers do once the start
    has died out; a note in each panel gives its extremes.
    """
    runs = comparison.runs
    extent = _extent(comparison)
    across, up = extent[1] - extent[0]
    # A row of tracks that lets a track fill its column.
    ratios = [float(min(0.5 + 0.9 * _COLUMN * up / across, 1.35 * _COLUMN)), *[_ROW] * len(_SERIES)]
    figure = Figure(
        figsize=(max(_COLUMN * len(runs) + 0.4, 6.4), 1.2 + sum(ratios)),
        layout=ConstrainedLayoutEngine(w_pad=0.08, h_pad=0.07),
    )
    axes = figure.subplots(len(ratios), len(runs), squeeze=False, height_ratios=ratios)
    colours = theme.colours(runs)
    bounds = {
        each.record: nice_limit([limit(run, each.record) * each.scale for run in runs.values()])
        for each in _SERIES
    }
    # From the colour of the path to a red that the eye goes to.
    reds = LinearSegmentedColormap.from_list("errors", [theme.path, theme.laws["pid"]])
    error = ScalarMappable(Normalize(0.0, bounds["cross_track_error"]), reds)
    end = max(run.metrics.time for run in runs.values()) or 1.0
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
    segments = list(np.stack((driven[:-1], driven[1:]), axis=1))
    look: Any = {"cmap": error.cmap, "norm": error.norm, "linewidths": 3.0, "capstyle": "round"}
    line = LineCollection(segments, **look)
    line.set_array(np.abs(run.records["cross_track_error"][1:]))
    panel.add_collection(line)
    edge: dict[str, Any] = {"markeredgecolor": theme.text, "markeredgewidth": 1.3}
    panel.plot(*driven[:1].T, "o", markersize=6, color=theme.background, zorder=3, **edge)
    panel.set(xlim=extent[:, 0], ylim=extent[:, 1], aspect="equal")  # alike for all controllers
    panel.xaxis.set_major_locator(_ticks(5))
    panel.yaxis.set_major_locator(_ticks(5))


def _draw_series(
    panel: Axes, run: Run, series: _Series, colour: str, bound: float, theme: Theme
) -> None:
    values: NDArray[np.float64] = run.records[series.record] * series.scale
    panel.axhline(0.0, color=theme.path, linewidth=0.9)
    time, first = run.records["time"], starting(run)
    plot_settling(panel, time, values, first, bound, color=colour, linewidth=1.1)
    note = fill(printable(run.ending), 40)  # where code of one's own raised in its first step
    if len(values):
        note = series.note.format(mean=np.abs(values).mean(), max=np.abs(values).max())
    box = {"facecolor": theme.background, "edgecolor": "none", "alpha": 0.9, "pad": 1.5}
    place: dict[str, Any] = {"transform": panel.transAxes, "ha": "right", "va": "top"}
    panel.text(0.98, 0.96, note, **place, fontsize=8.5, color=theme.faint, bbox=box)
    panel.yaxis.set_major_locator(_ticks(5, symmetric=True))
    panel.xaxis.set_major_locator(_ticks(6))


_BAR = 0.42  # of the distance between controllers


def overview_figure(comparison: Comparison, theme: Theme) -> Figure:
    """Draw the cross-track errors of all along the path, and mean errors beside the paper's."""
    figure = Figure(figsize=(13.4, 8.0), layout=ConstrainedLayoutEngine(w_pad=0.12, h_pad=0.1))
    panels = figure.subplot_mosaic([["all", "all"], ["cross-track", "heading"]])
    colours = theme.colours(comparison.runs)
    _draw_all(panels["all"], comparison, colours, theme)
    for place, unit in (("cross-track", "m"), ("heading", "rad")):
        quantity = f"mean_abs_{place.replace('-', '_')}_error"
        _draw_bars(panels[place], comparison, quantity, theme)
        panels[place].set_title(f"mean |{place} error| [{unit}]", fontsize=10.5)
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
    columns = (run.records[name] for name in ("reference_x", "reference_y", "yaw", "speed"))
    along, path = arcs(run.path, *columns), run.path
    if path.closed:
        along %= path.length
        along[1:][np.diff(along) < -0.5 * path.length] = np.nan  # a gap where it begins again
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
            at = place + _BAR * (number - 0.5 * (len(shown) - 1))
            fill, hatch = (theme.background, "////") if number else (colour, "")
            _draw_bar(panel, at, value, top, facecolor=fill, edgecolor=colour, hatch=hatch)
    marks = ("" if good else "\n(not finished)" for good in ended)
    names = [title_of(name, runs) + mark for name, mark in zip(runs, marks, strict=True)]
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
    said = f"{value:.4f}" if height == value else f"{value:.2g} ↑"
    above: dict[str, Any] = {"xytext": (0, 3), "textcoords": "offset points", "ha": "center"}
    panel.annotate(said, (place, height), va="bottom", fontsize=8, **above)


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
    panels = dict(zip(plants, grid.flat, strict=False))
    runs = [(each, law, run.metrics) for each in comparisons for law, run in each.runs.items()]
    left_out = 0
    for each, law, metrics in runs:
        error, effort = metrics.settled_mean_abs_cross_track_error, metrics.rms_steer_rate
        if not (error > 0.0 and effort > 0.0):  # what is 0 has no place on logarithmic axes
            left_out += 1
            continue
        # Hollow: the error of a run that did not finish says little.
        inside, edge = colours[law], theme.background
        if not metrics.finished:
            inside, edge = edge, inside
        look: dict[str, Any] = {"markerfacecolor": inside, "markeredgecolor": edge}
        at = math.degrees(effort), error
        panels[each.plant].plot(*at, markers[each.track], markersize=8.5, **look)
    for plant, panel in panels.items():
        logarithmic(panel, "xy")
        panel.margins(0.12)
        panel.set_title(plant, fontsize=10.5)
    for panel in grid.flat[max(len(plants) - across, 0) : len(plants)]:
        panel.tick_params(labelbottom=True)
        panel.set_xlabel("rate of the command, rms [deg/s]")
    settling = first.first.settings.settling_time
    for panel in grid[:, 0]:
        panel.set_ylabel(f"mean |cross-track error|\nafter {settling:g} s [m]")
    mark: Any = partial(Line2D, [], [], linestyle="")
    handles = [
        *(
            mark(marker="o", color=each, label=title_of(law, first.runs))
            for law, each in colours.items()
        ),
        *(mark(marker=each, color=theme.faint, label=track) for track, each in markers.items()),
    ]
    if not all(metrics.finished for _, _, metrics in runs):
        hollow = {"color": theme.faint, "markerfacecolor": theme.background}
        handles.append(mark(marker="o", label="not finished", **hollow))
    figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), 5))
    speed = first.constant_speed
    pace = "" if speed is None else f", constant {speed:g} m/s"
    title = f"Tracking error against the effort of steering{pace}"
    if left_out:
        title += f"; not drawn: {counted(left_out, 'run')} without an error or an effort"
    figure.suptitle(title, fontsize=11, wrap=True)
    return figure
