"""What a tracker remembers."""

from __future__ import annotations

from dataclasses import astuple, dataclass, fields, replace
from math import inf
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

from popsteer.reference.bounds import MAX_COORDINATE, MAX_SPEED, MAX_YAW
from popsteer.reference.error import input_below, input_within
from popsteer.reference.math import atan2, wrap
from popsteer.reference.path.stop import Ahead
from popsteer.reference.tracker.command import Command
from popsteer.reference.vehicle.delay import InFlight
from popsteer.reference.vehicle.estimate import Corrections
from popsteer.reference.vehicle.estimator import Estimator
from popsteer.reference.vehicle.past import Past
from popsteer.reference.vehicle.state import VehicleState

if TYPE_CHECKING:
    from popsteer.reference.geometry import Point
    from popsteer.reference.path.follow import Located
    from popsteer.reference.path.view import PathView
    from popsteer.reference.tracker.monitor.state import MonitorState
    from popsteer.reference.vehicle.timed import Timed
    from popsteer.status import Status

__all__ = [
    "HANDOVER_TIME",
    "NOWHERE",
    "Answer",
    "Deviation",
    "Place",
    "TrackerState",
    "check_waypoint",
    "estimator_of",
    "hands_over",
    "in_flight_of",
    "past_of",
    "with_estimator",
    "with_in_flight",
    "with_past",
]

MAX_DISTANCE = 1e18
"""Bound of a distance along a path [m], which no valid path reaches."""
HANDOVER_TIME = 1.0
"""Time in which the difference to a driver's angle fades [s]."""


class Deviation(NamedTuple):
    """Errors of the last step, which are repeated while an input is held."""

    cross_track_error: float
    """Cross-track error [m]."""
    yaw: float
    """Heading of the vehicle, mirrored where it drives backwards [rad]."""
    along_x: float
    """Along the path [m]."""
    along_y: float

    @classmethod
    def of(cls, at: Located) -> Deviation:
        """Take it from a located vehicle."""
        along = at.closest.along
        return cls(at.closest.cross_track_error(), at.vehicle.yaw, along[0], along[1])

    def heading_error(self) -> float:
        """Yaw less direction of the path [rad], in [-π, π]."""
        return wrap(self.yaw - atan2(self.along_y, self.along_x))

    def checked(self) -> Deviation:
        """Return the same, as floats, where each is within its bound."""
        most = 4.0 * MAX_COORDINATE
        return Deviation(
            input_within("answer", self.cross_track_error, most),
            input_within("answer", self.yaw, 2.0 * MAX_YAW),
            input_within("answer", self.along_x, most),
            input_within("answer", self.along_y, most),
        )


class Place(NamedTuple):
    """The projections of the last step, by which the place is found on another path."""

    x: float
    """That of the predicted vehicle, x [m]."""
    y: float
    """The same, y [m]."""
    measured_x: float
    """That of the measured vehicle, x [m]."""
    measured_y: float
    """The same, y [m]."""

    def checked(self) -> Place:
        """Return the same, as floats, where each is within its bound."""
        most = 4.0 * MAX_COORDINATE
        return Place(*(input_within("place", value, most) for value in self))


class Answer(NamedTuple):
    """The last step's command besides its angle."""

    measured: Deviation
    """The measured vehicle."""
    predicted: Deviation
    """The predicted one."""
    target: Point
    """The point aimed at [m]."""
    reverse: bool
    """Whether the path was driven backwards."""
    ahead: Ahead
    """Reference speed and distance to the next stop."""
    vehicle: tuple[float, float, float, float]
    """The pose of the vehicle's point x [m], y [m], yaw [rad], and the speed [m/s]."""

    def command(self, steer: float, status: Status) -> Command:
        """Return the command of an answer."""
        return Command(
            steer=steer,
            cross_track_error=self.measured.cross_track_error,
            heading_error=self.measured.heading_error(),
            predicted_cross_track_error=self.predicted.cross_track_error,
            predicted_heading_error=self.predicted.heading_error(),
            target=self.target,
            reverse=self.reverse,
            reference_speed=self.ahead.reference_speed,
            distance_to_stop=self.ahead.distance_to_stop,
            status=status,
        )

    def checked(self) -> Answer:
        """Return the same, as floats, where each is within its bound."""
        measured = Deviation(*self.measured).checked()
        predicted = Deviation(*self.predicted).checked()
        x, y = (input_within("answer", at, 4.0 * MAX_COORDINATE) for at in self.target)
        speed, distance = self.ahead
        if speed is not None:
            speed = input_within("answer", speed, 2.0 * MAX_SPEED)
        if distance != inf:
            distance = input_within("answer", distance, MAX_DISTANCE)
        here, there, yaw, now = self.vehicle
        vehicle = (
            input_within("answer", here, MAX_COORDINATE),
            input_within("answer", there, MAX_COORDINATE),
            input_within("answer", yaw, MAX_YAW),
            input_within("answer", now, MAX_SPEED),
        )
        return Answer(measured, predicted, (x, y), self.reverse, Ahead(speed, distance), vehicle)


_NOWHERE = Deviation(cross_track_error=0.0, yaw=0.0, along_x=1.0, along_y=0.0)
NOWHERE = Answer(
    measured=_NOWHERE,
    predicted=_NOWHERE,
    target=(0.0, 0.0),
    reverse=False,
    ahead=Ahead(reference_speed=None, distance_to_stop=0.0),
    vehicle=(0.0, 0.0, 0.0, 0.0),
)
"""Before the first step: stop."""


@dataclass(frozen=True, kw_only=True)
class TrackerState:
    """What all states remember beside the controller's own.

    Attributes
    ----------
    waypoint : int or None
        The segment of the last projection of the predicted vehicle, by the waypoint at which it
        starts; None before the first step.
    measured_waypoint : int or None
        The same of the measured vehicle, where there is a dead time.
    place : tuple of float or None
        Where both were projected to: x, y [m] of the predicted vehicle's projection, x, y [m] of
        the measured one's; None before the first step and after a jump.
    steer : float
        The angle last commanded [rad].
    handover_offset : float or None
        Difference to the angle that was taken over [rad]; None before the first step.
    handover_remaining : float
        How long it fades on [s]; 0 without a hand-over.
    held : int
        How many inputs in a row were refused.
    held_time : float
        How much time they took, which the next step counts [s].
    period : float
        The time that the last step counted [s]; 0 before the first.
    wheel : float or None
        Angle of the wheels by the vehicle's parameters [rad]; None where the vehicle is not
        modelled.
    commands_in_flight : tuple of tuple of float
        Commands in flight, oldest first: angle [rad] and duration [s].
    past_angles : tuple of tuple of float
        Recent mean angles of the wheels, oldest first: angle [rad] and duration [s].
    past_wheel : float or None
        Angle that they end with [rad]; None before the first pose that had an age.
    past_since : float
        How long ago the last pose was measured [s].
    last_measured : tuple of float or None
        x [m], y [m], yaw [rad] and speed [m/s] of the no-slip point when it was last measured;
        None where the motion since shows nothing.
    turn_turn, turn_offset, offset_offset : float
        Sums over the turns expected and those of a radian of steering offset [rad²], [rad], [1];
        see `Estimator`.
    turn_measured, offset_measured : float
        Sums of these times the turns measured [rad²], [rad].
    turn : float
        The turn expected for the last period [rad].
    change : float
        Rates at which the expected turns changed, squared [rad²/s²].
    gain : float
        Ratio of the measured turning to that of the vehicle's parameters.
    steer_offset : float
        Angle of the wheels at the command 0, beyond the vehicle's [rad].
    longer_dead_time : float
        How much longer the dead time is than the vehicle's [s].
    slip : float
        Angle of the motion of the no-slip point to the heading, straight on [rad].
    slip_length : float
        How much that angle grows with the curvature [m].
    acceleration : float
        Acceleration [m/s²].
    answer : tuple or None
        What the last step answered besides its angle: cross-track error [m], yaw [rad] and
        direction of the path (x, y) [m] of the measured vehicle, and of the predicted one; the
        target (x, y) [m]; whether the path was driven backwards; reference speed [m/s] and distance
        to stop [m]; and where the vehicle was: x [m], y [m], yaw [rad] and speed [m/s]. None before
        the first step.
    monitor : tuple or None
        What the monitor remembers, see `MonitorState`; None before the first step.
    """

    waypoint: int | None = None
    measured_waypoint: int | None = None
    place: Place | None = None
    steer: float = 0.0
    handover_offset: float | None = None
    handover_remaining: float = 0.0
    held: int = 0
    held_time: float = 0.0
    period: float = 0.0
    wheel: float | None = None
    commands_in_flight: Timed = ()
    past_angles: Timed = ()
    past_wheel: float | None = None
    past_since: float = 0.0
    last_measured: tuple[float, float, float, float] | None = None
    turn_turn: float = 0.0
    turn_offset: float = 0.0
    offset_offset: float = 0.0
    turn_measured: float = 0.0
    offset_measured: float = 0.0
    turn: float = 0.0
    change: float = 0.0
    gain: float = 1.0
    steer_offset: float = 0.0
    longer_dead_time: float = 0.0
    slip: float = 0.0
    slip_length: float = 0.0
    acceleration: float = 0.0
    answer: Answer | None = None
    monitor: MonitorState | None = None


StateT = TypeVar("StateT", bound=TrackerState)


def hands_over(state: TrackerState) -> bool:
    """Tell whether a hand-over is not over."""
    return not (state.handover_offset is None and state.handover_remaining == 0.0)


def in_flight_of(state: TrackerState) -> InFlight | None:
    """Return the commands in flight; None where the vehicle is not modelled."""
    return None if state.wheel is None else InFlight(state.commands_in_flight, state.wheel)


def with_in_flight(state: StateT, in_flight: InFlight | None) -> StateT:
    """Return the state with these commands in flight."""
    if in_flight is None:
        return replace(state, wheel=None, commands_in_flight=())
    return replace(state, wheel=in_flight.wheel, commands_in_flight=in_flight.commands)


def past_of(state: TrackerState) -> Past | None:
    """Return the wheels' recent angles; None before the first pose with an age."""
    if state.past_wheel is None:
        return None
    return Past(state.past_angles, state.past_wheel, state.past_since)


def with_past(state: StateT, past: Past | None) -> StateT:
    """Return the state with this past of the wheels."""
    if past is None:
        return replace(state, past_angles=(), past_wheel=None, past_since=0.0)
    return replace(state, past_angles=past.angles, past_wheel=past.wheel, past_since=past.since)


def estimator_of(state: TrackerState) -> Estimator:
    """Return what the motion of the vehicle has shown."""
    return Estimator(
        last_measured=None if state.last_measured is None else VehicleState(*state.last_measured),
        information=np.array(
            [[state.turn_turn, state.turn_offset], [state.turn_offset, state.offset_offset]]
        ),
        moment=np.array([state.turn_measured, state.offset_measured]),
        turn=state.turn,
        change=state.change,
        estimate=Corrections(*(getattr(state, each.name) for each in fields(Corrections))),
    )


def with_estimator(state: StateT, estimator: Estimator) -> StateT:
    """Return the state with what the motion of the vehicle has shown."""
    last_measured = estimator.last_measured
    (turn_turn, turn_offset), (_, offset_offset) = estimator.information.tolist()
    turn_measured, offset_measured = estimator.moment.tolist()
    return replace(
        state,
        last_measured=None if last_measured is None else astuple(last_measured),
        turn_turn=turn_turn,
        turn_offset=turn_offset,
        offset_offset=offset_offset,
        turn_measured=turn_measured,
        offset_measured=offset_measured,
        turn=estimator.turn,
        change=estimator.change,
        **vars(estimator.estimate),
    )


def check_waypoint(field: str, path: PathView, waypoint: int | None) -> int | None:
    """Return a remembered waypoint, where it is one of `path`."""
    return None if waypoint is None else input_below(field, waypoint, len(path))
