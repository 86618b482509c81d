"""The curvature of a path whose waypoints are noisy.

Waypoints are smoothed by penalised least squares before their curvature is taken: Whittaker's
graduation (E. T. Whittaker, *On a New Method of Graduation*, 1923), with the penalty on the third
derivative, which is the change of the curvature, and weights by spacing, as in P. H. C. Eilers, *A
Perfect Smoother*, Analytical Chemistry 75, 2003::

    minimise  Σ w_k |q_k - p_k|² + length⁶ Σ h_k |q'''_k|²

A wave of length 2π L along the path is kept up to the factor 1 / (1 + (length / L)⁶).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from popsteer.reference.math import sqrt

if TYPE_CHECKING:
    from popsteer.reference.geometry import Point
    from popsteer.reference.path.view import PathView

__all__ = ["path_curvature"]

NODES = 4.0
"""Nodes in a smoothing length: waypoints closer together than that are averaged first."""
SEAM = 20.0
"""How far a closed path is continued at its seam, in smoothing lengths."""
SEAM_NODES = 8
"""The same in nodes, where these are far apart."""

Nodes = list[tuple[float, "Point"]]


def path_curvature(path: PathView, length: float) -> list[float]:
    """Give the curvature at each waypoint of `path` [1/m], smoothed over `length` [m].

    Positive to the left. Where the vehicle turns round, the curvature is that of the section that
    begins there.

    Examples
    --------
    >>> from popsteer.reference.path.owned import Path
    >>> path_curvature(Path([(0.0, 0.0), (1.0, 0.0)]), 2.0)
    [0.0, 0.0]
    """
    curvature = [0.0] * len(path)
    segments = path.segments

    def turns(segment: int) -> bool:
        following = path.next_segment(segment)
        return following is not None and path.is_reverse(following) != path.is_reverse(segment)

    first_turn = next((segment for segment in range(segments) if turns(segment)), None)
    if first_turn is None:
        if path.closed:
            _smooth_loop(path, length, curvature)
        else:
            _smooth_section(path, 0, segments, length, curvature)
        return curvature
    # A closed path begins after its first cusp, so that no section leads across the start.
    begin = first_turn + 1 if path.closed else 0
    end = begin + segments
    for segment in range(begin, end):
        if segment + 1 == end or turns(segment % segments):
            _smooth_section(path, begin, segment + 1 - begin, length, curvature)
            begin = segment + 1
    return curvature


def _smooth_section(
    path: PathView, begin: int, segments: int, length: float, curvature: list[float]
) -> None:
    """Set the curvature of the section of `segments` segments that begins at a waypoint."""
    nodes, arcs = _average(path, begin, segments, length)
    _smooth(nodes, length)
    turned = _turns_at(nodes)
    node = 0
    # The waypoint at its end is the next section's, but for the last of an open path.
    open_end = not path.closed and begin + segments + 1 == len(path)
    count = segments + 1 if open_end else segments
    for step, arc in enumerate(arcs[:count]):
        curvature[(begin + step) % len(path)], node = _between(nodes, turned, arc, node)


def _smooth_loop(path: PathView, length: float, curvature: list[float]) -> None:
    """Set the curvature of a closed path that is driven in one direction."""
    count = len(path)
    enough = SEAM * length
    before = 0
    arc = 0.0
    while (arc < enough and before < 4 * count) or before < SEAM_NODES:
        before += 1
        arc += path.segment_length((4 * count - before) % count)
    begin = 5 * count - before
    nodes, arcs = _average(path, begin % count, 2 * before + count, length)
    _smooth(nodes, length)
    turned = _turns_at(nodes)
    node = 0
    for index in range(count):
        curvature[index], node = _between(nodes, turned, arcs[before + index], node)


def _average(path: PathView, begin: int, segments: int, length: float) -> tuple[Nodes, list[float]]:
    """Return the waypoints of a section as nodes, and the arc length at each waypoint [m]."""
    x0, y0 = path.waypoint(begin % len(path))
    spacing = length / NODES
    nodes: Nodes = []
    arcs: list[float] = []
    arc = first = count = 0.0
    sum_arc = sum_x = sum_y = 0.0
    for step in range(segments + 1):
        x, y = path.waypoint((begin + step) % len(path))
        if step > 0:
            arc += path.segment_length((begin + step - 1) % len(path))
        if count > 0.0 and arc - first >= spacing:
            nodes.append((sum_arc / count, (sum_x / count, sum_y / count)))
            first, count = arc, 0.0
            sum_arc = sum_x = sum_y = 0.0
        sum_arc += arc
        sum_x += x - x0
        sum_y += y - y0
        count += 1.0
        arcs.append(arc)
    nodes.append((sum_arc / count, (sum_x / count, sum_y / count)))
    return nodes, arcs


def _smooth(nodes: Nodes, length: float) -> None:
    """Move `nodes` to where the penalised least squares have them."""
    count = len(nodes)
    if count < 4:
        return
    arc = [node[0] for node in nodes]
    # Row k of a symmetric band: the diagonal, and the three entries after it.
    rows = [[0.0] * 4 for _ in range(count)]
    right = []
    for index, (_, (x, y)) in enumerate(nodes):
        before = index - 1 if index > 0 else 0
        after = index + 1 if index + 1 < count else index
        weight = 0.5 * (arc[after] - arc[before])
        rows[index][0] = weight
        right.append((x * weight, y * weight))
    cube = length * length * length
    for first in range(count - 3):
        s = arc[first : first + 4]
        # The third derivative of the cubic through four nodes: six times a divided difference.
        third = [
            6.0 / ((s[0] - s[1]) * (s[0] - s[2]) * (s[0] - s[3])) * cube,
            6.0 / ((s[1] - s[0]) * (s[1] - s[2]) * (s[1] - s[3])) * cube,
            6.0 / ((s[2] - s[0]) * (s[2] - s[1]) * (s[2] - s[3])) * cube,
            6.0 / ((s[3] - s[0]) * (s[3] - s[1]) * (s[3] - s[2])) * cube,
        ]
        weight = (s[3] - s[0]) / 3.0
        for offset, entry in enumerate(third):
            for place, other in enumerate(third[offset:]):
                rows[first + offset][place] += weight * entry * other
    _solve(rows, right)
    for index, place_xy in enumerate(right):
        nodes[index] = (arc[index], place_xy)


def _solve(rows: list[list[float]], right: list[Point]) -> None:
    """Solve a symmetric positive definite band of seven diagonals in place, by L D Lᵀ."""
    count = len(rows)
    for index, row in enumerate(rows):
        pivot = row[0]
        for offset in range(1, 4):
            if index + offset >= count:
                break
            factor = row[offset] / pivot
            below = rows[index + offset]
            for other in range(offset, 4):
                below[other - offset] -= factor * row[other]
            known, value = right[index], right[index + offset]
            right[index + offset] = (value[0] - known[0] * factor, value[1] - known[1] * factor)
    for index in range(count - 1, -1, -1):
        row = rows[index]
        x, y = right[index]
        for offset in range(1, 4):
            if index + offset < count:
                known = right[index + offset]
                x -= known[0] * row[offset]
                y -= known[1] * row[offset]
        right[index] = (x / row[0], y / row[0])


def _turns_at(nodes: Nodes) -> list[float]:
    """Return the curvature at each node: at the ends that of the node beside them."""
    turned = [
        _circle_through(nodes[index][1], nodes[index + 1][1], nodes[index + 2][1])
        for index in range(len(nodes) - 2)
    ]
    first = turned[0] if turned else 0.0
    last = turned[-1] if turned else 0.0
    return [first, *turned, last]


def _circle_through(a: Point, b: Point, c: Point) -> float:
    """Return the curvature of the circle through three points; 0 where two of them coincide."""
    one = (b[0] - a[0], b[1] - a[1])
    two = (c[0] - b[0], c[1] - b[1])
    chord = (c[0] - a[0], c[1] - a[1])
    twice_area = one[0] * two[1] - one[1] * two[0]
    squares = (
        (one[0] * one[0] + one[1] * one[1])
        * (two[0] * two[0] + two[1] * two[1])
        * (chord[0] * chord[0] + chord[1] * chord[1])
    )
    return 2.0 * twice_area / sqrt(squares) if squares > 0.0 else 0.0


def _between(nodes: Nodes, turned: list[float], arc: float, node: int) -> tuple[float, int]:
    """Return the curvature at `arc` [m], linear between nodes, and where to go on looking."""
    while node + 1 < len(nodes) and nodes[node + 1][0] <= arc:
        node += 1
    here = turned[node]
    start = nodes[node][0]
    if node + 1 < len(nodes) and arc > start:
        end, after = nodes[node + 1][0], turned[node + 1]
        return here + (arc - start) / (end - start) * (after - here), node
    return here, node
