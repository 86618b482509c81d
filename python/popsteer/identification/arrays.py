"""What the fits of a log do with arrays: sums from the start on, stretches, and Huber's weights."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

import numpy as np

from popsteer._core import _recursion

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Some = TypeVar("Some", NDArray[np.float64], NDArray[np.complex128])


def summed(values: Some) -> Some:
    """Give the sums of the rows before each, from 0 on: one row more."""
    found: Some = np.concatenate((np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)))
    return found


def recursion(kept: Array | float, added: Array) -> Array:
    """Give y_k = kept_k y_{k-1} + added_k from 0 on, (N,) or (N, M) by rows."""
    factors = np.empty(len(added))
    factors[:] = kept
    return _recursion(factors, added.ravel()).reshape(added.shape)


def middles(values: Array) -> Array:
    """Give the mean of each value and the next."""
    found: Array = 0.5 * (values[1:] + values[:-1])
    return found


def chords(heading: Array) -> NDArray[np.complex128]:
    """Give the chord of each step over its arc, east + i north, between headings [rad]."""
    found: NDArray[np.complex128] = np.sinc(0.5 * np.diff(heading) / np.pi) * np.exp(
        1j * middles(heading)
    )
    return found


def stretches(holds: NDArray[np.bool_]) -> Iterator[slice]:
    """Give the rows of each unbroken stretch in which something holds."""
    edges = np.flatnonzero(np.diff(np.pad(holds.astype(np.int8), 1))).tolist()
    yield from map(slice, edges[::2], edges[1::2])


def parted(gaps: Sequence[int], count: int) -> list[slice]:
    """Give the rows of each part of so many, by where all but the first begin."""
    return list(map(slice, [0, *gaps], [*gaps, count]))


def huber(residual: Array, sure: float) -> Array:
    """Give the roots of Huber's weights: 1 for residuals up to `sure`, less for larger ones."""
    found: Array = np.sqrt(np.minimum(1.0, sure / np.maximum(np.abs(residual), 1e-12)))
    return found
