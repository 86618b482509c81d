"""Missing and refused inputs: the last command is held, and the next step covers their time."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Generic, TypeVar

from popsteer.errors import InputError
from popsteer.reference.bounds import MAX_DT, MIN_DT
from popsteer.reference.math import saturate
from popsteer.reference.tracker.state import NOWHERE, TrackerState
from popsteer.reference.vehicle.state import checked_dt
from popsteer.status import Status

if TYPE_CHECKING:
    from collections.abc import Callable

    from popsteer.reference.tracker.command import Command

__all__ = ["ESTIMATION_GAP", "Holding", "elapse", "miss"]

ESTIMATION_GAP = 0.25
"""Longest period whose motion is used for estimates [s].

What happened within a longer one is not known well enough. Larger values allow slower loops, and
let gaps disturb the estimates.
"""

StateT = TypeVar("StateT", bound=TrackerState)


def miss(state: StateT, dt: float) -> StateT:
    """Miss an input, `dt` [s] after the last: the next step counts its time.

    A `dt` out of its range counts as that of the last step.

    Examples
    --------
    >>> from popsteer.reference.laws.pop import PopState
    >>> miss(miss(PopState(period=0.1), 0.05), float("nan")).held_time
    0.15000000000000002
    """
    try:
        dt = checked_dt(dt)
    except InputError:
        dt = state.period
    return replace(state, held_time=saturate(state.held_time + dt, 0.0, MAX_DT))


def elapse(state: StateT, dt: float) -> tuple[StateT, float]:
    """Return the time since the last step [s] of an input that comes `dt` [s] after the last.

    No time has been missed in the state that is returned with it.
    """
    elapsed = saturate(state.held_time + dt, MIN_DT, MAX_DT)
    state = replace(state, held_time=0.0, period=elapsed)
    if elapsed > ESTIMATION_GAP:
        state = replace(state, last_measured=None)
    return state, elapsed


class Holding(Generic[StateT]):
    """The methods `steer` and `step_or_hold` of a tracker."""

    _state: StateT
    step: Callable[..., Command]

    def steer(
        self,
        x: float,
        y: float,
        yaw: float,
        speed: float,
        dt: float,
        /,
        *,
        applied_steer: float | None = None,
        pose_age: float = 0.0,
    ) -> float:
        """Return the angle of `step` alone [rad]; same arguments, same state afterwards."""
        command = self.step(x, y, yaw, speed, dt, applied_steer=applied_steer, pose_age=pose_age)
        return command.steer

    def step_or_hold(
        self,
        x: float,
        y: float,
        yaw: float,
        speed: float,
        dt: float,
        hold_limit: int = 10,
        *,
        applied_steer: float | None = None,
        pose_age: float = 0.0,
    ) -> Command:
        """Take one control step, and answer whatever comes in.

        Where `step` would raise `InputError`, the last command is held, its angle, direction,
        errors and target, with the status `Status.INPUT_HELD` for up to `hold_limit` inputs in a
        row and `Status.INPUT_LOST` beyond. The time `dt` of a held input is added to the next step,
        which then is one step over the whole time. A `dt` that is itself refused counts as that of
        the last step.
        """
        try:
            return self.step(x, y, yaw, speed, dt, applied_steer=applied_steer, pose_age=pose_age)
        except InputError:
            state = miss(self._state, dt)
        state = replace(state, held=state.held + 1)
        self._state = state
        answer = NOWHERE if state.answer is None else state.answer
        lost = state.held > max(0, hold_limit)
        return answer.command(state.steer, Status.INPUT_LOST if lost else Status.INPUT_HELD)
