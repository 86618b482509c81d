"""Turning and shifting the world changes nothing beyond rounding.

Moved coordinates are rounded, so answers that depend on them continuously agree to `SLACK`. Where
a law chooses (a waypoint, a segment, a grid point, a candidate) the choice may flip, but only
between things that are as good as each other to within `SLACK`: that is what is asserted then.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import popsteer
from tests.parity.laws import BANG_BANG, LATERAL, POP, PREVIEW_POP, PURE_PURSUIT, STANLEY, Law
from tests.parity.strategies import SEEDS, Shape, Spot, Waypoints

REACH = 2e3
"""No coordinate in this file is larger [m]."""
SLACK = 64.0 * sys.float_info.epsilon * REACH
"""More than the few roundings of a coordinate add up to [m]: 3e-11."""
ANGLE_SLACK = 1e3 * SLACK
"""The same for an angle between points no less than a few centimetres apart [rad]."""
GRID_SPACING = 0.0137


@dataclass(frozen=True)
class Motion:
    """A turn about the origin and a shift."""

    turn: float
    dx: float
    dy: float

    def point(self, x: float, y: float) -> tuple[float, float]:
        c, s = math.cos(self.turn), math.sin(self.turn)
        return c * x - s * y + self.dx, s * x + c * y + self.dy

    def path(self, path: Waypoints) -> Waypoints:
        return Waypoints([self.point(*xy) for xy in path.xy], path.speed, path.closed)


MOTIONS = st.builds(
    Motion,
    turn=st.floats(-math.pi, math.pi),
    dx=st.floats(-1e3, 1e3),
    dy=st.floats(-1e3, 1e3),
)
SHAPES = st.builds(
    Shape,
    kind=st.sampled_from(["straight", "smooth", "collinear", "jagged", "loop"]),
    count=st.integers(2, 60),
    spacing=st.floats(0.5, 3.0),
    closed=st.booleans(),
    with_speed=st.booleans(),
    seed=SEEDS,
)
PLACES = st.builds(
    Spot,
    along=st.floats(0.0, 1.0),
    aside=st.one_of(st.floats(-3.0, 3.0), st.floats(-100.0, 100.0)),
    turned=st.floats(-math.pi, math.pi),
    speed=st.floats(0.5, 30.0),
    dt=st.floats(0.01, 0.2),
)


def _path(path: Waypoints) -> popsteer.Path:
    return popsteer.Path(path.xy, speed=path.speed, closed=path.closed)


def _lever(path: popsteer.Path, segment: int, here: tuple[float, float]) -> float:
    """How many times farther off than its segment is long a position lies; so rounding grows."""
    following = (segment + 1) % len(path)
    start, end = ((path.x[k], path.y[k]) for k in (segment, following))
    return float(1.0 + math.dist(here, start) / math.dist(start, end))


def _same_foot(
    ours: popsteer.Path,
    theirs: popsteer.Path,
    here: tuple[float, float],
    there: tuple[float, float],
) -> bool:
    """Whether both are located at one place; if not, that both places are as near is asserted."""
    nearest, moved = ours.nearest_waypoint(*here), theirs.nearest_waypoint(*there)
    if moved != nearest:
        first, second = ((ours.x[k], ours.y[k]) for k in (nearest, moved))
        assert abs(math.dist(here, first) - math.dist(here, second)) <= SLACK
        return False
    foot, moved_foot = ours.project(*here, nearest), theirs.project(*there, nearest)
    if moved_foot.segment != foot.segment:
        slack = SLACK * _lever(ours, foot.segment, here)
        assert abs(abs(moved_foot.cross_track_error) - abs(foot.cross_track_error)) <= slack
        return False
    return True


def _cost(off: float, askew: float) -> float:
    """What a place costs: its distance, and up to 10 m more for leading the opposite way [m]."""
    return abs(off) + 5.0 * (1.0 - math.cos(askew))


def _same_start(
    ours: popsteer.Path,
    theirs: popsteer.Path,
    pose: tuple[float, float, float],
    moved_pose: tuple[float, float, float],
) -> bool:
    """Whether a law starts from one segment; if not, that both cost the same is asserted."""
    start, moved = ours.relocalise(*pose), theirs.relocalise(*moved_pose)
    if start == moved:
        return True
    costs = []
    for k in (start, moved):
        end = (k + 1) % len(ours)
        alone = popsteer.Path([(ours.x[k], ours.y[k]), (ours.x[end], ours.y[end])])
        foot = alone.project(*pose[:2])
        beyond = foot.arc_length - min(max(foot.arc_length, 0.0), alone.length)
        off = math.hypot(foot.cross_track_error, beyond)
        costs.append(_cost(off, pose[2] - foot.path_yaw))
    assert abs(costs[0] - costs[1]) <= SLACK + ANGLE_SLACK
    return False


def _ahead(pose: tuple[float, float, float], offset: float) -> tuple[float, float]:
    x, y, yaw = pose
    return x + offset * math.cos(yaw), y + offset * math.sin(yaw)


def _side(path: Waypoints, segment: int, x: float, y: float) -> float:
    """Signed distance from the line of a segment; near 0, left and right are rounding's choice."""
    (x0, y0), (x1, y1) = path.xy[segment], path.xy[(segment + 1) % len(path.xy)]
    return ((x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)) / math.dist((x0, y0), (x1, y1))


@given(shape=SHAPES, motion=MOTIONS, spot=PLACES)
def test_path_moved_locates_the_same(shape: Shape, motion: Motion, spot: Spot) -> None:
    path = shape.build()
    here = spot.at(path)[:2]
    there = motion.point(*here)
    ours, theirs = _path(path), _path(motion.path(path))
    assert abs(theirs.length - ours.length) <= SLACK * len(path.xy)
    if not _same_foot(ours, theirs, here, there):
        return
    foot, moved = ours.project(*here), theirs.project(*there)
    slack = SLACK * _lever(ours, foot.segment, here)
    assert math.dist(moved.point, motion.point(*foot.point)) <= slack
    assert abs(moved.arc_length - foot.arc_length) <= slack * len(path.xy)
    assert abs(popsteer.wrap(moved.path_yaw - foot.path_yaw - motion.turn)) <= ANGLE_SLACK
    assert abs(abs(moved.cross_track_error) - abs(foot.cross_track_error)) <= slack
    if abs(_side(path, foot.segment, *here)) > slack:
        assert (moved.cross_track_error > 0.0) == (foot.cross_track_error > 0.0)


@pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)
@given(shape=SHAPES, motion=MOTIONS, spot=PLACES, exact=st.booleans())
def test_law_in_a_moved_world_steers_the_same(
    law: Law, shape: Shape, motion: Motion, spot: Spot, exact: bool
) -> None:
    path = shape.build()
    options: dict[str, Any] = {}
    if law.searches:
        options = {"grid_spacing": GRID_SPACING, "exact_lookahead": exact}
    params = getattr(popsteer, law.params_name)(**options)
    ours = getattr(popsteer, law.name)(_path(path), params)
    theirs = getattr(popsteer, law.name)(_path(motion.path(path)), params)
    x, y, yaw, speed, dt = spot.at(path)
    pose, moved_pose = (x, y, yaw), (*motion.point(x, y), yaw + motion.turn)
    here = _ahead(pose, ours.reference_offset)
    if not _same_start(ours.path, theirs.path, pose, moved_pose):
        return
    command = ours.step(*pose, speed, dt)
    moved = theirs.step(*moved_pose, speed, dt)
    segment, moved_segment = ours.state.waypoint, theirs.state.waypoint
    slack = SLACK * _lever(ours.path, segment, here)
    if moved_segment != segment:
        off, moved_off = (abs(one.cross_track_error) for one in (command, moved))
        costs = [_cost(one.cross_track_error, one.heading_error) for one in (command, moved)]
        # Of neighbours as near the last counts, of places farther apart the cheapest. Beside a
        # sharp corner rounding says which of both sides counts, and how askew that leads.
        assume(shape.kind == "smooth" and not shape.closed)
        assert abs(moved_off - off) <= slack or abs(costs[1] - costs[0]) <= slack + ANGLE_SLACK
        return
    # Straight ahead of the end of a segment, far from it, the sign of the error is rounding's.
    assume(abs(_side(path, segment, *here)) > slack)
    turned = popsteer.wrap(moved.heading_error - command.heading_error)
    assert abs(turned) <= ANGLE_SLACK
    assert abs(moved.cross_track_error - command.cross_track_error) <= slack
    if law.searches:
        assume(exact or _is_cut_the_same(path, ours.path, params.window_ahead, here, segment))
        if math.dist(moved.target, motion.point(*command.target)) > SLACK:
            _check_that_targets_tie(law, ours, here, speed, command)
        else:
            _check_aim(law, here, (yaw, speed, dt), command, moved)
        return
    # A heading error of half a turn is to the left or to the right.
    assume(law is not STANLEY or abs(command.heading_error) < math.pi - ANGLE_SLACK)
    if law is PREVIEW_POP and (shape.closed or shape.kind in ("jagged", "loop", "collinear")):
        # Where the path leaps or doubles back, rounding says which segments a chord spans.
        return
    # ... nor is one that is half a turn from the direction smoothed, not that of the segment.
    assume(law is not PREVIEW_POP or abs(command.heading_error) < math.pi - 0.5)
    gain = 1.0 if law is BANG_BANG else 10.0
    assert abs(moved.steer - command.steer) <= gain * ANGLE_SLACK
    # At the very end rounding says whether the vehicle is past it.
    end = (path.xy[-1][0] - here[0], path.xy[-1][1] - here[1])
    at_end = abs(math.hypot(*end) - abs(command.cross_track_error)) <= ANGLE_SLACK
    at_limit = abs(abs(command.steer) - params.max_steer) < 1e-6
    assert moved.status is command.status or at_limit or at_end


def _nearest(path: popsteer.Path, segment: int, here: tuple[float, float]) -> tuple[float, int]:
    """Where on a segment the foot lies, and the waypoint of it that is nearer along the path."""
    end = (segment + 1) % len(path)
    along = (path.x[end] - path.x[segment], path.y[end] - path.y[segment])
    to = (here[0] - path.x[segment], here[1] - path.y[segment])
    fraction = (to[0] * along[0] + to[1] * along[1]) / (along[0] ** 2 + along[1] ** 2)
    return fraction, segment if fraction < 0.5 else end


def _is_cut_the_same(
    path: Waypoints, made: popsteer.Path, ahead: float, here: tuple[float, float], segment: int
) -> bool:
    """Whether rounding chooses neither how a segment is cut nor where the window ends."""
    parts = [length / GRID_SPACING for length in path.lengths]
    fraction, nearest = _nearest(made, segment, here)
    if abs(fraction - 0.5) < 1e-6:
        return False
    arcs = made.s - made.s[nearest]
    ends = [*(arcs - ahead), *(arcs + made.length - ahead)]
    return all(abs(part - round(part)) > 1e-6 for part in parts) and min(map(abs, ends)) > 1e-6


def _check_that_targets_tie(
    law: Law, controller: Any, here: tuple[float, float], speed: float, command: popsteer.Command
) -> None:
    """Rounding says whether a point lies on the circle: a corner, the foot, a point of the grid."""
    params = controller.params
    lookahead = params.min_lookahead + params.lookahead_gain * speed
    if law is PURE_PURSUIT:
        lookahead = max(params.min_lookahead, params.lookahead_gain * speed)
    if params.exact_lookahead:
        path = controller.path
        corners = [math.dist(here, xy) for xy in zip(path.x, path.y, strict=True)]
        foot = abs(command.cross_track_error)
        # Within the circle a closed path is aimed at a quarter on, at one waypoint or the next.
        assume(not path.closed or max(corners) > lookahead)
        assert min(abs(each - lookahead) for each in (foot, *corners)) <= ANGLE_SLACK
        return
    _, nearest = _nearest(controller.path, controller.state.waypoint, here)
    grid = controller.path.resample(nearest, params.window_ahead, params.grid_spacing)
    off = (abs(math.dist(here, point) - lookahead) for point in grid.tolist())
    assert min(abs(each - params.lookahead_tolerance) for each in off) <= SLACK


def _check_aim(
    law: Law,
    here: tuple[float, float],
    moving: tuple[float, float, float],
    command: popsteer.Command,
    moved: popsteer.Command,
) -> None:
    """The target is the same, and so is the angle, or another that leads as near to it."""
    yaw, speed, dt = moving
    to = (command.target[0] - here[0], command.target[1] - here[1])
    assume(math.hypot(*to) > 0.05)
    if law is PURE_PURSUIT:
        assert abs(moved.steer - command.steer) <= ANGLE_SLACK
        return
    assert law is POP
    assert moved.status is command.status
    distances = [
        popsteer.get_distance(popsteer.get_predicted_location(0.0, 0.0, yaw, speed, steer, dt), to)
        for steer in (command.steer, moved.steer)
    ]
    assert abs(distances[0] - distances[1]) <= SLACK
