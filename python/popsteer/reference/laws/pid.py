"""PID on the cross-track error, the paper's Equation 1."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from popsteer.reference.error import count, number, optional
from popsteer.reference.laws.law import Belief, Decision, LateralLaw, Params, Tracked, limit_steer
from popsteer.reference.math import cos, sin
from popsteer.reference.path.preview import Preview

if TYPE_CHECKING:
    from popsteer.reference.geometry import Point
    from popsteer.reference.path.follow import Located
    from popsteer.reference.path.view import PathView


@dataclass(frozen=True, kw_only=True)
class PidParams(Params):
    """Parameters of `Pid`; the paper's Table 1 by default. See `popsteer.PidParams`."""

    # k_P [rad/m], k_I [rad/(m s)] or [rad/m] without integral_with_dt, k_D [rad s/m]
    kp: float | None = optional(0.0, 1e6, scaled=lambda car: 0.25 * (3.0 / car.wheelbase))
    ki: float | None = optional(0.0, 1e6, scaled=lambda car: 0.01 * (3.0 / car.wheelbase))
    kd: float | None = optional(0.0, 1e6, scaled=lambda car: 0.2 * (3.0 / car.wheelbase))
    buffer_length: int = count(500, 1, 500)  # how many errors the integral sums, against wind-up
    integral_with_dt: bool = True  # each error times its Δt, as the published code has it
    # of the path's heading [m]
    smoothing_length: float | None = optional(0.0, 1e4, scaled=lambda car: 2.0 * car.wheelbase)
    derivative_filter: float = number(0.05, 0.0, 1e3)  # its time constant [s]


@dataclass
class PidState:
    """What `Pid` remembers.

    Examples
    --------
    >>> state = PidState()
    >>> for term in (1.0, 2.0, 4.0, 8.0):
    ...     state.push(term, length=3)
    >>> state.terms, state.next, state.sum
    ([2.0, 4.0, 8.0], 1, 14.0)
    """

    previous_error: float | None = None
    """The last cross-track error [m]; None before the first step."""
    previous_position: Point | None = None
    """Where the front axle was at the last step [m]; None before, and without smoothing."""
    rate: float = 0.0
    """The filtered derivative [m/s]."""
    terms: list[float] = field(default_factory=list)
    """The terms of the integral, oldest first."""
    next: int = 0
    """Where in the buffer the next term goes; the sum is taken anew when it comes round to 0."""
    sum: float = 0.0
    """The sum of the terms as carried along."""

    def push(self, term: float, length: int) -> None:
        """Take in a term; the oldest leaves a buffer of this `length` that is full.

        The sum is carried along, and taken anew each time the buffer comes round, so that rounding
        cannot build up over a long run.
        """
        if len(self.terms) == length:
            self.sum = self.sum - self.terms.pop(0) + term
        else:
            self.sum = self.sum + term
        self.terms.append(term)
        self.next += 1
        if self.next == length:
            self.next = 0
            # No sum(), which compensates its rounding from Python 3.12 on.
            self.sum = 0.0
            for held in self.terms:
                self.sum += held


class Pid(LateralLaw[PidParams, PidState]):
    """PID on the cross-track error e at the front axle: Equation 1.

    δ = -(k_P e + k_I Σ e Δt + k_D r), limited to ±δ_max, with the filtered derivative
    r = (T r_previous + e - e_previous) / (T + Δt); T = 0 is as printed. The sign is that of this
    package's error, positive left of the path. The first step has no derivative.

    Examples
    --------
    >>> from popsteer.reference import Path, Tracker
    >>> tracker = Tracker(Pid(), Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]))
    >>> tracker.steer(0.0, 0.5, 0.0, 5.0, 0.05)  # left of the path: steer right
    -0.12525
    """

    TRACKED = Tracked.FRONT_AXLE
    PARAMS = PidParams
    STATE = PidState

    def decide(self, path: PathView, state: PidState, at: Located, belief: Belief) -> Decision:  # noqa: ARG002 - not needed here
        """Decide the angle for a located vehicle."""
        error, params = at.closest.cross_track_error(), self.resolved
        if at.direction_changed or at.off_path:
            self.leave_path(state)
        # At rest an error cannot be steered away; summing it would wind the integral up.
        if at.vehicle.forward_speed() > 0.0:
            term = error * at.dt if params.integral_with_dt else error
            state.push(term, params.buffer_length)
        position = None
        moved = None
        if params.smoothing_length > 0.0:
            position = at.position
            if state.previous_position is not None:
                moved = self._moved_across(path, state.previous_position, at)
        elif state.previous_error is not None:
            moved = error - state.previous_error
        lag = params.derivative_filter
        state.rate = 0.0 if moved is None else (lag * state.rate + moved) / (lag + at.dt)
        wanted = -(params.kp * error + params.ki * state.sum + params.kd * state.rate)
        steer, status = limit_steer(self.vehicle, wanted)
        state.previous_error, state.previous_position = error, position
        return Decision(steer, at.closest.point, status)

    def pull(self, at: Located) -> float:
        """Return the proportional term times the gain on the heading, by the derivative."""
        gain = max(self.resolved.kd * at.vehicle.forward_speed(), 1.0)
        return float(self.resolved.kp * at.closest.cross_track_error() * gain)

    def interrupt(self, state: PidState) -> None:
        """Forget what the derivative is taken from."""
        state.previous_error = state.previous_position = None
        state.rate = 0.0

    def leave_path(self, state: PidState) -> None:
        """Forget what was measured against the path."""
        self.interrupt(state)
        state.terms, state.next, state.sum = [], 0, 0.0

    def _moved_across(self, path: PathView, previous: Point, at: Located) -> float:
        """Tell how far the front axle moved across the path since `previous` [m], to the left.

        The path's heading is that in the middle of the step, so that in a bend the step is held
        against its own stretch of the path.
        """
        step = (at.position[0] - previous[0], at.position[1] - previous[1])
        half = 0.5 * (step[0] * at.heading[0] + step[1] * at.heading[1])
        middle = at.closest.arc_length(path) - half
        yaw = Preview.yaw_at(path, self.resolved.smoothing_length, at.closest.segment, middle)
        return step[1] * cos(yaw) - step[0] * sin(yaw)
