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
from tests.parity.checks import adapting
from tests.parity.laws import LATERAL, POP, PREVIEW_POP, PURE_PURSUIT, STANLEY, Law
from tests.parity.plans import decided
from tests.parity.strategies import ADAPTS, CALM_VEHICLES, SEEDS, Shape, Spot, Waypoints

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
    return popsteer.Path(path.xy, speed=path.speed, closed=path.closed, mend=False)


def _lever(path: popsteer.Path, segment: int, here: tuple[float, float]) -> float:
    """How many times farther off than its segment is long a position lies; so rounding grows."""
    following = (segment + 1) % len(path)
    start, end = ((path.x[k], path.y[k]) for k in (segment, following))
    return float(1.0 + math.dist(here, start) / math.dist(start, end))


def _same_projection(
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
    closest, moved_projection = ours.project(*here, nearest), theirs.project(*there, nearest)
    if moved_projection.segment != closest.segment:
        slack = SLACK * _lever(ours, closest.segment, here)
        assert (
            abs(abs(moved_projection.cross_track_error) - abs(closest.cross_track_error)) <= slack
        )
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
        closest = alone.project(*pose[:2])
        beyond = closest.arc_length - min(max(closest.arc_length, 0.0), alone.length)
        off = math.hypot(closest.cross_track_error, beyond)
        costs.append(_cost(off, pose[2] - closest.path_yaw))
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
    if not _same_projection(ours, theirs, here, there):
        return
    closest, moved = ours.project(*here), theirs.project(*there)
    slack = SLACK * _lever(ours, closest.segment, here)
    assert math.dist(moved.point, motion.point(*closest.point)) <= slack
    assert abs(moved.arc_length - closest.arc_length) <= slack * len(path.xy)
    assert abs(popsteer.paper.wrap(moved.path_yaw - closest.path_yaw - motion.turn)) <= ANGLE_SLACK
    assert abs(abs(moved.cross_track_error) - abs(closest.cross_track_error)) <= slack
    if abs(_side(path, closest.segment, *here)) > slack:
        assert (moved.cross_track_error > 0.0) == (closest.cross_track_error > 0.0)


@pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)
@given(
    shape=SHAPES,
    motion=MOTIONS,
    spot=PLACES,
    vehicle=CALM_VEHICLES,
    adapt=ADAPTS,
    exact=st.booleans(),
)
def test_law_in_a_moved_world_steers_the_same(
    *,
    law: Law,
    shape: Shape,
    motion: Motion,
    spot: Spot,
    vehicle: dict[str, Any],
    adapt: Any,
    exact: bool,
) -> None:
    path = shape.build()
    options: dict[str, Any] = {}
    if law.searches:
        options = {"grid_spacing": GRID_SPACING, "exact_lookahead": exact}
    car = popsteer.Vehicle(**vehicle)
    tuning = getattr(popsteer, law.params_name)(**options)
    given = adapting(adapt)
    ours = getattr(popsteer, law.name)(_path(path), car, tuning, **given)
    theirs = getattr(popsteer, law.name)(_path(motion.path(path)), car, tuning, **given)
    x, y, yaw, speed, dt = step = spot.at(path)
    moved_step = (*motion.point(x, y), yaw + motion.turn, speed, dt)
    before, moved_before = ours.state, theirs.state
    answers = (ours.step(*step), theirs.step(*moved_step))
    shown = decided(law, ours, before, ours.state, step)
    moved_shown = decided(law, theirs, moved_before, theirs.state, moved_step)
    # The vehicle that the law is shown is the predicted one.
    pose, moved_pose = (_pose(each[0].vehicle) for each in (shown, moved_shown))
    assert math.dist(moved_pose[:2], motion.point(*pose[:2])) <= SLACK
    assert abs(moved_pose[2] - pose[2] - motion.turn) <= ANGLE_SLACK
    # The place is the measured vehicle's; the predicted one is an offset from it.
    if not _same_start_of(law, ours, theirs, step[:3], moved_step[:3]):
        return
    here = _ahead(step[:3], ours.tracked_point)
    segments = (ours.state.place.segment, theirs.state.place.segment)
    errors = [(each.cross_track_error, each.heading_error) for each in answers]
    if not _is_seen_the_same(shape, path, here, segments, errors):
        return
    here = shown[0].position
    assert math.dist(here, _ahead(pose, ours.tracked_point)) <= SLACK
    segments = (shown[0].closest.segment, moved_shown[0].closest.segment)
    errors = [(each.predicted_cross_track_error, each.predicted_heading_error) for each in answers]
    if not _is_seen_the_same(shape, path, here, segments, errors):
        return
    if law.searches:
        window = tuning.resolved(car).window_ahead
        assume(exact or _is_cut_the_same(path, ours.path, window, here, segments[0]))
        targets = (answers[0].target, answers[1].target)
        if math.dist(targets[1], motion.point(*targets[0])) > SLACK:
            _check_that_targets_tie(law, ours, shown[0], answers[0])
            return
        if _is_on_the_axis(shown[0], targets[0]):
            return
        _check_aim(law, shown, moved_shown)
    elif not _tells_left_from_right(law, shape, abs(errors[0][1])):
        return
    gain = 1.0 if law.searches else 10.0
    assert abs(answers[1].steer - answers[0].steer) <= gain * ANGLE_SLACK
    _check_status(path, car, shown, answers)


def _is_on_the_axis(shown: Any, target: tuple[float, float]) -> bool:
    """Whether rounding decides on which side of the vehicle a point behind it lies."""
    (x, y), yaw = shown.position, shown.vehicle.yaw
    along = (target[0] - x) * math.cos(yaw) + (target[1] - y) * math.sin(yaw)
    aside = (target[1] - y) * math.cos(yaw) - (target[0] - x) * math.sin(yaw)
    return bool(along <= 0.0 and abs(aside) <= SLACK)


def _same_start_of(
    law: Law,
    ours: Any,
    theirs: Any,
    pose: tuple[float, float, float],
    moved_pose: tuple[float, float, float],
) -> bool:
    """The same for where a controller looks from: the rear axle, or the point without slip."""
    car = ours.vehicle
    base = car.rear_axle
    if law is PREVIEW_POP and car.no_slip_point is not None:
        base = car.no_slip_point
    at_base, moved = ((*_ahead(each, base), each[2]) for each in (pose, moved_pose))
    return _same_start(ours.path, theirs.path, at_base, moved)


def _tells_left_from_right(law: Law, shape: Shape, askew: float) -> bool:
    """Whether rounding chooses neither a side nor what of the path counts."""
    if law is STANLEY:
        # A heading error of half a turn is to the left or to the right.
        assume(askew < math.pi - ANGLE_SLACK)
    if law is PREVIEW_POP:
        if shape.closed or shape.kind in ("jagged", "loop", "collinear"):
            # Where the path leaps or doubles back, rounding says which segments a chord spans.
            return False
        # ... nor is one that is half a turn from the direction smoothed, not that of the segment.
        assume(askew < math.pi - 0.5)
    return True


def _check_status(
    path: Waypoints,
    car: popsteer.Vehicle,
    shown: tuple[Any, Any],
    answers: tuple[popsteer.Command, popsteer.Command],
) -> None:
    at, decision = shown
    command, moved = answers
    differ = moved.status ^ command.status
    limits = popsteer.Status.SATURATED | popsteer.Status.STEER_LIMIT
    limits |= popsteer.Status.RATE_LIMIT | popsteer.Status.LATERAL_LIMIT
    assert differ in limits | popsteer.Status.END_OF_PATH | popsteer.Status.DEVIATING
    if popsteer.Status.DEVIATING in differ:
        # At the very start rounding says whether the vehicle is before it, where none deviates.
        off = abs(command.predicted_cross_track_error)
        assert abs(math.dist(path.xy[0], at.position) - off) <= ANGLE_SLACK
    if popsteer.Status.END_OF_PATH in differ:
        # At the very end rounding says whether the vehicle is past it.
        off = abs(command.predicted_cross_track_error)
        assert abs(math.dist(path.xy[-1], at.position) - off) <= ANGLE_SLACK
    if popsteer.Status.SATURATED in differ:
        # At a limit rounding says whether the angle wanted is beyond it.
        wanted = decision.steer - car.steer_offset
        limited, at_most = abs(command.steer - wanted), abs(abs(wanted) - car.max_steer)
        assert min(limited, at_most) < 1e-6


def _pose(vehicle: Any) -> tuple[float, float, float]:
    return vehicle.x, vehicle.y, vehicle.yaw


def _is_seen_the_same(
    shape: Shape,
    path: Waypoints,
    here: tuple[float, float],
    segments: tuple[int, int],
    errors: list[tuple[float, float]],
) -> bool:
    """Whether one place is found in both worlds; if not, that both are as good is asserted."""
    segment, moved_segment = segments
    slack = SLACK * _lever(_path(path), segment, here)
    (off, askew), (moved_off, moved_askew) = errors
    if moved_segment != segment:
        costs = [_cost(*each) for each in errors]
        # Of neighbours as near the last counts, of places farther apart the cheapest. Beside a
        # sharp corner rounding says which of both sides counts, and how askew that leads.
        assume(shape.kind == "smooth" and not shape.closed)
        as_near = abs(abs(moved_off) - abs(off)) <= slack
        assert as_near or abs(costs[1] - costs[0]) <= slack + ANGLE_SLACK
        return False
    # Straight ahead of the end of a segment, far from it, the sign of the error is rounding's.
    assume(abs(_side(path, segment, *here)) > slack)
    assert abs(popsteer.paper.wrap(moved_askew - askew)) <= ANGLE_SLACK
    assert abs(moved_off - off) <= slack
    return True


def _nearest(path: popsteer.Path, segment: int, here: tuple[float, float]) -> tuple[float, int]:
    """The fraction of the segment at the closest point, and the nearer of its two waypoints."""
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


def _check_that_targets_tie(law: Law, controller: Any, at: Any, command: popsteer.Command) -> None:
    """Check that a corner, the closest point or a grid point is on the circle, within rounding."""
    here, speed = at.position, at.vehicle.speed
    params = controller.params.resolved(controller.vehicle)
    lookahead = params.min_lookahead + params.lookahead_gain * speed
    if law is PURE_PURSUIT:
        lookahead = max(params.min_lookahead, params.lookahead_gain * speed)
    if params.exact_lookahead:
        path = controller.path
        corners = [math.dist(here, xy) for xy in zip(path.x, path.y, strict=True)]
        closest = abs(command.predicted_cross_track_error)
        # Within the circle a closed path is aimed at a quarter on, at one waypoint or the next.
        assume(not path.closed or max(corners) > lookahead)
        assert min(abs(each - lookahead) for each in (closest, *corners)) <= ANGLE_SLACK
        return
    _, nearest = _nearest(controller.path, at.closest.segment, here)
    grid = controller.path.resample(nearest, params.window_ahead, params.grid_spacing)
    off = (abs(math.dist(here, point) - lookahead) for point in grid.tolist())
    assert min(abs(each - params.lookahead_tolerance) for each in off) <= SLACK


def _check_aim(law: Law, shown: tuple[Any, Any], moved_shown: tuple[Any, Any]) -> None:
    """At the same target, so is the angle, or another that leads as near to it."""
    (at, decision), (_, moved) = shown, moved_shown
    to = (decision.target[0] - at.position[0], decision.target[1] - at.position[1])
    assume(math.hypot(*to) > 0.05)
    if law is PURE_PURSUIT:
        assert abs(moved.steer - decision.steer) <= ANGLE_SLACK
        return
    assert law is POP
    assert moved.status == decision.status
    yaw, speed, dt = at.vehicle.yaw, max(at.vehicle.speed, 0.0), at.dt
    distances = [
        popsteer.paper.get_distance(
            popsteer.paper.get_predicted_location(0.0, 0.0, yaw, speed, steer, dt), to
        )
        for steer in (decision.steer, moved.steer)
    ]
    assert abs(distances[0] - distances[1]) <= SLACK
    # Of two angles as good either is commanded.
    assume(moved.steer == decision.steer)
