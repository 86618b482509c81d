"""Inputs that fail to come: the last command is held, and its time counts."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

from popsteer.errors import InputError
from popsteer.reference.math import saturate
from popsteer.reference.vehicle.state import MAX_DT, MIN_DT, checked_dt

if TYPE_CHECKING:
    from popsteer.reference.lateral.tracker_state import TrackerState

__all__ = ["LEARNING_GAP", "elapse", "miss"]

LEARNING_GAP = 0.25
"""From a motion over more time than this nothing is learnt [s].

What happened within it is not known well enough. Larger values learn from slower loops, and more
wrongly from gaps.
"""

StateT = TypeVar("StateT", bound="TrackerState")


def miss(state: StateT, dt: float) -> StateT:
    """Miss an input, `dt` [s] after the last: the next step counts its time.

    A `dt` out of its range counts as that of the last step.

    Examples
    --------
    >>> from popsteer.reference.lateral.pop import PopState
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
    if elapsed > LEARNING_GAP:
        state = replace(state, seen=None)
    return state, elapsed
