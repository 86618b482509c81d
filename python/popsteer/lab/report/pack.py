"""The numbers of a page, in few bytes: rounded, as differences, compressed, as text."""

from __future__ import annotations

import base64
import zlib
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

HOLE = -(2**31)
"""What stands for a number that is not finite."""
_MOST = 2.0**30


class Pack:
    """Columns of numbers that a page carries.

    A column is rounded to a resolution and stored as 32-bit integers, each the difference to the
    one before. The bytes of all are sorted by their place in the integer, which compresses to one
    or two bytes a number, and deflated.

    Examples
    --------
    >>> pack = Pack()
    >>> pack.add([1.0, 1.0004, float("nan")], 1e-3)
    [0, 3, 0.001, 1.0]
    >>> pack.add([1.0, 1.0004, float("nan")], 1e-3)  # the same is stored once
    [0, 3, 0.001, 1.0]
    >>> len(pack.text()) > 0
    True
    """

    def __init__(self) -> None:
        self._parts: list[Any] = []
        self._count = 0
        self._known: dict[tuple[bytes, float], list[float]] = {}

    def add(self, values: ArrayLike, resolution: float) -> list[float]:
        """Add a column of numbers, rounded to `resolution`.

        A column that spans more than 2³⁰ of it is rounded to more. Gives where it is and how to
        read it: first number, count, resolution, offset.
        """
        column = np.ascontiguousarray(values, dtype=np.float64)
        key = (column.tobytes(), resolution)
        if key not in self._known:
            whole = np.isfinite(column)
            low, high = (column[whole].min(), column[whole].max()) if whole.any() else (0.0, 0.0)
            scale = max(resolution, float(high - low) / _MOST)
            steps = np.full(len(column), HOLE, dtype=np.int64)
            steps[whole] = np.rint((column[whole] - low) / scale).astype(np.int64)
            # Differences wrap round at 32 bits, as the sums of them do on the page.
            differences = np.diff(steps, prepend=0).astype(np.uint64).astype(np.uint32)
            self._parts.append(differences)
            self._known[key] = [self._count, len(column), scale, float(low)]
            self._count += len(column)
        return list(self._known[key])

    def text(self) -> str:
        """Give all columns as text: Base64 of a zlib stream."""
        whole = np.concatenate([np.empty(0, dtype=np.uint32), *self._parts]).astype("<u4")
        return deflated(whole.view(np.uint8).reshape(-1, 4).T.tobytes())


def deflated(data: bytes) -> str:
    """Compress bytes as a page inflates them: Base64 of a zlib stream."""
    return base64.b64encode(zlib.compress(data, 9)).decode("ascii")
