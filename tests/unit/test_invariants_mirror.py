"""A mirrored world (y and yaw change sign) mirrors the angle, exactly.

Every operation of the laws is odd or even under the reflection, rounding included, so the answers
are compared without tolerance. Where left and right cannot be told apart the answer is a
convention and has no mirror image; those states are left out, each for the reason given.
"""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from popsteer.reference.lateral.rollout import Model

import popsteer
from popsteer.reference.lateral.rollout import Model
from tests.parity.laws import LATERAL, POP, PURE_PURSUIT, Law
from tests.parity.strategies import SPOTS, Shape, Spot, Waypoints, fitted, shapes

each_law = pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)


def _mirrored(path: Waypoints) -> Waypoints:
    return Waypoints([(x, -y) for x, y in path.xy], path.speed, path.closed)


def _path(path: Waypoints) -> popsteer.Path:
    return popsteer.Path(path.xy, speed=path.speed, closed=path.closed)


def _heads_west(path: Waypoints) -> bool:
    """Whether a segment heads exactly along -x, whose direction is pi in both worlds."""
    ends = path.xy[1:] + path.xy[:1]
    return any(y0 == y1 and x1 < x0 for (x0, y0), (x1, y1) in zip(path.xy, ends, strict=True))


def _reference_point(controller: Any, step: tuple[float, ...]) -> tuple[float, float]:
    x, y, yaw, *_ = step
    offset = controller.reference_offset
    return x + offset * math.cos(yaw), y + offset * math.sin(yaw)


def _on_the_line(path: Waypoints, controller: Any, step: tuple[float, ...]) -> bool:
    """Whether the vehicle lies exactly on the line of its segment, neither left nor right."""
    x, y = _reference_point(controller, step)
    # Its segment is where it was found, which at a bend need not be the one `Path.project` gives.
    segment = controller.state.waypoint
    (x0, y0), (x1, y1) = path.xy[segment], path.xy[(segment + 1) % len(path.xy)]
    side: float = (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)
    return side == 0.0


def _no_side(controller: Any, step: tuple[float, ...], target: tuple[float, float]) -> bool:
    """Whether the lookahead point lies straight ahead or behind, or exactly west."""
    x, y = _reference_point(controller, step)
    to_x, to_y = target[0] - x, target[1] - y
    yaw = step[2]
    aside = math.cos(yaw) * to_y - math.sin(yaw) * to_x
    return aside == 0.0 or (to_y == 0.0 and to_x <= 0.0)


def _candidate_distance(
    controller: Any, wheel: float, step: tuple[float, ...], target: Any, steer: float
) -> float:
    """How near to the target POP's prediction for `steer` comes, with the wheels at `wheel`."""
    x, y = _reference_point(controller, step)
    *_, yaw, speed, dt = step
    speed = max(speed, 0.0)
    to_target = (target[0] - x, target[1] - y)
    params = controller.params
    if params.horizon is None:
        predicted = popsteer.get_predicted_location(0.0, 0.0, yaw, speed, steer, dt)
        return popsteer.get_distance(predicted, to_target)
    model = Model(
        params.horizon,
        params.wheelbase,
        params.understeer,
        params.steer_lag,
        controller.reference_offset,
    )
    return model.rollout(yaw, speed, wheel, dt).get_least_distance(steer, to_target)


@each_law
@given(shape=shapes(), spots=st.lists(SPOTS, min_size=1, max_size=5), data=st.data())
def test_law_in_a_mirrored_world_steers_mirrored(
    law: Law, shape: Shape, spots: list[Spot], data: st.DataObject
) -> None:
    path = shape.build()
    assume(not _heads_west(path))
    params = data.draw(law.params())
    params = fitted(params, path, 100_000) if law.searches else params
    kind, params_kind = getattr(popsteer, law.name), getattr(popsteer, law.params_name)
    ours = kind(_path(path), params_kind(**params))
    theirs = kind(_path(_mirrored(path)), params_kind(**params))
    for spot in spots:
        step = spot.at(path)
        x, y, yaw, speed, dt = step
        wheel = ours.state.model_steer if law is POP else 0.0
        here, there = ours.step(*step), theirs.step(x, -y, -yaw, speed, dt)
        assume(not _on_the_line(path, ours, step))
        assume(law is not PURE_PURSUIT or not _no_side(ours, step, here.target))
        assert theirs.state.waypoint == ours.state.waypoint
        assert there.target == (here.target[0], -here.target[1])
        assert there.cross_track_error == -here.cross_track_error
        assert there.heading_error == -here.heading_error
        if law is POP and there.steer != -here.steer:
            # Two candidates are as good, to the last bit, and the first in the list is taken:
            # the list runs the other way in the mirror. Both are then best in either world.
            distances = {
                _candidate_distance(ours, wheel, step, here.target, steer)
                for steer in (here.steer, -there.steer)
            }
            assert len(distances) == 1
            assert max(spot.speed, 0.0) > 0.0
            return
        assert there.steer == -here.steer
        assert there.status is here.status


def test_vehicle_beside_a_place_on_its_own_line_has_no_side() -> None:
    path = Shape("straight", 41, 1.9481172071075352, seed=41).build()
    ours, theirs = popsteer.PreviewPop(_path(path)), popsteer.PreviewPop(_path(_mirrored(path)))
    for spot in (Spot(0.0, 1.0), Spot(0.5625, 0.0, math.pi, 0.0), Spot(0.1875)):
        x, y, yaw, speed, dt = step = spot.at(path)
        here, there = ours.step(*step), theirs.step(x, -y, -yaw, speed, dt)
    # 20 m behind its place, which is remembered; `Path.project` gives another segment.
    assert there.cross_track_error == here.cross_track_error != 0.0
    assert _on_the_line(path, ours, step)


def test_pop_over_a_horizon_with_two_candidates_as_good_takes_the_first() -> None:
    path = Shape("straight", 17, 100.0, (-1.192092896e-07, -444.46166948652785), True, seed=8967)
    way = path.build()
    params: dict[str, Any] = {
        "horizon": 1.1,
        "steer_lag": 0.5,
        "wheelbase": 2.1242318643248375,
        "max_steer": 1.1459511637564854,
        "candidate_count": 81,
        "steer_span": 0.25618226833346414,
        "min_lookahead": 1e4,
        "lookahead_gain": 0.9595451116267104,
        "lookahead_tolerance": 0.00923757370893381,
        "exact_lookahead": False,
        "window_ahead": 851994.7258787932,
        "grid_spacing": 0.0001,
        "lost_distance": 604199134.8177391,
    }
    law = popsteer.PopParams(**fitted(params, way, 100_000))
    ours, theirs = (popsteer.Pop(_path(each), law) for each in (way, _mirrored(way)))
    x, y, yaw, speed, dt = step = Spot(
        0.2748476968606282, 0.0, math.pi, 23.65754418037161, 0.013717976989337799
    ).at(way)
    here, there = ours.step(*step), theirs.step(x, -y, -yaw, speed, dt)
    assert there.steer != -here.steer
    both = [
        _candidate_distance(ours, 0.0, step, here.target, steer)
        for steer in (here.steer, -there.steer)
    ]
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
    x, y, turned, faster = popsteer.kinematic_bicycle(1.0, 2.0, yaw, speed, steer, 1.0, 3.0, 0.1)
    mirrored = popsteer.kinematic_bicycle(1.0, -2.0, -yaw, speed, -steer, 1.0, 3.0, 0.1)
    assert mirrored == (x, -y, -turned, faster)
    x, y = popsteer.get_predicted_location(1.0, 2.0, yaw, speed, steer, 0.1)
    assert popsteer.get_predicted_location(1.0, -2.0, -yaw, speed, -steer, 0.1) == (x, -y)
    assert popsteer.wrap(-yaw) == -popsteer.wrap(yaw)
