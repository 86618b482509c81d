"""A bare control step around a controller: predict, locate, decide, limit.

It is the core's `tracker::step` without what is no part of the controllers. It leaves out: the
estimator (its estimates are given, and stay), the hand-over from a driver, another path during a
run, `step_or_hold`, poses with an age and applied angles, the monitor, the next stop, and the
trajectory that a controller intends.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from popsteer.reference.error import input_within
from popsteer.reference.laws.law import Belief, Decision, LateralLaw
from popsteer.reference.math import PI, atan, divide, saturate, wrap
from popsteer.reference.path.preview import wheel_at_rest
from popsteer.reference.vehicle.delay import InFlight
from popsteer.reference.vehicle.estimate import Estimate
from popsteer.reference.vehicle.state import VehicleState, period
from popsteer.status import Status

if TYPE_CHECKING:
    from popsteer.reference.geometry import Point
    from popsteer.reference.path.follow import Located
    from popsteer.reference.path.view import PathView
    from popsteer.reference.vehicle import Vehicle


_AT_REST = 0.02
"""At rest: slower than this, in wheelbases a second."""
_ESTIMATION_GAP = 1.0
"""After a longer period the acceleration before it says nothing of now [s]."""
_HOLD_LIMIT = 10
"""How many times in a row a command is held before that is a fault."""


@dataclass(frozen=True)
class Command:
    """The command of one step, with its errors and status; see `popsteer.Command`."""

    steer: float = 0.0
    """Angle to command [rad], positive to the left."""
    cross_track_error: float = 0.0
    """Offset of the tracked point of the measured vehicle from the path [m], positive to the
    left."""
    heading_error: float = 0.0
    """Yaw of the measured vehicle less direction of the path [rad], in [-π, π]."""
    predicted_cross_track_error: float = 0.0
    """Cross-track error of the vehicle when the command reaches the wheels [m]."""
    predicted_heading_error: float = 0.0
    """Heading error of that vehicle [rad]."""
    target: Point = (0.0, 0.0)
    """The point aimed at: the lookahead point, or the projection onto the path, (x, y) [m]."""
    reverse: bool = False
    """Whether the path is driven backwards here."""
    status: Status = Status.OK
    """How the step went."""


StateT = TypeVar("StateT")


@dataclass
class TrackerState(Generic[StateT]):
    """What a tracker remembers."""

    law: StateT
    """What the controller remembers."""
    waypoint: int | None = None
    """The segment of the last projection of the measured vehicle; None before the first step."""
    steer: float = 0.0
    """The angle last commanded [rad]."""
    speed: float = 0.0
    """The speed at the last step [m/s]."""
    in_flight: InFlight | None = None
    """Commands in flight, and the wheels; None where the vehicle is not modelled."""
    command: Command = Command()
    """The last command; before the first step: stop."""
    held: int = 0
    """How many times in a row it was held."""


class Tracker(Generic[StateT]):
    """A controller on a path.

    With a dead time the controller gets the vehicle as predicted for the time when its command
    reaches the wheels. Commands keep the vehicle's limits of angle, rate and lateral acceleration.

    Examples
    --------
    >>> from popsteer.reference import Path, Stanley
    >>> tracker = Tracker(Stanley(), Path([(0.0, 0.0), (9.0, 0.0)]))
    >>> command = tracker.step(1.0, 0.5, 0.0, 5.0, 0.05)
    >>> command.cross_track_error, command.heading_error, command.target, str(command.status)
    (0.5, 0.0, (4.0, 0.0), 'ok')
    """

    def __init__(
        self, law: LateralLaw[Any, StateT], path: PathView, estimate: Estimate | None = None
    ) -> None:
        self.law, self.path = law, path
        car = law.vehicle
        # Whether wheels and motion of the vehicle are modelled; else nothing is estimated.
        self._models = law.READS_BELIEF or car.dead_time > 0.0
        self._given = estimate if estimate is not None and self._models else Estimate()
        # Whether the controller's angle is the command as it is.
        self._bare = (
            not self._models
            and car.max_steer_rate is None
            and car.max_lateral_acceleration is None
            and car.steer_offset == 0.0
        )
        self.reset()

    def reset(self) -> None:
        """Forget all steps."""
        self.estimate = self._given
        self.state = TrackerState(self.law.STATE())
        if self._models:
            self.state.in_flight = InFlight.settled(self.law.vehicle, 0.0)

    def steer(self, x: float, y: float, yaw: float, speed: float, dt: float) -> float:
        """Return the angle of `step` alone [rad]; same state afterwards."""
        return self.step(x, y, yaw, speed, dt).steer

    def step(
        self, x: float, y: float, yaw: float, speed: float, dt: float, *, roll: float = 0.0
    ) -> Command:
        """Take one control step: the pose of the vehicle's point, and the speed, after `dt` [s].

        The position is that of its antenna, where it has one, at a `roll` to the right [rad].

        A `dt` out of 1e-6 to 1e3 s counts as no time: the last command is held.

        Raises `InputError`, naming the first argument that is not finite or, but for `dt`, beyond
        its bound; the state is then unchanged.
        """
        antenna = VehicleState(x, y, yaw, speed).checked()
        roll = input_within("roll", roll, 0.5 * PI)
        passed = period(dt)
        law, state, path = self.law, self.state, self.path
        if passed is None:
            state.held += 1
            lost = state.held > _HOLD_LIMIT
            return replace(state.command, status=Status.INPUT_LOST if lost else Status.INPUT_HELD)
        dt, state.held = passed, 0
        vehicle = antenna.left(-law.vehicle.antenna_offset(roll))
        if dt > _ESTIMATION_GAP:
            self.estimate = replace(self.estimate, acceleration=0.0)
        predicted, belief = self._predict(vehicle, dt)

        # Since the last step it may have driven faster than now.
        travelled = max(abs(speed), abs(state.speed)) * dt
        state.speed = speed
        at = here = law.follow.locate(path, state.waypoint, vehicle, dt, travelled)
        state.waypoint = here.closest.segment
        if law.vehicle.dead_time > 0.0:
            at = law.follow.offset(path, here, predicted, travelled)

        if not self._bare:
            # The angle that the wheels were given.
            law.set_steer(state.law, law.vehicle.at_wheels(state.steer + self._offset))
        decision = self._rest(at) or law.decide(path, state.law, at, belief)
        wanted, status = at.mirror(decision.steer), decision.status
        if self._bare:
            state.steer = wanted
            law.set_steer(state.law, wanted)  # at rest the controller has not decided
        else:
            status |= self._limit(wanted, at.vehicle.speed, dt) | self._join(at)
        if here.past_end:
            status |= Status.END_OF_PATH
        if at.off_path:
            status |= Status.OFF_PATH
        state.command = Command(
            steer=state.steer,
            cross_track_error=here.closest.cross_track_error(),
            heading_error=wrap(here.vehicle.yaw - here.closest.path_yaw()),
            predicted_cross_track_error=at.closest.cross_track_error(),
            predicted_heading_error=wrap(at.vehicle.yaw - at.closest.path_yaw()),
            target=decision.target,
            reverse=at.reverse,
            status=status,
        )
        return state.command

    def _rest(self, at: Located) -> Decision | None:
        """Return the angle of a vehicle at rest; None where it drives.

        Wheels that turn at rest have the angle for the path just ahead; others keep theirs, since
        no error changes.
        """
        state, car, closest = self.state, self.law.vehicle, at.closest
        if abs(at.vehicle.speed) >= _AT_REST * car.wheelbase:
            return None
        if car.steers_at_rest:
            arc = closest.arc_length(self.path)
            steer = wheel_at_rest(car, self.path, closest.segment, arc)
        elif self._bare:
            return None
        else:
            steer = at.mirror(car.at_wheels(state.steer + self._offset))
        if at.direction_changed or at.off_path:
            self.law.leave_path(state.law)
        self.law.interrupt(state.law)
        return Decision(steer, closest.point, Status.OK)

    @property
    def _offset(self) -> float:
        """Angle of the wheels at the command 0 [rad]."""
        return self.law.vehicle.steer_offset + self.estimate.steer_offset

    def _predict(self, vehicle: VehicleState, dt: float) -> tuple[VehicleState, Belief]:
        """Put the last command in flight; return the vehicle as the controller is to see it."""
        car, state, estimate = self.law.vehicle, self.state, self.estimate
        if state.in_flight is None:
            return vehicle, Belief(state.steer, estimate)
        state.in_flight = state.in_flight.elapse(car, state.steer, dt)
        if car.dead_time > 0.0:
            now = vehicle.ahead(car.no_slip)
            then, wheel = state.in_flight.predict(car, now, estimate)
            # The input was valid, so its prediction is put within the bounds and not refused.
            return then.bounded().ahead(-car.no_slip).bounded(), Belief(wheel, estimate)
        return vehicle, Belief(state.in_flight.wheel, estimate)

    def _join(self, at: Located) -> Status:
        """Tell whether a path is joined faster than wheels of their rate can end the turn."""
        car, speed = self.law.vehicle, at.vehicle.forward_speed()
        if car.max_steer_rate is None:
            return Status.OK
        most = 2.0 * car.max_steer_rate * car.turning_length(speed)
        return Status.TOO_FAST if abs(self.law.pull(at)) * speed > most else Status.OK

    def _limit(self, wanted: float, speed: float, dt: float) -> Status:
        """Command the angle `wanted` of the wheels [rad] as far as the vehicle allows.

        Returns what limits it.
        """
        law, state, car, offset = self.law, self.state, self.law.vehicle, self._offset
        wanted = wanted - offset
        angle = car.at_wheels(wanted + offset)
        wheel = _limit_lateral_acceleration(car, angle, speed, self.estimate.gain)
        steer = command = car.at_wheels(wheel - offset)
        if car.max_steer_rate is not None:
            reach = car.max_steer_rate * dt
            steer = saturate(steer, state.steer - reach, state.steer + reach)
        state.steer = steer
        law.set_steer(state.law, car.at_wheels(steer + offset))
        limits = {
            Status.SATURATED: steer - wanted,
            Status.RATE_LIMIT: steer - command,
            Status.LATERAL_LIMIT: wheel - angle,
            Status.STEER_LIMIT: max(
                abs(angle - (wanted + offset)), abs(command - (wheel - offset))
            ),
        }
        # The offset is put off and on again, which rounds.
        status = Status.OK
        for limit, difference in limits.items():
            if abs(difference) > 1e-12:
                status |= limit
        return status


def _limit_lateral_acceleration(car: Vehicle, wheel: float, speed: float, gain: float) -> float:
    """Bring the angle `wheel` [rad] within `max_lateral_acceleration` at `speed` [m/s].

    For a vehicle that turns `gain` times as much as its parameters say.
    """
    most = car.max_lateral_acceleration
    if most is None:
        return wheel
    widest = atan(divide(most * car.turning_length(speed), speed * speed * gain))
    return saturate(wheel, -widest, widest)
