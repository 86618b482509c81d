"""What is estimated of a vehicle, and how fast a controller adapts to it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from popsteer.reference.bounds import MAX_SPEED
from popsteer.reference.error import config_in_range, config_optional
from popsteer.reference.math import saturate

if TYPE_CHECKING:
    from popsteer.reference.vehicle import Vehicle

__all__ = ["AdaptParams", "Corrections", "Estimate"]


@dataclass(frozen=True, kw_only=True)
class AdaptParams:
    """How fast a controller adapts to its vehicle.

    Attributes
    ----------
    turn_time : float
        Time constant of the estimates of turning gain, steering offset and dead time [s]; 0
        switches them off. Shorter: faster, and more noise of the heading in the estimates.
    slip_time : float
        Time constant of the estimated slip [s]; 0 switches it off. Shorter: faster, and more noise
        of the position in the estimate.
    min_speed : float or None
        Below this speed the slip is not estimated [m/s], because the position moves too little to
        show it. None is 5/3 wheelbases a second.

    Raises
    ------
    ConfigError
        Naming the parameter that is out of its range.

    Examples
    --------
    >>> AdaptParams(turn_time=20)
    AdaptParams(turn_time=20.0, slip_time=5.0, min_speed=None)
    """

    turn_time: float = 10.0
    slip_time: float = 5.0
    min_speed: float | None = None

    def __post_init__(self) -> None:
        config_in_range(self, "turn_time", 0.0, 1e6)
        config_in_range(self, "slip_time", 0.0, 1e6)
        config_optional(self, "min_speed", 0.0, 1e3)


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """The vehicle as it is estimated: its parameters, corrected by what its motion has shown.

    Attributes
    ----------
    gain : float
        Ratio of the measured turning to that of the vehicle's parameters. Controllers use it for a
        vehicle with a dead time, and 1 for others.
    steer_offset : float
        Steering offset: angle of the wheels at the command 0 [rad].
    dead_time : float
        Time from a command to its first effect on the wheels [s].
    slip : float
        Slip of the no-slip point on a straight: direction of its motion less the heading [rad].
    slip_length : float
        Change of the slip per curvature [m].
    acceleration : float
        Acceleration [m/s²].

    Examples
    --------
    >>> from popsteer.reference import Path, PreviewPop, Vehicle
    >>> controller = PreviewPop(Path([(0.0, 0.0), (9.0, 0.0)]), Vehicle(dead_time=0.2))
    >>> controller.estimate.gain, controller.estimate.dead_time
    (1.0, 0.2)
    """

    gain: float = 1.0
    steer_offset: float = 0.0
    dead_time: float = 0.0
    slip: float = 0.0
    slip_length: float = 0.0
    acceleration: float = 0.0


@dataclass(frozen=True)
class Corrections:
    """The estimates as corrections to the vehicle's parameters; `Estimate` in the Rust core.

    As in an `Estimate`, except that `steer_offset` [rad] and `longer_dead_time` [s], which may be
    negative, are in addition to the vehicle's. Controllers use a `gain` of 1 for a vehicle without
    a dead time.
    """

    gain: float = 1.0
    steer_offset: float = 0.0
    longer_dead_time: float = 0.0
    slip: float = 0.0
    slip_length: float = 0.0
    acceleration: float = 0.0

    def speed_after(self, speed: float, time: float) -> float:
        """Return the speed after `time` [s] at the estimated acceleration; braking stops at 0.

        Examples
        --------
        >>> Corrections(acceleration=-4.0).speed_after(1.0, 0.5)
        0.0
        """
        following = speed + self.acceleration * time
        if speed >= 0.0:
            return saturate(following, 0.0, MAX_SPEED)
        return saturate(following, -MAX_SPEED, 0.0)

    def of(self, vehicle: Vehicle) -> Estimate:
        """Return the corrected parameters of `vehicle`."""
        return Estimate(
            gain=self.gain,
            steer_offset=vehicle.steer_offset + self.steer_offset,
            dead_time=vehicle.dead_time + self.longer_dead_time,
            slip=self.slip,
            slip_length=self.slip_length,
            acceleration=self.acceleration,
        )
