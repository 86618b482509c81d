"""The picture of a replay: the angles of the controllers beside the driver's."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from popsteer.lab.common.draw import headline, plot_broken
from popsteer.lab.common.names import title_of
from popsteer.lab.common.theme import Theme
from popsteer.lab.replay.runs import Replay
from popsteer.lab.replay.table import caption
from popsteer.status import Status


def replay_figure(found: Replay, theme: Theme) -> Figure:
    """Draw where the log drove, the angles, their differences, the errors and the statuses."""
    log = found.log
    t = log.t - log.t[0]
    line = partial(plot_broken, breaks=log.gaps)
    colours, dashes = theme.colours(found.shadows), theme.styles(found.shadows)
    figure = Figure(figsize=(12.0, 7.6), layout="constrained")
    grid = figure.add_gridspec(4, 2, width_ratios=(1.0, 1.6), height_ratios=(1.0, 1.0, 1.0, 0.45))
    track = figure.add_subplot(grid[:, 0])
    angles = figure.add_subplot(grid[0, 1])
    others = [figure.add_subplot(grid[k, 1], sharex=angles) for k in (1, 2, 3)]
    differences, errors, marks = others
    first = next(iter(found.shadows.values())).path
    wide: dict[str, Any] = {"color": theme.path, "solid_capstyle": "round", "label": "to follow"}
    track.plot(first.x, first.y, linewidth=5.0, **wide)
    line(track, log.x, log.y, color=theme.text, linewidth=1.0, label="driven")
    track.set_aspect("equal", adjustable="datalim")
    track.set(xlabel="x [m]", ylabel="y [m]", title="Position")
    track.legend(loc="best", fontsize=8.5)
    line(angles, t, np.degrees(log.steer), color=theme.path, linewidth=3.5, label="driver")
    titles = [title_of(name, found.shadows) for name in found.shadows]
    for place, (name, shadow) in enumerate(found.shadows.items()):
        style: dict[str, Any] = {"color": colours[name], "linestyle": dashes[name]}
        style["linewidth"] = 1.1
        line(angles, t, np.degrees(shadow.steer), label=titles[place], **style)
        line(differences, t, np.degrees(shadow.steer - log.steer), **style)
        line(errors, t, shadow.cross_track_error, **style)
        _draw_marks(marks, t, shadow.status, place, theme)
    angles.set(ylabel="angle [deg]", title="Angle of the wheels")
    angles.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=8.5, handlelength=3.2)
    differences.set(ylabel="less driver's [deg]")
    errors.set(ylabel="error [m]")
    marks.set(xlabel="time [s]", ylim=(-0.7, len(found.shadows) - 0.3))
    marks.set_yticks(range(len(titles)), titles, fontsize=8.0)
    marks.invert_yaxis()
    handles = [
        Line2D([], [], label=level, **_mark(level, theme)) for level in ("degraded", "fault")
    ]
    marks.legend(handles=handles, loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=8.5)
    for panel in (angles, differences, errors):
        panel.axhline(0.0, color=theme.path, linewidth=0.8, zorder=0.5)
        panel.tick_params(labelbottom=False)
    angles.set_xlim(t[0], t[-1])
    figure.align_ylabels([angles, *others])
    headline(figure, caption(found), theme)
    return figure


def _draw_marks(
    panel: Axes, t: NDArray[np.float64], status: NDArray[np.uint32], place: int, theme: Theme
) -> None:
    levels = {int(bits): Status(int(bits)).level for bits in np.unique(status)}
    for level in ("degraded", "fault"):
        hit = np.isin(status, [bits for bits, found in levels.items() if found == level])
        edges = np.flatnonzero(np.diff(np.concatenate(([0], hit.astype(np.int8), [0]))))
        for start, end in zip(edges[::2], edges[1::2], strict=True):
            panel.plot([t[start], t[min(end, len(t) - 1)]], [place, place], **_mark(level, theme))


def _mark(level: str, theme: Theme) -> dict[str, Any]:
    """Give the look of a level: a fault is red and thick."""
    colour, width = (theme.laws["pid"], 8.0) if level == "fault" else (theme.speed, 3.0)
    return {"color": colour, "linewidth": width, "solid_capstyle": "butt"}
