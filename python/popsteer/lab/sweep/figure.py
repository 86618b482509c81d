"""Where a sweep fails: the error over each quantity that varies."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from popsteer.lab.common.draw import logarithmic
from popsteer.lab.common.theme import Theme
from popsteer.lab.sweep.job import Job
from popsteer.lab.sweep.summary import Rows, axis_title, caption, influence, outcomes, success_rates

_MOST = 9


def sweep_figure(job: Job, rows: Rows, theme: Theme) -> Figure:
    """Draw the error over up to nine quantities, those first that failing has most to do with."""
    names = list(influence(job, rows))[:_MOST] or ["run"]
    across = min(len(names), 3)
    down = math.ceil(len(names) / across)
    figure = Figure(figsize=(3.5 * across + 0.6, 3.4 * down + 1.3), layout="constrained")
    grid = figure.subplots(
        2 * down, across, squeeze=False, height_ratios=[3.0, 1.0] * down, sharey="row"
    )
    panels = list(zip(grid[0::2].flat, grid[1::2].flat, strict=True))
    good, ended, error = outcomes(rows)
    kinds = (
        ("succeeded", good, theme.laws["pop"], "o", 5.0, 0.35),
        ("failed", ~good & ended, theme.laws["pid"], "o", 11.0, 0.9),
        ("did not finish", ~ended, theme.laws["pid"], "x", 22.0, 0.9),
    )
    for k, name in enumerate(names):
        above, below = panels[k]
        values = np.array([row[name] for row in rows])
        for _, part, colour, marker, size, alpha in kinds:
            look: Any = {"s": size, "color": colour, "marker": marker, "alpha": alpha}
            width = 1.2 if marker == "x" else 0.0
            # Rasterised: ten thousand points would make a file of megabytes.
            above.scatter(values[part], error[part], linewidths=width, rasterized=True, **look)
        above.axhline(job.deviation, color=theme.faint, linestyle="--", linewidth=1.0)
        logarithmic(above)
        for panel in (above, below):
            panel.set_axisbelow(True)  # else the grid is drawn over the points
        above.tick_params(labelbottom=False)
        _rates(below, values, good, theme)
        above.set_xlim(below.get_xlim())
        below.xaxis.set_major_locator(MaxNLocator(4))
        below.set_xlabel(axis_title(name))
    for above, below in zip(grid[0::2, 0], grid[1::2, 0], strict=True):
        above.set_ylabel("greatest |cross-track error|\nafter settling [m]")
        below.set_ylabel("success")
    for panel in (each for spare in panels[len(names) :] for each in spare):
        panel.set_visible(False)
    handles = [
        Line2D([], [], linestyle="", marker=marker, color=colour, label=label)
        for label, part, colour, marker, _, _ in kinds
        if part.any()
    ]
    limit = f"allowed: {job.deviation:g} m"
    handles.append(Line2D([], [], linestyle="--", color=theme.faint, label=limit))
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    figure.suptitle(caption(job, rows).replace(": ", "\n", 1), fontsize=11, wrap=True)
    return figure


def _rates(panel: Any, values: Any, good: Any, theme: Theme) -> None:
    for low, high, rate in success_rates(values, good):
        panel.fill_between([low, high], rate.low, rate.high, color=theme.laws["pop"], alpha=0.25)
        panel.plot([low, high], [rate.share] * 2, color=theme.laws["pop"], linewidth=1.8)
    panel.set_ylim(-0.05, 1.05)
    panel.yaxis.set_major_formatter("{x:g}")
