"""How far apart the Rust core and its reference may be: the one table, with a reason a line."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    Tied = Callable[[str, Any, Any], bool]


class Refused(tuple[Any, ...]):
    """How a call was refused: the class of the error, its text, its attributes."""

    __slots__ = ()


@dataclass(frozen=True)
class Tolerance:
    """How far apart the floats of `what` may be: absolute up to 1, relative beyond; 0 is bits."""

    what: str
    holds_for: Callable[[Any], bool]
    within: float
    reason: str


# Angles, metres and curvatures differ by at most 1e-12 in most drives. 1e-9 leaves room for what
# extreme parameters amplify; a wrong term shows at 1e-7 and more. Whole drives are held to it too,
# without setting the state of one side to the other's: errors of rounding do not add up.
TABLE = (
    Tolerance(
        "preview POP",
        lambda shown: type(shown).__name__ == "PreviewPop",
        1e-9,
        "its cost-to-go and its plan are matrices in the reference, a scalar an entry in Rust",
    ),
    Tolerance(
        "all else: paths, projections, POP, PID, pure pursuit, Stanley, pedals",
        lambda _: True,
        0.0,
        "the same operations in the same order",
    ),
)
"""The first line that holds counts. Integers, flags, statuses and errors are equal in every line,
but for the cases of `plans`."""


def tolerance(shown: Any) -> float:
    """How far apart what an object of the Rust core shows, or answers, may be."""
    return next(line.within for line in TABLE if line.holds_for(shown))


LOST = 1e9
"""Errors that weigh so much reach 1 m: steps are not compared, until the next reset."""


def amplified(controller: Any, speed: Any, dt: Any) -> float:
    """How much more than 1 errors of rounding may weigh in a step of a controller.

    Up to the numbers below the tolerances of the table leave room for it; beyond, they grow in
    proportion.

    - Over a distance d, an error of the angle δ turns the heading by d / (L cos²δ) times as much,
      and moves the vehicle by d times that: 10, and 10 m.
    - The rate of the heading errs by 1 / dt times as much: 0.1 ms.
    - The cheaper a move, the more of an error a plan answers with it: 1 / 1000 of the default cost.
    """
    if not isinstance(speed, float) or not isinstance(dt, float) or not 1e-6 <= dt <= 1e3:
        return 1.0  # a step that is held, or refused
    vehicle = controller.vehicle
    length = vehicle.turning_wheelbase or vehicle.wheelbase
    distance = abs(speed) * (1.5 * vehicle.dead_time + dt)
    turned = distance / (length * math.cos(vehicle.max_steer) ** 2)
    weight = max(1.0, turned / 10.0) * max(1.0, distance / 10.0)
    weight *= max(1.0, 1e-4 / dt) if dt > 0.0 else 1.0
    cost = getattr(controller.params, "steer_rate_cost", None)
    weight *= max(1.0, vehicle.wheelbase / 12e3 / cost) if cost else 1.0
    return weight if math.isfinite(weight) else 1.0


def agree(ours: Any, theirs: Any, within: float, where: str = "", tied: Tied | None = None) -> str:
    """Name the first place where two values differ by more; empty where none does.

    `tied` says of a field whether both its values stand for the same plan.
    """
    if isinstance(ours, float) and isinstance(theirs, float):
        scale = max(1.0, abs(ours), abs(theirs))
        same = ours == theirs or abs(ours - theirs) <= within * scale < math.inf
        same = same or (math.isnan(ours) and math.isnan(theirs))
    elif isinstance(ours, Refused) and isinstance(theirs, Refused):
        # The text shows the number to the last digit.
        return agree(ours[::2], theirs[::2], within, f"{where}refused")
    elif isinstance(ours, tuple) and isinstance(theirs, tuple) and len(ours) == len(theirs):
        parts = zip(range(len(ours)), ours, theirs, strict=True)
        return _first(agree(a, b, within, f"{where}[{k}]", tied) for k, a, b in parts)
    elif isinstance(ours, dict) and isinstance(theirs, dict) and ours.keys() == theirs.keys():
        return _first(agree(ours[k], theirs[k], within, f"{where}.{k}", tied) for k in ours)
    else:
        same = type(ours) is type(theirs) and ours == theirs
        if tied is not None:
            same = same or tied(where.rpartition(".")[2], ours, theirs)
    return "" if same else f"{where or 'value'} is {ours!r} and {theirs!r}"


def _first(apart: Iterator[str]) -> str:
    return next((each for each in apart if each), "")
