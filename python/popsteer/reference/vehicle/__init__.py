"""The vehicle: its parameters, prediction, commands in flight, and estimation from its motion.

`bicycle` predicts, `delay` holds the commands in flight, `estimator` finds what the motion shows.
"""

from __future__ import annotations

from dataclasses import dataclass

from popsteer.reference.bounds import MAX_SPEED
from popsteer.reference.error import config_in_range, config_optional, input_within
from popsteer.reference.math import saturate

__all__ = ["Vehicle"]


@dataclass(frozen=True, kw_only=True)
class Vehicle:
    """All that is true of a car-like vehicle, given once.

    A *pose* is always that of the vehicle's point, wherever it is measured; the axles are given
    from there. One chain leads from a command to the motion of the vehicle::

        wheel' = clip((command(t - dead_time) + steer_offset - wheel) / steer_lag, ±max_steer_rate)
        |wheel| ≤ max_steer
        yaw'   = speed tan(wheel) / (turning_wheelbase + understeer speed²)

    and the no-slip point moves along the vehicle's heading.

    Attributes
    ----------
    wheelbase : float
        Distance of the axles L [m]; the default lengths of all parameters scale with it.
    rear_axle : float
        How far ahead of the pose's point the rear axle lies [m]: 0 where the pose is the rear
        axle's, negative where it is of a point ahead of that.
    no_slip_point : float or None
        How far ahead of the pose's point lies the no-slip point [m], the one that moves along the
        vehicle's heading; None is the rear axle.
    turning_wheelbase : float or None
        The wheelbase that the vehicle turns by [m]; None is `wheelbase`.
    understeer : float
        Understeer gradient K [s²/m].
    steer_offset : float
        Angle of the wheels at the command 0 [rad].
    steer_lag : float
        Time constant of the wheels' first-order response to a command [s].
    dead_time : float
        Time from a command to its first effect on the wheels [s].
    max_steer : float
        Largest angle of the front wheels δ_max [rad].
    max_steer_rate : float or None
        Largest rate of the front wheels' angle [rad/s]; None for no limit.
    max_lateral_acceleration : float or None
        Largest lateral acceleration that a command may ask for [m/s²]; None for no limit.
    max_speed : float or None
        Top speed [m/s]; None for no limit.
    max_acceleration : float or None
        Largest driving acceleration [m/s²]; None where it is not known.
    max_deceleration : float or None
        Largest braking deceleration [m/s²]; None where it is not known.
    drive_lag : float
        Time constant with which the drive answers the pedals [s].

    Raises
    ------
    ConfigError
        Naming the field that is out of its range.

    Examples
    --------
    >>> car = Vehicle(wheelbase=2.7, rear_axle=-1.35, understeer=0.002)
    >>> car.front_axle, round(car.turning_length(10.0), 9)
    (1.35, 2.9)
    >>> Vehicle(dead_time=-0.1)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: dead_time must be in [0, 10], got -0.1
    """

    wheelbase: float = 3.0
    rear_axle: float = 0.0
    no_slip_point: float | None = None
    turning_wheelbase: float | None = None
    understeer: float = 0.0
    steer_offset: float = 0.0
    steer_lag: float = 0.1
    dead_time: float = 0.0
    max_steer: float = 1.22
    max_steer_rate: float | None = None
    max_lateral_acceleration: float | None = 4.0
    max_speed: float | None = None
    max_acceleration: float | None = None
    max_deceleration: float | None = None
    drive_lag: float = 0.0

    def __post_init__(self) -> None:
        config_in_range(self, "wheelbase", 1e-3, 1e3)
        config_in_range(self, "rear_axle", -1e3, 1e3)
        config_optional(self, "no_slip_point", -1e3, 1e3)
        config_optional(self, "turning_wheelbase", 1e-3, 1e3)
        config_in_range(self, "understeer", 0.0, 1e3)
        config_in_range(self, "steer_offset", -0.5, 0.5)
        config_in_range(self, "steer_lag", 0.0, 10.0)
        config_in_range(self, "dead_time", 0.0, 10.0)
        config_in_range(self, "max_steer", 1e-3, 1.57)
        config_optional(self, "max_steer_rate", 1e-3, 1e6)
        config_optional(self, "max_lateral_acceleration", 1e-3, 1e6)
        config_optional(self, "max_speed", 1e-3, 1e4)
        config_optional(self, "max_acceleration", 1e-3, 1e3)
        config_optional(self, "max_deceleration", 1e-3, 1e3)
        config_in_range(self, "drive_lag", 0.0, 10.0)

    @property
    def front_axle(self) -> float:
        """How far ahead of the pose's point the front axle lies [m]."""
        return self.rear_axle + self.wheelbase

    @property
    def no_slip(self) -> float:
        """How far ahead of the pose's point the no-slip point lies [m].

        Examples
        --------
        >>> Vehicle(rear_axle=-1.25).no_slip, Vehicle(no_slip_point=0.5).no_slip
        (-1.25, 0.5)
        """
        return self.rear_axle if self.no_slip_point is None else self.no_slip_point

    def turning_length(self, speed: float) -> float:
        """Return the length that turns an angle of the wheels into a curvature [m].

        The curvature at `speed` [m/s] is tan(wheel) / turning_length.

        Raises
        ------
        InputError
            Where the speed is not finite or beyond its bound.
        """
        speed = input_within("speed", speed, MAX_SPEED)
        base = self.wheelbase if self.turning_wheelbase is None else self.turning_wheelbase
        return base + self.understeer * speed * speed

    def at_wheels(self, angle: float) -> float:
        """Return the angle nearest to `angle` that the wheels can stand at [rad].

        Examples
        --------
        >>> Vehicle(max_steer=0.5).at_wheels(-0.6)
        -0.5
        """
        return saturate(angle, -self.max_steer, self.max_steer)
