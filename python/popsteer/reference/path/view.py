"""Waypoints, validated once."""

from __future__ import annotations

from bisect import bisect_right
from typing import TYPE_CHECKING

from popsteer.errors import PathError
from popsteer.reference.path.measure import measure

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from popsteer.reference.geometry import Point


class PathView:
    """N waypoints, the arc length at each, and whether the last leads back to the first.

    Segment k runs from waypoint k to its successor: N - 1 segments in an open path, N in a
    closed one.

    Made as a `Path`, which answers a user's questions besides.

    Examples
    --------
    >>> path = PathView([(0.0, 0.0), (3.0, 0.0), (3.0, 4.0)], closed=True)
    >>> path.s, path.length, path.segments
    ((0.0, 3.0, 7.0), 12.0, 3)
    """

    x: tuple[float, ...]
    """The abscissas of the waypoints [m]."""
    y: tuple[float, ...]
    """The ordinates of the waypoints [m]."""
    s: tuple[float, ...]
    """The arc length at each waypoint [m]."""
    speed: tuple[float, ...] | None
    """The reference speed at each waypoint [m/s], where the path has one."""
    reverse: tuple[bool, ...] | None
    """For each segment whether it is driven backwards; None where none is."""
    length: float
    """Arc length of the whole path [m], the closing segment included."""
    closed: bool
    """Whether the last waypoint leads back to the first."""

    def __init__(
        self,
        xy: Iterable[Sequence[float]],
        *,
        speed: Iterable[float] | None = None,
        closed: bool = False,
        reverse: Iterable[bool] | None = None,
    ) -> None:
        pairs = [(float(x), float(y)) for x, y in xy]
        self.x, self.y = tuple(x for x, _ in pairs), tuple(y for _, y in pairs)
        self.speed = None if speed is None else tuple(float(value) for value in speed)
        self.closed = bool(closed)
        self.s, self.length = measure(self.x, self.y, self.speed, closed=self.closed)
        given = None if reverse is None else tuple(bool(value) for value in reverse)
        if given is not None:
            if len(given) != len(self.x):
                raise PathError.length_mismatch("reverse", len(given), len(self.x))
            self.reverse = given if any(given) else None
        elif self.speed is not None and any(value < 0.0 for value in self.speed):
            self.reverse = _reverse_by_speed(self.speed, closed=self.closed)
        else:
            self.reverse = None

    def __len__(self) -> int:
        return len(self.x)

    @property
    def segments(self) -> int:
        """The number of segments."""
        return len(self) if self.closed else len(self) - 1

    def waypoint(self, index: int) -> Point:
        """Return waypoint `index` [m]."""
        return self.x[index], self.y[index]

    def next(self, index: int) -> int | None:
        """Return the waypoint after `index`; None after the last of an open path."""
        if index + 1 < len(self):
            return index + 1
        return 0 if self.closed else None

    def previous(self, index: int) -> int | None:
        """Return the waypoint before `index`; None before the first of an open path."""
        if index > 0:
            return index - 1
        return len(self) - 1 if self.closed else None

    def segment_at(self, index: int) -> int:
        """Return the segment that starts at waypoint `index`, or ends there where none starts."""
        return min(index, self.segments - 1)

    def segment_end(self, index: int) -> float:
        """Return the arc length at the end of segment `index` [m]."""
        return self.s[index + 1] if index + 1 < len(self) else self.length

    def segment_length(self, index: int) -> float:
        """Return the length of segment `index` [m]."""
        return self.segment_end(index) - self.s[index]

    def segment_by_arc(self, arc: float) -> int:
        """Return the last segment whose start does not lie beyond `arc` [m], or the first."""
        return self.segment_at(max(bisect_right(self.s, arc) - 1, 0))

    def is_reverse(self, index: int) -> bool:
        """Tell whether segment `index` is driven backwards."""
        return self.reverse is not None and self.reverse[index]

    def next_segment(self, index: int) -> int | None:
        """Return the segment after `index`; None after the last of an open path."""
        following = self.next(index)
        return following if following is not None and following < self.segments else None

    def following(self, index: int) -> int | None:
        """Return the segment after `index`, where the vehicle keeps its direction."""
        following = self.next_segment(index)
        if following is None or self.is_reverse(following) != self.is_reverse(index):
            return None
        return following

    def preceding(self, index: int) -> int | None:
        """Return the segment before `index`, where the vehicle keeps its direction."""
        previous = self.previous(index)
        if previous is None or self.is_reverse(previous) != self.is_reverse(index):
            return None
        return previous

    def section(self, index: int) -> tuple[int, int]:
        """Return the first and the last segment about `index` that are driven in its direction."""
        first, last = index, index
        for _ in range(self.segments):
            before, after = self.preceding(first), self.following(last)
            first, last = first if before is None else before, last if after is None else after
        return first, last

    def segment(self, index: int) -> tuple[Point, Point]:
        """Return both ends of segment `index` [m]."""
        following = self.next(index)
        return self.waypoint(index), self.waypoint(index if following is None else following)


def _reverse_by_speed(speed: tuple[float, ...], *, closed: bool) -> tuple[bool, ...]:
    """Tell by the speeds at its ends which segment is driven backwards."""
    ends = (*speed[1:], speed[0] if closed else 0.0)
    reverse: list[bool] = []
    before = False
    for start, end in zip(speed, ends, strict=True):
        if start != 0.0:
            before = start < 0.0
        elif end != 0.0:
            before = end < 0.0
        reverse.append(before)
    return tuple(reverse)
