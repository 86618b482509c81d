"""The trajectory that a controller intends."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class Prediction(NamedTuple):
    """What `predict` of a controller answers: a trajectory, an entry an instant.

    Attributes
    ----------
    time : ndarray of shape (N,)
        Time since the last step [s].
    x, y : ndarray of shape (N,)
        Position of the vehicle's point [m].
    yaw : ndarray of shape (N,)
        Heading [rad].
    speed : ndarray of shape (N,)
        Speed [m/s].
    steer : ndarray of shape (N,)
        Angle commanded [rad]; the first is that of the last step.

    Examples
    --------
    >>> import popsteer
    >>> pop = popsteer.Pop(popsteer.Path([(0.0, 0.0), (100.0, 0.0)]))
    >>> command = pop.step(0.0, 0.0, 0.0, 5.0, 0.05)
    >>> ahead = pop.predict(1.0, 0.05)
    >>> len(ahead.time), round(float(ahead.x[-1]), 6)
    (21, 5.0)
    """

    time: NDArray[np.float64]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    yaw: NDArray[np.float64]
    speed: NDArray[np.float64]
    steer: NDArray[np.float64]
