"""From a sampled line to a track."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from popsteer.planning import SpeedLimits, speeds_along
from popsteer.planning.limits import DEFAULTS
from popsteer.tracks.track import Track

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from popsteer.tracks.geometry import Sampled

LIMITS = SpeedLimits(**DEFAULTS, exponent=math.inf)
"""What an ordinary car drives at briskly, far from the limit of a dry road."""
FIRST_SPEED = 1.5
"""Speed at the first waypoint of an open path [m/s]: a car setting off."""

# Sine and cosine differ in the last bit from one machine to the next. A micrometre hides that, so
# a track, and every figure printed from it, is the same everywhere; and it is far too little to
# disturb the curvature.
_DECIMALS = 6


def build(name: str, title: str, description: str, line: Sampled, *, closed: bool) -> Track:
    """Put reference speeds to a sampled line.

    The numbers are rounded to a micrometre, so that all machines make the same.

    Examples
    --------
    >>> from popsteer.tracks.geometry import sample, straight
    >>> build("short", "Three metres", "", sample(straight(3.0), 4), closed=False).speed.tolist()
    [1.5, 2.5, 3.201562, 3.774917]
    """
    return Track(
        name=name,
        title=title,
        description=description,
        xy=np.round(line.xy, _DECIMALS) + 0.0,  # + 0.0 turns -0.0 into 0.0
        speed=np.round(profile(line.curvature, line.step, closed=closed), _DECIMALS),
        closed=closed,
    )


def profile(curvature: NDArray[np.float64], step: float, *, closed: bool) -> NDArray[np.float64]:
    """Give the speeds of a track [m/s]: the fastest within `LIMITS`, along a curvature [1/m].

    `step` is the arc length between waypoints [m]. An open path is entered at `FIRST_SPEED`.
    """
    first = None if closed else FIRST_SPEED
    return speeds_along(curvature, step, LIMITS, closed=closed, start_speed=first)


def equal_steps(
    xy: NDArray[np.float64], parameter: NDArray[np.float64], spacing: float = 1.0
) -> tuple[NDArray[np.float64], float]:
    """Find the parameters of points at equal steps on a finely sampled curve, and the step [m].

    `xy` are points of the curve [m], far closer together than `spacing`, and `parameter` is what
    the curve is a function of, at each of them, increasing. The step is the one nearest to
    `spacing` [m] that divides the curve; its two ends are among the points.

    Examples
    --------
    >>> t = np.linspace(0.0, 1.0, 101)
    >>> parameter, step = equal_steps(np.column_stack((3.0 * t, 4.0 * t)), t, spacing=2.5)
    >>> parameter.round(9).tolist(), round(step, 9)
    ([0.0, 0.5, 1.0], 2.5)
    """
    steps = np.diff(xy, axis=0)
    arc = np.concatenate(([0.0], np.cumsum(np.sqrt((steps * steps).sum(axis=1)))))
    count = max(round(float(arc[-1]) / spacing), 1) + 1
    stations = np.linspace(0.0, arc[-1], count)
    return np.interp(stations, arc, parameter), float(arc[-1] / (count - 1))
