"""The controllers on one axis, and their figures beside the paper's."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.patches import Patch

from popsteer.lab.common.draw import limit, nice_limit, wrapped
from popsteer.lab.common.names import title_of
from popsteer.lab.compare.paper import PAPER, is_authors_path
from popsteer.lab.compare.table import caption, notes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from popsteer.lab.common.theme import Theme
    from popsteer.lab.compare import Comparison
    from popsteer.sim import Run

_BAR = 0.42  # of the distance between controllers


def overview_figure(comparison: Comparison, theme: Theme) -> Figure:
    """Draw the controllers together.

    Above is the cross-track error of all controllers over the distance along the path; below are
    the mean absolute cross-track and heading errors beside the paper's.
    """
    figure = Figure(figsize=(12.0, 8.0), layout=ConstrainedLayoutEngine(w_pad=0.12, h_pad=0.1))
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
        figure.supxlabel("\n".join(notes(comparison)[2:]), fontsize=8.5, color=theme.faint)
    title = wrapped(caption(comparison), figure, 10.0)
    figure.suptitle(title, fontsize=10, color=theme.faint)
    return figure


def _draw_all(panel: Axes, comparison: Comparison, colours: dict[str, str], theme: Theme) -> None:
    panel.axhline(0.0, color=theme.path, linewidth=0.9)
    for name, run in comparison.runs.items():
        panel.plot(
            _distance(run),
            run.records["cross_track_error"],
            color=colours[name],
            linewidth=1.8 if name == "pop" else 1.2,
            # A run that left the road is drawn behind those that can be compared.
            alpha=1.0 if run.metrics.finished else 0.4,
            zorder=2.0 if run.metrics.finished else 1.5,
            label=title_of(name),
        )
    bound = nice_limit([limit(run, "cross_track_error") for run in comparison.runs.values()])
    panel.set_ylim(-bound, bound)
    panel.set_xlim(0.0, comparison.path.length)
    panel.set_xlabel("distance along the path [m]")
    panel.set_ylabel("cross-track error [m]")
    panel.set_title("cross-track error at each controller's tracked point", fontsize=10.5)
    panel.legend(loc="upper right", ncols=len(comparison.runs), fontsize=9, handlelength=1.6)


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
    """Draw a pair of bars for each controller: the whole run, and the paper's figure.

    The paper's figures belong to its track; on another one the second bar is what remains after
    the start.
    """
    runs = comparison.runs
    whole = [getattr(run.metrics, quantity) for run in runs.values()]
    if is_authors_path(comparison.path):
        labels = ("measured", "paper")
        second = [getattr(PAPER.get(run.law), quantity, math.nan) for run in runs.values()]
    else:
        labels = ("whole run", f"after {comparison.first.settings.settling_time:g} s")
        second = [getattr(run.metrics, f"settled_{quantity}") for run in runs.values()]
    # A controller that left the road must not dwarf the others; its bars are cut off.
    pairs = zip(runs.values(), whole, second, strict=True)
    kept = [value for run, *pair in pairs if run.metrics.finished for value in pair]
    top = max((value for value in kept or whole if math.isfinite(value)), default=0.0) or 1.0

    for place, (colour, *pair) in enumerate(
        zip(theme.colours(runs).values(), whole, second, strict=True)
    ):
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
    panel.set_xticks(
        range(len(runs)),
        [
            title_of(name) + ("" if run.metrics.finished else "\n(not finished)")
            for name, run in runs.items()
        ],
    )
    panel.tick_params(axis="x", length=0, labelcolor=theme.text)
    panel.set_xlim(-0.6, len(runs) - 0.4)
    panel.set_ylim(0.0, 1.32 * top)
    panel.grid(visible=False, axis="x")
    handles = [
        Patch(facecolor=fill, edgecolor=theme.faint, linewidth=1.2, hatch=hatch, label=text)
        for text, fill, hatch in (
            (labels[0], theme.faint, ""),
            (labels[1], theme.background, "////"),
        )
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
