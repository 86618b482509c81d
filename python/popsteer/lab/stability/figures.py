"""Figures of the theory page: where the loops are stable, and how the carrot cuts bends."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from popsteer._core import PopParams, PreviewPopParams, PurePursuitParams
from popsteer.lab.common.draw import files_of, headline
from popsteer.lab.common.names import title_of
from popsteer.lab.stability.carrot import LATERAL, Carrot, Choice, carrot_curve, choice
from popsteer.lab.stability.linear import lookahead
from popsteer.lab.stability.response import Response, respond
from popsteer.lab.stability.runs import dead_time_map, run
from popsteer.lab.stability.table import stability_caption

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from popsteer._core import Vehicle
    from popsteer.lab.common.theme import Theme
    from popsteer.lab.stability import Stability


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

    def tell(share: float) -> None:
        if progress is not None:
            progress("figures", share)

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
    pop = result.params.get("pop")
    if isinstance(pop, PopParams):
        curve = carrot_curve(car, pop, believed, dt)
        if len(curve.radii):
            draw["carrot-offset"] = partial(_carrot_figure, result, curve)
    if choices := choice_curves(result):
        draw["preview-choice"] = partial(choice_figure, result, choices)
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
        panel.plot(
            speeds, line, color="#d1242f", linewidth=2.0, label="lookahead of the controller"
        )
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
    return _captioned(figure, f"{stability_caption(result)}; {note}", theme)


def _margins_figure(result: Stability, theme: Theme) -> Figure:
    colours = theme.colours(result.params)
    figure = Figure(figsize=(10.5, 3.9), layout="constrained")
    panels = figure.subplots(1, 3)
    dashes = theme.styles(result.margins)
    for name, found in result.margins.items():
        series = (
            [each.gain for each in found],
            [math.degrees(each.phase) for each in found],
            [1e3 * each.dead_time for each in found],
        )
        for panel, values in zip(panels, series, strict=True):
            panel.plot(
                result.speeds,
                values,
                color=colours[name],
                linestyle=dashes[name],
                label=title_of(name, result.margins),
                linewidth=1.8,
            )
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
    return _captioned(figure, f"{stability_caption(result)}; {note}", theme)


def loops_figure(result: Stability, responses: Mapping[str, Response], theme: Theme) -> Figure:
    """Draw Bode's and Nyquist's diagrams of the open loops, and the answers to a step."""
    figure = Figure(figsize=(11.4, 5.4), layout="constrained")
    grid = figure.add_gridspec(2, 3)
    size, phase = (figure.add_subplot(grid[row, 0]) for row in (0, 1))
    nyquist, step = (figure.add_subplot(grid[:, column]) for column in (1, 2))
    colours, dashes = theme.colours(result.params), theme.styles(result.params)
    for name, found in responses.items():
        look: dict[str, Any] = {
            "color": colours[name],
            "linestyle": dashes[name],
            "linewidth": 1.6,
        }
        gains, phases = found.crossings()
        size.plot(found.frequency, np.abs(found.gain), **look)
        phase.plot(found.frequency, np.degrees(found.phase), **look)
        mark: dict[str, Any] = {
            "marker": "o",
            "linestyle": "",
            "color": colours[name],
            "markersize": 4.5,
        }
        size.plot([at for at, _ in phases], [value for _, value in phases], **mark)
        phase.plot([at for at, _ in gains], [math.degrees(value) for _, value in gains], **mark)
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
    at = f"at {middle(result):g} m/s; dots: where the margins are read"
    return _captioned(figure, f"{stability_caption(result)}, {at}", theme)


def middle(result: Stability) -> float:
    """Give the speed that the answers are shown at: the middle one [m/s]."""
    return sorted(result.speeds)[len(result.speeds) // 2]


def responses(result: Stability) -> dict[str, Response]:
    """Compute the answers of the controllers at the middle speed."""
    return {
        name: respond(params, result.vehicle, middle(result), result.dt, believed=result.believed)
        for name, params in result.params.items()
    }


def _carrot_figure(result: Stability, curve: Carrot, theme: Theme) -> Figure:
    """Draw the offset that POP keeps on circles: computed, and driven."""
    figure = Figure(figsize=(7.6, 4.2), layout="constrained")
    panel = figure.subplots()
    panel.plot(
        curve.radii, curve.computed, color=theme.laws["pop"], linewidth=2.0, label="computed"
    )
    panel.plot(
        curve.radii, curve.rope, "--", color=theme.faint, linewidth=1.2, label="R - √(R² - ld²)"
    )
    panel.plot(
        curve.driven_radii,
        curve.driven,
        "o",
        color=theme.background,
        markeredgecolor=theme.text,
        markeredgewidth=1.5,
        markersize=6,
        label="driven as a kinematic bicycle",
    )
    panel.set_xscale("log")
    panel.set_xticks(curve.driven_radii)
    panel.xaxis.set_major_formatter("{x:.3g}")
    panel.minorticks_off()
    panel.set(xlabel="radius of the circle [m]", ylabel="offset to the inside [m]")
    panel.legend(fontsize=8.5)
    found: Any = result.params["pop"].resolved(result.believed)
    panel.set_title(
        f"POP's front axle on circles at {LATERAL:g} m/s² of lateral acceleration,"
        f"\nld = {found.min_lookahead:.3g} m + {found.lookahead_gain:.3g} s · v",
        pad=8,
        fontsize=10,
    )
    return _captioned(figure, stability_caption(result), theme)


def _captioned(figure: Figure, caption: str, theme: Theme) -> Figure:
    headline(figure, caption, theme)
    return figure


_SPEED, _RADIUS = 15.0, 50.0
_CHOICE_DISTANCES = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0)
_COSTS = (0.02, 0.05, 0.1, 0.25, 0.5, 1.0, 2.0)
_POP = "POP, over its lookahead [m]"
_MODELS = {
    "preview POP, over its steer_rate_cost [m s/rad]": (1.0, "o"),
    "preview POP that does not adapt, given a wheelbase 15 % too long": (1.15, "^"),
    "preview POP, 15 % too short (offset to the outside)": (0.85, "v"),
}
_MARKED = {_POP: (1.0, 3.0, 6.0, 9.0), next(iter(_MODELS)): (0.02, 0.25, 2.0)}


def choice_curves(result: Stability) -> dict[str, Choice]:
    """Compute the figure's curves, by what each shows; none without POP and preview POP."""
    pop, preview = result.params.get("pop"), result.params.get("preview-pop")
    if not (isinstance(pop, PopParams) and isinstance(preview, PreviewPopParams)):
        return {}
    vehicle, believed = result.vehicle, result.believed
    size, pace = _sized(vehicle)
    bend = partial(
        choice, vehicle=vehicle, radius=size * _RADIUS, speed=pace * _SPEED, dt=result.dt
    )
    values = [size * each for each in _CHOICE_DISTANCES]
    costs = [size * each for each in _COSTS]
    curves = {_POP: bend(pop, values=values, believed=believed)}
    for said, (share, _) in _MODELS.items():
        given = believed.replace(turning_wheelbase=share * believed.turning_length(0.0))
        curves[said] = bend(preview, values=costs, believed=given, adapt=None)
    return curves


def choice_figure(result: Stability, curves: Mapping[str, Choice], theme: Theme) -> Figure:
    """Draw offsets in a bend against dead-time margins."""
    size, pace = _sized(result.vehicle)
    figure = Figure(figsize=(8.4, 4.6), layout="constrained")
    panel = figure.subplots()
    for said, found in curves.items():
        law, marker = ("pop", "o") if said == _POP else ("preview-pop", _MODELS[said][1])
        panel.plot(
            [1e3 * each for each in found.dead_times],
            [abs(each) for each in found.offsets],
            f"{marker}-",
            color=theme.laws[law],
            linewidth=1.8 if said in _MARKED else 1.0,
            markersize=5,
            label=said,
        )
        for value, dead_time, offset in zip(*found, strict=True):
            marked = any(math.isclose(value, size * each) for each in _MARKED.get(said, ()))
            if marked and math.isfinite(dead_time):
                panel.annotate(
                    f"{value:.3g}",
                    (1e3 * dead_time, abs(offset)),
                    # Beside the steep curve, below the flat one.
                    xytext=(8, -4) if law == "pop" else (-5, -14),
                    textcoords="offset points",
                    fontsize=8.5,
                    color=theme.text,
                )
    panel.set(
        xlabel="dead time that may be added [ms]", xlim=(0.0, None), ylim=(-0.08 * size, 1.1 * size)
    )
    panel.set_ylabel("offset in the bend [m]")
    panel.set_title(f"A bend of {size * _RADIUS:.3g} m radius at {pace * _SPEED:.3g} m/s", pad=8)
    panel.legend(fontsize=8.5, loc="upper left")
    return _captioned(figure, stability_caption(result), theme)
