"""The plan of preview POP within the vehicle's limits.

The plan is the solution of a quadratic program over the moves u_k of the curvature that is
commanded, c_{k+1} = c_k + u_k::

    minimise    sum over k of  move_cost u_k² + stage(x_{k+1})
    subject to  least_k <= u_k <= most_k,    low <= c_{k+1} <= high

with the state x_{k+1} that `Travel.after` predicts from x_k and c_{k+1}. It is solved by an active
set: the limits that are reached are held as given, the backward recursion gives the best of the
other moves, and which limits are held is put right until nothing changes. A *pass* is one such
recursion. Most passes change the whole set at once, as the moves cut to their limits show it; once
that fails to lower the cost, one limit at a time is added, or those that keep the cost up are
released, which lowers it at every pass (Nocedal and Wright, *Numerical Optimization*, section
16.5).
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, NamedTuple

from popsteer.reference.lateral.held import CODES, Held, Side, Step, first_stop, later
from popsteer.reference.math import divide

if TYPE_CHECKING:
    from popsteer.reference.lateral.cost_to_go import BestMove, CostToGo, Predicted, Travel

__all__ = ["Horizon", "Limits", "Plan", "Reached", "later"]

MAX_PASSES = 40
"""The most passes of a plan; after them the best plan so far is taken."""
TRIES = 2
"""Passes that may fail to lower the cost; after them limits are added one at a time."""
ROUNDING = 1e-10
"""Shares of the largest move that are rounding: a limit that is exceeded by less is kept."""
SAME_COST = 1e-12
"""A cost that is lower by no more than this share is not lower."""


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
        """Tell whether `moves` from `start` keep to `limits`, that of the first move apart."""
        state, most = start, inf
        for best, turn in zip(moves, self.turns, strict=True):
            following = best.commanded(state)
            if not abs(following - state.commanded) <= most:
                return False
            if not limits.low <= following <= limits.high:
                return False
            state = self.travel.after(state._replace(commanded=following), turn, self.drift)
            most = limits.later
        return True

    def limited(  # noqa: C901 - a loop over passes, as in the twin
        self, start: Predicted, limits: Limits, guess: int = 0
    ) -> Plan:
        """Return the best plan from `start` within `limits`.

        Where the commanded curvature lies beyond its limit and cannot be brought back by one move,
        the moves go back as fast as they may until it can.

        `guess` are the limits that the plan may reach; it decides nothing but the count of passes.
        """
        steps = []
        for turn in self.turns:
            code = guess & 7
            steps.append(Step(turn, CODES[code] if code < len(CODES) else Held()))
            guess >>= 3
        rounding = limits.begin(start.commanded, steps) * ROUNDING
        best_cost, tries = inf, 0
        for count in range(1, MAX_PASSES + 1):
            self._recur(steps)
            cost = self._roll_cut(start, steps)
            if all(step.next_held == step.held for step in steps):
                return _plan(steps, [step.next for step in steps], count, cut_short=False)
            if cost < best_cost * (1.0 - SAME_COST):
                best_cost = cost
                for step in steps:
                    step.best, step.best_held = step.next, step.next_held
                    step.held = step.next_held
                continue
            if self._roll_held(start, steps, rounding):
                return _plan(steps, [step.next for step in steps], count, cut_short=False)
            tries += 1
            if tries <= TRIES:
                for step in steps:
                    step.held = step.next_held
            elif tries == TRIES + 1:
                for step in steps:
                    step.held = step.best_held
            else:
                best_cost = self._go_on(start, steps, rounding)
        return _plan(steps, [step.best for step in steps], MAX_PASSES, cut_short=True)

    def _recur(self, steps: list[Step]) -> None:
        """Backward: the best moves where some are held."""
        after, landing = self.stage, None
        for step in reversed(steps):
            cost = after.before(self.travel, step.turn, self.drift)
            step.policy = cost.best_move(self.move_cost)
            moved, target = step.held_move(), step.held_curvature()
            target = landing if target is None else target
            step.target, landing = target, None
            if moved is not None:
                # Both are held, so it is the step before that brings the curvature there.
                landing = None if target is None else target - moved
                after = cost.before_move_by(moved, self.stage)
            elif target is not None:
                after = cost.before_move_to(target, self.move_cost, self.stage)
            else:
                after = cost.before_best_move(self.move_cost, self.stage)

    def _roll_cut(self, start: Predicted, steps: list[Step]) -> float:
        """Forward: the best moves, each cut to its limits, and which limits cut them; the cost."""
        state, cost = start, 0.0
        for step in steps:
            wanted = step.policy.commanded(state)
            step.next, step.next_held = step.cut(state.commanded, wanted)
            state, more = self._advance(state, step.next, step.turn)
            cost += more
        return cost

    def _roll_held(self, start: Predicted, steps: list[Step], rounding: float) -> bool:
        """Forward: the best moves where some are held.

        Tells whether they are the best of all: no other limit is exceeded, and none that is held
        keeps the cost up. Where that is not so, `next_held` has those and not these.
        """
        state, right = start, True
        # What it is worth to move the place where held moves have to land.
        landed = 0.0
        for step in steps:
            before, moved = state.commanded, step.held_move()
            wanted = step.policy.commanded(state)
            if moved is not None:
                step.next = before + moved
            elif step.target is not None:
                step.next = step.target
            else:
                step.next = wanted
            # Half the slope of the cost over this move, and what of it counts.
            stiffness = divide(self.move_cost, step.policy.left)
            slope = stiffness * (step.next - wanted)
            least = stiffness * rounding
            rate, curvature = step.held
            if moved is None:
                landed = slope
            elif not step.forced:
                own = slope - landed if step.target is not None else slope
                if rate.resists(own, least):
                    rate = Side.NEITHER
            if curvature.resists(landed, least):
                curvature = Side.NEITHER
            step.next_held = Held(rate, curvature)
            step.hold_exceeded(before, rounding)
            right = right and step.next_held == step.held
            state, _ = self._advance(state, step.next, step.turn)
        return right

    def _go_on(self, start: Predicted, steps: list[Step], rounding: float) -> float:
        """Go from the best plan towards the next one, which costs less without the limits.

        Until a limit stops it, or farther, with the moves cut to their limits, where that costs
        less. Returns the cost of the best plan then.
        """
        share, stop, held = first_stop(start.commanded, steps, rounding)
        best, best_cost = share, self._cost_along(start, steps, share, cut=False)
        if stop is not None:
            farther = 1.0
            while farther > share and farther > 1e-3:
                cost = self._cost_along(start, steps, farther, cut=True)
                if cost < best_cost:
                    best, best_cost = farther, cost
                farther *= 0.25
        if best > share:
            self._cost_along(start, steps, best, cut=True)
        else:
            self._cost_along(start, steps, share, cut=False)
            for index, step in enumerate(steps):
                if stop is None:
                    step.trial_held = step.next_held
                else:
                    step.trial_held = held if stop == index else step.held
        for step in steps:
            step.best, step.held, step.best_held = step.trial, step.trial_held, step.trial_held
        return best_cost

    def _cost_along(self, start: Predicted, steps: list[Step], share: float, *, cut: bool) -> float:
        """Return the cost of a plan a `share` of the way from the best one to the next.

        Cut to its limits where that is asked for; the plan is `trial`.
        """
        state, cost = start, 0.0
        for step in steps:
            before = state.commanded
            between = step.best + share * (step.next - step.best)
            step.trial = between
            if cut:
                moved = step.held_move()
                wanted = between if moved is None else before + moved
                step.trial, step.trial_held = step.cut(before, wanted)
                if step.trial_held == Held():
                    # Neither limit is exceeded, so what was held still is where it is reached.
                    there = step.held_curvature() == step.trial
                    curvature = step.held.curvature if there else Side.NEITHER
                    step.trial_held = Held(step.held.rate, curvature)
            state, more = self._advance(state, step.trial, step.turn)
            cost += more
        return cost

    def _advance(self, state: Predicted, curvature: float, turn: float) -> tuple[Predicted, float]:
        """Move on by a step under `curvature`; return what it costs too."""
        moved = curvature - state.commanded
        state = self.travel.after(state._replace(commanded=curvature), turn, self.drift)
        return state, self.move_cost * moved * moved + self.stage.of(state)


def _plan(steps: list[Step], curvatures: list[float], passes: int, *, cut_short: bool) -> Plan:
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
