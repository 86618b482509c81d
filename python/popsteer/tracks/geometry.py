"""Lines composed of straights, arcs and clothoids, the points along them, and waypoints."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from popsteer.planning import SpeedLimits, speeds_along
from popsteer.planning.limits import DEFAULTS
from popsteer.ranges import check_in_range
from popsteer.tracks.track import Track

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray


class Piece(NamedTuple):
    """A line's stretch, curvature linear in arc length, left positive: straight, arc, clothoid."""

    length: float
    """Arc length [m], positive."""
    first_curvature: float
    """Curvature at the beginning [1/m]."""
    last_curvature: float
    """Curvature at the end [1/m]."""


class Sampled(NamedTuple):
    """Points at equal steps of arc length."""

    xy: NDArray[np.float64]
    """The points [m], shape (N, 2)."""
    curvature: NDArray[np.float64]
    """The curvature of the line at each point [1/m], shape (N,)."""
    step: float
    """Arc length between neighbours [m]."""


def straight(length: float) -> list[Piece]:
    """Make a straight of a length [m]."""
    return [Piece(length, 0.0, 0.0)]


def turn(angle_deg: float, radius: float, transition: float) -> list[Piece]:
    """Make a turn: a clothoid in, an arc, and the same clothoid out.

    The heading changes by `angle_deg`, positive to the left. `radius` is that of the arc [m],
    `transition` the length of each clothoid [m], less than `radius` times the angle. A clothoid of
    length c between curvature 0 and 1/R turns by c / (2 R), so the arc that is left for a turn by
    the angle α has the length R |α| - c.
    """
    curvature = math.copysign(1.0 / radius, angle_deg)
    arc = radius * abs(math.radians(angle_deg)) - transition
    return [
        Piece(transition, 0.0, curvature),
        Piece(arc, curvature, curvature),
        Piece(transition, curvature, 0.0),
    ]


def sample(pieces: Sequence[Piece], count: int) -> Sampled:
    """Place `count` points along a line that starts at the origin, heading along x.

    The points are at equal steps of arc length, the two ends among them. Heading and position
    follow from the curvature κ over the arc length s: θ' = κ, x' = cos θ, y' = sin θ.

    Examples
    --------
    >>> sample(straight(2.0), 3).xy.round(9).tolist()
    [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]
    """
    lengths, first, last = np.array(pieces, dtype=np.float64).T
    ends = np.cumsum(lengths)
    begins = ends - lengths
    slopes = (last - first) / lengths
    headings = np.concatenate(([0.0], np.cumsum(0.5 * (first + last) * lengths)))

    stations = np.linspace(0.0, ends[-1], count)
    # No interval of the quadrature spans a joint, where the curvature has a kink; within a piece
    # of about a metre five Gauss points are exact to rounding.
    knots = np.union1d(stations, begins)
    nodes, weights = np.polynomial.legendre.leggauss(5)
    half = 0.5 * np.diff(knots)
    inner = knots[:-1, None] + half[:, None] * (1.0 + nodes)
    piece = np.searchsorted(begins, inner, side="right") - 1
    along = inner - begins[piece]
    theta = headings[piece] + (first[piece] + 0.5 * slopes[piece] * along) * along

    xy = np.zeros((len(knots), 2))
    xy[1:, 0] = np.cumsum((np.cos(theta) @ weights) * half)
    xy[1:, 1] = np.cumsum((np.sin(theta) @ weights) * half)

    piece = np.searchsorted(begins, stations, side="right") - 1
    curvature = first[piece] + slopes[piece] * (stations - begins[piece])
    return Sampled(xy[np.searchsorted(knots, stations)], curvature, float(ends[-1] / (count - 1)))


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


def lemniscate(size: float, spacing: float = 1.0) -> Sampled:
    """Make a lemniscate of Bernoulli, closed, from the tip of its right loop, `size` from 0 [m]."""

    def curve(t: NDArray[np.float64]) -> NDArray[np.float64]:
        scale = size * np.cos(t) / (1.0 + np.sin(t) ** 2)
        return np.column_stack((scale, scale * np.sin(t)))

    fine = np.linspace(0.0, 2.0 * math.pi, 100_001)
    t, step = equal_steps(curve(fine), fine, spacing)
    t = t[:-1]  # a closed path does not repeat its first waypoint
    return Sampled(curve(t), 3.0 * np.cos(t) / (size * np.sqrt(1.0 + np.sin(t) ** 2)), step)


LIMITS = SpeedLimits(**DEFAULTS, exponent=math.inf)
"""What an ordinary car drives at briskly, far from the limit of a dry road."""
FIRST_SPEED = 1.5
"""Speed at the first waypoint of an open path [m/s]: a car setting off."""

# Sine and cosine differ in the last bit from one machine to the next. A micrometre hides that, so
# a track, and every figure printed from it, is the same everywhere; and it is far too little to
# disturb the curvature.
_DECIMALS = 6


def build(name: str, title: str, description: str, line: Sampled, *, closed: bool = False) -> Track:
    """Put reference speeds to a sampled line.

    The numbers are rounded to a micrometre, so that all machines make the same.

    Examples
    --------
    >>> build("short", "Three metres", "", sample(straight(3.0), 4)).speed.tolist()
    [1.5, 2.5, 3.201562, 3.774917]
    """
    return Track(
        name=name,
        title=title,
        description=description,
        xy=np.round(line.xy, _DECIMALS) + 0.0,  # + 0.0 turns -0.0 into 0.0
        speed=np.round(profile(line, closed=closed), _DECIMALS),
        closed=closed,
    )


def profile(line: Sampled, *, closed: bool) -> NDArray[np.float64]:
    """Give the fastest speeds [m/s] within `LIMITS`; an open path is entered at `FIRST_SPEED`."""
    first = None if closed else FIRST_SPEED
    return speeds_along(line.curvature, line.step, LIMITS, closed=closed, start_speed=first)


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
