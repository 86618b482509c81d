"""By how much following the carrot cuts a bend: in closed form, and driven.

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
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from popsteer import sim, vehicles
from popsteer._core import Path, Pop, PopParams, SpeedPid
from popsteer.errors import ConfigError
from popsteer.lab.stability.linear import lookahead, no_slip
from popsteer.ranges import check_in_range

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from popsteer._core import Vehicle

LATERAL = 2.0
"""Lateral acceleration in the bends of `carrot_curve` [m/s²]."""
_RADII = (12.0, 15.0, 20.0, 25.0, 30.0, 40.0, 60.0, 80.0, 120.0)


class Carrot(NamedTuple):
    """Offset of POP over the radius of a circle, computed and driven."""

    radii: NDArray[np.float64]
    """Radii of the computed curves [m]."""
    computed: NDArray[np.float64]
    """`carrot_offset` at each [m]."""
    rope: NDArray[np.float64]
    """R - √(R² - ld²) at each [m]."""
    driven_radii: NDArray[np.float64]
    """Radii that were driven [m]."""
    driven: NDArray[np.float64]
    """`driven_offset` at each [m]."""


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


def driven_offset(radius: float, plant: sim.Plant, speed: float) -> tuple[float, float]:
    """Drive POP round a circle and measure the offset that it keeps.

    Parameters
    ----------
    radius : float
        Radius of the circle [m].
    plant : str or CarlaIdentified or KinematicBicycle
        What moves; POP is given its vehicle.
    speed : float
        Reference speed [m/s].

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
    count = max(round(2.0 * math.pi * radius / 0.5), 16)
    angle = np.arange(count) * (2.0 * math.pi / count)
    xy = radius * np.column_stack((np.sin(angle), 1.0 - np.cos(angle)))
    path = Path(xy, speed=np.full(count, speed), closed=True)
    pop = Pop(path, sim.vehicle_of(plant))
    result = sim.run(
        pop,
        plant,
        start=(0.0, 0.0, 0.0),
        start_at="front",
        longitudinal=SpeedPid(),
    )
    records = result.records
    half = records["time"] > 0.5 * records["time"][-1]
    reach = lookahead(pop.params, pop.vehicle, float(records["speed"][half].mean()))
    return float(records["cross_track_error"][half].mean()), reach or 0.0


def carrot_curve(plant: str) -> Carrot:
    """Compute and drive the offset of POP on circles of many radii.

    The plant is given by its name; the lateral acceleration is `LATERAL`. Raises ConfigError where
    no plant has this name.
    """
    vehicle = vehicles.get(plant)
    radii = np.geomspace(_RADII[0], _RADII[-1], 60)
    speeds = np.sqrt(LATERAL * radii)
    reach = np.array(
        [lookahead(PopParams(), vehicle, float(speed)) for speed in speeds], dtype=np.float64
    )
    computed = [
        carrot_offset(float(ld), float(radius), vehicle, float(speed))
        for ld, radius, speed in zip(reach, radii, speeds, strict=True)
    ]
    driven = [driven_offset(radius, plant, math.sqrt(LATERAL * radius))[0] for radius in _RADII]
    rope = radii - np.sqrt(radii**2 - reach**2)
    return Carrot(radii, np.array(computed), rope, np.array(_RADII), np.array(driven))
