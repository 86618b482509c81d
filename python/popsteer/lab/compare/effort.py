"""The figure of several comparisons: tracking error against the effort of steering."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from popsteer.lab.common.draw import logarithmic
from popsteer.lab.common.names import counted, title_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from popsteer.lab.common.theme import Theme
    from popsteer.lab.compare.comparison import Comparison

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
