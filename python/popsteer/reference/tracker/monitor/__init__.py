"""Monitors two things: the deviation from the path, and whether the vehicle answers as modelled.

The turn measured over the last second is compared with the turns that the commands explain. These
follow from the vehicle's parameters, for every gain within the estimator's bounds, the steering
offset seen in the motion, and a somewhat faster or slower response. A turn outside of them by more
than the noise of the yaw is a fault: a wrong sign of the steering, stuck wheels, or a dead time
longer than the vehicle's.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import copysign
from typing import TYPE_CHECKING, NamedTuple, TypeVar

from popsteer.reference.error import config_in_range, config_optional
from popsteer.reference.math import saturate, wrap
from popsteer.reference.tracker.monitor.state import (
    ALARM_TIME,
    LEAST_TIME,
    MAX_PERIOD,
    MonitorState,
)
from popsteer.reference.tracker.state import TrackerState
from popsteer.status import Status

if TYPE_CHECKING:
    from popsteer.reference.path.follow import Located
    from popsteer.reference.vehicle import Vehicle
    from popsteer.reference.vehicle.state import VehicleState

__all__ = ["Measured", "Monitor", "MonitorParams"]

StateT = TypeVar("StateT", bound=TrackerState)


@dataclass(frozen=True, kw_only=True)
class MonitorParams:
    """Thresholds of the monitor's faults.

    Attributes
    ----------
    deviation_limit : float or None
        Cross-track error beyond which a vehicle that was nearer before is deviating [m]; None is
        half a wheelbase, 1e9 for never.
    turn_tolerance : float
        Largest difference of the turn measured over a second to the turns that the commands
        explain, besides noise [rad]; 1e9 switches it off. Smaller: faults are found sooner, false
        alarms are likelier.

    Raises
    ------
    ConfigError
        Naming the parameter that is out of its range.

    Examples
    --------
    >>> MonitorParams(deviation_limit=1)
    MonitorParams(deviation_limit=1.0, turn_tolerance=0.01)
    """

    deviation_limit: float | None = None
    turn_tolerance: float = 0.01

    def __post_init__(self) -> None:
        config_optional(self, "deviation_limit", 0.0, 1e9)
        config_in_range(self, "turn_tolerance", 0.0, 1e9)


class Measured(NamedTuple):
    """What is measured at a step."""

    here: Located
    """Where the tracked point of the measured vehicle is."""
    vehicle: VehicleState
    """The vehicle by the pose of its own point."""
    dt: float
    """Control period [s]."""


class Monitor:
    """The parameters with their defaults for a vehicle filled in."""

    def __init__(self, params: MonitorParams, vehicle: Vehicle) -> None:
        limit = params.deviation_limit
        self._vehicle = vehicle
        self._deviation_limit = 0.5 * vehicle.wheelbase if limit is None else limit
        self._turn_tolerance = params.turn_tolerance

    def check(self, state: StateT, now: Measured, *, models: bool) -> tuple[StateT, Status]:
        """Compare a step with what was commanded before it.

        Returns the state after it, and what is wrong. Only where the tracker `models` the wheels
        theirs in the state count.
        """
        car, monitored = self._vehicle, state.monitor
        if monitored is None:
            monitored = MonitorState.settled(car.at_wheels(state.steer + car.steer_offset))
        last = None if state.answer is None else state.answer.measured.cross_track_error
        monitored, is_deviating = self._check_path(monitored, now, last)
        wheel = state.wheel if models else None
        monitored, is_implausible = self._check_turn(monitored, now, state.steer, wheel)
        status = Status.DEVIATING if is_deviating else Status.OK
        if is_implausible:
            status |= Status.IMPLAUSIBLE
        return replace(state, monitor=monitored), status

    def _check_path(
        self, monitored: MonitorState, now: Measured, last: float | None
    ) -> tuple[MonitorState, bool]:
        """Tell whether the vehicle is beyond the limit, after it was within.

        Another direction that begins farther off is another task, as another path is: see
        `set_path` and `relocalise`.
        """
        error, within = now.here.closest.cross_track_error(), monitored.within
        # The path turns round at a cusp: there the same place has an error of the other sign.
        if (
            now.here.direction_changed
            and last is not None
            and abs(error + last) > self._deviation_limit
        ):
            within = False
        is_within = abs(error) <= self._deviation_limit
        within = within or is_within
        return monitored._replace(within=within), within and not is_within

    def _check_turn(
        self, monitored: MonitorState, now: Measured, last: float, wheel: float | None
    ) -> tuple[MonitorState, bool]:
        """Tell whether the vehicle turns otherwise than commands explain, or did lately."""
        car, speed, dt = self._vehicle, now.vehicle.speed, now.dt
        before = monitored.last_step.wheel
        if wheel is not None:
            mean = 0.5 * (before + wheel)
        else:
            wheel, mean = _respond(car, before, last, dt)
        monitored = monitored._replace(last_step=monitored.last_step._replace(wheel=wheel))
        share = speed / car.turning_length(speed)
        rate, excess = share * _tangent(mean), share * (_tangent(last) - last)

        if now.here.direction_changed or dt > MAX_PERIOD:
            monitored = monitored.interrupted()
        alarm = saturate(monitored.alarm - dt, 0.0, ALARM_TIME)
        monitored = monitored._replace(alarm=alarm)
        yaw = monitored.last_step.yaw
        if yaw is None:
            monitored = monitored._replace(turns=monitored.turns._replace(rate=rate))
        else:
            turn = wrap(now.vehicle.yaw - yaw)
            monitored = monitored.observed(turn, rate, excess, share, dt)
            is_beyond = monitored.is_beyond(self._turn_tolerance)
            if is_beyond and monitored.evidence.time >= LEAST_TIME:
                monitored = monitored._replace(alarm=ALARM_TIME)
        last_step = monitored.last_step._replace(yaw=now.vehicle.yaw)
        return monitored._replace(last_step=last_step), monitored.alarm > 0.0


def _respond(car: Vehicle, wheel: float, command: float, dt: float) -> tuple[float, float]:
    """Return the wheels at the angle `wheel` [rad] `dt` [s] later, and their mean.

    The vehicle's response to the angle `command` with a Padé approximant in place of the
    exponential. At most 3.3 % of a move is off up to a `dt` of the lag.
    """
    gap = car.at_wheels(command + car.steer_offset) - wheel
    lag = car.steer_lag
    turned = gap * (1.0 - lag * lag / (lag * lag + dt * (lag + 0.5 * dt)))
    rate = car.max_steer_rate
    if rate is not None and abs(turned) > rate * dt:
        turned = copysign(rate * dt, gap)
        return wheel + turned, wheel + 0.5 * turned
    return wheel + turned, wheel + gap - turned * (lag / dt)


def _tangent(angle: float) -> float:
    """Return a Padé approximant of the tangent: within 1 % up to 1.25 rad, finite up to π/2."""
    square = angle * angle
    return angle * (15.0 - square) / (15.0 - 6.0 * square)
