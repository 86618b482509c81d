"""The figure of a suite: errors at a glance, and what they cost in steering."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.colors import LinearSegmentedColormap, LogNorm
from matplotlib.figure import Figure

from popsteer.lab.common.draw import logarithmic
from popsteer.lab.common.names import counted, title_of
from popsteer.lab.common.theme import Theme
from popsteer.lab.suite.runs import Suite, mean_error, rows

_LOW, _HIGH = 1e-3, 1.0  # of the colours [m]
_LEAST_EFFORT = 1e-3  # of the logarithmic axis, which has no place for wheels that stand [rad/s]
_GOOD, _FAIR, _BAD = "#2a9d8f", "#e9c46a", "#c8553d"  # told apart by colour-blind readers too


def suite_figure(found: Suite, theme: Theme) -> Figure:
    """Draw the error of each controller in each row of the table, and over its steering."""
    lines = rows(found)[:-1]
    names = list(found.step_times)
    titles = [title_of(name, names) for name in names]
    size = 1.05 * len(names) + 8.2, 0.31 * len(lines) + 2.2
    figure = Figure(figsize=size, layout="constrained")
    table, scatter = figure.subplots(1, 2, width_ratios=(1.05 * len(names) + 2.6, 4.2))
    errors = np.array([[mean_error(cells[name]) for name in names] for _, cells in lines])
    colours = LinearSegmentedColormap.from_list("error", (_GOOD, _FAIR, _BAD))
    norm = LogNorm(_LOW, _HIGH, clip=True)
    table.imshow(np.maximum(errors, 1e-9), norm=norm, cmap=colours, aspect="auto")
    for row, (_, cells) in enumerate(lines):
        for column, name in enumerate(names):
            failed = sum(not each.success for each in cells[name])
            error = errors[row, column]
            text = f"{1e3 * error:.{0 if error >= 0.1 else 1}f}"
            text += f"\n{failed} failed" if failed else ""
            look: dict[str, Any] = {"ha": "center", "va": "center", "color": "#111111"}
            look |= {"fontsize": 6.5 if failed else 8.5, "linespacing": 0.95}
            table.text(column, row, text, **look)
    table.set_xticks(range(len(names)), titles, rotation=30, ha="right", fontsize=8.5)
    table.set_yticks(range(len(lines)), [title for title, _ in lines], fontsize=8.5)
    scenarios = len({each.scenario for each in found.cells})
    conditions = len({each.condition for each in found.cells})
    for above in {scenarios, scenarios + conditions} - {len(lines)}:
        table.axhline(above - 0.5, color=theme.text, lw=1.2)
    table.grid(visible=False)
    table.set_title("mean |cross-track error| of the rear axle [mm]", fontsize=10.5)
    shades = theme.colours(names)
    points: dict[str, tuple[float, float]] = {}
    for name in names:
        own = [each for each in found.cells if each.controller == name]
        effort = float(np.mean([each.steer_rate for each in own]))
        points[name] = (max(_LEAST_EFFORT, effort), mean_error(own))  # also where it is no number
    for (name, (effort, error)), title in zip(points.items(), titles, strict=True):
        scatter.plot(effort, error, "o", color=shades[name], markersize=8)
        # Below where another point, as high, is just to the right, whose own is above.
        right = (y / error for x, y in points.values() if 1.0 < x / effort < 2.5)
        at = (6, -11) if any(0.9 < each < 1.1 for each in right) else (6, 4)
        scatter.annotate(title, (effort, error), xytext=at, textcoords="offset points", fontsize=8)
    logarithmic(scatter, "xy")
    scatter.margins(0.25)
    scatter.set_xlabel(f"rate of the command, rms [rad/s], from {_LEAST_EFFORT:g} on")
    scatter.set_ylabel("mean |cross-track error| [m]")
    scatter.set_title("error over steering effort, all runs", fontsize=10.5)
    over = counted(len(found.cells), "run")
    figure.suptitle(f"{found.name}: geometric means over {over}", fontsize=11.5)
    return figure
