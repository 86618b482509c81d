"""Every sign and unit in which CARLA differs from popsteer.

CARLA is left-handed: x points forward, y to the right, yaw turns clockwise and is in degrees. Its
client keeps 32-bit floats: 0.01 mm in 100 m.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from statistics import fmean
from typing import TYPE_CHECKING, Any

from popsteer import Path
from popsteer.errors import PopsteerError
from popsteer.extras import require
from popsteer.ranges import check_in_range

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    import carla

_SPACING = 0.1
"""Waypoints closer than this to the one before are left out of a path [m]. CARLA's global planner
gives the ends of its segments twice; a few millimetres between them would be a corner."""

_LONGEST_WHEELBASE = 20.0
"""Wheels farther apart than this are given in centimetres, as CARLA 0.9 does [m]."""

_MAX_LOCK = 1.5
"""Largest angle of the wheels that is taken [rad]."""


def client_library() -> Any:  # noqa: ANN401 - the module, which is partly typed
    """Give CARLA's client library; PopsteerError where the extra ``carla`` is not installed."""
    require("CARLA's client", "carla")
    import carla

    return carla


def pose_of(transform: carla.Transform) -> tuple[float, float, float]:
    """Give the pose of an actor's or a waypoint's transform: (x, −y, −yaw) [m, m, rad].

    Examples
    --------
    >>> import carla
    >>> pose_of(carla.Transform(carla.Location(1.0, 2.0), carla.Rotation(yaw=90.0)))
    (1.0, -2.0, -1.5707963267948966)
    """
    place = transform.location
    return float(place.x), -float(place.y), -math.radians(transform.rotation.yaw)


def transform_of(x: float, y: float, yaw: float, z: float = 0.0) -> carla.Transform:
    """Give the transform of a pose [m, m, rad] at a height [m], as `pose_of` reads it.

    Examples
    --------
    >>> place = transform_of(1.0, 2.0, 0.5).location
    >>> place.x, place.y
    (1.0, -2.0)
    """
    carla = client_library()
    return carla.Transform(carla.Location(x=x, y=-y, z=z), carla.Rotation(yaw=-math.degrees(yaw)))


def speed_of(velocity: carla.Vector3D, transform: carla.Transform) -> float:
    """Give the signed speed [m/s]: the component of an actor's velocity [m/s] along its heading.

    It is negative while the actor rolls backwards.

    Examples
    --------
    >>> import carla
    >>> speed_of(carla.Vector3D(-3.0, 0.0, 0.0), carla.Transform())
    -3.0
    """
    ahead = transform.get_forward_vector()
    return float(velocity.x * ahead.x + velocity.y * ahead.y + velocity.z * ahead.z)


def speed_from_kmh(speed: float) -> float:
    """Give a speed in [m/s] that CARLA's agents and speed limits have in [km/h].

    Examples
    --------
    >>> speed_from_kmh(36.0)
    10.0
    """
    return speed / 3.6


def path_of(waypoints: Iterable[carla.Waypoint], offset: float = 0.0) -> Path:
    """Give the path through waypoints of a lane, in the order in which they are driven.

    A waypoint less than 0.1 m from the one before is left out. The path lies `offset` to the right
    of them [m], to the left where that is negative, and has no speeds. Raises PathError where fewer
    than two waypoints are apart.
    """
    return Path(thinned(waypoints, offset)[0])


def thinned(
    waypoints: Iterable[carla.Waypoint], offset: float = 0.0
) -> tuple[list[tuple[float, float]], list[int]]:
    """Give the points of `path_of` [m], and for each waypoint which of them stands for it."""
    xy: list[tuple[float, float]] = []
    index = []
    for waypoint in waypoints:
        x, y, yaw = pose_of(waypoint.transform)
        x, y = x + offset * math.sin(yaw), y - offset * math.cos(yaw)
        if not xy or math.dist(xy[-1], (x, y)) >= _SPACING:
            xy.append((x, y))
        index.append(len(xy) - 1)
    return xy, index


@dataclass(frozen=True)
class Steering:
    """What a share of full lock, CARLA's `steer`, is as an angle of the wheels.

    CARLA's server multiplies the share by the vehicle's steering curve at its present speed::

        angle = −steer · curve(3.6 |speed|) · lock

    Parameters
    ----------
    lock : float
        Angle of the front wheels at full lock [rad].
    curve : tuple of tuple of float, optional
        (speed [km/h], factor) in the order of speed; between them it is linear, beyond them it
        stays. None for a factor of 1.

    Raises
    ------
    ConfigError
        The lock is not in [0.01, 1.5].

    Examples
    --------
    >>> steering = Steering(lock=1.0, curve=((0.0, 1.0), (36.0, 0.5)))
    >>> steering.share(0.25, 10.0), steering.share(0.25, 0.0), steering.share(-2.0, 0.0)
    (-0.5, -0.25, 1.0)
    """

    lock: float
    curve: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        check_in_range("lock", self.lock, 0.01, _MAX_LOCK)

    def at_full(self, speed: float) -> float:
        """Give the angle of the wheels at full lock [rad], positive, at a speed [m/s].

        Examples
        --------
        >>> Steering(1.0, ((0.0, 1.0), (72.0, 0.5))).at_full(10.0)
        0.75
        """
        if not self.curve:
            return self.lock
        kmh = 3.6 * abs(speed)
        if kmh <= self.curve[0][0]:
            return self.lock * self.curve[0][1]
        for (begin, low), (end, high) in pairwise(self.curve):
            if kmh <= end:
                return self.lock * (low + (high - low) * (kmh - begin) / (end - begin))
        return self.lock * self.curve[-1][1]

    def share(self, angle: float, speed: float = 0.0) -> float:
        """Give CARLA's `steer`, −1 to 1, positive to the right, for an angle of the wheels [rad].

        Examples
        --------
        >>> Steering(lock=1.0).share(0.5)
        -0.5
        """
        return max(-1.0, min(-angle / self.at_full(speed), 1.0))

    def angle(self, share: float, speed: float = 0.0) -> float:
        """Give the angle of the wheels [rad], positive to the left, that CARLA's `steer` asks for.

        Examples
        --------
        >>> Steering(lock=1.0).angle(0.5)
        -0.5
        """
        return -max(-1.0, min(share, 1.0)) * self.at_full(speed)


def curve_of(points: Iterable[carla.Vector2D]) -> tuple[tuple[float, float], ...]:
    """Give the curve of `Steering` from a physics control; empty where its points do not rise."""
    curve = tuple((float(point.x), float(point.y)) for point in points)
    rises = all(a[0] < b[0] for a, b in pairwise(curve))
    sound = all(math.isfinite(speed) and 0.0 < factor <= 1.0 for speed, factor in curve)
    return curve if rises and sound else ()


def axles_of(
    wheels: Sequence[carla.WheelPhysicsControl], transform: carla.Transform
) -> tuple[float, float]:
    """Give the wheelbase, and how far ahead of the actor's point the rear axle lies [m].

    The first two wheels are the front ones. Their places are in [cm], or in [m] if only that gives
    a car's size. PopsteerError where they make no car around the actor.
    """
    if len(wheels) < 3:
        raise PopsteerError(
            f"the physics control has {len(wheels)} wheels: give wheelbase=... and rear_axle=..."
        )
    front, rear = _middle(wheels[:2]), _middle(wheels[2:])
    apart = math.dist(front, rear)
    scale = 0.01 if apart > _LONGEST_WHEELBASE else 1.0
    wheelbase = scale * apart
    if not wheelbase > 0.0:
        raise PopsteerError(
            "the physics control does not say where the wheels are: "
            "give wheelbase=... and rear_axle=..."
        )
    ahead = (front[0] - rear[0]) / apart, (front[1] - rear[1]) / apart
    place = transform.location
    rear_axle = (scale * rear[0] - place.x) * ahead[0] + (scale * rear[1] - place.y) * ahead[1]
    if not -2.0 * wheelbase < rear_axle < wheelbase:
        raise PopsteerError(
            f"the rear axle would lie {rear_axle:.1f} m ahead of the actor: "
            "let the world tick after the actor is spawned, or give rear_axle=..."
        )
    return wheelbase, rear_axle


def _middle(wheels: Sequence[carla.WheelPhysicsControl]) -> tuple[float, float]:
    return fmean(each.position.x for each in wheels), fmean(each.position.y for each in wheels)


def vehicle_control(
    steer: float,
    throttle: float,
    brake: float,
    *,
    steering: Steering,
    speed: float = 0.0,
    reverse: bool = False,
) -> carla.VehicleControl:
    """Give the control that turns the wheels to an angle.

    Parameters
    ----------
    steer : float
        Angle of the front wheels [rad], positive to the left.
    throttle, brake : float
        Pedals, 0 to 1.
    steering : Steering
        What a share of full lock is.
    speed : float, default 0.0
        Present speed [m/s], for the steering curve.
    reverse : bool, default False
        Whether the throttle drives backwards.

    Returns
    -------
    carla.VehicleControl
        For ``actor.apply_control``.

    Examples
    --------
    >>> vehicle_control(0.5, 0.25, 0.0, steering=Steering(lock=1.0)).steer
    -0.5
    """
    return client_library().VehicleControl(
        throttle=max(0.0, min(throttle, 1.0)),
        steer=steering.share(steer, speed),
        brake=max(0.0, min(brake, 1.0)),
        reverse=reverse,
    )


def ackermann_control(
    steer: float, speed: float, *, steer_rate: float = 0.0, acceleration: float = 0.0
) -> carla.VehicleAckermannControl:
    """Give the control that turns the wheels to an angle and leaves the pedals to CARLA.

    `steer` is the angle of the front wheels [rad], positive to the left; `speed` is to be gone at
    [m/s], negative backwards. The others are limits, 0 for none: of the wheels [rad/s] and [m/s²].
    It is for ``actor.apply_ackermann_control``.

    Examples
    --------
    >>> ackermann_control(0.5, 10.0).steer
    -0.5
    """
    return client_library().VehicleAckermannControl(
        steer=-steer, steer_speed=steer_rate, speed=speed, acceleration=acceleration
    )
