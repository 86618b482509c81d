"""Figures of a stability study: margins, the open loops, and the dead time over the lookahead."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator
from numpy.typing import NDArray

from popsteer._core import PopParams, PurePursuitParams, Vehicle
from popsteer.lab.common.draw import files_of, headline
from popsteer.lab.common.names import title_of
from popsteer.lab.common.theme import Theme
from popsteer.lab.stability.linear import lookahead
from popsteer.lab.stability.loop import Response, respond
from popsteer.lab.stability.runs import Stability, dead_time_map, run
from popsteer.lab.stability.table import stability_caption

USUAL = ((2.0, 5.0), (30.0, 60.0))
"""Gain [-] and phase margins [deg] that are usual: K. J. Åström, R. M. Murray, *Feedback Systems*,
2nd ed. 2021, section 10.3."""
_LEVELS = (0.0, 50.0, 100.0, 150.0, 200.0, 300.0, 400.0, 600.0, 1000.0)  # ms
# Of a car of 3 m wheelbase; `_sized` fits them to the vehicle.
_SPEEDS = np.linspace(1.0, 30.0, 59)
_DISTANCES = np.geomspace(1.0, 25.0, 41)


def _sized(vehicle: Vehicle) -> tuple[float, float]:
    """Give the vehicle's size in cars of 3 m wheelbase, and its speed: a large one is no faster."""
    size = vehicle.wheelbase / 3.0
    return size, min(size, 1.0)


def stability_figures(
    result: Stability, progress: Callable[[str, float], object] | None = None
) -> dict[str, bytes]:
    """Draw the figures of a stability study as PNG, for a light and a dark background, by name."""
    tell = partial(progress or (lambda *_: None), "figures")
    tell(0.0)
    car, dt, believed = result.vehicle, result.dt, result.believed
    size, pace = _sized(car)
    speeds, distances = (pace * _SPEEDS).tolist(), (size * _DISTANCES).tolist()
    fine = run(result.params, car, speeds, believed=believed, preset=result.preset, dt=dt)
    tell(0.2)
    maps = {
        name: dead_time_map(params, car, speeds, distances, dt, believed=believed)
        for name, params in result.params.items()
        if isinstance(params, PopParams | PurePursuitParams)
    }
    tell(0.7)
    draw: dict[str, Callable[[Theme], Figure]] = {
        "stability-margins": partial(_margins_figure, fine),
        "stability-loops": partial(loops_figure, result, responses(result)),
    }
    if maps:
        draw["stability-map"] = partial(_map_figure, result, maps)
    files = files_of(draw, lambda _, share: tell(0.8 + 0.2 * share))
    return {name: content for name, content in files.items() if name.endswith(".png")}


def _map_figure(result: Stability, maps: Mapping[str, NDArray[np.float64]], theme: Theme) -> Figure:
    size, pace = _sized(result.vehicle)
    speeds, distances = pace * _SPEEDS, size * _DISTANCES
    figure = Figure(figsize=(10.5, 4.9), layout="constrained")
    panels = figure.subplots(1, len(maps), squeeze=False, sharey=True)[0]
    colours = ScalarMappable(BoundaryNorm(_LEVELS, 256, extend="max"), "viridis")
    for panel, (name, found) in zip(panels, maps.items(), strict=True):
        # What is below the least level, the unstable, is left grey.
        shown = np.nan_to_num(1e3 * found, nan=-1.0)
        panel.set_facecolor(theme.path)
        look = {"norm": colours.norm, "cmap": colours.cmap, "extend": "max"}
        panel.contourf(speeds, distances, shown, _LEVELS, **look)
        params = result.params[name]
        line = [lookahead(params, result.believed, float(speed)) or math.nan for speed in speeds]
        panel.plot(speeds, line, color="#ffffff", linewidth=4.0)
        label = "lookahead of the controller"
        panel.plot(speeds, line, color="#d1242f", linewidth=2.0, label=label)
        panel.set_yscale("log")
        panel.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        panel.yaxis.set_major_formatter("{x:g}")
        panel.minorticks_off()
        panel.set(xlabel="speed [m/s]", xlim=speeds[[0, -1]], ylim=distances[[0, -1]])
        panel.set_title(title_of(name, result.margins), pad=8)
        panel.grid(visible=False)
        legend = panel.legend(loc="lower right", fontsize=8.5, frameon=True, edgecolor="none")
        legend.get_frame().set(facecolor=theme.background, alpha=0.85)
    panels[0].set_ylabel("lookahead [m]")
    bar = figure.colorbar(colours, ax=list(panels), ticks=_LEVELS, pad=0.02)
    bar.set_label("dead time that may be added [ms]")
    bar.ax.tick_params(labelcolor=theme.faint)
    note = "grey: unstable without any dead time"
    headline(figure, f"{stability_caption(result)}; {note}", theme)
    return figure


def _margins_figure(result: Stability, theme: Theme) -> Figure:
    colours = theme.colours(result.params)
    figure = Figure(figsize=(10.5, 3.9), layout="constrained")
    panels = figure.subplots(1, 3)
    dashes = theme.styles(result.margins)
    for name, found in result.margins.items():
        look = {"color": colours[name], "linestyle": dashes[name], "linewidth": 1.8}
        scaled = [(each.gain, math.degrees(each.phase), 1e3 * each.dead_time) for each in found]
        for panel, values in zip(panels, zip(*scaled, strict=True), strict=True):
            panel.plot(result.speeds, values, label=title_of(name, result.margins), **look)
    titles = "gain margin [-]", "phase margin [deg]", "dead-time margin [ms]"
    for panel, title in zip(panels, titles, strict=True):
        panel.set(xlabel="speed [m/s]", xlim=(0.0, result.speeds[-1]))
        panel.set_title(title, pad=8)
    panels[1].set_ylim(bottom=0.0)
    for panel in panels[[0, 2]]:
        panel.set_yscale("log")
        panel.yaxis.set_major_formatter("{x:g}")
        panel.set_ylim(bottom=1.0)
    for panel, usual in zip(panels, USUAL, strict=False):
        panel.axhspan(*usual, color=theme.faint, alpha=0.18, linewidth=0.0, zorder=0)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), handlelength=3.2)
    note = "a line ends where the loop becomes unstable; grey: margins that are usually asked for"
    headline(figure, f"{stability_caption(result)}; {note}", theme)
    return figure


def loops_figure(result: Stability, responses: Mapping[str, Response], theme: Theme) -> Figure:
    """Draw Bode's and Nyquist's diagrams of the open loops, and the answers to a step."""
    figure = Figure(figsize=(11.4, 5.4), layout="constrained")
    grid = figure.add_gridspec(2, 3)
    size, phase = (figure.add_subplot(grid[row, 0]) for row in (0, 1))
    nyquist, step = (figure.add_subplot(grid[:, column]) for column in (1, 2))
    colours, dashes = theme.colours(result.params), theme.styles(result.params)
    for name, found in responses.items():
        look: dict[str, Any] = {"color": colours[name], "linestyle": dashes[name], "linewidth": 1.6}
        gains, phases = found.crossings()
        size.plot(found.frequency, np.abs(found.gain), **look)
        phase.plot(found.frequency, np.degrees(found.phase), **look)
        mark: dict[str, Any] = {"color": colours[name], "markersize": 4.5}
        size.plot([at for at, _ in phases], [value for _, value in phases], "o", **mark)
        phase.plot(
            [at for at, _ in gains], [math.degrees(value) for _, value in gains], "o", **mark
        )
        nyquist.plot(found.gain.real, found.gain.imag, **look)
        step.plot(found.time, found.offset, label=title_of(name, responses), **look)
    size.axhline(1.0, color=theme.faint, linewidth=0.8, linestyle=":")
    phase.axhline(-180.0, color=theme.faint, linewidth=0.8, linestyle=":")
    size.set(yscale="log", ylabel="magnitude", ylim=(1e-3, 1e2), title="Bode, open loop")
    phase.set(ylabel="phase [deg]", xlabel="frequency [rad/s]", ylim=(-360.0, 0.0))
    phase.set_yticks(range(-360, 1, 90))
    for panel in (size, phase):
        panel.set(xscale="log", xlim=(0.05, math.pi / result.dt))
    # No nearer to -1 than half: what is amplified at most twofold.
    circle = np.exp(1j * np.linspace(0.0, math.tau, 181))
    nyquist.plot(circle.real, circle.imag, color=theme.faint, linewidth=0.8, linestyle=":")
    near = -1.0 + 0.5 * circle
    nyquist.fill(near.real, near.imag, color=theme.faint, alpha=0.18, linewidth=0.0)
    nyquist.plot(-1.0, 0.0, "+", color=theme.text, markersize=9)
    nyquist.set(xlim=(-2.5, 1.5), ylim=(-2.0, 2.0), xlabel="real", ylabel="imaginary")
    nyquist.set(aspect="equal", title="Nyquist, open loop")
    step.set(xlabel="time [s]", ylabel="offset of the vehicle [m]", ylim=(-0.2, 1.8))
    last = max(each.time[-1] for each in responses.values())
    step.set(title="the path moves by 1 m", xlim=(0.0, last))
    handles, labels = step.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), handlelength=3.2)
    ended = [title_of(k, responses) for k, each in responses.items() if np.isnan(each.offset).all()]
    wrong = f"; unstable, so without an answer to the step: {', '.join(ended)}" if ended else ""
    at = f"at {middle(result):g} m/s; dots: where the margins are read{wrong}"
    headline(figure, f"{stability_caption(result)}, {at}", theme)
    return figure


def middle(result: Stability) -> float:
    """Give the speed that the answers are shown at: the middle one [m/s]."""
    return sorted(result.speeds)[len(result.speeds) // 2]


def responses(result: Stability) -> dict[str, Response]:
    """Compute the answers of the controllers at the middle speed."""
    return {
        name: respond(params, result.vehicle, middle(result), result.dt, believed=result.believed)
        for name, params in result.params.items()
    }
