"""Reference speeds that a car of ordinary grip can drive on a given curvature."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = [
    "BRAKING",
    "DRIVING",
    "FIRST_SPEED",
    "LATERAL",
    "TOP_SPEED",
    "closed_profile",
    "open_profile",
]

LATERAL = 4.0
"""Largest lateral acceleration [m/s²]: brisk, and far from the limit of dry road."""
DRIVING = 2.0
"""Largest acceleration [m/s²]."""
BRAKING = 3.0
"""Largest deceleration [m/s²]."""
TOP_SPEED = 25.0
"""Speed that no straight exceeds [m/s]."""
FIRST_SPEED = 1.5
"""Speed at the first waypoint of an open path [m/s]: a car setting off."""


def open_profile(curvature: NDArray[np.float64], step: float) -> NDArray[np.float64]:
    """Speeds along an open path that is entered at `FIRST_SPEED`.

    The speed allowed by the curvature κ is √(`LATERAL` / |κ|), at most `TOP_SPEED`. A pass forward
    bounds v² by its neighbour's v² + 2 a Δs for driving, a pass backward does the same for braking.

    Parameters
    ----------
    curvature : (N,) ndarray
        Curvature at each waypoint [1/m].
    step : float
        Arc length Δs between neighbours [m].

    Returns
    -------
    (N,) ndarray
        Speed at each waypoint [m/s].

    Examples
    --------
    >>> open_profile(np.zeros(4), 1.0).round(2).tolist()
    [1.5, 2.5, 3.2, 3.77]
    """
    squared = _allowed_squared(curvature)
    squared[0] = min(squared[0], FIRST_SPEED * FIRST_SPEED)
    return np.sqrt(_reachable(squared, step))


def closed_profile(curvature: NDArray[np.float64], step: float) -> NDArray[np.float64]:
    """Speeds along a closed path, the same in every lap.

    Parameters
    ----------
    curvature : (N,) ndarray
        Curvature at each waypoint [1/m].
    step : float
        Arc length between neighbours, the last and the first among them [m].

    Returns
    -------
    (N,) ndarray
        Speed at each waypoint [m/s].

    Examples
    --------
    >>> closed_profile(np.full(4, 0.04), 1.0).tolist()
    [10.0, 10.0, 10.0, 10.0]
    """
    squared = _allowed_squared(curvature)
    # At the slowest waypoint the lap neither drives nor brakes, so it can be cut open there.
    slowest = int(np.argmin(squared))
    lap = np.roll(squared, -slowest)
    lap = _reachable(np.append(lap, lap[0]), step)[:-1]
    return np.sqrt(np.roll(lap, slowest))


def _allowed_squared(curvature: NDArray[np.float64]) -> NDArray[np.float64]:
    """Square of the speed that curvature and `TOP_SPEED` allow."""
    top = TOP_SPEED * TOP_SPEED
    return LATERAL / np.maximum(np.abs(curvature), LATERAL / top)


def _reachable(squared: NDArray[np.float64], step: float) -> NDArray[np.float64]:
    """Bound squared speeds by what driving before and braking after each waypoint permits."""
    bounded = squared.tolist()
    for index in range(1, len(bounded)):
        bounded[index] = min(bounded[index], bounded[index - 1] + 2.0 * DRIVING * step)
    for index in range(len(bounded) - 2, -1, -1):
        bounded[index] = min(bounded[index], bounded[index + 1] + 2.0 * BRAKING * step)
    return np.array(bounded)
