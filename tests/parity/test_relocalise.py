from __future__ import annotations

import math
import random
from math import inf, nan, nextafter
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import popsteer
from tests.parity.checks import check_steps, controller
from tests.parity.compare import Pair, make
from tests.parity.laws import LATERAL, Law
from tests.parity.strategies import SPOTS, VEHICLES, XY, Shape, Spot, shapes

BAD_POSES = [
    *((value, 1.0, 1.0) for value in (nan, inf, -inf, nextafter(1e9, inf), None)),
    *((1.0, value, 1.0) for value in (nan, inf, -inf, -nextafter(1e9, inf), None)),
    *((1.0, 1.0, value) for value in (nan, inf, -inf, nextafter(1e6, inf), None)),
    (nan, nan, nan),
    (1.0, nan, nan),
]


def _every_law() -> list[Any]:
    """The laws, each claimed for its own case."""
    return [
        pytest.param(law, id=law.name, marks=pytest.mark.covers(f"{law.name}.relocalise"))
        for law in LATERAL
    ]


def _eight() -> XY:
    """A figure of eight that crosses itself at the origin, leading 27 and 153 degrees there."""
    turns = [math.tau * k / 200 for k in range(200)]
    return [(50.0 * math.sin(t), 12.5 * math.sin(2.0 * t)) for t in turns]


@pytest.mark.covers("Path.relocalise")
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


@pytest.mark.covers("Path.relocalise")
def test_path_relocalise_matches_reference_edges() -> None:
    pair = make("Path", _eight(), closed=True)
    for x, y, yaw in BAD_POSES:
        assert pair.call("relocalise", x, y, yaw) is None
    for x, y in ((1e9, -1e9), (-1e9, 0.0), (0.0, -0.0)):
        for yaw in (1e6, -1e6, 0.0, -0.0, 5e-324):
            assert pair.call("relocalise", x, y, yaw) is not None
    for value in (nan, inf, -1.0, nextafter(1e9, inf)):
        assert pair.call("relocalise", 0.0, 0.0, 0.0, opposite_distance=value) is None


@pytest.mark.parametrize("wheelbase", [0.3, 2.7, 30.0])
def test_law_of_any_wheelbase_weighs_the_heading_by_it(wheelbase: float) -> None:
    # There, and back a wheelbase and a half or four of them beside it.
    for apart, taken in ((1.5, 2), (4.0, 0)):
        xy = [(0.0, 0.0), (50.0, 0.0), (50.0, apart), (0.0, apart)]
        path = make("Path", [(wheelbase * x, wheelbase * y) for x, y in xy])
        pair = make("Stanley", path, make("Vehicle", wheelbase=wheelbase))
        pair.call("relocalise", 25.0 * wheelbase, 0.0, math.pi)
        assert pair.get("state").rust.waypoint == taken
        far = {"opposite_distance": wheelbase * 10.0 / 3.0}
        found = path.call("relocalise", 25.0 * wheelbase, 0.0, math.pi, **far)
        assert found is not None
        assert found.rust == taken


@pytest.mark.covers("Path.relocalise")
def test_path_relocalise_on_a_crossing_takes_the_branch_of_the_heading() -> None:
    pair = make("Path", _eight(), closed=True)
    for yaw, branch in ((0.464, 0), (math.pi - 0.464, 100)):
        for askew in (-0.5, 0.0, 0.5):
            for turn in (0.0, -math.tau, 20.0 * math.tau):
                found = pair.call("relocalise", 0.0, 0.0, yaw + askew + turn)
                assert found is not None
                # The closest point is the waypoint itself: the segment before it or after it.
                assert found.rust in (branch, (branch - 1) % 200)


@pytest.mark.parametrize("law", _every_law())
@given(shape=shapes(most=120), vehicle=VEHICLES, spots=st.lists(SPOTS, min_size=2, max_size=4))
def test_law_relocalise_matches_reference_random(
    law: Law, shape: Shape, vehicle: dict[str, Any], spots: list[Spot]
) -> None:
    path = shape.build()
    pair = controller(law, path, {}, 400, vehicle)
    for spot in spots:
        x, y, yaw, speed, dt = spot.at(path)
        pair.call("relocalise", x, y, yaw)
        pair.get("state")
        check_steps(pair, [(x, y, yaw, speed, dt)])


@pytest.mark.parametrize("law", _every_law())
def test_law_relocalise_matches_reference_edges(law: Law) -> None:
    path = make("Path", _eight(), closed=True)
    search = {"grid_spacing": 0.5, "lookahead_tolerance": 0.3} if law.searches else {}
    pair = make(law.name, path, make("Vehicle"), make(law.params_name, **search))
    for warm in (False, True):
        if warm:
            check_steps(pair, [(20.0, 8.0, 0.2, 5.0, 0.05)] * 2)
        before = pair.get("state")
        for pose in (*BAD_POSES, (1.0, 1.0), (None,) * 3):
            assert pair.call("relocalise", *pose) is None
            assert pair.rust.state == before.rust
            assert pair.twin.state == before.twin
        _check_crossing(pair)


def _check_crossing(pair: Pair) -> None:
    """On the crossing the heading decides; the rest of the state stays."""
    offset = pair.rust.tracked_point
    for yaw, branch in ((0.464, 0), (math.pi - 0.464, 100)):
        before = pair.rust.state.as_dict()
        pose = (-offset * math.cos(yaw), -offset * math.sin(yaw), yaw)
        assert pair.call("relocalise", *pose) is not None
        after = pair.get("state").rust.as_dict()
        # The place is the rear axle's, up to two segments before the crossing.
        assert (branch - after["waypoint"]) % 200 <= 2
        changed: dict[str, Any] = {"waypoint": pair.rust.path.relocalise(*pose)}
        changed |= {
            "measured_waypoint": None,
            "place": None,
            "last_measured": None,
        }  # the jump shows nothing
        if before["monitor"] is not None:
            (wheel, _, _), turns, evidence, alarm, _ = before["monitor"]
            still = (0.0, 0.0, 0.0, turns[3], 0.0, 0.0)
            changed["monitor"] = ((wheel, None, None), still, evidence, alarm, False)
        assert after == before | changed
        check_steps(pair, [(*pose, 5.0, 0.05)])
        assert (pair.rust.state.waypoint - branch + 1) % 200 <= 2


def _knot(count: int) -> XY:
    """A long path that crosses itself again and again."""
    turns = [0.003 * k for k in range(count)]
    return [(400.0 * math.sin(t) + 0.5 * t, 300.0 * math.sin(1.7 * t + 0.3)) for t in turns]


@pytest.mark.parametrize("closed", [False, True], ids=["open", "closed"])
def test_law_on_a_long_path_finds_its_place_as_the_reference(closed: bool) -> None:
    path = make("Path", _knot(4000), closed=closed)
    other = make("Path", _knot(3000)[::-1])
    pair = make("Stanley", path)
    rng = random.Random(8)
    for k in range(60):
        x, y = path.rust.x[67 * k % 4000], path.rust.y[67 * k % 4000]
        angle, far = rng.uniform(-4.0, 4.0), rng.choice([0.0, 3.0, 60.0, 2000.0])
        pose = (x + far * math.cos(angle), y + far * math.sin(angle), rng.uniform(-4.0, 4.0))
        if k % 3 == 0:
            pair.call("set_path", (other if k % 2 else path))
        elif k % 5 == 0:
            pair.call("relocalise", *pose)
            pair.get("state")
        check_steps(pair, [(*pose, 5.0, 0.05)])
        path.call("relocalise", *pose)


def test_law_whose_search_runs_out_of_its_budget_matches_reference() -> None:
    # A circle from whose centre all is as far, and laps of which all are as near.
    whole = [math.tau * k / 70_000 for k in range(70_000)]
    lap = [math.tau * k / 600 for k in range(600)] * 117
    circle = make("Path", [(11e3 * math.cos(t), 11e3 * math.sin(t)) for t in whole], closed=True)
    laps = make("Path", [(95.0 * math.cos(t), 95.0 * math.sin(t)) for t in lap], closed=True)
    pair = make("Stanley", circle)
    # The first step goes on from the best place found, and a lost vehicle from its last place.
    for pose in ((0.0, 0.0, 0.3), (4.0, -3.0, 2.0), (0.0, 0.1, -2.0)):
        check_steps(pair, [(*pose, 5.0, 0.05)])
        command = pair.call("step", *pose, 5.0, 0.05)
        assert command is not None
        assert popsteer.Status.OFF_PATH in command.rust.status
    pair.call("set_path", laps)
    places = []
    for pose in ((95.2, 0.3, 1.6), (-94.0, 0.2, -1.5), (0.0, 0.0, 0.0)):
        check_steps(pair, [(*pose, 5.0, 0.05)])
        places.append(pair.rust.state.waypoint % 600)
    # Found, at the front axle, where the search has come near; at the centre nothing is near.
    assert abs(places[0] - 3) <= 1
    assert abs(places[1] - 303) <= 1
    assert abs(places[2] - 300) <= 20
