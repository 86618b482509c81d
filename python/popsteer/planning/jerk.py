"""Speeds whose acceleration changes no faster than a limit."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from popsteer._core import Path, Vehicle, _speed_defaults
from popsteer.errors import ConfigError, PopsteerError
from popsteer.extras import require
from popsteer.planning.limits import table_of
from popsteer.planning.profile import LIMITS, spacing_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

# Each program may exceed the squares of the speeds of the one before by this much.
_GROWTH = 1.2
_PROGRAMS = 4
_SLIGHTLY = 0.999
# How much the square of the start's speed outweighs that of any other waypoint.
_START = 100.0
# The programs hold their bounds to about 1e-6 of them.
_KEPT = 1.0 - 1e-5


def within_jerk(
    path: Path,
    speed: Floats,
    limit: NDArray[np.uint8],
    curvature: Floats,
    limits: Any,  # noqa: ANN401 - a SpeedLimits with all of them filled in
    vehicle: Vehicle,
) -> tuple[Floats, NDArray[np.uint8]]:
    """Lower the speeds of a plan until their acceleration changes slowly enough.

    A linear program maximises the squares w of the speeds, within those given. The jerk at a
    waypoint is the change of the acceleration divided by the time between the middles of its
    segments: l / (v + v_m) for the half of each, with its length l and the speed v_m in its middle.
    That time is bounded from below by the largest w that the program allows, so the limit holds
    whatever w it finds. The start of an open path outweighs all other waypoints. Four programs in
    succession tighten the bound.

    `limits` are as resolved. Raises ConfigError where the limit does not allow the start speed,
    PopsteerError where the extra ``lab`` is missing.
    """
    require("a limit of the jerk", "lab", "scipy")
    from scipy import sparse
    from scipy.optimize import linprog

    squared, spacing, closed = speed * speed, spacing_of(path), path.closed
    count, segments = speed.size, spacing.size
    after = (np.arange(segments) + 1) % count
    rows = np.arange(segments)
    half = 0.5 / spacing
    # Accelerations are the rows of this times w.
    along = sparse.csr_matrix(
        (np.concatenate((half, -half)), (np.tile(rows, 2), np.concatenate((after, rows)))),
        shape=(segments, count),
    )
    inner = np.arange(count) if closed else np.arange(1, count - 1)
    jump = along[inner % segments] - along[inner - 1]
    driving, braking = _bounds(path, squared, curvature, limits, vehicle)
    # From rest the acceleration a builds up over half a segment, in the time √(spacing / a).
    first = (limits.max_jerk**2 * spacing) ** (1.0 / 3.0)
    driving = np.where(squared[:segments] > 0.0, driving, np.minimum(driving, first))
    braking = np.where(squared[after] > 0.0, braking, np.minimum(braking, first))
    matrix = sparse.vstack((along, -along, jump, -jump)).tocsr()
    weight = np.zeros(count)
    np.add.at(weight, rows, spacing)
    np.add.at(weight, after, spacing)
    # A slow waypoint costs more time: the first program's speeds weigh the next one's.
    most = squared
    for _ in range(_PROGRAMS):
        middle = np.sqrt(0.5 * (most[rows] + most[after]))
        at = np.sqrt(np.maximum(most[inner], 1e-12))
        halves = [spacing[k] / (at + middle[k]) for k in (inner % segments, inner - 1)]
        slowly = _KEPT * limits.max_jerk * (halves[0] + halves[1])
        right = np.concatenate((driving, braking, slowly, slowly))
        price = np.where(squared > 0.0, -weight / np.maximum(most, 0.01) ** 1.5, 0.0)
        if not closed and squared[0] > 0.0:
            price[0] = _START * price.min()
        found: Any = linprog(
            price / np.abs(price).max(), matrix, right, bounds=np.column_stack((0.0 * most, most))
        )
        if not found.success:  # all bounds hold at rest, so that it is numerical
            raise PopsteerError(f"no speeds within max_jerk {limits.max_jerk!r}: {found.message}")
        result = np.clip(found.x, 0.0, most)
        most = np.minimum(squared, _GROWTH * result)
    if not closed and result[0] < _SLIGHTLY * squared[0]:
        allowed = f"at most {math.sqrt(result[0]):.3f}, which is what max_jerk allows there"
        raise ConfigError("start_speed", limits.start_speed, allowed)
    lowered = result < _SLIGHTLY * squared
    return np.sqrt(result), np.where(lowered, np.uint8(LIMITS.index("jerk")), limit)


def _bounds(
    path: Path,
    squared: Floats,
    curvature: Floats,
    limits: Any,  # noqa: ANN401 - as above
    vehicle: Vehicle,
) -> list[Floats]:
    """Bound driving and braking of each segment by both of its ends, at any lower speed."""
    used = np.clip(squared * np.abs(curvature) / limits.max_lateral_acceleration, 0.0, 1.0)
    share = (1.0 - used**limits.exponent) ** (1.0 / limits.exponent)
    start = np.arange(squared.size if path.closed else squared.size - 1)
    ends = np.stack((start, (start + 1) % squared.size))
    grade = np.zeros(squared.size) if path.grade is None else path.grade
    uphill = (_speed_defaults["gravity"] * grade / np.hypot(1.0, grade))[ends]
    brakes = max(_speed_defaults["brake_deceleration"], vehicle.max_deceleration or 0.0)
    brakes = vehicle.brake_deceleration or max(brakes, *table_of(limits.max_deceleration)[1])
    # Gravity takes a part of driving uphill, and of the brakes downhill, at the steeper end.
    lost, left = np.maximum(uphill.max(axis=0), 0.0), brakes + np.minimum(uphill.min(axis=0), 0.0)
    found = []
    for limit, less, most in (
        (limits.max_acceleration, lost, math.inf),
        (limits.max_deceleration, 0.0, left),
    ):
        knots, values = table_of(limit)
        # A table may have less to give at a lower speed.
        least = np.minimum.accumulate(values)
        place = np.searchsorted(knots, np.sqrt(squared), side="right") - 1
        level = np.minimum(np.interp(np.sqrt(squared), knots, values), least[np.maximum(place, 0)])
        given = np.minimum(level[ends] - less, most)
        given = np.maximum(given, _speed_defaults["least_on_slopes"] * level[ends])
        grip = given if limits.longitudinal_grip is None else limits.longitudinal_grip
        found.append(np.minimum(given, share[ends] * grip).min(axis=0))
    return found
