"""What the paths of `popsteer.tracks.edges` are made with."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from popsteer.ranges import check_in_range
from popsteer.tracks.geometry import Piece, Sampled, sample

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray


class Waypoints(NamedTuple):
    """Waypoints as `popsteer.Path` takes them: `Path(w.xy, speed=w.speed, closed=w.closed)`."""

    xy: NDArray[np.float64]
    """The waypoints [m], shape (N, 2)."""
    speed: NDArray[np.float64]
    """The reference speed at each waypoint [m/s], shape (N,); negative in reverse."""
    closed: bool
    """Whether the last waypoint leads back to the first."""


def placed(pieces: Sequence[Piece], spacing: float) -> Sampled:
    """Place waypoints on a line at a spacing [m], 0.01 to 100, rounded to divide the line.

    Raises ConfigError where the spacing is out of its range.

    Examples
    --------
    >>> placed([Piece(100.0, 0.0, 0.0)], 50.0).xy.round(9).tolist()
    [[0.0, 0.0], [50.0, 0.0], [100.0, 0.0]]
    """
    length = sum(piece.length for piece in pieces)
    check_in_range("spacing", spacing, 0.01, 100.0)
    segments = max(round(length / spacing), 1)
    # The quadrature wants steps of at most a metre and a radian; the rest is left out afterwards.
    sharpest = max(abs(piece.first_curvature) for piece in pieces)
    finer = math.ceil(length / segments * max(1.0, sharpest))
    line = sample(pieces, segments * finer + 1)
    return Sampled(line.xy[::finer], line.curvature[::finer], line.step * finer)
