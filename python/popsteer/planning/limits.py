"""What limits the speed along a path."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from popsteer._core import Vehicle, _speed_defaults
from popsteer.errors import ConfigError
from popsteer.parameters import Parameters
from popsteer.ranges import check_in_range

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

DEFAULTS = {
    name: _speed_defaults[name]
    for name in ("max_speed", "max_lateral_acceleration", "max_acceleration", "max_deceleration")
}
"""The limits that stand for those that neither plan nor vehicle has, by name: those of the core."""
_OVER_SPEED = ("max_acceleration", "max_deceleration")


@dataclass(frozen=True)
class SpeedLimits(Parameters):
    """What limits the speed along a path.

    A limit that is None is the vehicle's of that name. If that is None, too, it is a brisk one for
    an ordinary car, far from the grip of a dry road: 25 m/s, 4 m/s² of lateral acceleration, 2 m/s²
    of driving, 3 m/s² of braking. Plans use 0.9 of the lateral acceleration: controllers steer up
    to the vehicle's limit, so the rest is for correcting errors in bends.

    Parameters
    ----------
    max_speed : float, optional
        Top speed [m/s].
    max_lateral_acceleration : float, optional
        Largest lateral acceleration [m/s²]; by default 0.9 times the vehicle's.
    max_acceleration : float or sequence of (float, float), optional
        Largest driving acceleration [m/s²]; or points (speed [m/s], acceleration), speeds
        increasing, straight between them and constant beyond.
    max_deceleration : float or sequence of (float, float), optional
        Largest braking deceleration [m/s²], in the same way.
    longitudinal_grip : float, optional
        What the tyres hold along the car [m/s²]: half axis of the friction ellipse. By default each
        of the two limits above is its own half axis, so that the ellipse is one of comfort.
    exponent : float, default 2.0
        Exponent p of (a_x / grip)^p + (a_y / max_lateral_acceleration)^p <= 1: 2 is an ellipse, 1 a
        rhombus, ``math.inf`` a rectangle.
    start_speed : float, default 0.0
        Speed at the first waypoint of an open path [m/s].
    end_speed : float, default 0.0
        Largest speed at its last waypoint [m/s].
    max_jerk : float, optional
        Largest change of the acceleration along the path [m/s³]; no limit by default. It needs the
        extra ``lab``.
    smoothing_length : float, optional
        Length over which the curvature is smoothed [m]; 2/3 of the wheelbase by default.

    Raises
    ------
    ConfigError
        A number is not in its range, or the speeds of a table do not increase.

    Examples
    --------
    >>> SpeedLimits(max_acceleration=[(0.0, 3.0), (20.0, 1.0)]).max_acceleration
    ((0.0, 3.0), (20.0, 1.0))
    >>> SpeedLimits(exponent=0.5)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: exponent must be in [1, inf], got 0.5
    """

    RANGES: ClassVar = {
        "max_speed": (1e-3, 1e4),
        "max_lateral_acceleration": (1e-3, 1e3),
        "longitudinal_grip": (1e-3, 1e3),
        "exponent": (1.0, math.inf),
        "start_speed": (0.0, 1e4),
        "end_speed": (0.0, 1e4),
        "max_jerk": (1e-3, 1e4),
        "smoothing_length": (1e-3, 1e3),
    }

    max_speed: float | None = None
    max_lateral_acceleration: float | None = None
    max_acceleration: float | Sequence[tuple[float, float]] | None = None
    max_deceleration: float | Sequence[tuple[float, float]] | None = None
    longitudinal_grip: float | None = None
    exponent: float = 2.0
    start_speed: float = 0.0
    end_speed: float = 0.0
    max_jerk: float | None = None
    smoothing_length: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in _OVER_SPEED:
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, _checked(name, value))

    def resolved(self, vehicle: Vehicle) -> SpeedLimits:
        """Fill in what is None.

        Parameters
        ----------
        vehicle : Vehicle
            Whose limits stand where there is none here.

        Returns
        -------
        SpeedLimits
            With a number in every field but `longitudinal_grip` and `max_jerk`.

        Raises
        ------
        ConfigError
            A limit here is beyond the vehicle's, or the start is faster than the top speed.

        Examples
        --------
        >>> import popsteer
        >>> car = popsteer.Vehicle(wheelbase=2.7, max_speed=14.0)
        >>> limits = SpeedLimits().resolved(car)
        >>> limits.max_speed, limits.max_acceleration, round(limits.smoothing_length, 3)
        (14.0, 2.0, 1.8)
        >>> SpeedLimits(max_speed=20.0).resolved(car)
        Traceback (most recent call last):
        popsteer.errors.ConfigError: max_speed must be at most the vehicle's, 14.0, got 20.0
        """
        found: dict[str, Any] = {}
        for name, default in DEFAULTS.items():
            own, cars = getattr(self, name), getattr(vehicle, name)
            if own is None:
                found[name] = default if cars is None else cars
                if name == "max_lateral_acceleration":
                    found[name] *= _speed_defaults["bend_share"]
            elif cars is not None and table_of(own)[1].max() > cars:
                raise ConfigError(name, own, f"at most the vehicle's, {cars!r}")
        if self.smoothing_length is None:
            found["smoothing_length"] = _speed_defaults["smoothing"] * vehicle.wheelbase
        limits = self.replace(**found)
        for name in ("start_speed", "end_speed"):
            if getattr(limits, name) > limits.max_speed:
                most = f"at most max_speed, {limits.max_speed!r}"
                raise ConfigError(name, getattr(limits, name), most)
        return limits


def table_of(limit: float | Sequence[tuple[float, float]]) -> tuple[Floats, Floats]:
    """Give a limit of the acceleration as speeds and values."""
    table = np.array([(0.0, limit)] if isinstance(limit, int | float) else limit, dtype=np.float64)
    return np.ascontiguousarray(table[:, 0]), np.ascontiguousarray(table[:, 1])


def _checked(name: str, value: Any) -> float | tuple[tuple[float, float], ...]:  # noqa: ANN401 - of any kind
    """Settle a limit of the acceleration, a number or a table over speed."""
    if isinstance(value, (int, float)):
        check_in_range(name, float(value), 1e-3, 1e3)
        return float(value)
    try:
        table = tuple((float(speed), float(most)) for speed, most in value)
    except (TypeError, ValueError):
        table = ()
    if not table:
        raise ConfigError(name, value, "a number or pairs of speed and acceleration")
    for speed, most in table:
        check_in_range(name, speed, 0.0, 1e4)
        check_in_range(name, most, 1e-3, 1e3)
    if not (np.diff([speed for speed, _ in table]) > 1e-6).all():
        raise ConfigError(name, value, "a table whose speeds increase")
    return table
