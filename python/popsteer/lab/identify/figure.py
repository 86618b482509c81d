"""The picture of an identification: measured against simulated."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from popsteer.lab.common.draw import plot_broken, wrapped
from popsteer.lab.identify.table import caption, smoothed

if TYPE_CHECKING:
    from popsteer.identification import Identification
    from popsteer.lab.common.theme import Theme


def identified_figure(found: Identification, theme: Theme) -> Figure:
    """Draw positions, yaw rates, and the residuals of both."""
    records = found.records
    t = records["t"] - records["t"][0]
    measured, simulated = theme.laws["pop"], theme.laws["pid"]
    figure = Figure(figsize=(12.0, 7.2), layout="constrained")
    grid = figure.add_gridspec(3, 2, width_ratios=(1.0, 1.5))
    track = figure.add_subplot(grid[:, 0])
    rates = figure.add_subplot(grid[0, 1])
    left = figure.add_subplot(grid[1, 1], sharex=rates)
    off = figure.add_subplot(grid[2, 1], sharex=rates)
    breaks = found.log.gaps
    plot_broken(
        track,
        records["x"],
        records["y"],
        breaks,
        color=theme.path,
        linewidth=5.0,
        solid_capstyle="round",
        label="measured",
    )
    plot_broken(
        track,
        records["simulated_x"],
        np.where(records["counts"], records["simulated_y"], np.nan),
        breaks,
        color=simulated,
        linewidth=1.2,
        label="simulated, anew every 10 s",
    )
    track.set_aspect("equal", adjustable="datalim")
    track.set(xlabel="x [m]", ylabel="y [m]", title="Position")
    track.legend(loc="best", fontsize=8.5)
    period = found.log.period
    rate = records["yaw_rate"]
    model = np.where(records["counts"], records["simulated_yaw_rate"], np.nan)
    plot_broken(
        rates, t, smoothed(rate, period), breaks, color=measured, linewidth=1.6, label="measured"
    )
    plot_broken(
        rates, t, smoothed(model, period), breaks, color=simulated, linewidth=0.9, label="simulated"
    )
    rates.set(ylabel="yaw rate [rad/s]", title="Yaw rate, smoothed over 0.25 s")
    rates.legend(loc="upper right", fontsize=8.5, ncols=2)
    difference = rate - model
    plot_broken(left, t, smoothed(difference, period), breaks, color=measured, linewidth=0.9)
    left.set(ylabel="left over [rad/s]")
    left.set_title("measured less simulated", fontsize=9.0, fontweight="normal", color=theme.faint)
    plot_broken(
        off,
        t,
        np.where(records["counts"], records["position_error"], np.nan),
        breaks,
        color=measured,
        linewidth=0.9,
    )
    off.set(xlabel="time [s]", ylabel="to the side [m]")
    off.set_title(
        f"position, measured less simulated: {found.position_residual:.3f} m rms",
        fontsize=9.0,
        fontweight="normal",
        color=theme.faint,
    )
    for panel in (rates, left, off):
        panel.axhline(0.0, color=theme.path, linewidth=0.8, zorder=0.5)
        panel.set_xlim(t[0], t[-1])
    title = wrapped(f"{caption(found)}. {found.verdict}", figure, 10.0)
    figure.suptitle(title, fontsize=10, color=theme.faint)
    return figure
