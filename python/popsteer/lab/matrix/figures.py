"""The figure of a matrix: tracking error against the effort of steering."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from popsteer.lab.common.draw import logarithmic
from popsteer.lab.common.names import title_of
from popsteer.lab.matrix.runs import Matrix, rows

if TYPE_CHECKING:
    from popsteer.lab.common.theme import Theme

_MARKERS = "osD^vP*X"


def matrix_figure(found: Matrix, theme: Theme) -> Figure:
    """Draw a panel for each plant: a colour for each controller, a marker for each track."""
    shown = list(rows(found))
    plants = list(dict.fromkeys(row.plant for row in shown))
    tracks = list(dict.fromkeys(row.track for row in shown))
    colours = theme.colours(dict.fromkeys(row.law for row in shown))
    markers = {track: _MARKERS[k % len(_MARKERS)] for k, track in enumerate(tracks)}
    across = len(plants) if len(plants) <= 3 else math.ceil(len(plants) / 2)
    down = math.ceil(len(plants) / across)
    figure = Figure(figsize=(max(4.2 * across, 7.0), 3.1 * down + 1.2), layout="constrained")
    grid = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True)
    for spare in grid.flat[len(plants) :]:
        spare.set_visible(False)
    for panel, plant in zip(grid.flat, plants, strict=False):
        for row in shown:
            error = row.metrics.settled_mean_abs_cross_track_error
            if row.plant != plant or not error > 0.0:
                continue
            # Hollow: the error of a run that did not finish says little.
            inside, edge = colours[row.law], theme.background
            if not row.metrics.finished:
                inside, edge = edge, inside
            look: dict[str, Any] = {"markerfacecolor": inside, "markeredgecolor": edge}
            effort = math.degrees(row.metrics.rms_steer_rate)
            panel.plot(effort, error, markers[row.track], markersize=8.5, **look)
        logarithmic(panel, "xy")
        panel.margins(0.12)
        panel.set_title(plant, fontsize=10.5)
    for panel in grid.flat[max(len(plants) - across, 0) : len(plants)]:
        panel.tick_params(labelbottom=True)
        panel.set_xlabel("rate of the command, rms [deg/s]")
    for panel in grid[:, 0]:
        panel.set_ylabel("mean |cross-track error|\nafter 5 s [m]")
    handles = [
        Line2D([], [], linestyle="", marker="o", color=colour, label=title_of(law))
        for law, colour in colours.items()
    ] + [
        Line2D([], [], linestyle="", marker=marker, color=theme.faint, label=track)
        for track, marker in markers.items()
    ]
    if not all(row.metrics.finished for row in shown):
        hollow = Line2D([], [], linestyle="", marker="o", color=theme.faint, label="not finished")
        hollow.set_markerfacecolor(theme.background)
        handles.append(hollow)
    figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), 5))
    speed = found.constant_speed
    pedals = "the paper's pedals" if speed is None else f"constant {speed:g} m/s"
    figure.suptitle(
        f"Tracking error against the effort of steering, {pedals}", fontsize=11, wrap=True
    )
    return figure
