"""The plan of preview POP within the vehicle's limits.

The plan is the solution of a quadratic program over the moves u_k of the curvature that is
commanded, c_{k+1} = c_k + u_k::

    minimise    sum over k of  move_cost u_k² + stage(x_{k+1})
    subject to  least_k <= u_k <= most_k,    low <= c_{k+1} <= high

with the state x_{k+1} that `Travel.after` predicts from x_k and c_{k+1}. It is solved by an active
set: the limits that are reached are held as given, the backward recursion gives the best of the
other moves, and which limits are held is put right until nothing changes. A *pass* is one such
recursion. The first holds what the guess says. Most of the others decide what to hold on the way
back, by what the moves exceed along the best plan so far, as control-limited differential dynamic
programming does (Tassa, Mansard and Todorov, 2014), which changes the whole set at once. A pass
whose plan costs more is gone a part of the way. Once that fails to lower the cost as well, one
limit at a time is added, or those that keep the cost up are released, which lowers it at every
pass (Nocedal and Wright, *Numerical Optimization*, section 16.5).
"""

from __future__ import annotations

import enum
from math import inf
from typing import TYPE_CHECKING

from popsteer.reference.lateral.held import CODES, Held, Side, Step, first_stop, later
from popsteer.reference.lateral.plan import ROUNDING, Horizon, Limits, Plan, Reached, plan
from popsteer.reference.math import divide

if TYPE_CHECKING:
    from popsteer.reference.lateral.cost_to_go import Predicted

__all__ = ["Horizon", "Limits", "Plan", "Reached", "later", "limited"]

MAX_PASSES = 40
"""The most passes of a plan; after them the best plan so far is taken."""
SHORTENED = 2
"""How often a pass that does not lower the cost is gone a part of the way; after that limits are
added one at a time."""
SAME_COST = 1e-12
"""A cost that is lower by no more than this share is not lower."""


class PassKind(enum.Enum):
    """How a pass finds which limits to hold."""

    GUESS = enum.auto()
    """Those of the guess."""
    ALONG = enum.auto()
    """Those that the moves exceed along the best plan so far."""
    ONE_BY_ONE = enum.auto()
    """Those of the last pass, with one more, or without those that keep the cost up."""


def limited(  # noqa: C901, PLR0912 - a loop over passes, as in the twin
    horizon: Horizon, start: Predicted, limits: Limits, guess: int = 0
) -> Plan:
    """Return the best plan from `start` within `limits`.

    Where the commanded curvature lies beyond its limit and cannot be brought back by one move,
    the moves go back as fast as they may until it can.

    `guess` are the limits that the plan may reach; it decides nothing but the count of passes.
    """
    steps = []
    for turn in horizon.turns:
        code = guess & 7
        steps.append(Step(turn, CODES[code] if code < len(CODES) else Held()))
        guess >>= 3
    rounding = limits.begin(start.commanded, steps) * ROUNDING
    best_cost, kind, shortened = inf, PassKind.GUESS, 0
    for count in range(1, MAX_PASSES + 1):
        if kind is PassKind.ALONG:
            _recur_along(horizon, start, steps)
        else:
            _recur(horizon, steps)
        cost = _roll_cut(horizon, start, steps)
        if all(step.next_held == step.held for step in steps):
            return plan(steps, [step.next for step in steps], count, cut_short=False)
        if cost < best_cost * (1.0 - SAME_COST):
            best_cost = cost
            for step in steps:
                step.best, step.best_held = step.next, step.next_held
                step.held = step.next_held
            if kind is PassKind.GUESS:
                kind = PassKind.ALONG
            continue
        if _roll_held(horizon, start, steps, rounding):
            return plan(steps, [step.next for step in steps], count, cut_short=False)
        if kind is PassKind.ONE_BY_ONE:
            best_cost = _go_on(horizon, start, steps, rounding)
            continue
        if shortened < SHORTENED:
            shorter = _shorten(horizon, start, steps, best_cost)
            if shorter is not None:
                best_cost, kind = shorter, PassKind.ALONG
                shortened += 1
                continue
        kind = PassKind.ONE_BY_ONE
        for step in steps:
            step.held = step.best_held
    return plan(steps, [step.best for step in steps], MAX_PASSES, cut_short=True)


def _recur(horizon: Horizon, steps: list[Step]) -> None:
    """Backward: the best moves where some are held."""
    after, landing = horizon.stage, None
    for step in reversed(steps):
        cost = after.before(horizon.travel, step.turn, horizon.drift)
        step.policy = cost.best_move(horizon.move_cost)
        moved, target = step.held_move(), step.held_curvature()
        target = landing if target is None else target
        step.target, landing = target, None
        if moved is not None:
            # Both are held, so it is the step before that brings the curvature there.
            landing = None if target is None else target - moved
            after = cost.before_move_by(moved, horizon.stage)
        elif target is not None:
            after = cost.before_move_to(target, horizon.move_cost, horizon.stage)
        else:
            after = cost.before_best_move(horizon.move_cost, horizon.stage)


def _recur_along(horizon: Horizon, start: Predicted, steps: list[Step]) -> None:
    """Backward along the best plan so far: the best moves, held where they exceed a limit."""
    state = start
    for step in steps:
        step.state = state
        state, _ = horizon.advance(state, step.best, step.turn)
    after = horizon.stage
    for step in reversed(steps):
        cost = after.before(horizon.travel, step.turn, horizon.drift)
        step.policy = cost.best_move(horizon.move_cost)
        wanted = step.policy.commanded(step.state)
        _, step.held = step.cut(step.state.commanded, wanted)
        step.target = step.held_curvature()
        moved = step.held_move()
        if moved is not None:
            after = cost.before_move_by(moved, horizon.stage)
        elif step.target is not None:
            after = cost.before_move_to(step.target, horizon.move_cost, horizon.stage)
        else:
            after = cost.before_best_move(horizon.move_cost, horizon.stage)


def _roll_cut(horizon: Horizon, start: Predicted, steps: list[Step]) -> float:
    """Forward: the best moves, each cut to its limits, and which limits cut them; the cost."""
    state, cost = start, 0.0
    for step in steps:
        wanted = step.policy.commanded(state)
        step.next, step.next_held = step.cut(state.commanded, wanted)
        state, more = horizon.advance(state, step.next, step.turn)
        cost += more
    return cost


def _roll_held(horizon: Horizon, start: Predicted, steps: list[Step], rounding: float) -> bool:
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
        stiffness = divide(horizon.move_cost, step.policy.remaining)
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
        state, _ = horizon.advance(state, step.next, step.turn)
    return right


def _shorten(
    horizon: Horizon, start: Predicted, steps: list[Step], best_cost: float
) -> float | None:
    """Go a part of the way from the best plan to the next one, with the moves cut.

    Where that costs less than `best_cost`; returns the cost then.
    """
    share = 0.5
    while share > 0.05:
        cost = _cost_along(horizon, start, steps, share, cut=True)
        if cost < best_cost * (1.0 - SAME_COST):
            for step in steps:
                step.best, step.held = step.trial, step.trial_held
                step.best_held = step.held
            return cost
        share *= 0.5
    return None


def _go_on(horizon: Horizon, start: Predicted, steps: list[Step], rounding: float) -> float:
    """Go from the best plan towards the next one, which costs less without the limits.

    Until a limit stops it, or farther, with the moves cut to their limits, where that costs
    less. Returns the cost of the best plan then.
    """
    share, stop, held = first_stop(start.commanded, steps, rounding)
    best, best_cost = share, _cost_along(horizon, start, steps, share, cut=False)
    if stop is not None:
        farther = 1.0
        while farther > share and farther > 1e-3:
            cost = _cost_along(horizon, start, steps, farther, cut=True)
            if cost < best_cost:
                best, best_cost = farther, cost
            farther *= 0.25
    if best > share:
        _cost_along(horizon, start, steps, best, cut=True)
    else:
        _cost_along(horizon, start, steps, share, cut=False)
        for index, step in enumerate(steps):
            if stop is None:
                step.trial_held = step.next_held
            else:
                step.trial_held = held if stop == index else step.held
    for step in steps:
        step.best, step.held, step.best_held = step.trial, step.trial_held, step.trial_held
    return best_cost


def _cost_along(
    horizon: Horizon, start: Predicted, steps: list[Step], share: float, *, cut: bool
) -> float:
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
        state, more = horizon.advance(state, step.trial, step.turn)
        cost += more
    return cost
