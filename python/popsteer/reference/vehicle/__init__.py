"""The vehicle: its parameters, and the chain from a command to its motion.

`delay` holds the commands in flight, `wheels` answer them, `bicycle` moves.
"""

from __future__ import annotations

from dataclasses import dataclass

from popsteer.reference.bounds import MAX_SPEED
from popsteer.reference.error import Checked, input_within, number, optional
from popsteer.reference.math import cos, saturate, sin

__all__ = ["Vehicle"]


@dataclass(frozen=True, kw_only=True)
class Vehicle(Checked):
    """All parameters of a car-like vehicle, in one immutable value.

    A *pose* is always that of the vehicle's point, wherever it is measured; the axles are given
    from there. One chain leads from a command to the motion of the vehicle::

        wheel' = clip((command(t - dead_time) + steer_offset - wheel) / steer_lag, ±max_steer_rate)
        |wheel| ≤ max_steer
        yaw'   = speed tan(wheel) / (turning_wheelbase + understeer speed²)

    and the no-slip point moves along the vehicle's heading.

    Raises `ConfigError`, naming the field that is out of its range.

    Examples
    --------
    >>> car = Vehicle(wheelbase=2.7, rear_axle=-1.35, understeer=0.002)
    >>> car.front_axle, round(car.turning_length(10.0), 9)
    (1.35, 2.9)
    >>> Vehicle(dead_time=-0.1)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: dead_time must be in [0, 10], got -0.1
    """

    wheelbase: float = number(3.0, 1e-3, 1e3)
    """Distance of the axles L [m]; the default lengths of all parameters scale with it."""
    width: float | None = optional(1e-3, 1e2)
    """Width over all [m]; no monitor here asks for it. None: two thirds of the wheelbase."""
    rear_axle: float = number(0.0, -1e3, 1e3)
    """How far ahead of the pose's point the rear axle lies [m]."""
    antenna_left: float = number(0.0, -1e2, 1e2)
    """How far left of the centre line the antenna lies whose position is the pose's [m]."""
    antenna_height: float = number(0.0, 0.0, 1e2)
    """How high above ground it lies [m]."""
    no_slip_point: float | None = optional(-1e3, 1e3)
    """The same of the point that moves along the vehicle's heading; None is the rear axle."""
    turning_wheelbase: float | None = optional(1e-3, 1e3)
    """The wheelbase that the vehicle turns by [m]; None is `wheelbase`."""
    understeer: float = number(0.0, 0.0, 1e3)
    """Understeer gradient K [s²/m]."""
    steer_offset: float = number(0.0, -0.5, 0.5)
    """Angle of the wheels at the command 0 [rad]."""
    steer_lag: float = number(0.1, 0.0, 10.0)
    """Time constant of the wheels' first-order response to a command [s]."""
    dead_time: float = number(0.0, 0.0, 10.0)
    """Time from a command to its first effect on the wheels [s]."""
    max_steer: float = number(1.22, 1e-3, 1.57)
    """Largest angle of the front wheels δ_max [rad]."""
    max_steer_rate: float | None = optional(1e-3, 1e6)
    """Largest rate of the front wheels' angle [rad/s]; None for no limit."""
    steer_play: float = number(0.0, 0.0, 0.5)
    """By how much the steering turns back before the wheels do [rad]; prediction ignores it."""
    max_lateral_acceleration: float | None = optional(1e-3, 1e6, default=4.0)
    """Largest lateral acceleration that a command may ask for [m/s²]; None for no limit."""
    max_speed: float | None = optional(1e-3, 1e4)
    """Top speed [m/s]; None for no limit."""
    max_acceleration: float | None = optional(1e-3, 1e3)
    """Largest driving acceleration [m/s²]; None where it is not known."""
    max_deceleration: float | None = optional(1e-3, 1e3)
    """Largest deceleration of a plan [m/s²], one of comfort; None where it is not known."""
    brake_deceleration: float | None = optional(1e-3, 1e3)
    """What the brakes can do [m/s²]; None where it is not known."""
    drive_delay: float = number(0.1, 0.0, 10.0)
    """Time from a command to its first effect on the drive [s]."""
    drive_lag: float = number(0.0, 0.0, 10.0)
    """Time constant of the drive's first-order response to the pedals [s]."""
    stop_point: float | None = optional(-1e3, 1e3)
    """The point that stops at a stop line, ahead of the pose's point [m]; None: the rear axle."""
    steers_at_rest: bool = False
    """Whether the wheels turn while the vehicle stands."""

    @property
    def front_axle(self) -> float:
        """How far ahead of the pose's point the front axle lies [m]."""
        return self.rear_axle + self.wheelbase

    def antenna_offset(self, roll: float) -> float:
        """Return how far left of the centre line the antenna is at this `roll` [rad], to the right.

        Examples
        --------
        >>> round(Vehicle(antenna_left=0.5, antenna_height=3.0).antenna_offset(0.08), 6)
        0.258657
        """
        if self.antenna_height == 0.0 and self.antenna_left == 0.0:
            return 0.0
        return self.antenna_left * cos(roll) - self.antenna_height * sin(roll)

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

    @property
    def comfort_braking(self) -> float:
        """Largest braking deceleration of a plan for this vehicle [m/s²], one of comfort.

        Examples
        --------
        >>> Vehicle().comfort_braking
        3.0
        """
        comfort = 3.0 if self.max_deceleration is None else self.max_deceleration
        brakes = self.brake_deceleration
        return brakes if brakes is not None and brakes < comfort else comfort

    def at_wheels(self, angle: float) -> float:
        """Return the angle nearest to `angle` that the wheels can stand at [rad].

        Examples
        --------
        >>> Vehicle(max_steer=0.5).at_wheels(-0.6)
        -0.5
        """
        return saturate(angle, -self.max_steer, self.max_steer)
