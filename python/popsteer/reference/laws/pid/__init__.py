"""PID on the cross-track error, the paper's Equation 1."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from popsteer.reference.bounds import MAX_COORDINATE
from popsteer.reference.error import config_count, config_optional, input_within
from popsteer.reference.laws.law import Belief, Decision, Params, Tracked, limit_steer
from popsteer.reference.laws.pid.error_buffer import BOUND, CAPACITY, push, restore
from popsteer.reference.math import cos, saturate, sin
from popsteer.reference.path.preview import Preview
from popsteer.reference.tracker.state import TrackerState
from popsteer.reference.tracker.step import Tracker

if TYPE_CHECKING:
    from popsteer.reference.geometry import Point
    from popsteer.reference.path.follow import Located
    from popsteer.reference.vehicle import Vehicle

__all__ = ["Pid", "PidParams", "PidState"]


@dataclass(frozen=True, kw_only=True)
class PidParams(Params):
    """Parameters of `Pid`; the paper's Table 1 by default.

    Attributes
    ----------
    kp : float or None
        Proportional gain k_P [rad/m]; None is 0.25 at the paper's wheelbase, like the others
        inversely proportional to it at others.
    ki : float or None
        Integral gain k_I [rad/(m s)]; [rad/m] without `integral_with_dt`. None is 0.01 at the
        paper's wheelbase.
    kd : float or None
        Derivative gain k_D [rad s/m]; None is 0.2 at the paper's wheelbase.
    buffer_length : int
        How many of the last errors the integral sums, against wind-up: 1 to 500.
    integral_with_dt : bool
        Whether the integral weighs each error with its Δt, as the published code does; the
        paper's equation sums the bare errors.
    smoothing_length : float or None
        Length of path over which its heading is taken [m]; None is two wheelbases. The
        derivative is then how fast the front axle moves across that heading, which noise of the
        waypoints hardly reaches. 0: that of the error, as printed.
    search_distance : float or None
        Arc of the path that is searched on each side of the last projection [m], in addition to the
        distance travelled in a step; None is two wheelbases.
    lost_distance : float or None
        Distance from the path beyond which the vehicle is lost and is searched for on the whole
        path [m]; None is ten wheelbases.

    Raises
    ------
    ConfigError
        Naming the parameter that is out of its range.

    Examples
    --------
    >>> PidParams(buffer_length=0)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: buffer_length must be a count in [1, 500], got 0
    """

    kp: float | None = None
    ki: float | None = None
    kd: float | None = None
    buffer_length: int = 500
    integral_with_dt: bool = True
    smoothing_length: float | None = None
    search_distance: float | None = None
    lost_distance: float | None = None

    def __post_init__(self) -> None:
        config_count(self, "buffer_length", 1, CAPACITY)
        config_optional(self, "kp", 0.0, 1e6)
        config_optional(self, "ki", 0.0, 1e6)
        config_optional(self, "kd", 0.0, 1e6)
        config_optional(self, "smoothing_length", 0.0, 1e4)
        super().__post_init__()

    def _scaled(self, vehicle: Vehicle) -> dict[str, float]:
        """Return the defaults that scale with `vehicle`, by parameter."""
        wheelbase = vehicle.wheelbase
        return super()._scaled(vehicle) | {
            "kp": 0.25 * (3.0 / wheelbase),
            "ki": 0.01 * (3.0 / wheelbase),
            "kd": 0.2 * (3.0 / wheelbase),
            "smoothing_length": 2.0 * wheelbase,
        }


@dataclass(frozen=True, kw_only=True)
class PidState(TrackerState):
    """What `Pid` remembers beside what a `TrackerState` has.

    Attributes
    ----------
    previous_error : float or None
        The last cross-track error [m]; None before the first step.
    previous_position : tuple of float or None
        Where the front axle was at the last step [m]; None before the first, and without a
        `smoothing_length`.
    terms : tuple of float
        The terms of the integral, oldest first.
    next : int
        Where in the buffer the next term goes; the sum is taken anew when it comes round to 0.
    sum : float
        The sum of the terms as carried along.

    Examples
    --------
    >>> PidState() == PidState(previous_error=None, terms=(), next=0, sum=0.0)
    True
    """

    previous_error: float | None = None
    previous_position: Point | None = None
    terms: tuple[float, ...] = ()
    next: int = 0
    sum: float = 0.0


class Pid(Tracker[PidParams, PidState]):
    """PID on the cross-track error e at the front axle: Equation 1.

    δ = -(k_P e + k_I Σ e Δt + k_D (e - e_previous) / Δt), limited to ±δ_max. The sign is that of
    this package's error, positive left of the path. The first step has no derivative.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> controller = Pid(Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]))
    >>> controller.steer(0.0, 0.5, 0.0, 5.0, 0.05)  # left of the path: steer right
    -0.12525
    """

    TRACKED = Tracked.FRONT_AXLE
    PARAMS = PidParams
    STATE = PidState

    def decide(self, at: Located, belief: Belief) -> Decision:  # noqa: ARG002 - not needed here
        """Decide the angle for a located vehicle."""
        error = at.closest.cross_track_error()
        params, state = self._resolved, self.state
        if at.direction_changed or at.off_path:
            state = self.forget_path(state)
        # At rest an error cannot be steered away; summing it would wind the integral up.
        if at.vehicle.forward_speed() > 0.0:
            term = error * at.dt if params.integral_with_dt else error
            length = params.buffer_length
            terms, following, total = push(state.terms, state.next, state.sum, term, length)
            state = replace(state, terms=terms, next=following, sum=total)
        position = None
        rate = 0.0
        if params.smoothing_length > 0.0:
            position = at.position
            if state.previous_position is not None:
                rate = self._rate_across(state.previous_position, at)
        elif state.previous_error is not None:
            rate = (error - state.previous_error) / at.dt
        wanted = -(params.kp * error + params.ki * state.sum + params.kd * rate)
        steer, status = limit_steer(self.vehicle, wanted)
        self._state = replace(state, previous_error=error, previous_position=position)
        return Decision(steer, at.closest.point, status)

    def _rate_across(self, previous: Point, at: Located) -> float:
        """Tell how fast the front axle moved across the path since `previous` [m/s], to the left.

        The path's heading is that in the middle of the step, so that in a bend the step is held
        against its own stretch of the path.
        """
        step = (at.position[0] - previous[0], at.position[1] - previous[1])
        half = 0.5 * (step[0] * at.heading[0] + step[1] * at.heading[1])
        middle = at.closest.arc_length(self.path) - half
        smoothing = self._resolved.smoothing_length
        yaw = Preview.yaw_at(self.path, smoothing, at.closest.segment, middle)
        return (step[1] * cos(yaw) - step[0] * sin(yaw)) / at.dt

    def forget_path(self, state: PidState) -> PidState:
        """Forget what was measured against the path."""
        return replace(
            state, previous_error=None, previous_position=None, terms=(), next=0, sum=0.0
        )

    def change_path(self, state: PidState, offset: float | None) -> PidState:
        """Carry the integral on, and let the derivative see no jump."""
        previous = state.previous_error
        if previous is not None:
            previous = None if offset is None else saturate(previous + offset, -BOUND, BOUND)
        return replace(state, previous_error=previous)

    def restore(self, state: PidState) -> PidState:
        """Return `state`, where a buffer of this controller could hold its terms so."""
        length = self.params.buffer_length
        terms, following, total = restore(length, state.terms, state.next, state.sum)
        return replace(state, terms=terms, next=following, sum=total)

    def check_law_state(self, state: PidState) -> PidState:
        """Return `state`, where what is remembered in it is what this controller could remember."""
        previous = state.previous_error
        if previous is not None:
            previous = input_within("previous_error", previous, BOUND)
        position = state.previous_position
        if position is not None:
            most = 4.0 * MAX_COORDINATE
            x, y = (input_within("previous_position", at, most) for at in position)
            position = (x, y)
        return replace(state, previous_error=previous, previous_position=position)
