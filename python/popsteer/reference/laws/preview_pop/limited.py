"""The plan of preview POP within the vehicle's limits.

The plan is the solution of a quadratic program over the moves u_k of the curvature that is
commanded, c_k+1 = c_k + u_k::

    minimise    sum over k of  R u_k² + z_k+1ᵀ Q z_k+1
    subject to  least_k <= u_k <= most_k,    low <= c_k+1 <= high

with z_k+1 = A_k (z_k + B u_k). In u_k = -K_k z_k + v_k, the departure v from the best moves without
limits, the cost is the sum of (R + Bᵀ S_k B) v_k² (see `cost_to_go.Regulator`). So the plan within
the limits is the least departure, each v_k scaled by the root of its weight, that keeps them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from popsteer.reference.laws.preview_pop.cost_to_go import COMMANDED
from popsteer.reference.laws.preview_pop.horizon import Horizon, MoveLimit, Plan, PlanLimits

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

ROUNDING = 1e-12
"""Share of the largest curvature that is rounding: a limit exceeded by less is kept."""
SUM_ROUNDING = 1e-13
"""Share of the terms of a sum that is rounding, where they cancel: steps of many metres."""


class Problem(NamedTuple):
    """The limits as bounds of the departure x, scaled: rows x <= room."""

    rows: Array  # shape (limits, steps)
    room: Array  # how far each limit is away without a departure
    kinds: list[tuple[int, MoveLimit]]  # the step and the limit that each row stands for
    curvature: float  # after the first move without a departure [1/m]
    answer: Array  # what a departure adds to that


def plan_within(horizon: Horizon, start: Array, limits: PlanLimits) -> Plan:
    """Return the best plan from the state `start` within `limits`.

    Where the commanded curvature lies beyond its limit and cannot be brought back by one move,
    the moves go back as fast as they may until it can.
    """
    forced, first, start, limits = go_back(horizon, start, limits)
    reached = [*forced, *[MoveLimit.NOTHING] * (len(horizon.models) - len(forced))]
    if len(forced) < len(horizon.models):
        problem = bounds(horizon, start, limits, len(forced))
        rounding = ROUNDING * max(abs(limits.low), abs(limits.high))
        departure, held = least_norm(problem.rows, problem.room, rounding)
        for step, kind in sorted((problem.kinds[row] for row in held), reverse=True):
            # Of two limits of a step the state remembers that of the move.
            reached[len(forced) + step] = kind
        if not forced:
            first = problem.curvature + float(problem.answer @ departure)
    return Plan(first, reached)


def go_back(
    horizon: Horizon, start: Array, limits: PlanLimits
) -> tuple[list[MoveLimit], float, Array, PlanLimits]:
    """Make the moves that no plan can choose: those from beyond a limit of the curvature.

    Returns the limits that they reach, the curvature after the first of them, and state and limits
    after the last.
    """
    reached: list[MoveLimit] = []
    first, rounding = float(start[COMMANDED]), 1e-10 * min(limits.later, limits.high - limits.low)
    for model in horizon.models:
        curvature, (least, most) = float(start[COMMANDED]), limits.first
        if curvature + least >= limits.high - rounding:
            move, kind = least, MoveLimit.LEAST_MOVE
        elif curvature + most <= limits.low + rounding:
            move, kind = most, MoveLimit.MOST_MOVE
        else:
            break
        first = first if reached else curvature + move
        reached.append(kind)
        start = start.copy()
        start[COMMANDED] += move
        start = model @ start
        limits = limits._replace(first=(-limits.later, limits.later))
    return reached, first, start, limits


def bounds(horizon: Horizon, start: Array, limits: PlanLimits, begin: int) -> Problem:
    """Write the limits from step `begin` on, where the state is `start`, as bounds of departures.

    A departure x_k is v_k times the root of its weight.
    """
    count = len(horizon.models) - begin
    rows, room, kinds, curvatures = [], [], [], []
    # The state is the product of this matrix with (departures, 1).
    state = np.column_stack([np.zeros((len(start), count)), start])
    for k in range(count):
        gain, weight = horizon.best.gains[begin + k], horizon.best.weights[begin + k]
        move = -gain @ state
        move[k] += 1.0 / np.sqrt(weight)
        state[COMMANDED] += move
        curvatures.append(curvature := state[COMMANDED].copy())
        least, most = (-limits.later, limits.later) if k else limits.first
        for kind, sign, row, end in (
            (MoveLimit.LEAST_MOVE, -1.0, move, least),
            (MoveLimit.MOST_MOVE, 1.0, move, most),
            (MoveLimit.LOW_CURVATURE, -1.0, curvature, limits.low),
            (MoveLimit.HIGH_CURVATURE, 1.0, curvature, limits.high),
        ):
            if np.isfinite(end):
                rows.append(sign * row[:-1])
                room.append(sign * (end - row[-1]))
                kinds.append((k, kind))
        state = horizon.models[begin + k] @ state
    first = curvatures[0]
    return Problem(np.array(rows), np.array(room), kinds, float(first[-1]), first[:-1])


def least_norm(rows: Array, room: Array, rounding: float) -> tuple[Array, list[int]]:
    """Return the x of least norm with rows x <= room, and the rows that hold it.

    The dual active-set method of Goldfarb and Idnani, *Mathematical Programming* 27 (1983), for a
    cost of xᵀ x / 2. It begins with x = 0 and adds the row that x exceeds the most; a row whose
    multiplier would become negative is released. At every moment x is minus the sum of the held
    rows times their multipliers. A row that the held ones give, as the upper of two equal limits,
    is not added.
    """
    sizes = np.linalg.norm(rows, axis=1)
    held: list[int] = []
    given: list[int] = []
    x: Array = np.zeros(rows.shape[1])
    multipliers: Array = np.zeros(0)
    for _ in range(10 * len(rows)):
        excess = rows @ x - room
        excess -= rounding + SUM_ROUNDING * (abs(rows) @ abs(x) + abs(room))
        excess[held + given] = 0.0
        worst = int(np.argmax(excess / sizes))
        if excess[worst] <= 0.0:
            break
        own = 0.0
        row: Array = rows[worst]
        while True:
            # What of the row the held ones cannot give; a step along it keeps their ends.
            share = np.linalg.lstsq(rows[held].T, row)[0] if held else np.zeros(0)
            across = row - rows[held].T @ share
            size = across @ across
            full = (row @ x - room[worst]) / size if size > 1e-18 * (row @ row) else np.inf
            lasting = np.full(len(held), np.inf)
            least = 1e-9 * abs(share).max(initial=0.0)
            np.divide(multipliers, share, out=lasting, where=share > least)
            step = min(full, lasting.min(initial=np.inf))
            if not np.isfinite(step):
                given.append(worst)  # only rounding exceeds it
                break
            multipliers, own = multipliers - step * share, own + step
            if step == full:
                held.append(worst)
                multipliers = np.append(multipliers, own)
                # As x - step · across, without the rounding of the steps before.
                x = np.asarray(np.linalg.lstsq(rows[held], room[held])[0], float)
                given = []
                break
            x = x - step * across
            released = int(np.argmin(lasting))
            del held[released]
            multipliers = np.delete(multipliers, released)
    return x, held
