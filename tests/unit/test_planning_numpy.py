"""Planned speeds beside a textbook's forward and backward pass over the squares of the speeds."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

import numpy as np

from popsteer import Path, Vehicle, planning
from popsteer.planning import SpeedLimits, speeds_along
from tests.planned import closed_spline, random_course, spacing_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

TOP, SIDE, DRIVING, BRAKING = 22.0, 4.0, 2.0, 3.0


def _available(squared: float, bend: float, most: float, grip: float, exponent: float) -> float:
    """Acceleration that the friction ellipse leaves along the path [m/s²]."""
    used = min(squared * abs(bend) / SIDE, 1.0)
    share = 1.0 if math.isinf(exponent) else (1.0 - used**exponent) ** (1.0 / exponent)
    return min(most, grip * share)


def _passed(
    bound: Floats, bends: Floats, spacing: Floats, most: float, grip: float, exponent: float
) -> Floats:
    """One pass: no waypoint faster than its acceleration over a segment, at both ends, allows."""
    squared = bound.copy()
    for k, length in enumerate(spacing):

        def kept(there: float, k: int = k, length: float = length) -> bool:
            ends = ((squared[k], bends[k]), (there, bends[k + 1]))
            least = min(_available(v2, bend, most, grip, exponent) for v2, bend in ends)
            return bool(there <= squared[k] + 2.0 * length * least)

        low, high = squared[k], squared[k + 1]
        if kept(high):
            continue
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if kept(middle) else (low, middle)
        squared[k + 1] = low
    return squared


def _plan(
    bends: Floats, spacing: Floats, *, closed: bool, grip: float, exponent: float, ends: float
) -> Floats:
    bound = np.minimum(TOP**2, SIDE / np.maximum(np.abs(bends), 1e-12))
    start = int(np.argmin(bound)) if closed else 0
    if closed:  # cut open at its slowest waypoint, where a lap neither drives nor brakes
        bound, bends, spacing = (np.roll(each, -start) for each in (bound, bends, spacing))
        bound, bends = np.append(bound, bound[0]), np.append(bends, bends[0])
    else:
        bound[[0, -1]] = np.minimum(bound[[0, -1]], ends**2)
    forward = _passed(bound, bends, spacing, DRIVING, grip, exponent)
    turned = _passed(forward[::-1], bends[::-1], spacing[::-1], BRAKING, grip, exponent)
    squared = turned[::-1]
    return np.sqrt(np.roll(squared[:-1], start) if closed else squared)


def test_planned_speeds_are_those_of_a_forward_and_a_backward_pass() -> None:
    compared = 0
    for seed, closed in itertools.product(range(4), (False, True)):
        xy = closed_spline(seed, 150) if closed else random_course(seed, 150)
        path = Path(xy, closed=closed)
        bends, spacing = planning.curvature(path), spacing_of(path)
        for grip, exponent in itertools.product((2.5, 6.0), (1.0, 2.0, math.inf)):
            limits = SpeedLimits(
                max_speed=TOP,
                max_lateral_acceleration=SIDE,
                max_acceleration=DRIVING,
                max_deceleration=BRAKING,
                longitudinal_grip=grip,
                exponent=exponent,
            )
            ours = speeds_along(
                bends, spacing, limits, Vehicle(), closed=closed, start_speed=1.0, end_speed=1.0
            )
            theirs = _plan(bends, spacing, closed=closed, grip=grip, exponent=exponent, ends=1.0)
            assert np.abs(ours - theirs).max() < 1e-6
            compared += int((np.abs(ours - TOP) > 1.0).sum())
    assert compared > 1000
