"""The plan of preview POP over its horizon, and the limits of its moves."""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

    from popsteer.reference.laws.preview_pop.cost_to_go import Regulator

    Array = NDArray[np.float64]


class MoveLimit(enum.IntEnum):
    """The limit that a move reaches; the number that a state remembers it by."""

    NOTHING = 0
    LEAST_MOVE = 1
    MOST_MOVE = 2
    LOW_CURVATURE = 3
    HIGH_CURVATURE = 4

    def of_curvature(self) -> bool:
        """Tell whether it is a limit of the curvature."""
        return self in (MoveLimit.LOW_CURVATURE, MoveLimit.HIGH_CURVATURE)


class Plan(NamedTuple):
    """The best moves within the limits."""

    curvature: float  # that is commanded after the first move [1/m]
    reached: Sequence[MoveLimit]  # by each move


class PlanLimits(NamedTuple):
    """The limits of a plan."""

    first: tuple[float, float]  # least and greatest first move [1/m]; 0 lies between them
    later: float  # the largest of the other moves, either way [1/m]; positive
    low: float  # least curvature that is commanded [1/m]
    high: float  # greatest curvature that is commanded [1/m]


class Horizon(NamedTuple):
    """The planning problem without its limits."""

    models: Sequence[Array]  # A of each step; see `cost_to_go`
    best: Regulator  # the best moves without limits
