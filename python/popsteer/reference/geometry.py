"""Points of the plane, and how far apart they are."""

from __future__ import annotations

from typing import TypeAlias

from popsteer.reference.math import sqrt

Point: TypeAlias = tuple[float, float]
"""A point or a displacement in the plane, (x, y) [m]."""


def get_distance(a: Point, b: Point) -> float:
    """Euclidean distance of two points [m]: Equation 4, √((x₂ - x₁)² + (y₂ - y₁)²)."""
    return sqrt(squared_distance(a, b))


def squared_distance(a: Point, b: Point) -> float:
    """Square of `get_distance` [m²], enough where distances are only compared."""
    dx = b[0] - a[0]
    dy = b[1] - a[1]
    return dx * dx + dy * dy
