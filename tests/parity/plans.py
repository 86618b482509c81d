"""Plans of preview POP where both sides may decide otherwise, and how that is checked.

The Rust core searches for a plan within the limits by passes, the reference solves the quadratic
program by the textbook. Both find its one solution, but for two cases. In a third, a path that
overlaps has two places equally near (`equally_near`).

- A limit that the plan touches without being held back by it may count as reached or not.
- After 40 passes the Rust core takes the best plan so far, and says PLAN_CUT_SHORT.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import popsteer
from popsteer import Status, reference
from popsteer.reference.lateral import limited, preview_pop
from popsteer.reference.lateral.plan import Reached
from tests.parity.tolerances import agree

PLANS = 1e-9
"""How near to the best a plan is that counts as the best, and an angle to its limit."""
_LAST: list[tuple[Any, Any, Any]] = []
CUT_SHORT: list[Any] = []
"""Steps since the test began in which the Rust core's plan was cut short."""
TIED: set[tuple[int, int]] = set()
"""Limits that were reached by one side alone, since the test began."""


def _recorded(horizon: Any, start: Any, limits: Any) -> Any:
    _LAST[:] = [(horizon, start, limits)]
    return limited.limited(horizon, start, limits)


vars(preview_pop)["limited"] = _recorded


def tied(field: str, ours: Any, theirs: Any) -> bool:
    """Whether two values of a field that is decided by limits stand for the same last plan."""
    if field == "reached_limits":
        return _same_plan(ours, theirs)
    return field == "status" and ours ^ theirs == Status.SATURATED and _touches()


def _same_plan(ours: int, theirs: int) -> bool:
    """Whether the limits that the Rust core's last plan reached hold the same plan."""
    if (ours, theirs) in TIED:
        return True
    # A state keeps the limits of the next step on where the period is a step of the horizon.
    codes = [ours, *(ours << 3 | first for first in Reached)]
    if _LAST and any(_is_best(*_LAST[0], code) for code in codes):
        TIED.add((ours, theirs))
        return True
    return False


def _touches() -> bool:
    """Whether the first move may count as at a limit or not, and the plan is the best both ways."""
    later = limited.limited(*_LAST[0]).reached[1:]
    code = sum(limit << 3 * k for k, limit in enumerate(later, 1))
    return sum(_is_best(*_LAST[0], code | first) for first in Reached) >= 2


def equally_near(pair: Any) -> bool:
    """Whether the last step found places equally near, on two segments, on a path that overlaps.

    The reference then goes on from the state of the Rust core.
    """
    ours, theirs = pair.rust.state, pair.twin.state
    if ours.answer is None or theirs.answer is None or ours.waypoint == theirs.waypoint:
        return False
    near, far = sorted((abs(ours.answer[1][0]), abs(theirs.answer[1][0])))
    if far - near > PLANS * max(1.0, far):
        return False
    pair.twin.state = getattr(reference, f"{pair.name}State")(**ours.as_dict())
    return True


def _is_best(horizon: Any, start: Any, limits: Any, code: int) -> bool:
    """Whether the plan that is held by the limits of `code` keeps all limits, at the least cost."""
    forced, _, start, rest = limited.go_back(horizon, start, limits)
    if len(forced) == len(horizon.models):
        return False
    problem = limited.bounds(horizon, start, rest, len(forced))
    held = [
        row
        for row, (step, kind) in enumerate(problem.kinds)
        if code >> 3 * (len(forced) + step) & 7 == kind
    ]
    scale = max(abs(limits.low), abs(limits.high))
    best, _ = limited.least_norm(problem.rows, problem.room, limited.ROUNDING * scale)
    given: Any = np.zeros_like(best)
    if held:
        given = np.linalg.lstsq(problem.rows[held], problem.room[held])[0]
    exceeded = np.max(problem.rows @ given - problem.room)
    size = np.linalg.norm(best)
    return bool(exceeded <= PLANS * scale and np.linalg.norm(given) <= size * (1.0 + PLANS) + PLANS)


def check_cut_short(pair: Any, step: Any, theirs: Any = None) -> Any:
    """The command of a step whose plan was cut short; None where it was not.

    Its angle keeps the limits; all else agrees with `theirs`, where the reference's command is
    given. The reference goes on from the state of the Rust core.
    """
    rust, (before, method, args, kwargs) = pair.rust, step
    again = popsteer.PreviewPop(
        rust.path, rust.vehicle, rust.params, adapt=rust.adapt, monitor=rust.monitor
    )
    again.state = before
    command = getattr(again, "step" if method == "steer" else method)(*args, **kwargs)
    if Status.PLAN_CUT_SHORT not in command.status:
        return None
    assert again.state == rust.state
    assert abs(command.steer) <= rust.vehicle.max_steer
    rate = rust.vehicle.max_steer_rate
    if rate is not None:
        assert abs(command.steer - before.steer) <= rate * rust.state.period * (1.0 + PLANS)
    if method != "steer" and theirs is not None:
        for field in ("cross_track_error", "heading_error", "target", "reverse"):
            apart = agree(getattr(command, field), getattr(theirs, field), PLANS, field)
            assert not apart, apart
    pair.twin.state = reference.PreviewPopState(**rust.state.as_dict())
    CUT_SHORT.append(command)
    return command.steer if method == "steer" else command
