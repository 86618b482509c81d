"""Preview POP's prediction as a linear-quadratic regulator.

Its state is z = (e, p, a, c, 1): cross-track error e [m], heading error p [rad], driven curvature a
[1/m], commanded curvature c [1/m]. The independent variable is the distance travelled, so the model
is the same at any speed; only the steering lag becomes a distance, lag times speed::

    e' = p + offset a,    p' = a - path curvature,    a' = (c - a) / lag distance

A step moves the wheels by u and travels; the path's turn is in the last column of the
matrix A. It costs R u² for the move and a quadratic form of the state that it leads to::

    z⁺ = A (z + B u),    cost = R u² + z⁺ᵀ Q z⁺,    B = (0, 0, 0, 1, 0)ᵀ
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Array = NDArray[np.float64]

COMMANDED = 3
"""Place of the commanded curvature in the state."""


def transition(step: float, lag: float, kept: float, offset: float, turn: float = 0.0) -> Array:
    """Return A, the model solved exactly over `step` [m].

    The curvature responds with a first-order lag over `lag` [m]; `kept` is exp(-step / lag);
    errors are those of a point `offset` [m] ahead of the no-slip point. Within the step the path
    turns by `turn` [rad].
    """
    by_driven = lag * (1.0 - kept)
    by_commanded = step - by_driven
    lagging = lag * by_commanded
    ahead, aside = 0.5 * step * step - lagging, -0.5 * step * turn
    return np.array(
        [
            [1.0, step, lagging + offset * by_driven, ahead + offset * by_commanded, aside],
            [0.0, 1.0, by_driven, by_commanded, -turn],
            [0.0, 0.0, kept, 1.0 - kept, 0.0],
            [0.0, 0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, 1.0],
        ]
    )


def stage(heading_cost: float, offset: float) -> Array:
    """Return Q of the cost e² + (heading_cost (p + offset a))² of one state.

    The second is the direction in which the reference point travels.
    """
    direction = np.array([0.0, 1.0, offset, 0.0, 0.0])
    return np.diag([1.0, 0.0, 0.0, 0.0, 0.0]) + heading_cost**2 * np.outer(direction, direction)


class Regulator(NamedTuple):
    """The best moves u = -K z of a prediction.

    The moves u = -K z + v cost zᵀ P z, which does not depend on v, and the sum of weight · v².
    """

    gains: Array  # K of each step, shape (steps, 5)
    weights: Array  # R + Bᵀ S B of each step, shape (steps,)
    cost: Array  # S of the first step: the cost-to-go after its move, but before its travel


def regulator(models: Sequence[Array], stage: Array, move_cost: float) -> Regulator:
    """Carry the cost-to-go back over the horizon: the Riccati recursion.

    From P = Q at the end, for each step from the last to the first::

        S = Aᵀ P A,    K = Bᵀ S / (R + Bᵀ S B),    P = Q + S - S B K

    as in Bertsekas, *Dynamic Programming and Optimal Control*, section 3.1. P is computed as
    Q + (I - B K)ᵀ S (I - B K) + Kᵀ R K, which is the same and loses no digits. The `models` are A
    of each step, `stage` is Q, and `move_cost` R, which is positive.
    """
    gains, weights = [], []
    cost = after = stage
    for model in reversed(models):
        cost = model.T @ after @ model
        weight = move_cost + cost[COMMANDED, COMMANDED]
        gain = cost[COMMANDED] / weight
        closed = np.eye(len(gain))
        closed[COMMANDED] -= gain
        after = stage + closed.T @ cost @ closed + move_cost * np.outer(gain, gain)
        gains.append(gain)
        weights.append(weight)
    return Regulator(np.array(gains[::-1]), np.array(weights[::-1]), cost)
