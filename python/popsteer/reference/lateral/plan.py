"""What preview POP plans over its horizon, and what the moves of a plan keep to."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, NamedTuple

from popsteer.reference.lateral.held import CODES, Held, Side, Step

if TYPE_CHECKING:
    from popsteer.reference.lateral.cost_to_go import BestMove, CostToGo, Predicted, Travel

__all__ = ["ROUNDING", "Horizon", "Limits", "Plan", "Reached", "plan"]

ROUNDING = 1e-10
"""Shares of the largest move that are rounding: a limit that is exceeded by less is kept."""


class Reached(enum.Enum):
    """The limit that a first move reaches."""

    NOTHING = enum.auto()
    RATE = enum.auto()
    CURVATURE = enum.auto()


class Plan(NamedTuple):
    """A plan, and how it was found."""

    curvatures: tuple[float, ...]
    """Curvature that is commanded after each move [1/m]."""
    reached: Reached
    """The limit that the first move reaches."""
    limits: int
    """The limits that the plan reaches, three bits a step."""
    passes: int
    """Backward recursions taken."""
    cut_short: bool
    """Whether the passes ran out: the plan keeps the limits but is not the best."""


class Limits(NamedTuple):
    """What the moves of a plan keep to."""

    first: tuple[float, float]
    """Least and greatest first move [1/m]; 0 lies between them."""
    later: float
    """The largest of the other moves, either way [1/m]; positive."""
    low: float
    """Least curvature that is commanded [1/m]."""
    high: float
    """Greatest curvature that is commanded [1/m]."""

    def begin(self, commanded: float, steps: list[Step]) -> float:
        """Prepare the steps of a plan; return a length of move to measure rounding by."""
        between = self.high - self.low
        scale = self.later if self.later < between else between
        rounding = scale * ROUNDING
        curvature = commanded
        least, most = self.first
        for step in steps:
            step.least, step.most = least, most
            step.low, step.high = self.low, self.high
            # Where there is no end, none is held.
            if step.held_move() in (-inf, inf):
                step.held = Held()
            if curvature + least >= self.high - rounding:
                step.force(Side.LOW)
                curvature += least
            elif curvature + most <= self.low + rounding:
                step.force(Side.HIGH)
                curvature += most
            else:
                # From here on the limits can be kept.
                curvature = 0.5 * (self.low + self.high)
            least, most = -self.later, self.later
        return scale


@dataclass(frozen=True)
class Horizon:
    """What is planned: a prediction, and what its steps cost.

    Attributes
    ----------
    travel : Travel
        One step of travel.
    stage : CostToGo
        Cost of the state after a step.
    move_cost : float
        Cost of a move, times its square; positive.
    turns : list of float
        How far the path turns in each step [rad].
    drift : float
        How far the vehicle drifts to the left in a step [m].
    """

    travel: Travel
    stage: CostToGo
    move_cost: float
    turns: list[float]
    drift: float

    def unlimited(self) -> tuple[list[BestMove], CostToGo]:
        """Return the best moves without limits, and the cost-to-go before the first of them."""
        moves = []
        after = cost = self.stage
        for turn in reversed(self.turns):
            cost = after.before(self.travel, turn, self.drift)
            moves.append(cost.best_move(self.move_cost))
            after = cost.before_best_move(self.move_cost, self.stage)
        return moves[::-1], cost

    def keeps(self, moves: list[BestMove], start: Predicted, limits: Limits) -> bool:
        """Tell whether `moves` from `start` keep to `limits`, that of the first move apart.

        As in the twin, where each step costs this: the state is carried without what the present
        curvature adds to it, and the next curvature waits for little else than the present one.
        """
        travel = self.travel
        state = travel.before_commanded(start, self.turns[0], self.drift)
        present = moves[0].commanded(start)
        kept = limits.low <= present <= limits.high
        added = travel.added()
        for best, turn in zip(moves[1:], self.turns[1:], strict=True):
            following = best.remaining_after(travel) * present - best.pull(state)
            kept = kept and abs(following - present) <= limits.later
            kept = kept and limits.low <= following <= limits.high
            state = travel.before_commanded(state, turn, self.drift)
            state = state._replace(
                error=state.error + added.error * present,
                heading=state.heading + added.heading * present,
                driven=state.driven + added.driven * present,
            )
            present = following
        return kept

    def advance(self, state: Predicted, curvature: float, turn: float) -> tuple[Predicted, float]:
        """Move on by a step under `curvature`; return what it costs too."""
        moved = curvature - state.commanded
        state = self.travel.after(state._replace(commanded=curvature), turn, self.drift)
        return state, self.move_cost * moved * moved + self.stage.of(state)


def plan(steps: list[Step], curvatures: list[float], passes: int, *, cut_short: bool) -> Plan:
    """Return the plan that `steps` hold, with its `curvatures`."""
    held = [step.held for step in steps]
    reached = Reached.NOTHING
    if held and held[0].curvature is not Side.NEITHER:
        reached = Reached.CURVATURE
    elif held and held[0].rate is not Side.NEITHER:
        reached = Reached.RATE
    limits = 0
    for each in reversed(held):
        rate_first = Held(rate=each.rate) if each.rate is not Side.NEITHER else each
        limits = limits << 3 | CODES.index(rate_first)
    return Plan(tuple(curvatures), reached, limits, passes, cut_short)
