"""PID that tracks a reference speed."""

from __future__ import annotations

from dataclasses import dataclass

from popsteer.reference.bounds import MAX_SPEED
from popsteer.reference.error import config_in_range, input_within
from popsteer.reference.math import saturate
from popsteer.reference.speed.pedals import Pedals
from popsteer.reference.vehicle.state import checked_dt

__all__ = ["SpeedPid", "SpeedPidParams", "SpeedPidState"]


@dataclass(frozen=True, kw_only=True)
class SpeedPidParams:
    """Parameters of `SpeedPid`.

    Attributes
    ----------
    kp : float
        Proportional gain [s/m].
    ki : float
        Integral gain [1/m].
    kd : float
        Derivative gain [s²/m].

    Raises
    ------
    ConfigError
        Naming the parameter that is out of its range.

    Examples
    --------
    >>> SpeedPidParams(kp=1)
    SpeedPidParams(kp=1.0, ki=0.1, kd=0.0)
    """

    kp: float = 0.5
    ki: float = 0.1
    kd: float = 0.0

    def __post_init__(self) -> None:
        config_in_range(self, "kp", 0.0, 1e6)
        config_in_range(self, "ki", 0.0, 1e6)
        config_in_range(self, "kd", 0.0, 1e6)


@dataclass(frozen=True, kw_only=True)
class SpeedPidState:
    """What `SpeedPid` remembers.

    Attributes
    ----------
    integral : float
        The integral's share of the command, within -1 to 1.
    previous_error : float or None
        The last speed error [m/s]; None before the first step.

    Examples
    --------
    >>> SpeedPidState()
    SpeedPidState(integral=0.0, previous_error=None)
    """

    integral: float = 0.0
    previous_error: float | None = None


class SpeedPid:
    """PID on the speed error e = target_speed - speed.

    command = k_P e + k_I ∫e dt + k_D de/dt; throttle where it is positive, brake where it is
    negative. The integral's share is held within the range of the command, so it cannot wind up.

    Parameters
    ----------
    params : SpeedPidParams, optional
        The parameters.

    Examples
    --------
    >>> throttle, brake = SpeedPid().step(speed=0.0, target_speed=20.0, dt=0.05)
    >>> throttle
    1.0
    """

    def __init__(self, params: SpeedPidParams | None = None) -> None:
        self._params = SpeedPidParams() if params is None else params
        self._state = SpeedPidState()

    @property
    def params(self) -> SpeedPidParams:
        """The parameters."""
        return self._params

    @property
    def state(self) -> SpeedPidState:
        """What the controller remembers; may be set to a state saved before.

        Raises
        ------
        InputError
            Where it is no state that this controller could have; the state is then unchanged.
        """
        return self._state

    @state.setter
    def state(self, state: SpeedPidState) -> None:
        self._state = self.check_state(state)

    def reset(self) -> None:
        """Forget everything: the state before the first step."""
        self._state = SpeedPidState()

    def step(self, speed: float, target_speed: float, dt: float) -> Pedals:
        """Set the pedals.

        Parameters
        ----------
        speed, target_speed : float
            The speed there is, and the one wanted [m/s].
        dt : float
            Control period [s].

        Returns
        -------
        Pedals
            Throttle and brake, each in 0 to 1.

        Raises
        ------
        InputError
            For a number that is not finite or beyond its bound; the state is then unchanged.
        """
        speed = input_within("speed", speed, MAX_SPEED)
        target_speed = input_within("target_speed", target_speed, MAX_SPEED)
        dt = checked_dt(dt)
        error = target_speed - speed
        previous = self._state.previous_error
        rate = 0.0 if previous is None else (error - previous) / dt
        integral = saturate(self._state.integral + self._params.ki * error * dt, -1.0, 1.0)
        self._state = SpeedPidState(integral=integral, previous_error=error)
        return Pedals.from_command(self._params.kp * error + integral + self._params.kd * rate)

    def check_state(self, state: SpeedPidState) -> SpeedPidState:
        """Return `state`, where it is one that this controller could have."""
        integral = input_within("integral", state.integral, 1.0)
        error = state.previous_error
        if error is not None:
            error = input_within("previous_error", error, 2.0 * MAX_SPEED)
        return SpeedPidState(integral=integral, previous_error=error)
