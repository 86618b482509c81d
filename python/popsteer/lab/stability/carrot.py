"""Offsets in a bend: following the carrot cuts it, in closed form and driven; preview POP hardly.

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
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from popsteer import sim
from popsteer._core import AdaptParams, Path, Pop, PopParams, PreviewPopParams, SpeedPid, Vehicle
from popsteer.errors import ConfigError
from popsteer.lab.stability.linear import lookahead, no_slip, preview_gains
from popsteer.lab.stability.runs import margins
from popsteer.ranges import check_in_range

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray


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
    """Offset that follow-the-carrot from the front axle keeps on a circle.

    Parameters
    ----------
    distance : float
        Lookahead distance ld [m].
    radius : float
        Radius R of the circle [m], greater than `distance`.
    vehicle : Vehicle
        The vehicle.
    speed : float, default 0.0
        Speed v [m/s]; counts where the vehicle understeers.

    Returns
    -------
    float
        How far inside the circle the front axle runs [m].

    Raises
    ------
    ConfigError
        A number is out of its range, or the vehicle cannot turn so tightly.

    Examples
    --------
    >>> from popsteer import Vehicle
    >>> round(carrot_offset(8.0, 50.0, Vehicle()), 6) == round(50.0 - (50.0**2 - 8.0**2) ** 0.5, 6)
    True
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


def driven_offset(
    radius: float,
    plant: sim.Plant,
    speed: float,
    params: PopParams | None = None,
    vehicle: Vehicle | None = None,
    dt: float = 0.05,
) -> tuple[float, float]:
    """Drive POP round a circle and measure the offset that it keeps.

    Parameters
    ----------
    radius : float
        Radius of the circle [m].
    plant : str or CarlaIdentified or KinematicBicycle
        What moves.
    speed : float
        Reference speed [m/s].
    params : PopParams, optional
        POP's tuning.
    vehicle : Vehicle, optional
        What POP is given; the plant's by default.
    dt : float, default 0.05
        Control period [s].

    Returns
    -------
    offset : float
        Mean offset of the front axle over the second half of a lap, to the inside [m].
    lookahead : float
        Mean lookahead distance there [m].

    Raises
    ------
    ConfigError
        No plant has this name.

    Examples
    --------
    >>> offset, distance = driven_offset(50.0, "kinematic-bicycle", 8.0)
    >>> round(offset, 1), round(distance, 1)
    (0.6, 7.6)
    """
    xy = circle(radius)
    path = Path(xy, speed=np.full(len(xy), speed), closed=True)
    pop = Pop(path, sim.vehicle_of(plant) if vehicle is None else vehicle, params)
    found = sim.run(
        pop,
        plant,
        start=(0.0, 0.0, 0.0),
        start_at="front",
        longitudinal=SpeedPid(),
        settings=sim.Settings(dt=dt),
    )
    records = found.records
    half = records["time"] > 0.5 * records["time"][-1]
    reach = lookahead(pop.params, pop.vehicle, float(records["speed"][half].mean()))
    return float(records["cross_track_error"][half].mean()), reach or 0.0


def circle(radius: float) -> NDArray[np.float64]:
    """Give waypoints every half metre, 150 at least, on a circle to the left, from the origin."""
    count = max(round(2.0 * math.pi * radius / 0.5), 150)
    angle = np.arange(count) * (2.0 * math.pi / count)
    return radius * np.column_stack((np.sin(angle), 1.0 - np.cos(angle)))


def carrot_curve(
    vehicle: Vehicle,
    params: PopParams | None = None,
    believed: Vehicle | None = None,
    dt: float = 0.05,
) -> Carrot:
    """Compute and drive POP's offset at `LATERAL` m/s² on circles of many radii.

    They are 4 to 40 wheelbases of `vehicle`, a kinematic bicycle, as far as it can drive them and
    they are wider than the lookahead. `believed` is what POP is given. Nothing may be left.
    """
    params = PopParams() if params is None else params
    believed = vehicle if believed is None else believed

    def computed(radius: float) -> tuple[float, float, float] | None:
        """Offset, that of a rope, and speed; None where it cannot be driven."""
        speed = math.sqrt(LATERAL * radius)
        reach = lookahead(params, believed, speed) or 0.0
        tightest = vehicle.turning_length(speed) / math.tan(vehicle.max_steer)
        try:
            offset = carrot_offset(reach, radius, vehicle, speed)
        except ConfigError:
            return None
        if math.hypot(tightest, vehicle.front_axle - no_slip(vehicle)) > radius - offset:
            return None
        return offset, radius - math.sqrt(radius**2 - reach**2), speed

    def along(radii: NDArray[np.float64]) -> NDArray[np.float64]:
        rows = [(each, *row) for each in radii.tolist() if (row := computed(each)) is not None]
        return np.array(rows).reshape(-1, 4).T

    wide = vehicle.wheelbase * np.array(_RADII)
    radii, offsets, rope, _ = along(np.geomspace(wide[0], wide[-1], 60))
    corners, _, _, speeds = along(wide)
    plant = sim.KinematicBicycle(vehicle)
    driven = [
        driven_offset(radius, plant, speed, params, believed, dt)[0]
        for radius, speed in zip(corners.tolist(), speeds.tolist(), strict=True)
    ]
    return Carrot(radii, offsets, rope, corners, np.array(driven))


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
    """Offset that preview POP keeps in a steady bend.

    Parameters
    ----------
    params : PreviewPopParams
        Tuning of the controller.
    vehicle : Vehicle
        The vehicle as it is.
    radius : float
        Radius R of the bend [m]; it should be wide against the wheelbase.
    speed : float
        Speed v [m/s], positive.
    dt : float, default 0.05
        Control period [s].
    believed : Vehicle, optional
        The vehicle that the controller is given; `vehicle` by default.
    adapt : AdaptParams or None, optional
        How the controller adapts; None: not at all. Left out: as it does by default.

    Returns
    -------
    float
        How far inside the bend its tracked point runs [m]; negative outside. 0 where it estimates
        how the vehicle turns.

    Raises
    ------
    ConfigError
        A number is out of its range.

    Examples
    --------
    >>> from popsteer import PreviewPopParams, Vehicle
    >>> preview_offset(PreviewPopParams(), Vehicle(), 50.0, 15.0, adapt=None)
    0.0
    >>> longer = Vehicle(turning_wheelbase=3.3)
    >>> offset = preview_offset(
    ...     PreviewPopParams(), Vehicle(), 50.0, 15.0, believed=longer, adapt=None
    ... )
    >>> 0.0 < offset < 0.1
    True
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
    params: PopParams | PreviewPopParams,
    vehicle: Vehicle,
    values: Sequence[float],
    *,
    radius: float = 50.0,
    speed: float = 15.0,
    dt: float = 0.05,
    believed: Vehicle | None = None,
    adapt: AdaptParams | Literal["auto"] | None = "auto",
) -> Choice:
    """Vary POP's lookahead [m] or preview POP's `steer_rate_cost` [m s/rad] in a bend.

    The other arguments are those of `preview_offset`; ConfigError where one is out of range.
    """
    found = []
    for value in values:
        changed: PopParams | PreviewPopParams
        if isinstance(params, PopParams):
            changed = params.replace(lookahead_gain=0.0, min_lookahead=value)
            offset = carrot_offset(value, radius, vehicle, speed)
        else:
            changed = params.replace(steer_rate_cost=value)
            offset = preview_offset(
                changed, vehicle, radius, speed, dt, believed=believed, adapt=adapt
            )
        margin = margins(changed, vehicle, speed, dt, believed=believed)
        found.append((value, margin.dead_time, offset))
    return Choice(*zip(*found, strict=True))
