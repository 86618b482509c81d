"""Waypoints, checked and measured once."""

from __future__ import annotations

from popsteer import errors
from popsteer.errors import PathError
from popsteer.reference.bounds import MAX_COORDINATE, MAX_SPEED
from popsteer.reference.geometry import get_distance

COINCIDING = 1e-9
"""Neighbouring waypoints at most this far apart [m] coincide."""


def measure(
    x: tuple[float, ...],
    y: tuple[float, ...],
    speed: tuple[float, ...] | None,
    *,
    closed: bool,
) -> tuple[tuple[float, ...], float]:
    """Check waypoints; return the arc length at each, and the length of the path."""
    waypoints = len(x)
    least = 3 if closed else 2
    if waypoints < least:
        raise PathError.too_few_waypoints(waypoints, least)
    if speed is not None and len(speed) != waypoints:
        raise PathError.length_mismatch("speed", len(speed), waypoints)
    _check_numbers("x", x, MAX_COORDINATE)
    _check_numbers("y", y, MAX_COORDINATE)
    if speed is not None:
        _check_numbers("speed", speed, MAX_SPEED)

    s: list[float] = []
    length = 0.0
    for index in range(waypoints):
        s.append(length)
        last = index + 1 == waypoints
        if last and not closed:
            break
        following = 0 if last else index + 1
        step = get_distance((x[index], y[index]), (x[following], y[following]))
        if step <= COINCIDING:
            raise PathError.coinciding(index, following)
        length += step
    return tuple(s), length


def _check_numbers(field: str, values: tuple[float, ...], bound: float) -> None:
    """Raise `PathError` for the first value that is no number in [-bound, bound]."""
    for index, value in enumerate(values):
        if not -bound <= value <= bound:
            raise PathError.out_of_range(field, index, value, errors.in_range(-bound, bound))
