"""Steering loops in small signals: a controller and a vehicle about straight driving at one speed.

The vehicle is the chain of `popsteer.Vehicle`: a dead time, wheels with a first-order lag τ, and a
bicycle; e₀ is the offset of the no-slip point, ψ the heading error, w the angle of the wheels::

    e₀' = v ψ      ψ' = v w / (L + K v²)      τ w' = δ - w

The controller sees e = e₀ + a ψ at its tracked point a ahead, and commands
δ = -(C_e(z) e + C_ψ(z) ψ), where both divide by the same polynomial D(z) if it remembers what it
commanded. What a controller estimates is a constant here: the slip counts only where it stands out
of what is not known of it. A controller that believes in a dead time sees e
and ψ as its own chain predicts them through the commands in flight. Commands are held for the
control period Δt. Sampling is exact: the vehicle's step response is known in closed form, and a
dead time that is no multiple of Δt splits a period in two. Broken at the command, the loop has the
gain::

    L(z) = (C_e E(z) + C_ψ Ψ(z)) / D(z)

of what the vehicle shows, and its closed loop the poles where 1 + L(z) = 0. What the controller
predicts from its own commands is part of D.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from popsteer._core import Vehicle
from popsteer.controllers import Params
from popsteer.lab.stability.linear import LinearLaw, decay, linearised, no_slip

_Response: TypeAlias = "NDArray[np.complex128]"

_PREDICTION_STEP = 0.05  # the longest step of a controller's prediction [s]


class Loop:
    """The loop of a controller and a vehicle at one speed [m/s], on a grid of frequencies.

    `dt` is the control period Δt [s]. The controller is given `believed`, the vehicle by default.
    `frequencies` is how many there are up to the half of the control rate; `back` has other places
    instead, as 1 / z.
    """

    def __init__(
        self,
        law: LinearLaw,
        vehicle: Vehicle,
        speed: float,
        dt: float,
        *,
        believed: Vehicle | None = None,
        frequencies: int = 3000,
        back: _Response | None = None,
    ) -> None:
        slow = np.geomspace(1e-5, 0.1, frequencies // 4, endpoint=False)
        angles = np.concatenate((slow, np.linspace(0.1, math.pi, frequencies - len(slow))))
        self.angles = angles
        """Frequencies ω Δt [rad], up to π."""
        self._vehicle, self._speed, self._dt = vehicle, speed, dt
        self._back = back = np.exp(-1j * angles) if back is None else back  # 1 / z

        believed = vehicle if believed is None else believed
        weights = (law.cross_track, law.heading, law.steer)
        cross_track, heading, steer = (
            np.polynomial.polynomial.polyval(back, weight) for weight in weights
        )
        # The prediction turns the vehicle by the commands in flight, and moves it aside, ...
        aside, turn = _predicted(believed, speed, dt, back)
        aside = aside + (law.tracked_point - no_slip(believed)) * turn
        self._steer = steer + cross_track * aside + heading * turn
        self._aside = cross_track
        # ... and along its heading.
        heading = heading + speed * believed.dead_time * cross_track

        # The weights of the measured offset of the vehicle's no-slip point, and of its heading.
        ahead = law.tracked_point - no_slip(vehicle)
        self._cross_track, self._heading = cross_track, heading + ahead * cross_track

    def gain(self, dead_time: float | None = None) -> _Response:
        """Evaluate the open loop's gain L; `dead_time` [s] stands for the vehicle's own."""
        offset, yaw = self._moved(dead_time)
        return np.asarray((self._cross_track * offset + self._heading * yaw) / self._steer)

    def answer(self) -> _Response:
        """Evaluate the closed loop: the offset of the no-slip point over that of the path."""
        offset, _ = self._moved(None)
        return np.asarray(self._aside * offset / self._steer / (1.0 + self.gain()))

    def _moved(self, dead_time: float | None) -> tuple[_Response, _Response]:
        """Offset of the no-slip point and heading of the vehicle, for a command."""
        dead_time = self._vehicle.dead_time if dead_time is None else dead_time
        speed, dt, lag, back = self._speed, self._dt, self._vehicle.steer_lag, self._back
        steps = math.floor(dead_time / dt + 1e-9)
        # A command acts first at the end of a period, in the part that the dead time leaves.
        first = self._step_response(dt - max(dead_time - steps * dt, 0.0))
        rest = self._step_response(dt) - first
        pushed = back**steps * (first[:, None] + rest[:, None] * back)

        kept = decay(dt, lag)
        swing = lag * (1.0 - kept)  # the turn in a period by a yaw rate of 1 that decays
        z = 1.0 / back
        rate = pushed[2] / (z - kept)
        yaw = (pushed[1] + swing * rate) / (z - 1.0)
        offset = (pushed[0] + speed * dt * yaw + speed * lag * (dt - swing) * rate) / (z - 1.0)
        return offset, yaw

    def is_stable(self, dead_time: float | None = None) -> bool:
        """Whether all poles of the closed loop lie inside the unit circle.

        D (1 + L) (1 - 1/z)² (1 - E/z), with E the decay of the lag over Δt, has no pole outside the
        circle, so by the principle of the argument the loop is stable exactly where its phase comes
        back to where it was on the way from ω = 0 to π / Δt. `dead_time` [s] stands instead of the
        vehicle's.
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
    # The wheels now are those without a dead time, a dead time ago.
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


Crossings: TypeAlias = tuple[list[tuple[float, float]], list[tuple[float, float]]]

_ALIASED = 1e-9  # of what comes after the window, what remains in it
_LONGEST = 60.0  # s


class Response(NamedTuple):
    """What a loop answers at one speed."""

    frequency: NDArray[np.float64]
    """Frequencies, ascending, up to half of the control rate [rad/s]."""
    gain: NDArray[np.complex128]
    """The gain of the open loop there."""
    time: NDArray[np.float64]
    """Times from the step on, one a control period [s]."""
    offset: NDArray[np.float64]
    """Offset of the no-slip point where the path moves by 1 m at once [m]; NaN if unstable."""

    @property
    def phase(self) -> NDArray[np.float64]:
        """Phase of the gain [rad], without jumps, within half a turn of -180 degrees at first."""
        phase = np.unwrap(np.angle(self.gain))
        return np.asarray(phase - math.tau * np.round((phase[0] + math.pi) / math.tau))

    def crossings(self) -> Crossings:
        """Find where the margins are read."""
        return crossings(self.frequency, self.gain, self.phase)


def crossings(
    frequency: NDArray[np.float64], gain: NDArray[np.complex128], phase: NDArray[np.float64]
) -> Crossings:
    """Find where the margins of a response are read, of its continuous phase [rad].

    Frequency [rad/s] and phase [rad] where the gain falls or rises through 1; frequency and size of
    the gain where the phase passes -180 degrees.
    """

    def between(at: NDArray[Any], share: NDArray[Any], values: NDArray[Any]) -> Any:
        ends = (each[at] + share * (each[at + 1] - each[at]) for each in (frequency, values))
        return zip(*(each.tolist() for each in ends), strict=True)

    size = np.log(np.abs(gain))
    at = np.flatnonzero(np.diff(np.sign(size)))
    gains = list(between(at, size[at] / (size[at] - size[at + 1]), phase))
    # An odd number of half turns: where the gain is real and negative.
    turned = (phase + math.pi) / (2.0 * math.pi)
    whole = np.floor(turned)
    at = np.flatnonzero(np.diff(whole))
    share = (np.maximum(whole[at], whole[at + 1]) - turned[at]) / (turned[at + 1] - turned[at])
    return gains, [(where, math.exp(value)) for where, value in between(at, share, size)]


def respond(
    params: Params,
    vehicle: Vehicle,
    speed: float,
    dt: float = 0.05,
    *,
    believed: Vehicle | None = None,
    seconds: float = 6.0,
) -> Response:
    """Compute the answers of a loop; the arguments are those of `margins`, and for how long.

    The step is found by the inverse z-transform on a circle around all poles::

        y[k] = rᵏ IFFT(T(z) / (1 - 1/z)),   T = C_e E / (D (1 + L)),   z = r exp(jθ)
    """
    believed = vehicle if believed is None else believed
    law = linearised(params, believed, speed, dt)
    loop = Loop(law, vehicle, speed, dt, believed=believed)
    count = math.ceil(min(seconds, _LONGEST) / dt) + 1
    size = 1 << (2 * count - 1).bit_length()
    # Beyond a window of `size` it would come again, by so much less.
    radius = _ALIASED ** (-1.0 / size)
    angles = 2.0 * math.pi * np.arange(size) / size
    back = np.exp(-1j * angles) / radius
    around = Loop(law, vehicle, speed, dt, believed=believed, back=back)
    found = np.fft.ifft(around.answer() / (1.0 - back)).real * radius ** np.arange(size)
    offset = np.where(np.abs(found) < 1e-9, 0.0, found)[:count].astype(np.float64)
    if not loop.is_stable():
        offset = np.full(count, math.nan)
    time = dt * np.arange(count, dtype=np.float64)
    return Response(loop.angles / dt, loop.gain(), time, offset)
