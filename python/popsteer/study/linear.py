"""Steering loops in small signals: a law and a vehicle about straight driving at one speed.

The vehicle is the kinematic bicycle with a first-order lag τ from command to yaw rate and a dead
time; e₀ is the offset of the point that does not slip, ψ the heading error, r the yaw rate::

    e₀' = v ψ      ψ' = r      τ r' = v δ / (L + K v²) - r

The law sees e = e₀ + a ψ at its reference point a ahead, and commands δ = -(C_e(z) e + C_ψ(z) ψ),
where C_e and C_ψ divide by the same polynomial D(z) if the law remembers what it commanded. It is
held for the control period Δt. Sampling is exact: the vehicle's step response is known in closed
form, and a dead time that is no multiple of Δt splits a period in two. Broken at the command, the
loop has the gain::

    L(z) = C_e(z) (E₀(z) + a Ψ(z)) + C_ψ(z) Ψ(z)

and its closed loop the poles where 1 + L(z) = 0.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np

from popsteer import laws
from popsteer._core import (
    PidParams,
    PopParams,
    PreviewPopParams,
    PurePursuitParams,
    StanleyParams,
)
from popsteer.errors import ConfigError
from popsteer.ranges import check_in_range
from popsteer.reference.math import decay
from popsteer.study.linear_preview import preview_pop

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from numpy.typing import NDArray

    from popsteer.laws import Params
    from popsteer.study.vehicle import Vehicle

_Weights: TypeAlias = tuple[list[float], list[float], list[float]]

__all__ = ["LinearLaw", "Loop", "linearised", "lookahead"]


class LinearLaw(NamedTuple):
    """A law in small signals.

    Σ steer[i] δ(k - i) = -Σ cross_track[i] e(k - i) - Σ heading[i] ψ(k - i)
    """

    offset: float
    """Where e is measured, ahead of the point that does not slip [m]."""
    cross_track: NDArray[np.float64]
    """Weights of the cross-track errors, the latest first [rad/m]."""
    heading: NDArray[np.float64]
    """Weights of the heading errors, the latest first [-]."""
    steer: NDArray[np.float64] = np.ones(1)
    """Weights of the angles, the latest first [-]; of that it is 1."""


def lookahead(params: Params, speed: float) -> float | None:
    """Give the lookahead distance of a law.

    Parameters
    ----------
    params : any class of parameters
        Parameters of the law.
    speed : float
        Speed [m/s].

    Returns
    -------
    float or None
        The distance [m]; None of a law that has none.

    Examples
    --------
    >>> lookahead(PopParams(), 10.0), lookahead(PurePursuitParams(), 20.0)
    (8.0, 18.0)
    """
    if isinstance(params, PopParams):
        return params.min_lookahead + params.lookahead_gain * speed
    if isinstance(params, PurePursuitParams):
        return max(params.min_lookahead, params.lookahead_gain * speed)
    return None


def _pop(params: PopParams, speed: float, _dt: float) -> _Weights:
    """δ = β - ψ with the bearing β = -asin(e / ld) of the lookahead point."""
    return [1.0 / _positive_lookahead(params, speed)], [1.0], [1.0]


def _pure_pursuit(params: PurePursuitParams, speed: float, _dt: float) -> _Weights:
    """δ = atan(2 L sin α / ld) with α = β - ψ."""
    distance = _positive_lookahead(params, speed)
    gain = 2.0 * params.wheelbase / distance
    return [gain / distance], [gain], [1.0]


def _stanley(params: StanleyParams, speed: float, _dt: float) -> _Weights:
    """δ = -(ψ + atan(k e / (k_s + k_v v)))."""
    return [params.cross_track_gain / (params.softening + params.speed_gain * speed)], [1.0], [1.0]


def _pid(params: PidParams, _speed: float, dt: float) -> _Weights:
    """δ = -(k_P e + k_I Σ e Δt + k_D Δe / Δt), the sum over the buffer."""
    term = params.ki * (dt if params.integral_with_dt else 1.0)
    weights = [term] * max(params.buffer_length, 2)
    if params.buffer_length == 1:
        weights[1] = 0.0
    weights[0] += params.kp + params.kd / dt
    weights[1] -= params.kd / dt
    return weights, [0.0], [1.0]


_LINEAR: dict[type[Any], Callable[[Any, float, float], _Weights]] = {
    PopParams: _pop,
    PurePursuitParams: _pure_pursuit,
    StanleyParams: _stanley,
    PidParams: _pid,
    PreviewPopParams: preview_pop,
}


def linearised(params: Params, speed: float, dt: float) -> LinearLaw:
    """Linearise a law about straight driving on the path.

    POP is taken without its grid of candidates and within the span that it may move in one step,
    pure pursuit without `alpha_by_arccos`, whose bearing has no slope at zero; both with the
    lookahead point inside the window that is searched. Preview POP is taken within its limits.

    Parameters
    ----------
    params : PopParams or PurePursuitParams or StanleyParams or PidParams or PreviewPopParams
        Parameters of the law, with its reference point.
    speed : float
        Speed [m/s], positive.
    dt : float
        Control period [s].

    Returns
    -------
    LinearLaw
        Its weights.

    Raises
    ------
    ConfigError
        The law has no linear loop, no reference point or no lookahead.

    Examples
    --------
    >>> law = linearised(PopParams(reference_offset=3.0), 10.0, 0.05)
    >>> law.offset, law.cross_track.tolist(), law.heading.tolist()
    (3.0, [0.125], [1.0])
    """
    make = _LINEAR.get(type(params))
    if make is None:
        known = ", ".join(laws.name_of(kind) for kind in _LINEAR)
        raise ConfigError("law", laws.name_of(type(params)), f"one with a linear loop: {known}")
    if params.reference_offset is None:
        raise ConfigError("reference_offset", None, "given; see Vehicle.fitted")
    check_in_range("speed", speed, 1e-3, 1e3)
    check_in_range("dt", dt, 1e-3, 1.0)
    return LinearLaw(params.reference_offset, *map(np.array, make(params, speed, dt)))


class Loop:
    """The loop of a law and a vehicle at one speed, on a grid of frequencies.

    Parameters
    ----------
    law : LinearLaw
        The law.
    vehicle : Vehicle
        The vehicle.
    speed : float
        Speed v [m/s].
    dt : float
        Control period Δt [s].
    frequencies : int, default 3000
        How many frequencies there are up to the half of the control rate.

    Examples
    --------
    >>> from popsteer.study import Vehicle
    >>> law = linearised(PopParams(reference_offset=3.0), 10.0, 0.05)
    >>> loop = Loop(law, Vehicle(), 10.0, 0.05)
    >>> loop.is_stable(), loop.is_stable(dead_time=0.5)
    (True, False)
    """

    def __init__(
        self, law: LinearLaw, vehicle: Vehicle, speed: float, dt: float, frequencies: int = 3000
    ) -> None:
        slow = np.geomspace(1e-5, 0.1, frequencies // 4, endpoint=False)
        angles = np.concatenate((slow, np.linspace(0.1, math.pi, frequencies - len(slow))))
        self.angles = angles
        """Frequencies ω Δt [rad], up to π."""
        self._vehicle, self._speed, self._dt, self._offset = vehicle, speed, dt, law.offset
        self._back = np.exp(-1j * angles)  # 1 / z
        self._cross_track = np.polynomial.polynomial.polyval(self._back, law.cross_track)
        self._heading = np.polynomial.polynomial.polyval(self._back, law.heading)
        self._steer = np.polynomial.polynomial.polyval(self._back, law.steer)

    def gain(self, dead_time: float | None = None) -> NDArray[np.complex128]:
        """Evaluate L at the frequencies.

        Parameters
        ----------
        dead_time : float, optional
            Dead time [s], instead of the vehicle's.

        Returns
        -------
        (N,) ndarray of complex
            The gain of the open loop, broken at the command.
        """
        dead_time = self._vehicle.dead_time if dead_time is None else dead_time
        speed, dt, lag, back = self._speed, self._dt, self._vehicle.lag, self._back
        steps = math.floor(dead_time / dt + 1e-9)
        # A command acts first at the end of a period, for what the dead time leaves of it.
        first = self._step_response(dt - max(dead_time - steps * dt, 0.0))
        rest = self._step_response(dt) - first
        pushed = back**steps * (first[:, None] + rest[:, None] * back)

        kept = decay(dt, lag)
        swing = lag * (1.0 - kept)  # what a yaw rate turns the car by before it has died out
        z = 1.0 / back
        rate = pushed[2] / (z - kept)
        yaw = (pushed[1] + swing * rate) / (z - 1.0)
        offset = (pushed[0] + speed * dt * yaw + speed * lag * (dt - swing) * rate) / (z - 1.0)
        seen = offset + self._offset * yaw
        return np.asarray((self._cross_track * seen + self._heading * yaw) / self._steer)

    def is_stable(self, dead_time: float | None = None) -> bool:
        """Tell whether all poles of the closed loop lie inside the unit circle.

        D (1 + L) (1 - 1/z)² (1 - E/z), with E the decay of the lag over Δt, has no pole outside the
        circle, so by the principle of the argument the loop is stable exactly where its phase comes
        back to where it was on the way from ω = 0 to π / Δt.

        Parameters
        ----------
        dead_time : float, optional
            Dead time [s], instead of the vehicle's.

        Returns
        -------
        bool
            Whether it is stable.
        """
        kept = decay(self._dt, self._vehicle.lag)
        back = self._back
        value = self._steer * (1.0 + self.gain(dead_time))
        value *= (1.0 - back) ** 2 * (1.0 - kept * back)
        phase = np.unwrap(np.angle(value))
        return bool(abs(phase[-1] - phase[0]) < 0.5 * math.pi)

    def _step_response(self, time: float) -> NDArray[np.float64]:
        """Offset, heading and yaw rate some time after a unit step of the angle, from rest."""
        vehicle, speed = self._vehicle, self._speed
        turning = speed / (vehicle.wheelbase + vehicle.understeer * speed * speed)
        kept, lag = decay(time, vehicle.lag), vehicle.lag
        swing = lag * (1.0 - kept)
        heading = time - swing
        offset = speed * (0.5 * time * time - lag * heading)
        return turning * np.array([offset, heading, 1.0 - kept])


def _positive_lookahead(params: PopParams | PurePursuitParams, speed: float) -> float:
    distance = lookahead(params, speed)
    if not distance:
        raise ConfigError("lookahead", distance, "positive")
    return distance
