"""Twins of a forward case: the same drive mirrored at the x axis, or driven backwards.

A drive forwards along a path and one backwards along the path that is turned by half a turn look
the same from outside: all places and speeds have the other sign, all angles of wheels stay.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

import popsteer

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray


class Twin(NamedTuple):
    """By what the forward case is multiplied."""

    x: float
    y: float
    yaw: float
    speed: float
    steer: float

    def path(self, xy: ArrayLike, speed: ArrayLike | None = None, **options: bool) -> popsteer.Path:
        """Give the path of the twin from the waypoints of the forward case."""
        places = np.asarray(xy, dtype=np.float64) * (self.x, self.y)
        if speed is None and self.speed < 0.0:
            return popsteer.Path(places, reverse=np.ones(len(places), dtype=bool), **options)
        speeds = None if speed is None else self.speed * np.asarray(speed, dtype=np.float64)
        return popsteer.Path(places, speed=speeds, **options)

    def pose(self, x: float, y: float, yaw: float) -> tuple[float, float, float]:
        return self.x * x, self.y * y, self.yaw * yaw

    def columns(self, columns: dict[str, NDArray[np.float64]]) -> dict[str, NDArray[np.float64]]:
        """Give the columns of a log or of records as the twin has them."""
        signs = {**self._asdict(), "cross_track_error": self.steer, "heading_error": self.steer}
        return {name: signs.get(name, 1.0) * values for name, values in columns.items()}


SELF = Twin(1.0, 1.0, 1.0, 1.0, 1.0)
MIRRORED = Twin(1.0, -1.0, -1.0, 1.0, -1.0)
# Along a straight line the heading stays 0: the path leads to -x, and so does the vehicle.
BACKWARDS = Twin(-1.0, 1.0, 1.0, -1.0, 1.0)
