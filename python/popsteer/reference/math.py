"""Angles, limits and the float shim.

Python raises where IEEE 754, and so Rust, goes on with an infinity or a NaN: the sine of an
infinity, the division by zero. The functions here go on too.
"""

from __future__ import annotations

import math
from math import acos, atan, atan2, ceil, exp, sqrt

__all__ = [
    "PI",
    "acos",
    "atan",
    "atan2",
    "ceil",
    "cos",
    "decay",
    "divide",
    "exp",
    "saturate",
    "sin",
    "sqrt",
    "tan",
    "wrap",
]

PI = math.pi
TAU = math.tau


def sin(x: float) -> float:
    """Sine of `x` [rad]; NaN for an infinity."""
    return math.nan if math.isinf(x) else math.sin(x)


def cos(x: float) -> float:
    """Cosine of `x` [rad]; NaN for an infinity."""
    return math.nan if math.isinf(x) else math.cos(x)


def tan(x: float) -> float:
    """Tangent of `x` [rad]; NaN for an infinity."""
    return math.nan if math.isinf(x) else math.tan(x)


def divide(a: float, b: float) -> float:
    """Quotient a / b; an infinity or NaN where b is zero."""
    if b != 0.0:
        return a / b
    if a == 0.0 or math.isnan(a):
        return math.nan
    return math.copysign(math.inf, a) * math.copysign(1.0, b)


def saturate(value: float, low: float, high: float) -> float:
    """Limit `value` to [low, high], for low ≤ high and a value that is a number."""
    if value < low:
        return low
    if value > high:
        return high
    return value


def decay(time: float, time_constant: float) -> float:
    """Tell what is left after `time` of what fades with a time constant: exp(-time / constant).

    Nothing where the time constant is 0.
    """
    return exp(-time / time_constant) if time_constant > 0.0 else 0.0


def wrap(angle: float) -> float:
    """Bring an angle [rad] into [-π, π] by whole turns.

    The remainder is exact, so an angle that needs no turn comes back unchanged, and
    ``wrap(-a) == -wrap(a)`` for every finite a. NaN for an infinity.
    """
    if -PI <= angle <= PI:
        return angle
    turned = math.nan if math.isinf(angle) else math.fmod(angle, TAU)
    if turned > PI:
        return turned - TAU
    if turned < -PI:
        return turned + TAU
    return turned
