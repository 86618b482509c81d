"""A whole control step: estimate, predict, locate, decide, limit.

A `Tracker` runs a controller on a vehicle. It predicts the vehicle to the time when the next
command reaches the wheels, keeps the commands within the vehicle's limits, takes over from a driver
without a jump of the angle, and answers every input.
"""

from __future__ import annotations

import operator
from dataclasses import replace
from math import copysign
from typing import TYPE_CHECKING, ClassVar, Generic, Literal, TypeVar

from popsteer.reference.bounds import MAX_DT, MIN_DT
from popsteer.reference.error import input_in_range
from popsteer.reference.laws.law import (
    Command,
    LateralLaw,
    Params,
    Tracked,
    check_steer,
)
from popsteer.reference.path.relocalise import relocalise
from popsteer.reference.path.stop import Ahead
from popsteer.reference.tracker.hold import Holding, elapse
from popsteer.reference.tracker.intend import Predicting
from popsteer.reference.tracker.limit import limit, widest_offset
from popsteer.reference.tracker.monitor import Measured, Monitor, MonitorParams
from popsteer.reference.tracker.monitor.state import MonitorState
from popsteer.reference.tracker.perceive import observe_slip, perceive
from popsteer.reference.tracker.replan import carry_over
from popsteer.reference.tracker.reported import Reported
from popsteer.reference.tracker.state import (
    HANDOVER_TIME,
    Answer,
    Deviation,
    Place,
    TrackerState,
    check_waypoint,
    estimator_of,
    hands_over,
    in_flight_of,
    past_of,
    with_estimator,
    with_in_flight,
    with_past,
)
from popsteer.reference.vehicle import Vehicle
from popsteer.reference.vehicle.delay import InFlight
from popsteer.reference.vehicle.past import Past
from popsteer.reference.vehicle.state import VehicleState, checked_dt
from popsteer.status import Status

if TYPE_CHECKING:
    from collections.abc import Callable

    from popsteer.reference.path.view import PathView
    from popsteer.reference.vehicle.estimate import AdaptParams, Estimate

__all__ = ["HANDOVER_TIME", "Tracker"]

ParamsT = TypeVar("ParamsT", bound=Params)
StateT = TypeVar("StateT", bound=TrackerState)


class Tracker(
    Holding[StateT], Predicting[StateT], LateralLaw[ParamsT, StateT], Generic[ParamsT, StateT]
):
    """A controller on a path, its vehicle, and how it adapts to that.

    With a dead time the controller gets the vehicle as predicted for the time when its command
    reaches the wheels. Commands keep the vehicle's limits of angle, rate and lateral acceleration.
    After a driver, or on another path, the command continues from the present angle: its difference
    to the controller's own angle fades linearly over `HANDOVER_TIME`; POP, whose next angle lies in
    the neighbourhood of the last, needs no fading.
    """

    TRACKED: ClassVar[Tracked]
    PARAMS: Callable[[], ParamsT]
    STATE: Callable[[], StateT]

    def __init__(
        self,
        path: PathView,
        vehicle: Vehicle | None = None,
        params: ParamsT | None = None,
        *,
        adapt: AdaptParams | Literal["auto"] | None = "auto",
        monitor: MonitorParams | Literal["auto"] | None = "auto",
    ) -> None:
        """Steer a vehicle along a path.

        Parameters
        ----------
        path : Path
            The path to follow.
        vehicle : Vehicle, optional
            What is steered; `Vehicle()` without.
        params : optional
            The controller's parameters; the defaults of their class without.
        adapt : AdaptParams or None, optional
            How the controller adapts to its vehicle; None for not at all. Without, as by default
            where an estimate counts: with a dead time, and always in `PreviewPop`.
        monitor : MonitorParams or None, optional
            From where on a step says that something is wrong; None for never. Without, as
            ``MonitorParams()``.
        """
        params = self.PARAMS() if params is None else params
        super().__init__(path, Vehicle() if vehicle is None else vehicle, params)
        self._vehicle_given = vehicle is not None
        self._follow = self.TRACKED.follow(self._vehicle, self._resolved)
        self._adapt = self.default_adapt() if adapt == "auto" else adapt
        self._monitor_params = MonitorParams() if monitor == "auto" else monitor
        monitor_params = self._monitor_params
        self._monitor = None if monitor_params is None else Monitor(monitor_params, self._vehicle)
        # Whether wheels and motion of the vehicle are modelled.
        self._models = (
            self.reads_belief() or self._vehicle.dead_time > 0.0 or self._adapt is not None
        )
        # Whether the controller's angle is the command as it is.
        offset = self._vehicle.steer_offset
        self._bare = (
            not self._models
            and self._vehicle.max_steer_rate is None
            and self._vehicle.max_lateral_acceleration is None
            and offset == 0.0
            and copysign(1.0, offset) > 0.0
        )
        self._state = self._before_first_step()

    @property
    def vehicle_given(self) -> bool:
        """Whether the vehicle was given, and is not the default one."""
        return self._vehicle_given

    @property
    def adapt(self) -> AdaptParams | None:
        """How the controller adapts to its vehicle; None where it does not."""
        return self._adapt

    @property
    def monitor(self) -> MonitorParams | None:
        """The thresholds beyond which a step reports a fault; None without a monitor."""
        return self._monitor_params

    @property
    def tracked_point(self) -> float:
        """How far ahead of the pose's point the tracked point lies [m], driving forward."""
        return self._follow.base + self._follow.reference_offset

    @property
    def estimate(self) -> Estimate:
        """What is known of the vehicle: its parameters, corrected by what its motion has shown."""
        return estimator_of(self._state).known().of(self._vehicle)

    @property
    def state(self) -> StateT:
        """What the controller remembers; may be set to a state saved before.

        Raises
        ------
        InputError
            Where it is no state that this controller could have; the state is then unchanged.
        """
        return self._state

    @state.setter
    def state(self, state: StateT) -> None:
        self._state = self._checked(state)

    def reset(self, *, steer: float | None = None) -> None:
        """Forget all steps; go on from a driver's angle `steer` [rad], where one is given.

        Raises
        ------
        InputError
            Where the angle is not within `max_steer`; the state is then unchanged.
        """
        if steer is None:
            self._state = self._before_first_step()
            return
        steer = check_steer("steer", steer, self._vehicle.max_steer)
        self._state = self._take_over(self._before_first_step(steer), steer)

    def set_path(self, path: PathView) -> None:
        """Follow another path from the next step on.

        The place on it is that of the last projection. Estimates, integral and commands in flight
        continue; so does the whole state if the path is unchanged there. To a path that lies
        elsewhere the command changes over from the present angle within `HANDOVER_TIME`; a
        hand-over in progress keeps its end. Before the first step nothing changes.
        """
        self._state = carry_over(self, self._follow, self._state, self._path, path)
        self._path = path

    def relocalise(self, x: float, y: float, yaw: float) -> None:
        """Find the vehicle's place on the path anew, after a jump to x, y [m] and `yaw` [rad].

        Puts the remembered waypoint to `relocalise` of the rear axle, or of the no-slip point; the
        rest of the state stays, as does all of it where `InputError` is raised.
        """
        vehicle = VehicleState(x, y, yaw, speed=0.0).checked()
        base = vehicle.ahead(self._follow.base)
        waypoint = relocalise(self._path, (base.x, base.y), yaw, self._follow.opposite_distance)
        # Nothing is learnt of the motion until then.
        self._state = replace(
            self._state, waypoint=waypoint, measured_waypoint=None, place=None, last_measured=None
        )
        monitored = self._state.monitor
        if monitored is not None:
            monitored = monitored.interrupted()._replace(within=False)
            self._state = replace(self._state, monitor=monitored)

    def step(
        self,
        x: float,
        y: float,
        yaw: float,
        speed: float,
        dt: float,
        *,
        applied_steer: float | None = None,
        pose_age: float = 0.0,
    ) -> Command:
        """Estimate, predict, locate, decide, limit: one control step.

        Parameters
        ----------
        x, y : float
            Position of the vehicle's point [m].
        yaw : float
            Heading [rad]; need not be wrapped.
        speed : float
            Forward speed [m/s], negative while rolling backwards.
        dt : float
            Time since the last step [s].
        applied_steer, pose_age : optional
            What the vehicle reports beside that; see `Reported`.

        Returns
        -------
        Command
            The angle, the errors, the point aimed at, and how the step went.

        Raises
        ------
        InputError
            Naming the first argument that is not finite or beyond its bound; the state is then
            unchanged.
        """
        vehicle = VehicleState(x, y, yaw, speed).checked()
        dt = checked_dt(dt)
        reported = Reported(applied_steer, pose_age).checked(self._vehicle)
        self._state, dt = elapse(self._state, dt)
        self._state, (now, predicted, belief, observed, travel) = perceive(
            self, self._adapt, self._state, vehicle, dt, reported, models=self._models
        )

        at = self._follow.locate(self._path, self._state.waypoint, predicted, dt)
        self._state = replace(self._state, waypoint=at.closest.segment)
        here = at
        if self._vehicle.dead_time > 0.0:
            here = self._follow.locate(self._path, self._state.measured_waypoint, now, dt)
            self._state = replace(self._state, measured_waypoint=here.closest.segment)
        else:
            # One that a state of another vehicle brought along may be none of this path.
            self._state = replace(self._state, measured_waypoint=None)
        if self._adapt is not None:
            estimator = estimator_of(self._state)
            # A pose that was given before carries no new information.
            if observed >= MIN_DT:
                since = (observed, travel)
                follow, adapt = self._follow, self._adapt
                estimator = observe_slip(self, follow, adapt, estimator, here, vehicle, since)
            self._state = with_estimator(self._state, estimator)
            belief = replace(belief, estimate=estimator.estimate)

        fault = Status.OK
        if self._monitor is not None:
            measured = Measured(here, now, dt)
            self._state, fault = self._monitor.check(self._state, measured, models=self._models)

        if not self._bare:
            # The angle of the last command, with the present estimate of the offset.
            offset = self._vehicle.steer_offset + belief.estimate.steer_offset
            last = self._vehicle.at_wheels(self._state.steer + offset)
            self._state, _ = self.set_steer(self._state, last)
        decision = self.decide(at, belief)
        steer = at.mirror(decision.steer)
        self._state = replace(self._state, held=0)
        limited = False
        if self._bare and not hands_over(self._state):
            self._state = replace(self._state, steer=steer)
        else:
            self._state, limited = limit(
                self, self._state, steer, at.vehicle.speed, dt, belief.estimate
            )
        ahead = Ahead.of(self._path, self._follow, here)
        pose = (now.x, now.y, now.yaw, now.speed)
        answer = Answer(
            Deviation.of(here), Deviation.of(at), decision.target, at.reverse, ahead, pose
        )
        place = Place(*at.closest.point, *here.closest.point)
        self._state = replace(self._state, answer=answer, place=place)
        status = decision.status | fault
        if limited:
            status |= Status.SATURATED
        if at.past_end:
            status |= Status.END_OF_PATH
        if at.off_path:
            status |= Status.OFF_PATH
        return answer.command(self._state.steer, status)

    def _before_first_step(self, steer: float = 0.0) -> StateT:
        """Return the state before the first step, with the wheels at the angle `steer` [rad]."""
        state = self.STATE()
        if self._models:
            return with_in_flight(state, InFlight.settled(self._vehicle, steer))
        return state

    def _take_over(self, state: StateT, steer: float) -> StateT:
        """Let a controller without a neighbourhood of its own fade from `steer`."""
        state, goes_on = self.set_steer(state, steer)
        remaining = 0.0 if goes_on else HANDOVER_TIME
        return replace(state, steer=steer, handover_offset=None, handover_remaining=remaining)

    def _checked(self, state: StateT) -> StateT:
        """Return `state`, where it is one that this tracker could have on its path.

        Raises
        ------
        InputError
            Naming the field that is not.
        """
        car = self._vehicle
        state = self.restore(state)
        in_flight = self._restored_in_flight(state)
        past = past_of(state)
        if past is not None:
            past = Past.restore(past.angles, past.wheel, past.since)
        state = self.check_law_state(state)
        waypoint = check_waypoint("waypoint", self._path, state.waypoint)
        measured = check_waypoint("measured_waypoint", self._path, state.measured_waypoint)
        steer = check_steer("steer", state.steer, car.max_steer)
        offset, remaining = state.handover_offset, state.handover_remaining
        # No offset and no time left is no hand-over; NaN is one, and refused.
        if hands_over(state):
            if offset is not None:
                offset = check_steer("handover_offset", offset, widest_offset(car))
            remaining = input_in_range("handover_remaining", remaining, 0.0, HANDOVER_TIME)
        else:
            remaining = 0.0
        place = None if state.place is None else Place(*state.place).checked()
        held_time = input_in_range("held_time", state.held_time, 0.0, MAX_DT)
        period = input_in_range("period", state.period, 0.0, MAX_DT)
        answer = None if state.answer is None else Answer(*state.answer).checked()
        estimator = estimator_of(state).checked(car)
        monitor = None if state.monitor is None else MonitorState.of(state.monitor).checked()
        if in_flight is not None:
            in_flight = in_flight.checked(car, estimator.estimate.longer_dead_time)
        state = with_in_flight(with_estimator(state, estimator), in_flight)
        return replace(
            with_past(state, past),
            waypoint=waypoint,
            measured_waypoint=measured,
            place=place,
            steer=steer,
            handover_offset=offset,
            handover_remaining=remaining,
            held=max(0, operator.index(state.held)),
            held_time=held_time,
            period=period,
            answer=answer,
            monitor=monitor,
        )

    def _restored_in_flight(self, state: StateT) -> InFlight | None:
        """Return the commands in flight of a state to restore."""
        if not self._models:
            return None
        in_flight = in_flight_of(state)
        if in_flight is None:
            # Of a state that knows nothing of the wheels they are at rest under the last command.
            return InFlight.settled(self._vehicle, state.steer)
        longer = state.longer_dead_time
        return InFlight.restore(self._vehicle, in_flight.commands, in_flight.wheel, longer)
