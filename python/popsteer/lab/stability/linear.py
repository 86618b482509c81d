"""Steering loops in small signals: a controller and a vehicle about straight driving at one speed.

The vehicle is the chain of `popsteer.Vehicle`: a dead time, wheels with a first-order lag τ, and a
bicycle; e₀ is the offset of the no-slip point, ψ the heading error, w the angle of the wheels::

    e₀' = v ψ      ψ' = v w / (L + K v²)      τ w' = δ - w

The controller sees e = e₀ + a ψ at its tracked point a ahead, and commands
δ = -(C_e(z) e + C_ψ(z) ψ + C_s(z) s), where all divide by the same polynomial D(z) if it remembers
what it commanded; s is the slip that it estimates. A controller that believes in a dead time sees e
and ψ as its own chain predicts them through the commands in flight. Commands are held for the
control period Δt. Sampling is exact: the vehicle's step response is known in closed form, and a
dead time that is no multiple of Δt splits a period in two. Broken at the command, the loop has the
gain::

    L(z) = (C_e E(z) + C_ψ Ψ(z) + C_s S(z)) / D(z)

of what the vehicle shows, and its closed loop the poles where 1 + L(z) = 0. What the controller
predicts from its own commands is part of D.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np

from popsteer import controllers
from popsteer._core import (
    PidParams,
    PopParams,
    PreviewPopParams,
    PurePursuitParams,
    StanleyParams,
)
from popsteer.errors import ConfigError
from popsteer.lab.stability.linear_preview import preview_pop
from popsteer.ranges import check_in_range
from popsteer.reference.math import decay

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from numpy.typing import NDArray

    from popsteer._core import Vehicle
    from popsteer.controllers import Params

_Response: TypeAlias = "NDArray[np.complex128]"

__all__ = ["LinearLaw", "Loop", "Weights", "linearised", "lookahead", "no_slip"]

_PREDICTION_STEP = 0.05  # the longest step of a controller's prediction [s]


class Weights(NamedTuple):
    """What a controller's angle is made of, each with the latest first.

    Σ steer[i] δ(k - i) = -Σ (cross_track[i] e(k - i) + heading[i] ψ(k - i) + slip[i] s(k - i))
    """

    cross_track: list[float]
    """Of the cross-track errors [rad/m]."""
    heading: list[float]
    """Of the heading errors [-]."""
    steer: list[float]
    """Of the angles [-]; of the latest it is 1."""
    slip: list[float]
    """Of the slip that is estimated [-]."""


class LinearLaw(NamedTuple):
    """A controller in small signals: `Weights` as arrays, and the point that it tracks."""

    tracked_point: float
    """Where e is measured, ahead of the pose's point [m]."""
    cross_track: NDArray[np.float64]
    """Weights of the cross-track errors, the latest first [rad/m]."""
    heading: NDArray[np.float64]
    """Weights of the heading errors, the latest first [-]."""
    steer: NDArray[np.float64] = np.ones(1)
    """Weights of the angles, the latest first [-]; of that it is 1."""
    slip: NDArray[np.float64] = np.zeros(1)
    """Weights of the slip that is estimated, the latest first [-]."""


def no_slip(vehicle: Vehicle) -> float:
    """Tell where the point lies that moves where the vehicle looks.

    Parameters
    ----------
    vehicle : Vehicle
        The vehicle.

    Returns
    -------
    float
        How far ahead of the pose's point [m].

    Examples
    --------
    >>> from popsteer import Vehicle
    >>> no_slip(Vehicle(rear_axle=-1.4)), no_slip(Vehicle(rear_axle=-1.4, no_slip_point=0.0))
    (-1.4, 0.0)
    """
    return vehicle.rear_axle if vehicle.no_slip_point is None else vehicle.no_slip_point


def lookahead(params: Params, vehicle: Vehicle, speed: float) -> float | None:
    """Give the lookahead distance of a controller.

    Parameters
    ----------
    params : any class of parameters
        Tuning of the controller.
    vehicle : Vehicle
        The vehicle that it is given, with which defaults scale.
    speed : float
        Speed [m/s].

    Returns
    -------
    float or None
        The distance [m]; None of a controller that has none.

    Examples
    --------
    >>> from popsteer import Vehicle
    >>> lookahead(PopParams(), Vehicle(), 10.0), lookahead(PurePursuitParams(), Vehicle(), 20.0)
    (8.0, 18.0)
    """
    if isinstance(params, PopParams):
        pop = params.resolved(vehicle)
        return _given(pop.min_lookahead) + pop.lookahead_gain * speed
    if isinstance(params, PurePursuitParams):
        pursuit = params.resolved(vehicle)
        return max(_given(pursuit.min_lookahead), pursuit.lookahead_gain * speed)
    return None


def _given(value: float | None) -> float:
    """Give a number that `resolved` has filled in."""
    return math.nan if value is None else value


def _pop(params: PopParams, vehicle: Vehicle, speed: float, _dt: float) -> Weights:
    """δ = β - ψ with the bearing β = -asin(e / ld) of the lookahead point."""
    return Weights([1.0 / _positive_lookahead(params, vehicle, speed)], [1.0], [1.0], [0.0])


def _pure_pursuit(params: PurePursuitParams, vehicle: Vehicle, speed: float, _dt: float) -> Weights:
    """δ = atan(2 L sin α / ld) with α = β - ψ."""
    distance = _positive_lookahead(params, vehicle, speed)
    gain = 2.0 * vehicle.wheelbase / distance
    return Weights([gain / distance], [gain], [1.0], [0.0])


def _stanley(params: StanleyParams, vehicle: Vehicle, speed: float, _dt: float) -> Weights:
    """δ = -(ψ + atan(k e / (k_s + k_v v)))."""
    softening = _given(params.resolved(vehicle).softening)
    pull = params.cross_track_gain / (softening + params.speed_gain * speed)
    return Weights([pull], [1.0], [1.0], [0.0])


def _pid(params: PidParams, vehicle: Vehicle, _speed: float, dt: float) -> Weights:
    """δ = -(k_P e + k_I Σ e Δt + k_D Δe / Δt), the sum over the buffer."""
    params = params.resolved(vehicle)
    kp, ki, kd = map(_given, (params.kp, params.ki, params.kd))
    term = ki * (dt if params.integral_with_dt else 1.0)
    weights = [term] * max(params.buffer_length, 2)
    if params.buffer_length == 1:
        weights[1] = 0.0
    weights[0] += kp + kd / dt
    weights[1] -= kd / dt
    return Weights(weights, [0.0], [1.0], [0.0])


def _preview_pop(params: PreviewPopParams, vehicle: Vehicle, speed: float, dt: float) -> Weights:
    return Weights(*preview_pop(params, vehicle, speed, dt))


_LINEAR: dict[type[Any], Callable[[Any, Vehicle, float, float], Weights]] = {
    PopParams: _pop,
    PurePursuitParams: _pure_pursuit,
    StanleyParams: _stanley,
    PidParams: _pid,
    PreviewPopParams: _preview_pop,
}


def linearised(params: Params, vehicle: Vehicle, speed: float, dt: float) -> LinearLaw:
    """Linearise a controller about straight driving on the path.

    POP is taken without its grid of candidates and within the span that it may move in one step,
    pure pursuit without `alpha_by_arccos`, whose bearing has no slope at zero; both with the
    lookahead point inside the window that is searched. Preview POP is taken within its limits. The
    gain and the steering offset that a controller estimates are taken as constants.

    Parameters
    ----------
    params : PopParams or PurePursuitParams or StanleyParams or PidParams or PreviewPopParams
        Tuning of the controller.
    vehicle : Vehicle
        The vehicle that it is given.
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
        The controller has no linear loop, or no lookahead.

    Examples
    --------
    >>> from popsteer import Vehicle
    >>> law = linearised(PopParams(), Vehicle(), 10.0, 0.05)
    >>> law.tracked_point, law.cross_track.tolist(), law.heading.tolist()
    (3.0, [0.125], [1.0])
    """
    make = _LINEAR.get(type(params))
    if make is None:
        known = ", ".join(controllers.name_of(kind) for kind in _LINEAR)
        raise ConfigError(
            "controller", controllers.name_of(type(params)), f"one with a linear loop: {known}"
        )
    check_in_range("speed", speed, 1e-3, 1e3)
    check_in_range("dt", dt, 1e-3, 1.0)
    weights = make(params, vehicle, speed, dt)
    return LinearLaw(
        _tracked_point(params, vehicle),
        cross_track=np.array(weights.cross_track),
        heading=np.array(weights.heading),
        steer=np.array(weights.steer),
        slip=np.array(weights.slip),
    )


def _tracked_point(params: Params, vehicle: Vehicle) -> float:
    """Tell how far ahead of the pose's point the tracked point lies [m]."""
    axle = controllers.get(controllers.name_of(type(params))).axle
    if axle == "front":
        return vehicle.front_axle
    return vehicle.rear_axle if axle == "rear" else no_slip(vehicle)


class Loop:
    """The loop of a controller and a vehicle at one speed, on a grid of frequencies.

    Parameters
    ----------
    law : LinearLaw
        The controller.
    vehicle : Vehicle
        The vehicle as it is.
    speed : float
        Speed v [m/s].
    dt : float
        Control period Δt [s].
    believed : Vehicle, optional
        The vehicle that the controller is given; `vehicle` by default.
    slip_time : float, default 0.0
        Time over which the controller estimates the slip [s]; 0 for never.
    frequencies : int, default 3000
        How many frequencies there are up to the half of the control rate.

    Examples
    --------
    >>> from popsteer import Vehicle
    >>> law = linearised(PopParams(), Vehicle(), 10.0, 0.05)
    >>> loop = Loop(law, Vehicle(), 10.0, 0.05)
    >>> loop.is_stable(), loop.is_stable(dead_time=0.5)
    (True, False)
    """

    def __init__(
        self,
        law: LinearLaw,
        vehicle: Vehicle,
        speed: float,
        dt: float,
        *,
        believed: Vehicle | None = None,
        slip_time: float = 0.0,
        frequencies: int = 3000,
    ) -> None:
        slow = np.geomspace(1e-5, 0.1, frequencies // 4, endpoint=False)
        angles = np.concatenate((slow, np.linspace(0.1, math.pi, frequencies - len(slow))))
        self.angles = angles
        """Frequencies ω Δt [rad], up to π."""
        self._vehicle, self._speed, self._dt = vehicle, speed, dt
        self._back = back = np.exp(-1j * angles)  # 1 / z

        believed = vehicle if believed is None else believed
        weights = (law.cross_track, law.heading, law.steer, law.slip)
        cross_track, heading, steer, slip = (
            np.polynomial.polynomial.polyval(back, weight) for weight in weights
        )
        # The prediction turns the vehicle by the commands in flight, and moves it aside, ...
        aside, turn = _predicted(believed, speed, dt, back)
        aside = aside + (law.tracked_point - no_slip(believed)) * turn
        self._steer = steer + cross_track * aside + heading * turn
        # ... and along its heading and the slip of the last step: this one's is found after it.
        reach = speed * believed.dead_time
        heading = heading + reach * cross_track
        slip = slip + reach * cross_track * back

        # The weights of the measured offset of the vehicle's no-slip point, and of its heading.
        estimated, by_heading = _slip_filter(speed, dt, slip_time, back)
        ahead = law.tracked_point - no_slip(vehicle)
        beside = no_slip(believed) - no_slip(vehicle)
        self._cross_track = cross_track + slip * estimated
        self._heading = heading + ahead * cross_track + slip * (beside * estimated + by_heading)

    def gain(self, dead_time: float | None = None) -> _Response:
        """Evaluate L at the frequencies.

        Parameters
        ----------
        dead_time : float, optional
            Dead time of the vehicle [s], instead of its own.

        Returns
        -------
        (N,) ndarray of complex
            The gain of the open loop, broken at the command.
        """
        dead_time = self._vehicle.dead_time if dead_time is None else dead_time
        speed, dt, lag, back = self._speed, self._dt, self._vehicle.steer_lag, self._back
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
        return np.asarray((self._cross_track * offset + self._heading * yaw) / self._steer)

    def is_stable(self, dead_time: float | None = None) -> bool:
        """Whether all poles of the closed loop lie inside the unit circle.

        D (1 + L) (1 - 1/z)² (1 - E/z), with E the decay of the lag over Δt, has no pole outside the
        circle, so by the principle of the argument the loop is stable exactly where its phase comes
        back to where it was on the way from ω = 0 to π / Δt.

        Parameters
        ----------
        dead_time : float, optional
            Dead time of the vehicle [s], instead of its own.

        Returns
        -------
        bool
            Whether it is stable.
        """
        kept = decay(self._dt, self._vehicle.steer_lag)
        back = self._back
        value = self._steer * (1.0 + self.gain(dead_time))
        value *= (1.0 - back) ** 2 * (1.0 - kept * back)
        phase = np.unwrap(np.angle(value))
        return bool(abs(phase[-1] - phase[0]) < 0.5 * math.pi)

    def _step_response(self, time: float) -> NDArray[np.float64]:
        """Offset, heading and yaw rate some time after a unit step of the angle, from rest."""
        vehicle, speed = self._vehicle, self._speed
        turning = speed / vehicle.turning_length(speed)
        kept, lag = decay(time, vehicle.steer_lag), vehicle.steer_lag
        swing = lag * (1.0 - kept)
        heading = time - swing
        offset = speed * (0.5 * time * time - lag * heading)
        return turning * np.array([offset, heading, 1.0 - kept])


def _predicted(
    believed: Vehicle, speed: float, dt: float, back: _Response
) -> tuple[_Response, _Response]:
    """Offset of the no-slip point and heading that the commands in flight are going to add.

    Both are for a unit of the latest command; the steps are those of the controllers' prediction.
    """
    lag, dead_time = believed.steer_lag, believed.dead_time
    turning = speed / believed.turning_length(speed)
    whole = math.floor(dead_time / dt + 1e-9)
    part = max(dead_time - whole * dt, 0.0)
    # The wheels now: those that the commands would give without a dead time, so much later.
    kept, oldest = decay(dt, lag), back ** (whole + 1)
    wheel = oldest * (1.0 - kept) * back / (1.0 - kept * back)
    wheel = oldest + (wheel - oldest) * decay(dt - part, lag)

    in_flight = [(part, oldest)] if part > 0.0 else []
    in_flight += [(dt, back**age) for age in range(whole, 0, -1)]
    offset, heading = np.zeros_like(back), np.zeros_like(back)
    for duration, command in in_flight:
        steps = math.ceil(duration / _PREDICTION_STEP)
        step = duration / steps
        remaining = decay(step, lag)
        for _ in range(steps):
            mean = command + (wheel - command) * lag * (1.0 - remaining) / step
            wheel = command + (wheel - command) * remaining
            turn = turning * step * mean
            offset = offset + speed * step * (heading + 0.5 * turn)
            heading = heading + turn
    return offset, heading


def _slip_filter(
    speed: float, dt: float, time: float, back: _Response
) -> tuple[_Response, _Response]:
    """Slip that is estimated for a unit of offset of the no-slip point, and of heading."""
    if time <= 0.0:
        return np.zeros_like(back), np.zeros_like(back)
    share = min(dt / time, 1.0)
    smooth = share / (1.0 - (1.0 - share) * back)
    return smooth * (1.0 - back) / (speed * dt), -0.5 * smooth * (1.0 + back)


def _positive_lookahead(
    params: PopParams | PurePursuitParams, vehicle: Vehicle, speed: float
) -> float:
    distance = lookahead(params, vehicle, speed)
    if not distance:
        raise ConfigError("lookahead", distance, "positive")
    return distance
