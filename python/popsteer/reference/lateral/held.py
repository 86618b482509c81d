"""The active set of `limited`."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from math import inf
from typing import NamedTuple

from popsteer.reference.lateral.cost_to_go import BestMove, Predicted

__all__ = ["CODES", "Held", "Side", "Step", "first_stop", "later"]


class Side(enum.IntEnum):
    """One end of a range, or none."""

    NEITHER = 0
    LOW = 1
    HIGH = 2

    def resists(self, slope: float, least: float) -> bool:
        """Tell whether what is held at this end would lower the cost by leaving it."""
        if self is Side.LOW:
            return slope < -least
        return self is Side.HIGH and slope > least


class Held(NamedTuple):
    """The limits that a step is held at."""

    rate: Side = Side.NEITHER
    curvature: Side = Side.NEITHER


CODES = (
    Held(),
    Held(rate=Side.LOW),
    Held(rate=Side.HIGH),
    Held(curvature=Side.LOW),
    Held(curvature=Side.HIGH),
)


def later(reached: int) -> int:
    """Return the limits that a plan reaches one step later."""
    return reached >> 3


_FREE = Held()
_NO_MOVE = BestMove(0.0, 0.0, 0.0, 0.0, 0.0)
_NOWHERE = Predicted(0.0, 0.0, 0.0, 0.0)


@dataclass
class Step:
    """One step of a plan while it is made."""

    turn: float
    held: Held
    least: float = 0.0
    most: float = 0.0
    low: float = 0.0
    high: float = 0.0
    forced: bool = False
    state: Predicted = _NOWHERE
    policy: BestMove = _NO_MOVE
    target: float | None = None
    best: float = 0.0
    best_held: Held = _FREE
    next: float = 0.0
    next_held: Held = _FREE
    trial: float = 0.0
    trial_held: Held = _FREE

    def force(self, side: Side) -> None:
        """Give the move: the curvature is on its way back into its limits."""
        self.forced = True
        self.held = Held(rate=side)
        self.low, self.high = -inf, inf

    def held_move(self) -> float | None:
        """Return the move that is given."""
        return (None, self.least, self.most)[self.held.rate]

    def held_curvature(self) -> float | None:
        """Return the curvature that is given."""
        return (None, self.low, self.high)[self.held.curvature]

    def hold_exceeded(self, before: float, rounding: float) -> None:
        """Hold a limit that the next plan exceeds, and not one that it cannot be brought to."""
        if self.forced:
            return
        rate, curvature = self.next_held
        if rate is Side.NEITHER:
            rate = _beyond(self.next - before, self.least, self.most, rounding)
            if rate is not Side.NEITHER:
                self.next_held = Held(rate, curvature)
                return
        held = self.held_curvature()
        if held is None:
            side = _beyond(self.next, self.low, self.high, rounding)
            if side is not Side.NEITHER:
                # Less of the move keeps the curvature.
                self.next_held = Held(curvature=side)
        elif abs(self.next - held) > rounding:
            self.next_held = Held(rate)

    def cut(self, before: float, wanted: float) -> tuple[float, Held]:
        """Return the curvature `wanted` after `before`, or the limit that it exceeds."""
        moved = self.held_move()
        if self.forced and moved is not None:
            return before + moved, self.held
        low, at_low = before + self.least, Held(rate=Side.LOW)
        if low < self.low:
            low, at_low = self.low, Held(curvature=Side.LOW)
        high, at_high = before + self.most, Held(rate=Side.HIGH)
        if high > self.high:
            high, at_high = self.high, Held(curvature=Side.HIGH)
        if wanted > high:
            return high, at_high
        if wanted < low:
            return low, at_low
        return wanted, Held()


def first_stop(start: float, steps: list[Step], rounding: float) -> tuple[float, int | None, Held]:
    """Return the share of the step from the best plan to the next one that keeps all limits.

    And the step that ends it, with what it is held at then.
    """
    first: tuple[float, int | None, Held] = (1.0, None, Held())
    best_before = next_before = start
    for index, step in enumerate(steps):
        rate, curvature = step.held
        moves = step.best - best_before, step.next - next_before
        best_before, next_before = curvatures = step.best, step.next
        if step.forced:
            continue
        of_move = _crossed(rate, moves, step.least, step.most, rounding)
        if of_move is not None and of_move[0] < first[0]:
            first = of_move[0], index, Held(of_move[1], curvature)
        of_curvature = _crossed(curvature, curvatures, step.low, step.high, rounding)
        if of_curvature is not None and of_curvature[0] < first[0]:
            first = of_curvature[0], index, Held(rate, of_curvature[1])
    return first


def _crossed(
    held: Side, way: tuple[float, float], low: float, high: float, rounding: float
) -> tuple[float, Side] | None:
    """Return the share of the step between two numbers at which a limit is crossed, and which.

    None where it is `held`, or not crossed.
    """
    start, end = way
    if held is not Side.NEITHER:
        return None
    if end > high + rounding and end - start > rounding:
        limit, side = high, Side.HIGH
    elif end < low - rounding and start - end > rounding:
        limit, side = low, Side.LOW
    else:
        return None
    share = (limit - start) / (end - start)
    return share if share > 0.0 else 0.0, side


def _beyond(value: float, low: float, high: float, rounding: float) -> Side:
    if value > high + rounding:
        return Side.HIGH
    return Side.LOW if value < low - rounding else Side.NEITHER
