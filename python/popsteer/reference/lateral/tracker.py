"""A law as a vehicle takes it: actuator, hand-over from a driver, an answer to every input."""

from __future__ import annotations

import operator
from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Generic, TypeVar

from popsteer.errors import InputError
from popsteer.reference.error import input_in_range
from popsteer.reference.lateral import BodyParams, Command, LateralLaw, check_steer
from popsteer.reference.math import saturate
from popsteer.reference.path.relocalise import relocalise
from popsteer.reference.vehicle import actuator as chain
from popsteer.reference.vehicle.learning import Learnt
from popsteer.reference.vehicle.state import VehicleState, checked_dt
from popsteer.status import Status

if TYPE_CHECKING:
    from popsteer.reference.path.view import PathView
    from popsteer.reference.vehicle.actuator import Actuator, UnderWay
    from popsteer.reference.vehicle.learning import Lesson

__all__ = ["HANDOVER_TIME", "Tracker", "TrackerState"]

HANDOVER_TIME = 1.0
"""How long the difference to a driver's angle takes to fade [s]."""


@dataclass(frozen=True, kw_only=True)
class TrackerState:
    """What all states remember beside the law's own.

    Attributes
    ----------
    waypoint : int or None
        The waypoint at which the segment of the last foot starts; None before the first step.
    steer : float
        The angle last commanded [rad].
    handover_offset : float or None
        Difference to the angle that was taken over [rad]; None before the first step.
    handover_left : float
        How long it fades on [s]; 0 without a hand-over.
    held : int
        How many inputs in a row were refused.
    wheel : float or None
        Angle of the wheels [rad]; None without an actuator.
    under_way : tuple of tuple of float
        Commands on their way to the wheels, oldest first: angle [rad] and duration [s].
    seen : tuple of float or None
        Heading [rad] and speed [m/s] at the last step, where the actuator learns.
    learnt : tuple of float
        What the actuator has learnt: acceleration, expected, measured, turn, change and delay of
        `Learnt`.
    """

    waypoint: int | None = None
    steer: float = 0.0
    handover_offset: float | None = None
    handover_left: float = 0.0
    held: int = 0
    wheel: float | None = None
    under_way: UnderWay = ()
    seen: tuple[float, float] | None = None
    learnt: Lesson = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


ParamsT = TypeVar("ParamsT", bound=BodyParams)
StateT = TypeVar("StateT", bound=TrackerState)


class Tracker(LateralLaw[ParamsT, StateT], Generic[ParamsT, StateT]):
    """A law on a path, and the actuator that its commands go through.

    With an actuator the law is shown the vehicle as it will be when its command arrives, and the
    errors of its `Command` are those of that vehicle; commands keep the actuator's rate. A law
    that starts from a driver's angle, or on another path, goes on from the present angle: the
    difference to what the law itself wants fades evenly over `HANDOVER_TIME`; POP, whose next
    angle lies in the neighbourhood of the last, needs no fading.
    """

    def __init__(
        self, path: PathView, params: ParamsT, default_offset: float, actuator: Actuator | None
    ) -> None:
        super().__init__(path, params, default_offset)
        self._actuator = actuator
        self._state = self._settled(self.initial_state(), 0.0)

    @property
    def actuator(self) -> Actuator | None:
        """What the commands go through on their way to the wheels; None for nothing."""
        return self._actuator

    @property
    def state(self) -> StateT:
        """What the law remembers; may be set to a state saved before.

        Raises
        ------
        InputError
            Where it is no state that this law could have; the state is then unchanged.
        """
        return self._state

    @state.setter
    def state(self, state: StateT) -> None:
        checked = self.check_state(state)
        held = max(0, operator.index(state.held))
        line, wheel, learnt = self._restored_line(state)
        steer = check_steer("steer", state.steer, self.params.max_steer)
        offset, left = state.handover_offset, state.handover_left
        # No offset and no time left is no hand-over; NaN is one, and refused.
        if not (offset is None and left == 0.0):
            if offset is not None:
                offset = check_steer("handover_offset", offset, 2.0 * self.params.max_steer)
            left = input_in_range("handover_left", left, 0.0, HANDOVER_TIME)
        self._state = replace(
            checked,
            steer=steer,
            handover_offset=offset,
            handover_left=left,
            held=held,
            wheel=wheel,
            under_way=line,
            seen=learnt.seen,
            learnt=learnt.lesson,
        )

    def reset(self, *, steer: float | None = None) -> None:
        """Forget all steps; go on from a driver's angle `steer` [rad], where one is given.

        Raises
        ------
        InputError
            Where the angle is not within `max_steer`; the state is then unchanged.
        """
        if steer is None:
            self._state = self._settled(self.initial_state(), 0.0)
            return
        steer = check_steer("steer", steer, self.params.max_steer)
        self._state = self._settled(self._take_over(self.initial_state(), steer), steer)

    def set_path(self, path: PathView) -> None:
        """Follow another path from the next step on, without a jump of the angle."""
        self._path = path
        self._state = self._take_over(self.leave_path(self._state), self._state.steer)

    def relocalise(self, x: float, y: float, yaw: float) -> None:
        """Find the vehicle's place on the path anew, after a jump.

        Puts the remembered waypoint to `relocalise` of the rear axle; the next step goes on from
        there. The rest of the state stays.

        Parameters
        ----------
        x, y : float
            Position of the middle of the rear axle [m].
        yaw : float
            Heading [rad]; tells branches apart that cross or lie alongside.

        Raises
        ------
        InputError
            Naming the first argument that is not finite or beyond its bound; the state is then
            unchanged.
        """
        vehicle = VehicleState(x, y, yaw, speed=0.0).checked()
        segment = relocalise(
            self._path, (vehicle.x, vehicle.y), vehicle.yaw, self._follow.opposite_distance
        )
        self._state = self.set_waypoint(self._state, segment)

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float) -> Command:
        """Locate the vehicle on the path, aim, steer: one control step.

        Parameters
        ----------
        x, y : float
            Position of the middle of the rear axle [m].
        yaw : float
            Heading [rad]; need not be wrapped.
        speed : float
            Speed [m/s]; negative while rolling backwards.
        dt : float
            Control period [s].

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
        seen = VehicleState(x, y, yaw, speed).checked()
        dt = checked_dt(dt)
        state, learnt = self._state, self._known
        if self._actuator is not None and state.wheel is not None:
            under_way, wheel, known = state.under_way, state.wheel, learnt
            learnt = chain.learn(self._actuator, under_way, wheel, known, state.steer, seen, dt)
            # What was given is good, so what comes of it is not refused.
            seen = chain.predict(
                self._actuator, under_way, wheel, known, state.steer, seen, dt, learnt
            ).bounded()
        command = self.decide(seen, dt)
        steer, limited = self._give(command.steer, dt, learnt)
        if limited and command.status is Status.OK:
            return replace(command, steer=steer, status=Status.SATURATED)
        return replace(command, steer=steer)

    def steer(self, x: float, y: float, yaw: float, speed: float, dt: float, /) -> float:
        """Return the angle of `step` alone [rad]; same arguments, same state afterwards."""
        return self.step(x, y, yaw, speed, dt).steer

    def step_or_hold(
        self, x: float, y: float, yaw: float, speed: float, dt: float, hold_limit: int = 10
    ) -> Command:
        """Take one control step, and answer whatever comes in.

        Where `step` would raise `InputError`, the last angle is held, with the status
        `Status.INPUT_HELD` for up to `hold_limit` inputs in a row and `Status.INPUT_LOST` beyond.
        The errors and the target of such a command are 0; the law's state stays.
        """
        try:
            return self.step(x, y, yaw, speed, dt)
        except InputError:
            held = self._state.held + 1
        self._state = replace(self._state, held=held)
        try:
            # The angle held goes on its way like any other.
            self._elapse(checked_dt(dt), self._known)
        except InputError:
            pass
        self._state = replace(self._state, seen=None)
        return Command(
            steer=self._state.steer,
            cross_track_error=0.0,
            heading_error=0.0,
            target=(0.0, 0.0),
            reverse=False,
            status=Status.INPUT_LOST if held > max(0, hold_limit) else Status.INPUT_HELD,
        )

    @abstractmethod
    def decide(self, vehicle: VehicleState, dt: float) -> Command:
        """Take the law's own step with a checked input."""

    def leave_path(self, state: StateT) -> StateT:
        """Forget what was measured against the path: another one is followed from now on."""
        return self.set_waypoint(state, None)

    def set_waypoint(self, state: StateT, waypoint: int | None) -> StateT:
        """Put the remembered waypoint; the rest stays as it is."""
        return replace(state, waypoint=waypoint)

    def set_steer(self, state: StateT, _steer: float) -> tuple[StateT, bool]:
        """Take note of the angle that the wheels were given instead of the law's answer.

        Returns the state, and whether the law's next answer goes on from it.
        """
        return state, False

    def _settled(self, state: StateT, steer: float) -> StateT:
        if self._actuator is None:
            return state
        return replace(state, wheel=steer, under_way=chain.settled(self._actuator, steer))

    def _take_over(self, state: StateT, steer: float) -> StateT:
        """Let a law without a neighbourhood of its own fade from `steer`."""
        state, goes_on = self.set_steer(state, steer)
        left = 0.0 if goes_on else HANDOVER_TIME
        return replace(state, steer=steer, handover_offset=None, handover_left=left)

    @property
    def _known(self) -> Learnt:
        return Learnt.of(self._state.seen, self._state.learnt)

    def _give(self, wanted: float, dt: float, learnt: Learnt) -> tuple[float, bool]:
        """Return the angle to command where the law wants `wanted`, and whether it is limited."""
        state = replace(self._state, held=0)
        fading = state.handover_offset is not None or state.handover_left > 0.0
        if self._actuator is None and not fading:
            self._state = replace(state, steer=wanted)
            return wanted, False
        faded = wanted
        if fading:
            offset, left = state.handover_offset, state.handover_left
            if offset is None:
                offset = state.steer - wanted
            else:
                left -= dt
            faded = wanted + saturate(left / HANDOVER_TIME, 0.0, 1.0) * offset
            if left <= 0.0:
                offset, left = None, 0.0
            state = replace(state, handover_offset=offset, handover_left=left)
        self._state = state
        max_steer = self.params.max_steer
        faded = saturate(faded, -max_steer, max_steer)
        steer = faded
        if self._actuator is not None:
            self._elapse(dt, learnt)
            steer = chain.limit(self._actuator, state.steer, faded, dt)
        state, _ = self.set_steer(self._state, steer)
        self._state = replace(state, steer=steer)
        return steer, steer != faded

    def _elapse(self, dt: float, learnt: Learnt) -> None:
        """Let `dt` [s] pass for what is under way."""
        state = self._state
        if self._actuator is None or state.wheel is None:
            return
        line, wheel = chain.elapse(
            self._actuator, state.under_way, state.wheel, self._known, state.steer, dt, learnt
        )
        self._state = replace(
            state, under_way=line, wheel=wheel, seen=learnt.seen, learnt=learnt.lesson
        )

    def _restored_line(self, state: StateT) -> tuple[UnderWay, float | None, Learnt]:
        """Return what is under way in a state to restore, the wheels, and what was learnt."""
        if self._actuator is None:
            return (), None, Learnt()
        if state.wheel is None:
            # Of a state from before an actuator was there the wheels follow at once.
            return chain.settled(self._actuator, state.steer), state.steer, Learnt()
        learnt = Learnt.of(state.seen, state.learnt)
        return chain.restore(self._actuator, state.under_way, state.wheel, learnt)
