"""Paths to plan, and what a plan has to hold."""

from __future__ import annotations

import math
import random
from typing import TYPE_CHECKING

import numpy as np

from popsteer.planning.limits import table_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from popsteer import Path
    from popsteer.planning import SpeedProfile


def closed_spline(seed: int, count: int = 400, radius: float = 80.0) -> NDArray[np.float64]:
    """A smooth closed curve, a few waves on a circle."""
    rng = random.Random(seed)
    angle = np.arange(count) * (2.0 * math.pi / count)
    distance = np.full(count, radius)
    for wave in range(2, 6):
        size = rng.uniform(0.0, 0.3) * radius / wave
        distance = distance + size * np.cos(wave * angle + rng.uniform(0.0, 2.0 * math.pi))
    return np.column_stack((distance * np.cos(angle), distance * np.sin(angle)))


def random_course(seed: int, count: int = 300) -> NDArray[np.float64]:
    """An open path whose curvature wanders, with unequal spacing."""
    rng = random.Random(seed)
    x = y = yaw = bend = 0.0
    points = []
    for _ in range(count):
        points.append((x, y))
        step = rng.uniform(0.2, 2.0)
        bend = max(-0.15, min(bend + rng.gauss(0.0, 0.02) * math.sqrt(step) - 0.02 * bend, 0.15))
        yaw += bend * step
        x, y = x + step * math.cos(yaw), y + step * math.sin(yaw)
    return np.array(points)


def spacing_of(path: Path) -> NDArray[np.float64]:
    return np.diff(np.append(path.s, path.length) if path.closed else path.s)


def excess(profile: SpeedProfile) -> dict[str, float]:
    """By how much each limit is exceeded at the most, over all waypoints and segments."""
    limits, car, path = profile.limits, profile.vehicle, profile.path
    speed, bends, spacing = profile.speed, profile.curvature, spacing_of(path)
    assert isinstance(limits.max_speed, float)
    assert isinstance(limits.max_lateral_acceleration, float)
    lateral = speed * speed * np.abs(bends)
    after = (np.arange(spacing.size) + 1) % len(path)
    found = {
        "speed": float((speed - limits.max_speed).max()),
        "lateral": float((lateral - limits.max_lateral_acceleration).max()),
    }
    along = profile.acceleration
    for name, sign in (("max_acceleration", 1.0), ("max_deceleration", -1.0)):
        knots, values = table_of(getattr(limits, name))
        worst = 0.0
        for end in (np.arange(spacing.size), after):
            most = np.interp(speed[end], knots, values)
            worst = max(worst, float((sign * along - most).max()))
            # The ellipse in the form in which a rounding of the speed stays one.
            half = most if limits.longitudinal_grip is None else limits.longitudinal_grip
            used = lateral[end] / limits.max_lateral_acceleration
            pulled = np.maximum(sign * along, 0.0) / half
            if not math.isinf(limits.exponent):
                whole = pulled**limits.exponent + used**limits.exponent
                worst = max(worst, float(whole.max()) - 1.0)
        found[name] = worst
    if car.max_steer_rate is not None:
        length = np.array([car.turning_length(float(v)) for v in speed])
        wheel = np.arctan(bends * length)
        rate = np.abs(wheel[after] - wheel[: spacing.size])
        rate *= 0.5 * (speed[after] + speed[: spacing.size]) / spacing
        cusp = np.zeros(len(path), dtype=bool)
        if path.reverse is not None:
            cusp = profile.speed <= 0.0  # the curvature there is that of the way on
        found["steer rate"] = float((rate[~cusp[after]] - car.max_steer_rate).max())
    return found
