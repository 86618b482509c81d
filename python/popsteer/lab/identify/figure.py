"""The picture of an identification: measured against simulated, and why it is known or not."""

from __future__ import annotations

import math
from functools import partial
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib.figure import Figure, SubFigure

from popsteer.identification import Identification
from popsteer.identification.fit import NUISANCES
from popsteer.lab.common.draw import headline, logarithmic, plot_broken
from popsteer.lab.common.theme import Theme
from popsteer.lab.identify import caption, smoothed

_MARKERS = "osv^DPX*<>"


def identified_figure(found: Identification, theme: Theme) -> Figure:
    """Draw positions, yaw rates and what is left of them; innovations, excitation, likelihoods."""
    records = found.records
    t = records["t"] - records["t"][0]
    line = partial(plot_broken, breaks=found.log.gaps)
    smooth = partial(smoothed, period=found.log.period)
    measured: dict[str, Any] = {"color": theme.laws["pop"], "linewidth": 0.9}
    simulated: dict[str, Any] = {"color": theme.laws["pid"], "linewidth": 0.9}
    figure = Figure(figsize=(12.0, 10.8), layout="constrained")
    halves = figure.add_gridspec(2, 1, height_ratios=(2.0, 1.0))
    upper, lower = figure.add_subfigure(halves[0]), figure.add_subfigure(halves[1])
    grid = upper.add_gridspec(3, 2, width_ratios=(1.0, 1.5))
    track, rates = upper.add_subplot(grid[:, 0]), upper.add_subplot(grid[0, 1])
    left, off = (upper.add_subplot(grid[row, 1], sharex=rates) for row in (1, 2))
    wide: dict[str, Any] = {"color": theme.path, "linewidth": 5.0, "solid_capstyle": "round"}
    line(track, records["x"], records["y"], label="measured", **wide)
    counts = records["counts"]
    y = np.where(counts, records["simulated_y"], np.nan)
    label = "simulated, anew every 10 s"
    line(track, records["simulated_x"], y, **simulated | {"linewidth": 1.2, "label": label})
    track.set_aspect("equal", adjustable="datalim")
    track.set(xlabel="x [m]", ylabel="y [m]", title="Position")
    below: dict[str, Any] = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.1), "fontsize": 8.5}
    track.legend(**below, ncols=2)
    rate = records["yaw_rate"]
    model = np.where(counts, records["simulated_yaw_rate"], np.nan)
    line(rates, t, smooth(rate), **measured | {"linewidth": 1.6, "label": "measured"})
    line(rates, t, smooth(model), label="simulated", **simulated)
    rates.set(ylabel="yaw rate [rad/s]")
    rates.set_title("Yaw rate, smoothed over 0.25 s", loc="left")
    rates.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), fontsize=8.5, ncols=2)
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
    _reasons(found, lower, theme)
    headline(figure, f"{caption(found)}. {found.verdict}", theme)
    return figure


def _reasons(found: Identification, figure: SubFigure, theme: Theme) -> None:
    """Draw the innovations by octave, what was driven, and the profile likelihoods."""
    spectrum, driven, likely = figure.subplots(1, 3)
    middle = [math.sqrt(each.low * each.high) for each in found.octaves]
    spectrum.plot(middle, [each.power for each in found.octaves], "o-", color=theme.laws["pop"])
    spectrum.plot(middle, [each.most for each in found.octaves], color=theme.laws["pid"])
    logarithmic(spectrum, "xy")
    spectrum.set(xlabel="octave [Hz]", ylabel="power over the noise's")
    spectrum.set_title("Innovations, and the limit")
    log, moves = found.log, np.abs(found.log.speed) > 0.0
    places = np.degrees(log.steer[moves]), log.speed[moves]
    driven.plot(*places, ",", color=theme.laws["pop"], alpha=0.5)
    driven.set(xlabel="steer [deg]", ylabel="speed [m/s]", title="What was driven")
    share = np.linspace(-1.0, 1.0, 9)
    errors = {
        name: error
        for name, error in found.fit.errors.items()
        if name not in NUISANCES and math.isfinite(error)
    }
    colours, styles = theme.colours(errors), theme.styles(errors)
    for marker, (name, error) in zip(cycle(_MARKERS), errors.items(), strict=False):
        values = found.fit.values[name] + 4.0 * error * share
        there = values >= min(0.0, values[4])
        likelihood = np.maximum(found.fit.profile(name, values[there].tolist()), -12.0)
        style: dict[str, Any] = {"color": colours[name], "linestyle": styles[name]}
        style |= {"marker": marker, "markersize": 4.5, "linewidth": 1.0, "label": name}
        likely.plot(4.0 * share[there], likelihood, **style)
    likely.axhline(-2.0, color=theme.path, linewidth=0.8)
    likely.set(xlabel="off the estimate [errors]", ylabel="log-likelihood")
    likely.set_title("Profile likelihoods")
    likely.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=7.5, handlelength=3.0)
