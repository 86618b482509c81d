"""Where a path leads ahead: its heading, continuous along each stretch of one direction."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from popsteer import Path


class Ahead:
    """The headings of a path, one stretch between cusps after the other.

    The heading at a waypoint is the mean of those of the segments beside it, between waypoints it
    is taken linearly, and beyond the ends of a stretch it stays.
    """

    def __init__(self, path: Path) -> None:
        xy = np.column_stack((path.x, path.y))
        self._closed, self._length = path.closed, path.length
        self._count = len(xy) if path.closed else len(xy) - 1
        along = np.diff(np.vstack((xy, xy[:1])) if path.closed else xy, axis=0)
        yaw = np.arctan2(along[:, 1], along[:, 0])
        s = np.append(path.s, path.length) if path.closed else np.array(path.s)
        reverse = path.reverse
        self._reverse = None if reverse is None else reverse[: self._count]
        # Of each segment, which stretch it belongs to.
        self._stretch = np.zeros(self._count, dtype=int)
        firsts = np.zeros(1, dtype=int)
        if self._reverse is not None:
            before = np.roll(self._reverse, 1)
            firsts = np.flatnonzero(self._reverse != before)
            if not path.closed:
                firsts = np.union1d(firsts, [0])
        if path.closed and len(firsts) < 2:
            yaw = np.unwrap(np.concatenate((yaw[-1:], yaw, yaw[:1])))
            self._stretches = [(0, s, 0.5 * (yaw[1:] + yaw[:-1]))]
            return
        self._stretches = []
        ends = np.append(firsts[1:], self._count + (firsts[0] if path.closed else 0))
        for number, (first, end) in enumerate(zip(firsts.tolist(), ends.tolist(), strict=True)):
            # One across the seam of a closed path goes on with arc lengths beyond it.
            segments = np.arange(first, end) % self._count
            self._stretch[segments] = number
            headings = np.unwrap(yaw[segments])
            between = 0.5 * (headings[1:] + headings[:-1])
            lengths = s[segments + 1] - s[segments]
            arcs = s[first] + np.concatenate(([0.0], np.cumsum(lengths)))
            headings = np.concatenate((headings[:1], between, headings[-1:]))
            self._stretches.append((first, arcs, headings))

    def reverse(self, segment: int) -> bool:
        """Whether a segment is driven backwards."""
        return self._reverse is not None and bool(self._reverse[segment])

    def turning(self, segment: int, *, reverse: bool) -> int:
        """Find the first segment from the last one on that is driven so; itself where none is."""
        if self._reverse is None or self.reverse(segment) == reverse:
            return segment
        rest = range(segment + 1, segment + self._count if self._closed else self._count)
        found = (k % self._count for k in rest if self._reverse[k % self._count] == reverse)
        return next(found, segment)

    def headings(
        self, segment: int, arc: float, distances: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Give the path's headings [rad] at distances ahead [m], the turns of a lap included."""
        first, arcs, headings = self._stretches[self._stretch[segment]]
        ahead = arc + distances
        if not self._closed:
            return np.asarray(np.interp(ahead, arcs, headings), dtype=np.float64)
        if len(self._stretches) > 1:
            lap = self._length if segment < first else 0.0  # behind the seam of its stretch
            return np.asarray(np.interp(ahead + lap, arcs, headings), dtype=np.float64)
        laps = np.floor(ahead / self._length)
        turn = headings[-1] - headings[0]
        heading = np.interp(ahead - laps * self._length, arcs, headings)
        return np.asarray(heading + laps * turn, dtype=np.float64)
