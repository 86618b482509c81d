"""The picture of an identification: measured against simulated."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from popsteer.lab.common.draw import headline, plot_broken
from popsteer.lab.identify.table import caption, smoothed

if TYPE_CHECKING:
    from popsteer.identification import Identification
    from popsteer.lab.common.theme import Theme


def identified_figure(found: Identification, theme: Theme) -> Figure:
    """Draw positions, yaw rates, and the residuals of both."""
    records = found.records
    t = records["t"] - records["t"][0]
    line = partial(plot_broken, breaks=found.log.gaps)
    smooth = partial(smoothed, period=found.log.period)
    measured: dict[str, Any] = {"color": theme.laws["pop"], "linewidth": 0.9}
    simulated: dict[str, Any] = {"color": theme.laws["pid"], "linewidth": 0.9}
    figure = Figure(figsize=(12.0, 7.2), layout="constrained")
    grid = figure.add_gridspec(3, 2, width_ratios=(1.0, 1.5))
    track = figure.add_subplot(grid[:, 0])
    rates = figure.add_subplot(grid[0, 1])
    left = figure.add_subplot(grid[1, 1], sharex=rates)
    off = figure.add_subplot(grid[2, 1], sharex=rates)
    wide: dict[str, Any] = {"color": theme.path, "linewidth": 5.0, "solid_capstyle": "round"}
    line(track, records["x"], records["y"], label="measured", **wide)
    counts = records["counts"]
    y = np.where(counts, records["simulated_y"], np.nan)
    label = "simulated, anew every 10 s"
    line(track, records["simulated_x"], y, **simulated | {"linewidth": 1.2, "label": label})
    track.set_aspect("equal", adjustable="datalim")
    track.set(xlabel="x [m]", ylabel="y [m]", title="Position")
    track.legend(loc="best", fontsize=8.5)
    rate = records["yaw_rate"]
    model = np.where(counts, records["simulated_yaw_rate"], np.nan)
    line(rates, t, smooth(rate), **measured | {"linewidth": 1.6, "label": "measured"})
    line(rates, t, smooth(model), label="simulated", **simulated)
    rates.set(ylabel="yaw rate [rad/s]", title="Yaw rate, smoothed over 0.25 s")
    rates.legend(loc="upper right", fontsize=8.5, ncols=2)
    line(left, t, smooth(rate - model), **measured)
    left.set(ylabel="left over [rad/s]")
    line(off, t, np.where(counts, records["position_error"], np.nan), **measured)
    off.set(xlabel="time [s]", ylabel="to the side [m]")
    said = f"position, measured less simulated: {found.position_residual:.3f} m rms"
    for panel, title in ((left, "measured less simulated"), (off, said)):
        panel.set_title(title, fontsize=9.0, fontweight="normal", color=theme.faint)
    for panel in (rates, left, off):
        panel.axhline(0.0, color=theme.path, linewidth=0.8, zorder=0.5)
        panel.set_xlim(t[0], t[-1])
    headline(figure, f"{caption(found)}. {found.verdict}", theme)
    return figure
