"""Paths of the core and of the reference, and places found on the whole of them."""

from __future__ import annotations

import itertools
import math
import random
from math import inf, nan, nextafter
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from popsteer import PathError
from tests.parity.compare import Controller, Pair, call, make
from tests.parity.strategies import SPOTS, XY, Shape, Spot, fitted, shapes, usually

SQUARE = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)]
BAD_INDEXES: tuple[Any, ...] = (4, 5, -1, -(10**6), 2**53, 1.0, "1")
BAD_POSITIONS = [
    *((value, 1.0) for value in (nan, inf, -inf, nextafter(1e9, inf), None)),
    *((1.0, value) for value in (nan, inf, -inf, -nextafter(1e9, inf), None)),
    (nan, nan),
]


def _made(shape: Shape) -> Pair:
    path = shape.build()
    return make("Path", path.xy, speed=path.speed, closed=path.closed)


@given(shape=shapes())
def test_path_matches_reference_random(shape: Shape) -> None:
    pair = _made(shape)
    assert len(pair.rust) == len(pair.twin)


BAD_WAYPOINTS: list[tuple[Any, dict[str, Any]]] = [
    *(([(0.0, 0.0), (value, 1.0)], {}) for value in (nan, inf, -inf, nextafter(1e9, inf))),
    *(([(0.0, value), (1.0, 1.0)], {}) for value in (nan, inf, -inf, -nextafter(1e9, inf))),
    # The first of several faults, in the order of the check: x before y before speed.
    ([(0.0, nan), (nan, 1.0)], {"speed": [nan, nan]}),
    ([(0.0, nan), (0.0, 1.0)], {"speed": [nan, nan]}),
    *((SQUARE, {"speed": [1.0, value, 3.0, 4.0]}) for value in (nan, inf, 10000.1, -1e5)),
    *((SQUARE, {"speed": [1.0] * count}) for count in (0, 3, 5)),
    *((SQUARE, {"reverse": [True] * count}) for count in (0, 3, 5)),
    (SQUARE[:1], {}),
    *((SQUARE[:count], {"closed": True}) for count in (1, 2)),
    *(([(1.0, 1.0)] * count, {}) for count in (2, 3)),
    ([*SQUARE, SQUARE[-1]], {}),
    ([*SQUARE, SQUARE[0]], {"closed": True}),
    ([*SQUARE, SQUARE[0]], {"closed": True, "speed": [1.0]}),
    ([(0.0, 0.0), (1e-9, 0.0)], {}),
    ([(0.0, 0.0), (0.0, -1e-9), (1.0, 1.0)], {}),
    (np.zeros((2, 2)), {}),
    (np.array([[0.0, 0.0], [1.0, nan]]), {}),
]
ANY_KIND: list[tuple[Any, dict[str, Any]]] = [
    (SQUARE, {"closed": True}),
    (SQUARE, {"speed": [1, 2, 3, 4]}),
    (SQUARE, {"speed": [1.0, -2.0, 0.0, 0.0], "closed": True}),
    (SQUARE, {"speed": [0.0, -2.0, 0.0, 3.0]}),
    ([(0, 0), (3, 4)], {}),
    ([[0, 0], [3, 4]], {}),
    (np.array(SQUARE, dtype=np.float32), {}),
    (np.array(SQUARE)[::-1], {}),
    (np.array(SQUARE, order="F"), {"speed": np.arange(8.0)[::2]}),
    ([(0.0, 0.0), (nextafter(1e-9, 1.0), 0.0)], {}),
    ([(-1e9, 1e9), (1e9, -1e9)], {}),
    ([(0.0, 0.0), (1.0, 1.0), (0.0, 0.0)], {}),
    ([(-0.0, 0.0), (0.0, -1.0), (-0.0, 0.0)], {}),
]


def test_path_matches_reference_edges() -> None:
    for xy, options in BAD_WAYPOINTS:
        assert call("Path", xy, **options) is None
    for xy, options in ANY_KIND:
        pair = make("Path", xy, **options)
        for x, y in ((0.0, 0.0), (-0.0, -0.0), (2.0, 2.0), (-5.0, 1.0), (1e9, -1e9)):
            pair.call("project", x, y)


@given(shape=shapes(), spot=SPOTS, start=st.floats(0.0, 1.0))
def test_path_location_matches_reference_random(shape: Shape, spot: Spot, start: float) -> None:
    path = shape.build()
    pair = _made(shape)
    x, y, yaw, speed, _ = spot.at(path)
    first = min(int(start * len(path.xy)), len(path.xy) - 1)
    pair.call("nearest_waypoint", x, y)
    for reach in (0.0, abs(speed), 1e9):
        arrived = pair.call("locate", x, y, yaw, first, reach)
        assert arrived is not None
        pair.call("locate", x, y, yaw, first, reach, opposite_distance=0.3 * abs(speed))
        pair.call("get_crossing", x, y, abs(speed), arrived.rust.segment)
        for nearest in (None, first, arrived.rust.segment):
            pair.call("project", x, y, nearest)
            pair.call("reference_speed", x, y, nearest)
    pair.call("path_yaw_behind", first)


@given(
    shape=shapes(),
    spot=SPOTS,
    lookahead=usually((0.0, 15.0), 0.0, 1e6),
    tolerance=usually((0.001, 0.5), 1e-9, 1e3),
    window_ahead=usually((1.0, 40.0), 1e-3, 1e6),
    grid_spacing=usually((0.01, 1.0), 1e-4, 1e3),
    given_nearest=st.booleans(),
)
def test_path_lookahead_matches_reference_random(
    shape: Shape,
    spot: Spot,
    lookahead: float,
    tolerance: float,
    window_ahead: float,
    grid_spacing: float,
    given_nearest: bool,
) -> None:
    path = shape.build()
    pair = _made(shape)
    x, y, *_ = spot.at(path)
    nearest = pair.rust.nearest_waypoint(x, y)
    asked = {"window_ahead": window_ahead, "grid_spacing": grid_spacing}
    search = fitted({**asked, "lookahead_tolerance": tolerance}, path, 2000)
    options = {
        "window_ahead": window_ahead,
        "grid_spacing": search["grid_spacing"],
        "tolerance": search["lookahead_tolerance"],
        "nearest": nearest if given_nearest else None,
    }
    pair.call("window", nearest, window_ahead)
    pair.call("resample", nearest, window_ahead, search["grid_spacing"])
    pair.call("get_lookahead_point", x, y, lookahead, **options)
    pair.call("get_lookahead_point_index", x, y, lookahead, **options)


def test_path_questions_match_reference_edges() -> None:
    pair = make("Path", SQUARE)
    for x, y in BAD_POSITIONS:
        assert pair.call("nearest_waypoint", x, y) is None
        assert pair.call("locate", x, y, nan, 9, nan) is None
        assert pair.call("get_crossing", x, y, nan, 9) is None
        for method in ("project", "reference_speed"):
            assert pair.call(method, x, y) is None
            assert pair.call(method, x, y, 9) is None
        for method in ("get_lookahead_point", "get_lookahead_point_index"):
            assert pair.call(method, x, y, nan, nearest=9, tolerance=nan) is None
    for index in BAD_INDEXES:
        assert pair.call("locate", 1.0, 1.0, 0.0, index, nan) is None
        assert pair.call("get_crossing", 1.0, 1.0, 1.0, index) is None
        for method in ("project", "reference_speed"):
            assert pair.call(method, 1.0, 1.0, index) is None
        assert pair.call("path_yaw_behind", index) is None
        assert pair.call("window", index) is None
        assert pair.call("resample", index, ahead=2.0) is None
        assert pair.call("get_lookahead_point", 1.0, 1.0, 2.0, nearest=index) is None
    for value in (nan, inf, -inf, -5e-324, nextafter(1e9, inf)):
        assert pair.call("locate", 1.0, 1.0, 0.0, 0, value) is None
        assert pair.call("locate", 1.0, 1.0, 0.0, 0, 6.0, opposite_distance=value) is None
        assert pair.call("get_crossing", 1.0, 1.0, value, 9) is None
    for value in (nan, inf, -inf, nextafter(1e6, inf)):
        assert pair.call("locate", 1.0, 1.0, value, 9, nan) is None
    for value in (nan, inf, -inf, 0.0, -1.0, nextafter(1e-3, 0.0), nextafter(1e6, inf)):
        assert pair.call("window", 0, value) is None
        assert pair.call("resample", 0, value, nan) is None
    for value in (nan, inf, -inf, 0.0, -1.0, nextafter(1e-4, 0.0), nextafter(1e3, inf)):
        assert pair.call("resample", 0, 2.0, value) is None


def test_path_of_a_grid_too_large_matches_reference_edges() -> None:
    far = make("Path", [(0.0, 0.0), (1e9, 0.0)])
    assert far.call("resample", 0) is None
    assert far.call("resample", 0, 1e6, 1e-4) is None
    assert far.call("get_lookahead_point", 0.0, 0.0, 6.0) is None
    with pytest.raises(PathError, match="would have 100000000001 points, more than 10000000"):
        far.rust.resample(0)
    # Just too many, and so few that they are made.
    assert make("Path", [(0.0, 0.0), (1e5, 0.0)]).call("resample", 0) is None
    assert make("Path", [(0.0, 0.0), (1e7, 0.0)]).call("resample", 0, 20.0, 1000.0) is not None
    assert make("Path", [(0.0, 0.0), (1e5, 0.0)]).call("resample", 1, 20.0, 1.0) is not None


def test_path_lookahead_of_bad_numbers_matches_reference_edges() -> None:
    pair = make("Path", SQUARE)
    bad: list[tuple[float, dict[str, Any]]] = [
        *((value, {}) for value in (nan, inf, -inf, -5e-324, nextafter(1e6, inf))),
        *((1.0, {"tolerance": value}) for value in (nan, 0.0, 9e-10, nextafter(1e3, inf))),
        *((1.0, {"window_ahead": value}) for value in (nan, 0.0, 9e-4, nextafter(1e6, inf))),
        *((1.0, {"grid_spacing": value}) for value in (nan, 0.0, 9e-5, nextafter(1e3, inf))),
        (nan, {"tolerance": nan, "window_ahead": nan, "grid_spacing": nan, "nearest": 9}),
        (nan, {"tolerance": nan, "window_ahead": nan, "grid_spacing": nan}),
        (1.0, {"tolerance": nan, "window_ahead": nan, "grid_spacing": nan}),
        (1.0, {"window_ahead": nan, "grid_spacing": nan}),
    ]
    for lookahead, options in bad:
        assert pair.call("get_lookahead_point", 1.0, 1.0, lookahead, **options) is None
        assert pair.call("get_lookahead_point_index", 1.0, 1.0, lookahead, **options) is None


def test_path_lookahead_at_its_bounds_matches_reference_cases() -> None:
    for closed, nearest in itertools.product((False, True), range(4)):
        pair = make("Path", SQUARE, closed=closed)
        for ahead in (1e-3, 4.0, nextafter(4.0, 5.0), 8.0, 12.0, 16.0, 1e6, 5):
            pair.call("window", nearest, ahead)
            for spacing in (0.01, 0.3, 4.0, 1e3, 1):
                pair.call("resample", nearest, ahead, spacing)
                for lookahead, tolerance in itertools.product(
                    (0.0, 2.0, 4.0, 1e6), (1e-9, 0.01, 1e3)
                ):
                    pair.call(
                        "get_lookahead_point",
                        *(2.0, 0.0, lookahead),
                        nearest=nearest,
                        tolerance=tolerance,
                        window_ahead=ahead,
                        grid_spacing=spacing,
                    )


BAD_POSES = [
    *((value, 1.0, 1.0) for value in (nan, inf, -inf, nextafter(1e9, inf), None)),
    *((1.0, value, 1.0) for value in (nan, inf, -inf, -nextafter(1e9, inf), None)),
    *((1.0, 1.0, value) for value in (nan, inf, -inf, nextafter(1e6, inf), None)),
    (nan, nan, nan),
    (1.0, nan, nan),
]


def figure_of_eight() -> XY:
    """A figure of eight that crosses itself at the origin, leading 27 and 153 degrees there."""
    turns = [math.tau * k / 200 for k in range(200)]
    return [(50.0 * math.sin(t), 12.5 * math.sin(2.0 * t)) for t in turns]


@given(
    shape=shapes(most=200),
    spot=SPOTS,
    yaw=st.none() | st.integers(-4, 4).map(lambda quarters: quarters * math.pi / 2),
)
def test_path_relocalise_matches_reference_random(
    shape: Shape, spot: Spot, yaw: float | None
) -> None:
    path = shape.build()
    pair = make("Path", path.xy, speed=path.speed, closed=path.closed)
    x, y, along, *_ = spot.at(path)
    assert pair.call("relocalise", x, y, along if yaw is None else yaw) is not None
    for opposite in (0.0, 3.0, 1e9):
        pair.call("relocalise", x, y, along + 3.0, opposite_distance=opposite)
    # On a waypoint itself.
    x, y = path.xy[len(path.xy) // 3]
    pair.call("relocalise", x, y, along)


def test_path_relocalise_matches_reference_edges() -> None:
    pair = make("Path", figure_of_eight(), closed=True)
    for x, y, yaw in BAD_POSES:
        assert pair.call("relocalise", x, y, yaw) is None
    for x, y in ((1e9, -1e9), (-1e9, 0.0), (0.0, -0.0)):
        for yaw in (1e6, -1e6, 0.0, -0.0, 5e-324):
            assert pair.call("relocalise", x, y, yaw) is not None
    for value in (nan, inf, -1.0, nextafter(1e9, inf)):
        assert pair.call("relocalise", 0.0, 0.0, 0.0, opposite_distance=value) is None


def test_path_relocalise_on_a_crossing_takes_the_branch_of_the_heading() -> None:
    pair = make("Path", figure_of_eight(), closed=True)
    for yaw, branch in ((0.464, 0), (math.pi - 0.464, 100)):
        for askew in (-0.5, 0.0, 0.5):
            for turn in (0.0, -math.tau, 20.0 * math.tau):
                found = pair.call("relocalise", 0.0, 0.0, yaw + askew + turn)
                assert found is not None
                # The closest point is the waypoint itself: the segment before it or after it.
                assert found.rust in (branch, (branch - 1) % 200)


def test_path_relocalise_on_a_long_path_matches_reference() -> None:
    # Beyond 512 segments the core has an index, and the reference a scan.
    turns = [0.003 * k for k in range(3000)]
    knot = [(400.0 * math.sin(t) + 0.5 * t, 300.0 * math.sin(1.7 * t + 0.3)) for t in turns]
    rng = random.Random(8)
    for closed in (False, True):
        pair = make("Path", knot, closed=closed)
        for _ in range(30):
            x, y = rng.choice(knot)
            angle, far = rng.uniform(-4.0, 4.0), rng.choice([0.0, 3.0, 60.0, 2000.0])
            yaw = rng.uniform(-4.0, 4.0)
            pair.call("relocalise", x + far * math.cos(angle), y + far * math.sin(angle), yaw)


def test_open_lap_matches_reference_at_its_first_step() -> None:
    laps = 0
    for seed in range(200):
        random_ = random.Random(seed)
        count, radius = random_.randint(20, 60), random_.uniform(6.0, 30.0)
        angles = [math.tau * k / count for k in range(count + 1 - random_.choice([0, 0, 1, 3]))]
        lap = [(radius * math.sin(a), radius * (1.0 - math.cos(a))) for a in angles]
        path, car = make("Path", lap), make("Vehicle", wheelbase=random_.uniform(0.3, 4.0))
        pair = Controller("Stanley", path, car, make("StanleyParams"), {})
        pose = (random_.gauss(0.0, 3.0), random_.gauss(0.0, 2.0), random_.gauss(0.0, 1.0))
        assert pair.step(*pose, 1.0, 0.05) is not None
        laps += pair.rust.state.waypoint < 5 and pose[0] < 0.0
    assert laps > 20
