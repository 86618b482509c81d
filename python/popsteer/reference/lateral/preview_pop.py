"""Preview POP: POP's neighbourhood, judged by where it leads over a horizon."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import copysign
from typing import TYPE_CHECKING, Any

from popsteer.reference.error import config_in_range, input_in_range
from popsteer.reference.lateral import (
    Command,
    check_body,
    check_steer,
    check_waypoint,
    command,
)
from popsteer.reference.lateral.cost_to_go import CostToGo, Travel
from popsteer.reference.lateral.tracker import Tracker, TrackerState
from popsteer.reference.math import PI, atan, cos, decay, saturate, sin, tan, wrap
from popsteer.reference.path.preview import Preview
from popsteer.reference.path.view import MAX_COORDINATE
from popsteer.reference.vehicle.predict import steps
from popsteer.reference.vehicle.state import MAX_YAW
from popsteer.status import Status

if TYPE_CHECKING:
    from popsteer.reference.path.follow import Located
    from popsteer.reference.path.view import PathView
    from popsteer.reference.vehicle.actuator import Actuator
    from popsteer.reference.vehicle.state import VehicleState

__all__ = ["PreviewPop", "PreviewPopParams", "PreviewPopState"]

LEAST_TRAVEL = 1e-8
"""The shortest way that teaches anything [m]; a step of the law goes at least ten times as far."""
MAX_TURN_OFFSET = 0.05
"""The largest turn that is learnt [1/m]."""
MAX_SLIP = 0.15
"""The largest slip that is learnt [rad]."""
BEND = 0.01
"""Curvature at which a half of what is learnt is laid to the bend [1/m]."""


@dataclass(frozen=True, kw_only=True)
class PreviewPopParams:
    """Parameters of `PreviewPop`.

    Attributes
    ----------
    steer_span : float
        Optimization range δ_nbd [rad]: an angle lies at most this far from the last one.
    max_steer_rate : float
        Fastest the wheels are told to turn [rad/s]; at a control period of 50 ms, 60°/s are the
        paper's 3° a step.
    max_lateral_acceleration : float
        Largest lateral acceleration that an angle may ask for [m/s²]. Less: a vehicle that is too
        fast for a bend runs wide instead of sliding.
    horizon : float
        How long the prediction looks ahead [s]. Longer: bends are entered earlier and a lag is
        seen through; shorter than the lag and the way back to the path, the vehicle swings.
    heading_cost : float
        How many metres of cross-track error are as bad as 1 rad of heading error [m/rad]. More:
        the path is joined more gently, and offsets take longer to vanish.
    steer_rate_cost : float
        How many metres of cross-track error are as bad as turning the wheels at 1 rad/s
        [m s/rad]. More: calmer wheels, less noise passed on, wider bends where the model is wrong.
    approach_angle : float
        Heading at which the path is approached from afar [rad]. More: sooner back on the path, by
        a sharper manoeuvre.
    min_speed : float
        Below this speed [m/s] the wheels turn in proportion to the way travelled, and the
        prediction looks as far as at this speed; at rest they keep their angle.
    smoothing_length : float
        Length of path over which its direction is taken [m]. More: less of the waypoints' noise
        is steered, and bends shorter than this are cut.
    turn_learning_time : float
        Time in which the law learns how much more the vehicle turns than the model says [s]; 0
        never. Shorter: sooner right, and more noise of the heading passed on.
    slip_learning_time : float
        Time in which it learns at what angle to its heading the vehicle travels, straight on and
        in bends [s]; 0 never. Shorter: sooner right, and more noise of the position passed on.
    wheelbase : float
        Effective wheelbase of the model [m].
    understeer : float
        Understeer of the model [s²/m]: curvature = tan δ / (wheelbase + understeer v²).
    steer_lag : float
        Time constant with which the curvature follows the angle [s].
    reference_offset : float or None
        Reference point ahead of the rear axle [m], which is taken not to slip; None is the rear
        axle.
    max_steer : float
        Steering limit δ_max [rad].
    search_distance : float or None
        How far along the path from the last place the vehicle is looked for [m], beside what it
        travels in a step; None is two wheelbases.
    lost_distance : float or None
        Farther than this from its place the vehicle is lost, and looked for on the whole path
        [m]; None is ten wheelbases.

    Raises
    ------
    ConfigError
        Naming the parameter that is out of its range.

    Examples
    --------
    >>> PreviewPopParams(horizon=2).horizon
    2.0
    >>> PreviewPopParams(steer_lag=-0.1)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: steer_lag must be in [0, 10], got -0.1
    """

    steer_span: float = 12.0 * (PI / 180.0)
    max_steer_rate: float = 60.0 * (PI / 180.0)
    max_lateral_acceleration: float = 15.0
    horizon: float = 1.0
    heading_cost: float = 3.0
    steer_rate_cost: float = 0.25
    approach_angle: float = 0.25
    min_speed: float = 5.0
    smoothing_length: float = 2.0
    turn_learning_time: float = 0.0
    slip_learning_time: float = 5.0
    wheelbase: float = 3.0
    understeer: float = 0.0
    steer_lag: float = 0.1
    reference_offset: float | None = None
    max_steer: float = 1.22
    search_distance: float | None = None
    lost_distance: float | None = None

    def __post_init__(self) -> None:
        config_in_range(self, "steer_span", 1e-6, PI)
        config_in_range(self, "max_steer_rate", 1e-3, 1e3)
        config_in_range(self, "max_lateral_acceleration", 1e-3, 1e6)
        config_in_range(self, "horizon", 0.05, 100.0)
        config_in_range(self, "heading_cost", 0.0, 1e3)
        config_in_range(self, "steer_rate_cost", 1e-3, 1e3)
        config_in_range(self, "approach_angle", 1e-3, 0.5 * PI)
        config_in_range(self, "min_speed", 0.1, 1e3)
        config_in_range(self, "smoothing_length", 0.0, 1e3)
        config_in_range(self, "turn_learning_time", 0.0, 1e6)
        config_in_range(self, "slip_learning_time", 0.0, 1e6)
        config_in_range(self, "understeer", 0.0, 1e3)
        config_in_range(self, "steer_lag", 0.0, 10.0)
        check_body(self)


@dataclass(frozen=True, kw_only=True)
class PreviewPopState(TrackerState):
    """What `PreviewPop` remembers beside what a `TrackerState` has.

    Attributes
    ----------
    previous_steer : float
        The last angle δ_prev [rad].
    curvature : float
        Curvature that the vehicle drives by now, by the model [1/m].
    previous_x, previous_y : float
        Where the vehicle was seen at the last step [m].
    previous_yaw : float
        Its heading then [rad].
    travel : float
        How far it was to come since then [m]; 0 where nothing is to be learnt from it.
    turn : float
        How much it was to turn since then by the model [rad].
    turn_offset : float
        How much more the vehicle turns than the model says, as learnt [1/m].
    slip : float
        Angle of the way it travels to its heading, straight on, as learnt [rad].
    slip_length : float
        How much that angle grows with the curvature, as learnt [m]: so much farther ahead of the
        point that does not slip lies the reference point than the model says.

    Examples
    --------
    >>> PreviewPopState().previous_steer
    0.0
    """

    previous_steer: float = 0.0
    curvature: float = 0.0
    previous_x: float = 0.0
    previous_y: float = 0.0
    previous_yaw: float = 0.0
    travel: float = 0.0
    turn: float = 0.0
    turn_offset: float = 0.0
    slip: float = 0.0
    slip_length: float = 0.0


class PreviewPop(Tracker[PreviewPopParams, PreviewPopState]):
    """Preview POP.

    Of the angles in the neighbourhood of the last one, the angle with the least cost over a
    horizon. The cost of a step is e² + (heading_cost ψ)² + (steer_rate_cost rate)², with the
    cross-track error e, the heading error ψ and the rate of the wheels, predicted by a bicycle
    with lag along the curvature of the path ahead. What follows the first step is taken at its
    best, the cost-to-go, so the cost of an angle is a parabola: the best angle of the
    neighbourhood is the lowest point of it, brought within the neighbourhood and the limits.
    There is no list of candidates; the law is this closed form.

    Parameters
    ----------
    path : Path
        The path to follow.
    params : PreviewPopParams, optional
        The parameters.
    actuator : Actuator, optional
        What lies between the commands and the wheels; nothing by default.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> law = PreviewPop(Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]))
    >>> law.steer(0.0, 0.5, 0.0, 5.0, 0.05) < 0.0  # left of the path: steer right
    True
    """

    def __init__(
        self,
        path: PathView,
        params: PreviewPopParams | None = None,
        *,
        actuator: Actuator | None = None,
    ) -> None:
        params = PreviewPopParams() if params is None else params
        super().__init__(path, params, 0.0, actuator)

    def initial_state(self) -> PreviewPopState:
        """Return the state before the first step."""
        return PreviewPopState()

    def decide(self, vehicle: VehicleState, dt: float) -> Command:
        """Locate, learn, predict, choose, remember."""
        at = self._locate(self.state.waypoint, vehicle, dt)
        state = self._learn(_turned(self.state, at), at)
        state = replace(state, waypoint=at.foot.segment)
        steer, status = self._choose(state, at)
        self._state = _turned(self._remember(state, at, steer), at)
        return command(at, steer, at.foot.point, status)

    def set_waypoint(self, state: PreviewPopState, waypoint: int | None) -> PreviewPopState:
        """Put the remembered waypoint; nothing is to be learnt of a jump."""
        return replace(state, waypoint=waypoint, travel=0.0)

    def set_steer(self, state: PreviewPopState, steer: float) -> tuple[PreviewPopState, bool]:
        """Take note of the angle; the next neighbourhood is its own."""
        return replace(state, previous_steer=steer), True

    def _turning_length(self, speed: float) -> float:
        """Length that turns an angle into a curvature, tan δ / length [m]."""
        return self.params.wheelbase + self.params.understeer * speed * speed

    def _learn(self, state: PreviewPopState, at: Located) -> PreviewPopState:
        """Return the state with what the way since the last step teaches."""
        vehicle = at.vehicle
        if state.travel < LEAST_TRAVEL or at.turned:
            return state
        turned = wrap(vehicle.yaw - state.previous_yaw)
        turn_offset = _learnt(
            state.turn_offset,
            (turned - state.turn) / state.travel,
            at.dt,
            self.params.turn_learning_time,
            MAX_TURN_OFFSET,
        )
        slip, slip_length = 0.0, 0.0
        if self.params.slip_learning_time > 0.0:
            heading = state.previous_yaw + 0.5 * turned
            aside = (vehicle.y - state.previous_y) * cos(heading) - (
                vehicle.x - state.previous_x
            ) * sin(heading)
            start = at.foot.arc_length(self.path) - state.travel
            preview = Preview(
                self.path, self.params.smoothing_length, at.foot.segment, start, state.travel
            )
            _, (turn,) = preview.turns(start, state.travel, 1)
            slip, slip_length = self._learn_slip(
                state, aside / state.travel, turn / state.travel, at.dt
            )
        return replace(state, turn_offset=turn_offset, slip=slip, slip_length=slip_length)

    def _learn_slip(
        self, state: PreviewPopState, sample: float, bend: float, dt: float
    ) -> tuple[float, float]:
        """Return the slip, straight on and by curvature, after a period in which it was `sample`.

        Normalised least mean squares. The curvature is the path's, `bend` [1/m]. The vehicle's own
        answers to the errors of the position, which are in the sample too, and would be taken for
        slip.
        """
        time, most = self.params.slip_learning_time, self.params.wheelbase
        share = dt / time if dt < time else 1.0
        sample = saturate(sample, -4.0 * MAX_SLIP, 4.0 * MAX_SLIP)
        missed = sample - (state.slip + state.slip_length * bend)
        gain = share * missed / (BEND * BEND + bend * bend)
        return (
            saturate(state.slip + gain * (BEND * BEND), -MAX_SLIP, MAX_SLIP),
            saturate(state.slip_length + gain * bend, -most, most),
        )

    def _choose(self, state: PreviewPopState, at: Located) -> tuple[float, Status]:
        """Find the best angle of the neighbourhood."""
        params, foot = self.params, at.foot
        offset = self.reference_offset + state.slip_length
        speed = at.vehicle.forward_speed()
        count, period = steps(params.horizon, at.dt)
        pace = speed if speed > params.min_speed else params.min_speed
        step = pace * period
        lag = params.steer_lag * speed
        kept = decay(step, lag)
        travel = Travel.over(step, lag, kept, offset)
        length = self._turning_length(speed)
        move_cost = params.steer_rate_cost * length / period
        move_cost = move_cost * move_cost

        arc_length = foot.arc_length(self.path)
        preview = Preview(
            self.path, params.smoothing_length, foot.segment, arc_length, count * step
        )
        path_yaw, turns = preview.turns(arc_length, step, count)
        gained = step * state.turn_offset
        drift = step * state.slip
        stage = CostToGo.stage(params.heading_cost, offset)
        after = cost = stage
        for turn in reversed(turns):
            cost = after.before(travel, turn - gained, drift)
            after = cost.before_best_move(move_cost, stage)

        # From afar the error counts only as far as it calls for the approach angle.
        heading_error = wrap(at.vehicle.yaw - path_yaw)
        most = params.approach_angle * cost.pc
        most = most if most > 0.0 else 0.0
        pull = saturate(foot.cross_track_error() * cost.ec, -most, most)
        told = tan(state.previous_steer) / length
        slope = pull + heading_error * cost.pc + state.curvature * cost.ac + told * cost.cc + cost.c
        # The lowest point of the parabola; a control period may be a part of the step.
        wanted = told - slope / (move_cost + cost.cc) * (at.dt / period)
        return self._within(state.previous_steer, wanted, length, speed, at.dt)

    def _within(
        self, previous_steer: float, wanted: float, length: float, speed: float, dt: float
    ) -> tuple[float, Status]:
        """Turn a curvature into an angle within the limits and the neighbourhood."""
        params = self.params
        status = Status.OK
        if abs(wanted) * speed * speed > params.max_lateral_acceleration:
            wanted = copysign(params.max_lateral_acceleration / (speed * speed), wanted)
            status = Status.SATURATED
        span = params.max_steer_rate * dt
        if span > params.steer_span:
            span = params.steer_span
        if speed < params.min_speed:
            span *= speed / params.min_speed
        steer = saturate(atan(wanted * length), previous_steer - span, previous_steer + span)
        steer, limited = self._limit(steer)
        return steer, limited if limited is Status.SATURATED else status

    def _remember(self, state: PreviewPopState, at: Located, steer: float) -> PreviewPopState:
        """Carry the model over the period that begins, under the angle decided on."""
        speed = at.vehicle.forward_speed()
        told = tan(steer) / self._turning_length(speed)
        lag = self.params.steer_lag
        kept = decay(at.dt, lag)
        excess = state.curvature - told
        distance = speed * at.dt
        teaches = speed >= self.params.min_speed
        return replace(
            state,
            previous_steer=steer,
            travel=distance if teaches else 0.0,
            turn=told * distance + excess * (lag * (1.0 - kept) * speed),
            curvature=told + excess * kept,
            previous_x=at.vehicle.x,
            previous_y=at.vehicle.y,
            previous_yaw=at.vehicle.yaw,
        )

    def check_state(self, state: PreviewPopState) -> PreviewPopState:
        """Return `state`, where it is one that this law could have on its path."""
        checked: dict[str, Any] = {
            "waypoint": check_waypoint(self.path, state.waypoint),
            "previous_steer": check_steer(
                "previous_steer", state.previous_steer, self.params.max_steer
            ),
        }
        for field, bound in (
            ("curvature", 1e7),
            ("previous_x", MAX_COORDINATE),
            ("previous_y", MAX_COORDINATE),
            ("previous_yaw", MAX_YAW + PI),
            ("turn", 1e15),
            ("turn_offset", MAX_TURN_OFFSET),
            ("slip", MAX_SLIP),
            ("slip_length", self.params.wheelbase),
        ):
            checked[field] = input_in_range(field, getattr(state, field), -bound, bound)
        checked["travel"] = input_in_range("travel", state.travel, 0.0, 1e7)
        return replace(state, **checked)


def _turned(state: PreviewPopState, at: Located) -> PreviewPopState:
    """Turn the state of the turned vehicle into that of the vehicle itself, or the other way round.

    Its wheels, and what it turns, are to the other side, and ahead is behind. Place and way are
    those seen.
    """
    return replace(
        state,
        previous_steer=at.turn(state.previous_steer),
        curvature=at.turn(state.curvature),
        turn_offset=at.turn(state.turn_offset),
        slip_length=at.turn(state.slip_length),
    )


def _learnt(value: float, sample: float, dt: float, time: float, bound: float) -> float:
    """Return `value` after a period `dt` [s] in which `sample` was seen.

    `time` [s] to learn, 0 for never. A sample counts up to four times the bound and the value
    keeps within it, so that neither a jump of the localisation nor a fault that cannot be learnt
    winds it up.
    """
    if time <= 0.0:
        return 0.0
    share = dt / time if dt < time else 1.0
    sample = saturate(sample, -4.0 * bound, 4.0 * bound)
    return saturate(value + share * (sample - value), -bound, bound)
