"""A mirrored world (y and yaw change sign) mirrors the angle, exactly.

Every operation of the laws is odd or even under the reflection, rounding included, so the answers
are compared without tolerance; the steering offset and the antenna of the mirrored vehicle have the
other sign. Where left and right cannot be told apart the answer is a convention and has no mirror
image; those states are left out, each for the reason given.
"""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import popsteer
from popsteer.reference.vehicle.state import VehicleState
from tests.parity.checks import adapting
from tests.parity.laws import LATERAL, POP, PURE_PURSUIT, Law
from tests.parity.plans import decided
from tests.parity.strategies import (
    ADAPTS,
    CALM_VEHICLES,
    SPOTS,
    VEHICLES,
    Shape,
    Spot,
    Waypoints,
    fitted,
    shapes,
)

CARS = CALM_VEHICLES | VEHICLES

each_law = pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)


def _mirrored(path: Waypoints) -> Waypoints:
    return Waypoints([(x, -y) for x, y in path.xy], path.speed, path.closed)


def _path(path: Waypoints) -> popsteer.Path:
    return popsteer.Path(path.xy, speed=path.speed, closed=path.closed, mend=False)


def _heads_west(path: Waypoints) -> bool:
    """Whether a segment heads exactly along -x, whose direction is pi in both worlds."""
    ends = path.xy[1:] + path.xy[:1]
    return any(y0 == y1 and x1 < x0 for (x0, y0), (x1, y1) in zip(path.xy, ends, strict=True))


def _is_on_line(path: Waypoints, segment: int, position: tuple[float, float]) -> bool:
    """Whether a position lies exactly on the line of a segment, neither left nor right."""
    x, y = position
    # Its segment is where it was found, which at a bend need not be the one `Path.project` gives.
    (x0, y0), (x1, y1) = path.xy[segment], path.xy[(segment + 1) % len(path.xy)]
    side: float = (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)
    return side == 0.0


def _measured_on_line(path: Waypoints, controller: Any, step: tuple[float, ...]) -> bool:
    """The same of the tracked point of the vehicle that was just measured."""
    x, y, yaw, speed, _ = step
    antenna = VehicleState(x, y, yaw, speed)
    point = antenna.left(-controller.vehicle.antenna_left).point_ahead(controller.tracked_point)
    return _is_on_line(path, controller.state.place.segment, point)


def _no_side(at: Any, target: tuple[float, float]) -> bool:
    """Whether the lookahead point lies straight ahead or behind, or exactly west."""
    x, y = at.position
    to_x, to_y = target[0] - x, target[1] - y
    yaw: float = at.vehicle.yaw
    aside = math.cos(yaw) * to_y - math.sin(yaw) * to_x
    return bool(aside == 0.0 or (to_y == 0.0 and to_x <= 0.0))


def _candidate_distance(at: Any, target: tuple[float, float], steer: float) -> float:
    """How near to the target POP's prediction for `steer` comes."""
    yaw, speed = at.vehicle.yaw, max(at.vehicle.speed, 0.0)
    to_target = (target[0] - at.position[0], target[1] - at.position[1])
    predicted = popsteer.paper.get_predicted_location(0.0, 0.0, yaw, speed, steer, at.dt)
    return popsteer.paper.get_distance(predicted, to_target)


def _are_mirrored(ours: Any, theirs: Any, here: popsteer.Command, there: popsteer.Command) -> bool:
    """Whether two controllers found mirrored places and answered mirrored commands."""
    errors = ("cross_track_error", "heading_error")
    odd = ("steer", *errors, *(f"predicted_{error}" for error in errors))
    return (
        theirs.state.place.segment == ours.state.place.segment
        and all(getattr(there, name) == -getattr(here, name) for name in odd)
        and there.target == (here.target[0], -here.target[1])
        and there.status == here.status
    )


@each_law
@given(
    shape=shapes(),
    spots=st.lists(SPOTS, min_size=1, max_size=5),
    vehicle=CARS,
    adapt=ADAPTS,
    data=st.data(),
)
def test_law_in_a_mirrored_world_steers_mirrored(
    law: Law,
    shape: Shape,
    spots: list[Spot],
    vehicle: dict[str, Any],
    adapt: Any,
    data: st.DataObject,
) -> None:
    path = shape.build()
    assume(not _heads_west(path))
    # A turn by a half circle has no side, and what it tells the estimates has none.
    assume(all(abs(spot.turned) < math.pi for spot in spots))
    params = data.draw(law.params())
    if law.searches:
        params = fitted(params, path, 100_000, vehicle.get("wheelbase", 3.0))
    kind, tuning = getattr(popsteer, law.name), getattr(popsteer, law.params_name)(**params)
    # Without a monitor every pose is believed, also one that nothing leads to.
    given = {**adapting(adapt), "monitor": None}
    car = popsteer.Vehicle(**vehicle)
    ours = kind(_path(path), car, tuning, **given)
    car = car.replace(steer_offset=-car.steer_offset, antenna_left=-car.antenna_left)
    theirs = kind(_path(_mirrored(path)), car, tuning, **given)
    for spot in spots:
        x, y, yaw, speed, dt = step = spot.at(path)
        before, theirs_before = ours.state, theirs.state
        here, there = ours.step(*step), theirs.step(x, -y, -yaw, speed, dt)
        assume(not _measured_on_line(path, ours, step))
        if _are_mirrored(ours, theirs, here, there):
            continue
        # What the law was shown tells whether there is a side to be told.
        at, decision = decided(law, ours, before, ours.state, step)
        assume(not _is_on_line(path, at.closest.segment, at.position))
        assume(law is not PURE_PURSUIT or not _no_side(at, here.target))
        if law is POP and there.steer != -here.steer:
            # Two candidates are as good, to the last bit, and the first in the list is taken:
            # the list runs the other way in the mirror. Both are then best in either world.
            there_step = (x, -y, -yaw, speed, dt)
            mirrored = decided(law, theirs, theirs_before, theirs.state, there_step)[1]
            assert mirrored.steer != -decision.steer
            distances = {
                _candidate_distance(at, here.target, steer)
                for steer in (decision.steer, -mirrored.steer)
            }
            assert len(distances) == 1
            assert at.vehicle.speed > 0.0
            assert there.target == (here.target[0], -here.target[1])
            assert there.predicted_cross_track_error == -here.predicted_cross_track_error
            assert there.predicted_heading_error == -here.predicted_heading_error
            return
        assert _are_mirrored(ours, theirs, here, there), (here, there)


def test_vehicle_beside_a_place_on_its_own_line_has_no_side() -> None:
    path = Shape("straight", 41, 1.9481172071075352, seed=41).build()
    ours, theirs = (
        popsteer.PreviewPop(_path(each), monitor=None) for each in (path, _mirrored(path))
    )
    for spot in (Spot(0.0, 1.0), Spot(0.5625, 0.0, math.pi, 0.0), Spot(0.1875)):
        x, y, yaw, speed, dt = step = spot.at(path)
        here, there = ours.step(*step), theirs.step(x, -y, -yaw, speed, dt)
    # 20 m behind its place, which is remembered; `Path.project` gives another segment.
    assert there.cross_track_error == here.cross_track_error != 0.0
    assert _measured_on_line(path, ours, step)


def test_pop_with_two_candidates_as_good_takes_the_first() -> None:
    # West along the axis, the vehicle looking east: what it is to reach lies straight behind.
    way = Waypoints([(20.0 - k, 0.0) for k in range(21)], None, closed=False)
    ours, theirs = popsteer.Pop(_path(way)), popsteer.Pop(_path(_mirrored(way)))
    before, step = ours.state, (10.0, 0.0, 0.0, 5.0, 0.05)
    here, there = ours.step(*step), theirs.step(*step)
    assert there.steer == here.steer != 0.0
    at, _ = decided(POP, ours, before, ours.state, step)
    both = [_candidate_distance(at, here.target, steer) for steer in (here.steer, -here.steer)]
    assert both[0] == both[1]


@given(shape=shapes(), spot=SPOTS, lookahead=st.floats(0.0, 30.0))
def test_path_in_a_mirrored_world_answers_mirrored(
    shape: Shape, spot: Spot, lookahead: float
) -> None:
    path = shape.build()
    x, y, *_ = spot.at(path)
    ours, theirs = _path(path), _path(_mirrored(path))
    assert theirs.length == ours.length
    assert theirs.nearest_waypoint(x, -y) == ours.nearest_waypoint(x, y)
    here, there = ours.project(x, y), theirs.project(x, -y)
    assert (there.segment, there.fraction) == (here.segment, here.fraction)
    assert there.arc_length == here.arc_length
    assert there.point == (here.point[0], -here.point[1])
    assert abs(there.cross_track_error) == abs(here.cross_track_error)
    spacing = fitted({}, path, 100_000).get("grid_spacing", 0.01)
    found = ours.get_lookahead_point(x, y, lookahead, grid_spacing=spacing)
    mirrored = theirs.get_lookahead_point(x, -y, lookahead, grid_spacing=spacing)
    assert (mirrored.index, mirrored.found) == (found.index, found.found)
    assert mirrored.point == (found.point[0], -found.point[1])


@given(speed=st.floats(-100.0, 100.0), steer=st.floats(-1.5, 1.5), yaw=st.floats(-1e3, 1e3))
def test_vehicle_in_a_mirrored_world_moves_mirrored(speed: float, steer: float, yaw: float) -> None:
    x, y, turned, faster = popsteer.paper.kinematic_bicycle(
        1.0, 2.0, yaw, speed, steer, 1.0, 3.0, 0.1
    )
    mirrored = popsteer.paper.kinematic_bicycle(1.0, -2.0, -yaw, speed, -steer, 1.0, 3.0, 0.1)
    assert mirrored == (x, -y, -turned, faster)
    x, y = popsteer.paper.get_predicted_location(1.0, 2.0, yaw, speed, steer, 0.1)
    assert popsteer.paper.get_predicted_location(1.0, -2.0, -yaw, speed, -steer, 0.1) == (x, -y)
    assert popsteer.paper.wrap(-yaw) == -popsteer.paper.wrap(yaw)
