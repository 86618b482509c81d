"""Parking manoeuvres: paths with cusps, where the direction of driving changes.

The sign of the reference speed tells the direction: negative where the car rolls backwards. The
sign at a waypoint is that of the segment that begins there, so the waypoint of a cusp has the sign
of the leg that it begins. The line is that of the middle of the rear axle; a car in reverse points
against it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from popsteer.ranges import check_in_range
from popsteer.tracks.geometry import Piece, Waypoints, placed

if TYPE_CHECKING:
    from collections.abc import Sequence

MANOEUVRING = 1.5
"""Greatest speed of a parking manoeuvre [m/s]."""
CREEP = 0.3
"""Its speed at each cusp and at both ends [m/s]."""
SLOWING = 0.5
"""Its acceleration and deceleration [m/s²]."""


def three_point_turn(
    radius: float = 6.0, arc_deg: float = 60.0, final: float = 5.0, spacing: float = 0.1
) -> Waypoints:
    """Turn round by 180° with two cusps: forward left, reverse right, forward left and away.

    It begins with a straight of 3 m along x; the reverse leg has negative speeds. `radius` is that
    of all three arcs of the rear axle [m]; a wheelbase of 3 m turns 6 m with 0.46 rad. `arc_deg` is
    the angle of the first and of the second arc, and the third turns by what is left of 180.
    `final` is the length of the straight at the end, `spacing` the distance of neighbours [m].
    Raises ConfigError where a dimension is out of its range.

    Examples
    --------
    >>> turn = three_point_turn()
    >>> np.sign(turn.speed)[np.flatnonzero(np.diff(np.sign(turn.speed)))].tolist()
    [1.0, -1.0]
    """
    check_in_range("radius", radius, 0.1, 1e3)
    check_in_range("arc_deg", arc_deg, 10.0, 80.0)
    check_in_range("final", final, spacing, 1e3)
    left = 1.0 / radius
    arc = radius * math.radians(arc_deg)
    rest = radius * math.radians(180.0 - 2.0 * arc_deg)
    # Backwards with the wheels to the right: the line of travel still bends to the left.
    return _manoeuvre(
        [
            [Piece(3.0, 0.0, 0.0), Piece(arc, left, left)],
            [Piece(arc, left, left)],
            [Piece(rest, left, left), Piece(final, 0.0, 0.0)],
        ],
        spacing,
    )


def parallel_parking(
    radius: float = 6.0, offset: float = 2.5, final: float = 3.0, spacing: float = 0.1
) -> Waypoints:
    """Park beside the lane with two cusps: past the slot, backwards into it, forward in it.

    It begins along x; two arcs of the rear axle, of `radius` R and by φ with cos φ = 1 - offset / 2
    R, lead backwards into the slot, `offset` to the right of the lane. `final` is the length of the
    straight forward in it, `spacing` the distance of neighbours [m]. Raises ConfigError where a
    dimension is out of its range.

    Examples
    --------
    >>> float(parallel_parking(offset=2.5).xy[-1, 1].round(9))
    -2.5
    """
    check_in_range("radius", radius, 0.1, 1e3)
    check_in_range("offset", offset, 0.01, 2.0 * radius)
    check_in_range("final", final, spacing, 1e3)
    bend = 1.0 / radius
    arc = radius * math.acos(1.0 - 0.5 * offset * bend)
    return _manoeuvre(
        [
            [Piece(10.0, 0.0, 0.0)],
            # Against x, the slot is to the left: the line of travel bends left, then right.
            [Piece(1.0, 0.0, 0.0), Piece(arc, bend, bend), Piece(arc, -bend, -bend)],
            [Piece(final, 0.0, 0.0)],
        ],
        spacing,
    )


def _manoeuvre(legs: Sequence[Sequence[Piece]], spacing: float) -> Waypoints:
    """Join legs at cusps: driven forward, in reverse, and forward again."""
    points, speeds = [], []
    origin, heading = np.zeros(2), 0.0
    for index, pieces in enumerate(legs):
        line = placed(pieces, spacing)
        cosine, sine = math.cos(heading), math.sin(heading)
        xy = origin + line.xy @ np.array([[cosine, sine], [-sine, cosine]])
        along = line.step * np.arange(len(xy))
        to_cusp = np.minimum(along, along[::-1])
        speed = np.minimum(np.sqrt(CREEP**2 + 2.0 * SLOWING * to_cusp), MANOEUVRING)
        last = index + 1 == len(legs)
        stop = len(xy) if last else -1  # the next leg begins with the cusp
        points.append(xy[:stop])
        speeds.append((-speed if index % 2 else speed)[:stop])
        heading += math.pi + sum(piece.length * piece.first_curvature for piece in pieces)
        origin = xy[-1]
    return Waypoints(np.concatenate(points), np.concatenate(speeds), closed=False)
