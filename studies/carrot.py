"""Offsets in a bend: following the carrot cuts it, in closed form and driven; preview POP hardly.

    python -m studies.carrot    # draws the two figures of docs/theory.md

POP steers the front wheels towards a point of the path at the distance ld, so the front axle moves
as if it were drawn by a rope of that length. On a circle of radius R it comes to rest on a smaller
one. With the centre O, the front axle F at the distance R_f from it and the lookahead point T, the
triangle OFT gives the angle η by which the rope points inward of F's tangent, and steady turning
the angle γ of that tangent off the heading, and the angle δ of the wheels::

    R² = R_f² + ld² - 2 R_f ld sin η      tan γ = a / ρ      tan δ = (L + K v²) / ρ      γ + η = δ

with ρ² = R_f² - a² the radius on which the point runs that does not slip, a behind the front axle.
Where the front axle turns about the same point as the wheels say, a = L + K v², there is η = 0, and

    R_f = √(R² - ld²),  an offset of R - √(R² - ld²) ≈ ld² / 2R

to the inside, whatever the wheelbase, the speed and the lag. Where the wheels turn the car less
than that, the rope points inward, and on wide circles the offset is about
ld (ld / 2 - (L + K v² - a)) / R.

In a steady bend of curvature κ the prediction of preview POP with the right model foresees no error
and asks for no move. Where the vehicle turns by l = L + K v² and the model by l', the controller
commands c = κ l / l' in the model's curvature, and rests where the error asks for what is missing,
with its gains g of `popsteer.lab.stability.linear`::

    g_e e = (g_a + g_c) (κ - c)      e = (g_a + g_c) / g_e · (1 - l / l') / R
"""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from popsteer import sim, vehicles
from popsteer._core import AdaptParams, Path, Pop, PopParams, PreviewPopParams, SpeedPid, Vehicle
from popsteer.errors import ConfigError
from popsteer.lab.stability.linear import lookahead, no_slip, preview_gains
from popsteer.lab.stability.runs import margins
from popsteer.ranges import check_in_range
from studies.layout import write_figures

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from popsteer.lab.common.theme import Theme

CAR = vehicles.get("paper")
RADIUS, SPEED = 50.0, 15.0  # of the bend in which margin and accuracy are compared: m, m/s
LATERAL = 2.0
"""Lateral acceleration in the bends of `carrot_curve` [m/s²]."""
_RADII = (4.0, 5.0, 20.0 / 3.0, 25.0 / 3.0, 10.0, 40.0 / 3.0, 20.0, 80.0 / 3.0, 40.0)  # wheelbases


class Carrot(NamedTuple):
    """Offset of POP [m] over the radius of a circle [m]: computed, by R - √(R² - ld²), driven."""

    radii: NDArray[np.float64]
    computed: NDArray[np.float64]
    rope: NDArray[np.float64]
    driven_radii: NDArray[np.float64]
    driven: NDArray[np.float64]


def carrot_offset(distance: float, radius: float, vehicle: Vehicle, speed: float = 0.0) -> float:
    """Offset that follow-the-carrot from the front axle keeps on a circle, of its front axle [m].

    ConfigError where a number is out of range, or the vehicle cannot turn so tightly.
    """
    check_in_range("radius", radius, 1e-3, 1e6)
    check_in_range("distance", distance, 0.0, 0.999 * radius)
    ahead = vehicle.front_axle - no_slip(vehicle)
    turning = vehicle.turning_length(speed)
    front = radius
    for _ in range(100):  # a contraction: η is small and changes little with R_f
        if front <= ahead:
            raise ConfigError(
                "radius", radius, f"one that the vehicle can turn with ld {distance:g}"
            )
        rolling = math.sqrt(front * front - ahead * ahead)
        inward = math.atan(turning / rolling) - math.atan(ahead / rolling)
        reach = distance * math.cos(inward)
        front = distance * math.sin(inward) + math.sqrt(radius * radius - reach * reach)
    return radius - front


def driven_offset(radius: float, plant: sim.Plant, speed: float) -> tuple[float, float]:
    """Drive POP round a circle; give the mean offset of its front axle and its mean lookahead [m].

    Both are of the second half of a lap.
    """
    xy = circle(radius)
    pop = Pop(Path(xy, speed=np.full(len(xy), speed), closed=True), sim.vehicle_of(plant))
    start: tuple[float, float, float] = (0.0, 0.0, 0.0)
    records = sim.run(pop, plant, start=start, start_at="front", longitudinal=SpeedPid()).records
    half = records["time"] > 0.5 * records["time"][-1]
    reach = lookahead(pop.params, pop.vehicle, float(records["speed"][half].mean()))
    return float(records["cross_track_error"][half].mean()), reach or 0.0


def circle(radius: float) -> NDArray[np.float64]:
    """Give waypoints every half metre, 150 at least, on a circle to the left, from the origin."""
    count = max(round(2.0 * math.pi * radius / 0.5), 150)
    angle = np.arange(count) * (2.0 * math.pi / count)
    return radius * np.column_stack((np.sin(angle), 1.0 - np.cos(angle)))


def carrot_curve(vehicle: Vehicle) -> Carrot:
    """Compute and drive POP's offset at `LATERAL` m/s² on circles of 4 to 40 wheelbases."""

    def reach(radius: float) -> float:
        return lookahead(PopParams(), vehicle, math.sqrt(LATERAL * radius)) or 0.0

    corners = vehicle.wheelbase * np.array(_RADII)
    radii = np.geomspace(corners[0], corners[-1], 60)
    computed = [carrot_offset(reach(r), r, vehicle, math.sqrt(LATERAL * r)) for r in radii.tolist()]
    rope = [r - math.sqrt(r**2 - reach(r) ** 2) for r in radii.tolist()]
    plant = sim.KinematicBicycle(vehicle)
    driven = [driven_offset(r, plant, math.sqrt(LATERAL * r))[0] for r in corners.tolist()]
    return Carrot(radii, np.array(computed), np.array(rope), corners, np.array(driven))


class Choice(NamedTuple):
    """Margin and accuracy at each value of a parameter that trades one for the other."""

    values: tuple[float, ...]
    dead_times: tuple[float, ...]
    """Dead time that may be added [s]; NaN where the loop is unstable without."""
    offsets: tuple[float, ...]
    """Offset in the bend, to the inside [m]."""


def preview_offset(
    params: PreviewPopParams,
    vehicle: Vehicle,
    radius: float,
    speed: float,
    dt: float = 0.05,
    *,
    believed: Vehicle | None = None,
    adapt: AdaptParams | Literal["auto"] | None = "auto",
) -> float:
    """Offset that preview POP's tracked point keeps in a wide steady bend [m], to the inside.

    0 where it estimates how the vehicle turns. ConfigError where a number is out of range.
    """
    check_in_range("radius", radius, 1e-3, 1e6)
    check_in_range("speed", speed, 1e-3, 1e3)
    check_in_range("dt", dt, 1e-3, 1.0)
    adapt = AdaptParams() if adapt == "auto" else adapt
    if adapt is not None and adapt.turn_time > 0.0:
        return 0.0
    believed = vehicle if believed is None else believed
    gains = preview_gains(params, believed, speed, dt)
    turns, modelled = vehicle.turning_length(speed), believed.turning_length(speed)
    return (gains.driven + gains.commanded) / gains.error * (1.0 - turns / modelled) / radius


def choice(
    params: PopParams | PreviewPopParams, values: Sequence[float], believed: Vehicle = CAR
) -> Choice:
    """Vary POP's lookahead [m] or preview POP's `steer_rate_cost` [m s/rad] in a bend."""
    found = []
    for value in values:
        changed: PopParams | PreviewPopParams
        if isinstance(params, PopParams):
            changed = params.replace(lookahead_gain=0.0, min_lookahead=value)
            offset = carrot_offset(value, RADIUS, CAR, SPEED)
        else:
            changed = params.replace(steer_rate_cost=value)
            offset = preview_offset(changed, CAR, RADIUS, SPEED, believed=believed, adapt=None)
        margin = margins(changed, CAR, SPEED, believed=believed)
        found.append((value, margin.dead_time, offset))
    return Choice(*zip(*found, strict=True))


def carrot_figure(curve: Carrot, theme: Theme) -> Figure:
    """Draw the offset that POP keeps on circles: computed, and driven."""
    figure = Figure(figsize=(7.6, 4.2), layout="constrained")
    panel = figure.subplots()
    look: dict[str, Any] = {"color": theme.laws["pop"], "linewidth": 2.0}
    panel.plot(curve.radii, curve.computed, label="computed", **look)
    look = {"color": theme.faint, "linewidth": 1.2}
    panel.plot(curve.radii, curve.rope, "--", label="R - √(R² - ld²)", **look)
    look = {"color": theme.background, "markeredgecolor": theme.text, "markeredgewidth": 1.5}
    label = "driven as a kinematic bicycle"
    panel.plot(curve.driven_radii, curve.driven, "o", markersize=6, label=label, **look)
    panel.set(xscale="log", xticks=curve.driven_radii)
    panel.xaxis.set_major_formatter("{x:.3g}")
    panel.minorticks_off()
    panel.set(xlabel="radius of the circle [m]", ylabel="offset to the inside [m]")
    panel.legend(fontsize=8.5)
    title = f"POP's front axle on circles at {LATERAL:g} m/s² of lateral acceleration"
    panel.set_title(title, pad=8, fontsize=10)
    return figure


_POP = "POP, over its lookahead [m]"
_MODELS = {
    "preview POP, over its steer_rate_cost [m s/rad]": (1.0, "o"),
    "preview POP that does not adapt, given a wheelbase 15 % too long": (1.15, "^"),
    "preview POP, 15 % too short (offset to the outside)": (0.85, "v"),
}
_MARKED = {_POP: (1.0, 3.0, 6.0, 9.0), next(iter(_MODELS)): (0.02, 0.25, 2.0)}


def choice_curves() -> dict[str, Choice]:
    """Compute the curves of margin and accuracy, by what each shows."""
    distances = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0)
    costs = (0.02, 0.05, 0.1, 0.25, 0.5, 1.0, 2.0)
    curves = {_POP: choice(PopParams(), distances)}
    for said, (share, _) in _MODELS.items():
        given = CAR.replace(turning_wheelbase=share * CAR.turning_length(0.0))
        curves[said] = choice(PreviewPopParams(), costs, given)
    return curves


def choice_figure(curves: Mapping[str, Choice], theme: Theme) -> Figure:
    """Draw offsets in a bend against dead-time margins."""
    figure = Figure(figsize=(8.4, 4.6), layout="constrained")
    panel = figure.subplots()
    for said, found in curves.items():
        law, marker = ("pop", "o") if said == _POP else ("preview-pop", _MODELS[said][1])
        across = [1e3 * each for each in found.dead_times]
        up = [abs(each) for each in found.offsets]
        width = 1.8 if said in _MARKED else 1.0
        look: dict[str, Any] = {"color": theme.laws[law], "linewidth": width, "markersize": 5}
        panel.plot(across, up, f"{marker}-", label=said, **look)
        for value, x, y in zip(found.values, across, up, strict=True):
            if value in _MARKED.get(said, ()) and math.isfinite(x):
                # Beside the steep curve, below the flat one.
                place = (8, -4) if law == "pop" else (-5, -14)
                look = {"xytext": place, "textcoords": "offset points", "color": theme.text}
                panel.annotate(f"{value:.3g}", (x, y), fontsize=8.5, **look)
    panel.set(xlabel="dead time that may be added [ms]", xlim=(0.0, None), ylim=(-0.08, 1.45))
    panel.set_ylabel("offset in the bend [m]")
    panel.set_title(f"A bend of {RADIUS:g} m radius at {SPEED:g} m/s", pad=8)
    panel.legend(fontsize=8.5, loc="upper left")
    return figure


def main() -> None:
    """Draw both figures."""
    write_figures(
        {
            "carrot-offset": partial(carrot_figure, carrot_curve(vehicles.get("carla-identified"))),
            "preview-choice": partial(choice_figure, choice_curves()),
        }
    )


if __name__ == "__main__":
    main()
