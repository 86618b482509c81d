"""The terms that the integral of a PID sums: the last so many."""

from __future__ import annotations

import operator

from popsteer import errors
from popsteer.reference.error import input_within

__all__ = ["BOUND", "CAPACITY", "Buffer", "push", "restore"]

CAPACITY = 500
"""The longest buffer: the paper's."""
BOUND = 1e16
"""Bound of errors, terms and their sums [m], [m s], which no valid input reaches."""

Buffer = tuple[tuple[float, ...], int, float]
"""The terms, oldest first, the place of the next one, and their sum as carried along."""


def push(
    terms: tuple[float, ...], following: int, total: float, term: float, length: int
) -> Buffer:
    """Take in a term; the oldest leaves a buffer of this `length` that is full.

    The sum is carried along, and taken anew each time the buffer comes round, so that rounding
    cannot build up over a long run.

    Examples
    --------
    >>> buffer = (), 0, 0.0
    >>> for term in (1.0, 2.0, 4.0, 8.0):
    ...     buffer = push(*buffer, term, length=3)
    >>> buffer
    ((2.0, 4.0, 8.0), 1, 14.0)
    """
    if len(terms) == length:
        total = total - terms[0] + term
        terms = (*terms[1:], term)
    else:
        total = total + term
        terms = (*terms, term)
    following += 1
    if following == length:
        following = 0
        # No sum(), which compensates its rounding from Python 3.12 on.
        total = 0.0
        for held in terms:
            total += held
    return terms, following, total


def restore(length: int, terms: tuple[float, ...], following: int, total: float) -> Buffer:
    """Return a buffer as it was.

    Raises
    ------
    InputError
        Where no buffer of this `length` could have been so.
    """
    held = len(terms)
    if held > length:
        raise errors.InputError("terms", held, errors.count_in_range(0, length))
    # Until the buffer is full, the next term goes behind the last.
    low, high = (held, held) if held < length else (0, length - 1)
    following = operator.index(following)
    if not low <= following <= high:
        raise errors.InputError("next", following, errors.count_in_range(low, high))
    terms = tuple(input_within("terms", term, BOUND) for term in terms)
    return terms, following, input_within("sum", total, BOUND)
