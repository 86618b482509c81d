"""PID that tracks a reference speed."""

from __future__ import annotations

from dataclasses import dataclass

from popsteer.reference.bounds import MAX_SPEED
from popsteer.reference.error import Checked, input_within, number
from popsteer.reference.math import saturate
from popsteer.reference.speed.pedals import Pedals
from popsteer.reference.vehicle.state import period


@dataclass(frozen=True, kw_only=True)
class SpeedPidParams(Checked):
    """Parameters of `SpeedPid`."""

    kp: float = number(0.5, 0.0, 1e6)
    """Proportional gain [s/m]."""
    ki: float = number(0.1, 0.0, 1e6)
    """Integral gain [1/m]."""
    kd: float = number(0.0, 0.0, 1e6)
    """Derivative gain [s²/m]."""


@dataclass(frozen=True, kw_only=True)
class SpeedPidState:
    """What `SpeedPid` remembers."""

    integral: float = 0.0
    """The integral's share of the command, within -1 to 1."""
    previous_error: float | None = None
    """The last speed error [m/s]; None before the first step."""


class SpeedPid:
    """PID on the speed error e = target_speed - speed.

    command = k_P e + k_I ∫e dt + k_D de/dt; throttle where it is positive, brake where it is
    negative. The integral's share is held within the range of the command, so it cannot wind up.

    Examples
    --------
    >>> throttle, brake = SpeedPid().step(speed=0.0, target_speed=20.0, dt=0.05)
    >>> throttle
    1.0
    """

    def __init__(self, params: SpeedPidParams | None = None) -> None:
        self.params = SpeedPidParams() if params is None else params
        self.state = SpeedPidState()

    def reset(self) -> None:
        """Forget everything: the state before the first step."""
        self.state = SpeedPidState()

    def step(self, speed: float, target_speed: float, dt: float) -> Pedals:
        """Set the pedals, `dt` [s] after the last step, by the speeds there is and wanted [m/s].

        In a `dt` out of 1e-6 to 1e3 s no time passes: integral and state stay, and there is no
        derivative.

        Raises `InputError` for a number that is not finite or, but for `dt`, beyond its bound; the
        state is then unchanged.
        """
        speed = input_within("speed", speed, MAX_SPEED)
        target_speed = input_within("target_speed", target_speed, MAX_SPEED)
        passed = period(dt)
        error = target_speed - speed
        if passed is None:
            return Pedals.from_command(self.params.kp * error + self.state.integral)
        dt, previous = passed, self.state.previous_error
        rate = 0.0 if previous is None else (error - previous) / dt
        integral = saturate(self.state.integral + self.params.ki * error * dt, -1.0, 1.0)
        self.state = SpeedPidState(integral=integral, previous_error=error)
        return Pedals.from_command(self.params.kp * error + integral + self.params.kd * rate)
