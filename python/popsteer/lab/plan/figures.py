"""The figure of a plan: speeds and what limits them, over the distance."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from popsteer.lab.common.theme import Theme
from popsteer.planning import SpeedProfile
from popsteer.planning.profile import LIMITS

# Limits that are alike share a colour of the theme.
COLOURS = {
    "driving": "pure-pursuit",
    "braking": "pid",
    "lateral": "pop",
    **dict.fromkeys(("steer rate", "steer angle"), "stanley"),
    **dict.fromkeys(("top speed", "speed limit"), "speed"),
    "jerk": "mpc",
    "stop": "preview-pop",
}


def plan_figure(profile: SpeedProfile, theme: Theme) -> Figure:
    """Draw the speeds with what limits them, and the accelerations, over the distance."""
    figure = Figure(figsize=(11.0, 6.2), layout="constrained")
    speeds, pulls = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    path = profile.path
    distance = np.append(path.s, path.length) if path.closed else path.s
    there = np.arange(len(distance)) % len(path)  # a lap ends where it began
    speed, limit, bends = profile.speed[there], profile.limit[there], profile.curvature[there]
    bends = np.abs(bends)
    _draw_speeds(speeds, profile, (distance, speed, limit, bends), theme)
    along = np.append(profile.acceleration, profile.acceleration[-1])
    label = "along the path"
    pulls.step(distance, along, where="post", color=theme.text, linewidth=1.1, label=label)
    aside = {"color": theme.laws["pop"], "label": "to the side (magnitude)"}
    pulls.plot(distance, speed * speed * bends, linewidth=1.1, **aside)
    pulls.axhline(0.0, color=theme.faint, linewidth=0.6)
    pulls.set(xlabel="distance along the path [m]", ylabel="acceleration [m/s²]")
    pulls.set_xlim(0.0, path.length)
    low, high = pulls.get_ylim()
    pulls.set_ylim(low, high + 0.3 * (high - low))  # room for the legend
    pulls.legend(loc="upper right", ncols=2)
    return figure


def _draw_speeds(
    panel: Axes, profile: SpeedProfile, course: tuple[NDArray[Any], ...], theme: Theme
) -> None:
    distance, speed, limit, bends = course
    most: float = profile.limits.max_speed or float(speed.max())
    side: float = profile.limits.max_lateral_acceleration or 0.0
    bound = np.sqrt(side / np.maximum(bends, side / most**2))
    label = "bend and top speed"
    panel.plot(distance, bound, ":", color=theme.faint, linewidth=1.0, label=label)
    stops = limit == LIMITS.index("stop")
    for name in profile.shares():
        colour = theme.colour(COLOURS[name])
        mine = limit == LIMITS.index(name)
        if name == "stop":
            look: Any = {"color": colour, "clip_on": False, "zorder": 3, "label": name}
            panel.scatter(distance[mine], speed[mine], 24.0, **look)
            continue
        # A line has the colour of the limit at its end; up to a stop, of the limit at its start.
        shown = mine.copy()
        shown[:-1] |= mine[1:]
        shown[1:] |= mine[:-1] & stops[1:]
        stretch = np.where(shown, speed, np.nan)
        panel.plot(distance, stretch, color=colour, linewidth=2.0, label=name)
    panel.set_ylim(0.0, 1.18 * max(float(speed.max()), min(most, 1.3 * float(speed.max()))))
    panel.set_ylabel("speed [m/s]")
    panel.set_title(f"planned speed and what limits it: {profile.time:.1f} s", loc="left")
    panel.legend(loc="upper right", ncols=6, fontsize=8.5)
