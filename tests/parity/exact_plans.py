"""The best plan of preview POP within its limits, in 100 digits.

It is the judge where Rust core and reference differ in the limits that are reached: whether both
hold the best plan. Plain and slow.
"""

from __future__ import annotations

from decimal import Context, Decimal, localcontext
from typing import Any, NamedTuple

import numpy as np

from popsteer.reference.laws.preview_pop import limited
from popsteer.reference.laws.preview_pop.cost_to_go import COMMANDED
from popsteer.reference.laws.preview_pop.horizon import Horizon, MoveLimit, Plan, PlanLimits

DIGITS = Context(prec=100)
TINY = Decimal("1e-60")
"""Share of a number that is rounding."""


class Planned(NamedTuple):
    """What a plan was made of."""

    horizon: Horizon
    start: Any
    limits: PlanLimits
    stage: Any
    """Q of the regulator."""
    move_cost: float
    """R of the regulator."""


class _Problem(NamedTuple):
    """Minimise x H x / 2 + g x within rows x <= room, over the curvatures x after each move."""

    inverse: Any
    """That of H."""
    free: Any
    """The best x without limits."""
    rows: Any
    room: Any
    kinds: list[tuple[int, MoveLimit]]


class _Solved(NamedTuple):
    """The moves that no plan can choose, the first curvature after them, and the best of the rest.

    Without a rest it has no problem.
    """

    forced: list[MoveLimit]
    first: float
    problem: _Problem | None
    curvatures: Any
    held: list[int]


_LAST: list[tuple[Planned, _Solved]] = []
"""The last one that was solved: many codes are asked of one plan."""


def _solved(planned: Planned) -> _Solved:
    if not (_LAST and _LAST[0][0] is planned):
        horizon, start, limits = planned[:3]
        forced, first, start, limits = limited.go_back(horizon, start, limits)
        solved = _Solved(forced, first, None, None, [])
        if len(forced) < len(horizon.models):
            with localcontext(DIGITS):
                problem = _problem(planned, start, limits, len(forced))
                solved = _Solved(forced, first, problem, *_within_limits(problem))
        _LAST[:] = [(planned, solved)]
    return _LAST[0][1]


def best(planned: Planned) -> Plan:
    """The best plan, as `limited.plan_within` gives it."""
    forced, first, problem, curvatures, held = _solved(planned)
    reached = [*forced, *[MoveLimit.NOTHING] * (len(planned.horizon.models) - len(forced))]
    if problem is not None:
        for step, kind in sorted((problem.kinds[row] for row in held), reverse=True):
            reached[len(forced) + step] = kind
        first = first if forced else float(curvatures[0])
    return Plan(first, reached)


def is_best(planned: Planned, code: int, within: float) -> bool:
    """Whether the limits of `code` hold the best plan, `within` a share of the widest curvature.

    Of two limits of a step a code names that of the move; the best plan tells the other.
    """
    forced, _, problem, curvatures, _ = _solved(planned)
    if problem is None:
        return False
    with localcontext(DIGITS):
        near = Decimal(within * max(abs(planned.limits.low), abs(planned.limits.high)))
        held = []
        for row, (step, kind) in enumerate(problem.kinds):
            named = code >> 3 * (len(forced) + step) & 7
            reached = abs(problem.rows[row] @ curvatures - problem.room[row]) <= near
            of_two = named in (MoveLimit.LEAST_MOVE, MoveLimit.MOST_MOVE) and kind.of_curvature()
            if named == kind or (of_two and reached):
                held.append(row)
        return bool(max(abs(_held(problem, held) - curvatures)) <= near)


def rounding(planned: Planned) -> float:
    """How far from the best the reference's plan may be, a share of the widest curvature.

    A departure and what it departs from cancel to the curvature that is left.
    """
    horizon, start, limits = planned[:3]
    forced, _, start, limits = limited.go_back(horizon, start, limits)
    if len(forced) == len(horizon.models):
        return 0.0
    room = limited.bounds(horizon, start, limits, len(forced)).room
    widest = max(abs(limits.low), abs(limits.high))
    return float(limited.SUM_ROUNDING * abs(room).max(initial=0.0) / widest)


def _problem(planned: Planned, start: Any, limits: PlanLimits, begin: int) -> _Problem:
    models = [_decimals(model) for model in planned.horizon.models[begin:]]
    stage, move_cost, count = _decimals(planned.stage), Decimal(planned.move_cost), len(models)
    # The state, a curvature, the cost: what stands before (x, 1), once or twice.
    unit = _decimals(np.eye(count + 1))
    state = np.outer(_decimals(start), unit[-1])
    before, cost = state[COMMANDED].copy(), 0 * unit
    rows, room, kinds = [], [], []
    for k, model in enumerate(models):
        moved = unit[k] - before
        state[COMMANDED] = before = unit[k].copy()
        least, most = (-limits.later, limits.later) if k else limits.first
        for kind, sign, row, end in (
            (MoveLimit.LEAST_MOVE, -1, moved, least),
            (MoveLimit.MOST_MOVE, 1, moved, most),
            (MoveLimit.LOW_CURVATURE, -1, before, limits.low),
            (MoveLimit.HIGH_CURVATURE, 1, before, limits.high),
        ):
            if np.isfinite(end):
                rows.append(sign * row[:-1])
                room.append(sign * (Decimal(end) - row[-1]))
                kinds.append((k, kind))
        state = model @ state
        cost = cost + move_cost * np.outer(moved, moved) + state.T @ stage @ state
    inverse = _solve(cost[:-1, :-1], unit[:-1, :-1])
    return _Problem(inverse, -inverse @ cost[:-1, -1], np.array(rows), np.array(room), kinds)


def _within_limits(problem: _Problem) -> tuple[Any, list[int]]:
    """Goldfarb and Idnani's method, as in `limited.least_norm`; the rows that hold the best x."""
    inverse, x, rows, room, _ = problem
    sizes = [(row @ inverse @ row).sqrt() for row in rows]
    held: list[int] = []
    multipliers: list[Decimal] = []
    while True:
        excess = (rows @ x - room) / sizes
        worst = max(set(range(len(rows))) - set(held), key=lambda row: excess[row])
        if excess[worst] <= TINY * max(abs(x)):
            return x, held
        row, own = rows[worst], Decimal(0)
        while True:
            kept = rows[held]
            share = _solve(kept @ inverse @ kept.T, kept @ inverse @ row) if held else []
            across = inverse @ (row - kept.T @ share) if held else inverse @ row
            size = row @ across
            dependent = size <= TINY * sizes[worst] ** 2
            full = Decimal("inf") if dependent else (row @ x - room[worst]) / size
            lasting = [(multipliers[k] / s, k) for k, s in enumerate(share) if s > 0]
            step, released = min([*lasting, (full, -1)])
            assert step.is_finite(), "the limits contradict each other"
            x, own = x - step * across, own + step
            multipliers = [m - step * s for m, s in zip(multipliers, share, strict=True)]
            if released < 0:
                held.append(worst)
                multipliers.append(own)
                break
            del held[released], multipliers[released]


def _held(problem: _Problem, held: list[int]) -> Any:
    """The best x with these rows at their ends; a row that others give is left out."""
    x = problem.free
    ways: list[tuple[Any, Decimal]] = []
    for row, room in zip(problem.rows[held], problem.room[held], strict=True):
        across = problem.inverse @ row
        whole = row @ across
        for way, size in ways:
            across = across - (row @ way) / size * way
        if row @ across > TINY * whole:
            x = x - (row @ x - room) / (row @ across) * across
            ways.append((across, row @ across))
    return x


def _decimals(numbers: Any) -> Any:
    return np.vectorize(Decimal, otypes=[object])(numbers)


def _solve(matrix: Any, right: Any) -> Any:
    """Gauss and Jordan's elimination of a symmetric positive definite matrix."""
    matrix, right = matrix.copy(), right.copy()
    for k in range(len(matrix)):
        pivot = matrix[k, k]
        matrix[k], right[k] = matrix[k] / pivot, right[k] / pivot
        for other in range(len(matrix)):
            if other != k:
                factor = matrix[other, k]
                matrix[other] = matrix[other] - factor * matrix[k]
                right[other] = right[other] - factor * right[k]
    return right
