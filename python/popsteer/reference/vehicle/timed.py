"""A ring of angles with durations: commands in flight, or past angles of the wheels."""

from __future__ import annotations

from typing import TYPE_CHECKING

from popsteer import errors
from popsteer.reference.error import input_in_range, input_within
from popsteer.reference.math import PI

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

__all__ = ["Timed", "checked_count", "checked_entries", "clipped", "push_or_join", "take"]

Timed = tuple[tuple[float, float], ...]
"""Angles [rad], oldest first, and how long each lasts [s]."""


def clipped(timed: Iterable[tuple[float, float]], time: float) -> Iterator[tuple[float, float]]:
    """Give the first `time` [s] of angles that last for so long each; the last is cut short.

    Examples
    --------
    >>> list(clipped([(0.1, 0.25), (0.2, 0.5)], 0.5))
    [(0.1, 0.25), (0.2, 0.25)]
    """
    remaining = time
    for angle, duration in timed:
        if remaining <= 0.0:
            break
        part = duration if duration < remaining else remaining
        remaining -= part
        yield angle, part


def checked_count(field: str, timed: Timed, capacity: int) -> Timed:
    """Return angles that are no more than `capacity`; else raise `InputError`, naming `field`."""
    if len(timed) > capacity:
        raise errors.InputError(field, len(timed), errors.count_in_range(0, capacity))
    return timed


def checked_entries(field: str, timed: Timed, longest: float) -> Timed:
    """Return angles, as floats, up to a quarter turn that last up to `longest` [s]; else raise."""
    return tuple(
        (input_within(field, each[0], 0.5 * PI), input_in_range(field, each[1], 0.0, longest))
        for each in timed
    )


def push_or_join(
    timed: Timed, angle: float, duration: float, shortest: float, capacity: int
) -> Timed:
    """Add an angle; where there is no place for it, the oldest is forgotten.

    Or join it to the newest where both together last `shortest` [s] at most: to their mean. One
    that does not last is none.

    Examples
    --------
    >>> push_or_join(((1.0, 0.25),), 4.0, 0.5, 0.75, 2)
    ((3.0, 0.75),)
    >>> push_or_join(((1.0, 0.5), (2.0, 0.5)), 4.0, 0.5, 0.75, 2)
    ((2.0, 0.5), (4.0, 0.5))
    """
    if duration <= 0.0:
        return timed
    if timed:
        mean, lasted = timed[-1]
        total = lasted + duration
        if total <= shortest:
            # Written so, it lies between the two however short they are.
            joined = mean + (angle - mean) * (duration / total)
            return (*timed[:-1], (joined, total))
    return (*timed, (angle, duration))[-capacity:]


def take(timed: Timed, time: float) -> tuple[tuple[float, float], Timed]:
    """Take off the oldest angle, or the first `time` [s] of one that lasts longer.

    Examples
    --------
    >>> take(((0.1, 0.5), (0.2, 0.25)), 0.125)
    ((0.1, 0.125), ((0.1, 0.375), (0.2, 0.25)))
    """
    angle, duration = timed[0]
    if duration > time:
        return (angle, time), ((angle, duration - time), *timed[1:])
    return (angle, duration), timed[1:]
