"""Every controller of the reference beside the core's: cases, edges, draws and whole drives."""

from __future__ import annotations

import itertools
import math
import random
from math import pi
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import popsteer
from tests.helpers import long_drives
from tests.parity.checks import (
    Rollout,
    check_bad_steps,
    check_params,
    check_random,
    check_resolved,
    check_rollout,
    check_steps,
    check_zeros,
    controller,
)
from tests.parity.laws import LATERAL, PID, POP, PREVIEW_POP, PURE_PURSUIT, STANLEY, Law
from tests.parity.scenes import CASES, drives
from tests.parity.strategies import (
    CALM_VEHICLES,
    ESTIMATES,
    SEEDS,
    SPOTS,
    VEHICLES,
    Shape,
    Spot,
    Waypoints,
    shapes,
)

if TYPE_CHECKING:
    from tests.parity.compare import Controller

each_law = pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)

# Parameters and vehicles that are driven through every case, beside the default ones.
VARIANTS: dict[str, list[tuple[dict[str, Any], dict[str, Any]]]] = {
    "Pop": [
        ({"candidate_count": 5, "steer_span": 0.3}, {"rear_axle": -1.94}),
        ({}, {"dead_time": 0.2, "wheelbase": 2.7, "max_steer_rate": 0.4}),
    ],
    "PreviewPop": [
        ({"heading_cost": 1.0}, {"steer_lag": 0.0, "dead_time": 0.3, "steer_offset": 0.02}),
        (
            {"horizon": 2.0, "smoothing_length": 0.0},
            {"rear_axle": -1.94, "no_slip_point": 0.0, "understeer": 0.002},
        ),
    ],
    "Pid": [
        ({"smoothing_length": 0.0}, {}),
        ({"buffer_length": 7, "integral_with_dt": False}, {"max_steer": 0.5, "dead_time": 0.1}),
    ],
    "PurePursuit": [
        ({"alpha_by_arccos": True}, {"dead_time": 0.15}),
        ({"min_lookahead": 0.0}, {"rear_axle": -1.94}),
    ],
    "Stanley": [
        ({"smoothing_length": 0.0}, {}),
        ({"heading_behind": True, "softening": 1.0}, {"dead_time": 0.2, "steer_offset": -0.03}),
    ],
}
BELIEVED = {"gain": 1.3, "steer_offset": 0.02, "slip": -0.03, "slip_length": 0.2}
"""What is believed of the vehicle in one of them."""


@each_law
@pytest.mark.parametrize("drive", CASES.values(), ids=CASES)
def test_law_matches_reference_cases(law: Law, drive: Rollout) -> None:
    check_rollout(law, drive, {}, most=5000)
    for params, vehicle in VARIANTS[law.name]:
        check_rollout(law, drive, params, most=5000, vehicle=vehicle)
    check_rollout(law, drive, {}, most=5000, vehicle={"dead_time": 0.1}, estimate=BELIEVED)


@each_law
def test_law_matches_reference_edges(law: Law) -> None:
    check_params(law)
    check_bad_steps(law)
    check_zeros(law)
    _check_hardly_moving(law)
    _check_beyond_the_bounds(law)


def _check_hardly_moving(law: Law) -> None:
    path = Waypoints([(k * 1.0, 0.1 * k) for k in range(50)], None, closed=False)
    pair = controller(law, path, {}, most=200)
    for k, speed in enumerate((5e-324, 5e-324, 1e-320, 1e-300, 1e-9, -5e-324, 0.0, 3.0)):
        command = pair.step(1.0, 0.1 * k, 0.0, speed, 0.05)
        assert command is not None
        assert math.isfinite(command.rust.steer)


def _check_beyond_the_bounds(law: Law) -> None:
    """The prediction of a vehicle leaves the bounds of a given one."""
    path = Waypoints([(-1e9, -1e9), (0.0, 0.0), (1e9, 1e9)], None, closed=False)
    pair = controller(law, path, {}, most=200, vehicle={"dead_time": 10.0})
    if pair.within > 0.0:
        # A place on this path is known to the rounding of its coordinates, 1.2e-7 m.
        pair.within = 1e-8
    for x, y in itertools.product((-1e9, 1e9), repeat=2):
        for yaw, speed in itertools.product((-1e6, 1e6, 0.1), (-1e4, 1e4)):
            assert pair.step(x, y, yaw, speed, 0.05) is not None


@each_law
@given(data=st.data())
def test_law_matches_reference_random(law: Law, data: st.DataObject) -> None:
    params = data.draw(law.params(), label="params")
    vehicle = data.draw(st.none() | VEHICLES, label="vehicle")
    spots = data.draw(st.lists(SPOTS, min_size=1, max_size=6), label="spots")
    estimate = data.draw(ESTIMATES, label="estimate")
    check_random(law, data.draw(shapes(), label="shape"), params, spots, vehicle, estimate)
    check_resolved(law, params, vehicle or {})


@each_law
@long_drives()
@given(data=st.data())
def test_law_matches_reference_rollout(law: Law, data: st.DataObject) -> None:
    drive, params = data.draw(drives(), label="drive"), data.draw(law.params(), label="params")
    vehicle = data.draw(CALM_VEHICLES, label="vehicle")
    check_rollout(law, drive, params, vehicle=vehicle, estimate=data.draw(ESTIMATES))


# Draws that once told both sides apart.
HARD: list[tuple[Law, Shape, dict[str, Any], dict[str, Any], list[Spot]]] = [
    # Near a right angle the wheels' tangent turns rounding into 5e-8 m.
    (
        PID,
        Shape(count=2),
        {},
        {"wheelbase": 1.0, "rear_axle": 0.0, "max_steer": 1.57, "dead_time": 0.0625},
        [Spot(turned=turned, speed=1.0, dt=0.125) for turned in (0.0, 0.5, 0.0)],
    ),
    # Wheels that steer a wheelbase of 1 mm for 10 s at 10,000 m/s: no digit is left.
    (
        POP,
        Shape(count=2),
        {},
        {"turning_wheelbase": 0.001, "dead_time": 10.0, "steer_offset": 0.03125},
        [Spot(speed=1.0, dt=0.125), Spot(turned=pi, speed=-1e4, dt=0.125)],
    ),
    # Limits close to rounding: at 10,000 m/s, where the first move must be 0, and where one follows
    # from others.
    (
        PREVIEW_POP,
        Shape(count=3, closed=True),
        {"steer_span_rate": None, "heading_cost": 0.0},
        {},
        [*[Spot(speed=1.0, dt=0.125)] * 4, Spot(speed=1e4, dt=0.0625)],
    ),
    (
        PREVIEW_POP,
        Shape("noisy", 4, seed=1),
        {"heading_cost": 0.0, "steer_rate_cost": 1e-05},
        {},
        [Spot(speed=1.0, dt=0.125), Spot(speed=1e-160, dt=0.0625)],
    ),
    (
        PREVIEW_POP,
        Shape("noisy", 36, 0.875, seed=36),
        {"steer_span_rate": None, "heading_cost": 40.0},
        {},
        [
            Spot(speed=0.5, dt=0.015625),
            Spot(along=1.0, speed=4.0, dt=0.03125),
            Spot(speed=1.0, dt=0.03125),
            Spot(along=1.0, speed=5.0, dt=0.03125),
            Spot(speed=0.5, dt=0.125),
            Spot(along=0.625, speed=12.0, dt=0.109375),
        ],
    ),
    (
        PREVIEW_POP,
        Shape(),
        {},
        {"no_slip_point": None, "steer_offset": -0.5, "max_steer": 0.3125},
        [Spot(speed=1.0, dt=0.125), Spot(turned=pi, speed=1e4, dt=0.125)],
    ),
]


def test_law_matches_reference_where_they_once_differed() -> None:
    for law, shape, params, vehicle, spots in HARD:
        check_random(law, shape, params, spots, vehicle)


def _cusps(seed: int) -> Waypoints:
    """A bend forward, a bend back from its end, and one forward again."""
    rng = random.Random(seed)
    x, y, heading = 0.0, 0.0, rng.uniform(-3.0, 3.0)
    xy, reverse = [], []
    for section in range(3):
        curvature = rng.uniform(-0.15, 0.15)
        for _ in range(20):
            xy.append((x, y))
            reverse.append(section == 1)
            way = -0.5 if section == 1 else 0.5
            x, y = popsteer.paper.kinematic_bicycle(x, y, heading, way, 0.0, 0.0, 1.0, 1.0)[:2]
            heading += way * curvature
    return Waypoints(xy, None, closed=False, reverse=reverse)


def _drive(pair: Controller, path: Waypoints, car: dict[str, Any], seed: int) -> None:
    """Follow the path with a vehicle that is another than the controller thinks; noise and all."""
    rng = random.Random(seed)
    gain, offset, slip = rng.uniform(0.7, 1.4), rng.uniform(-0.03, 0.03), rng.uniform(-0.05, 0.05)
    (x, y), (x1, y1) = path.xy[:2]
    backwards = path.reverse is not None and path.reverse[0]
    yaw = math.atan2(y1 - y, x1 - x) + (3.14 if backwards else 0.0)
    wheel, speed = 0.0, 0.0
    queue = [0.0] * round(car.get("dead_time", 0.0) / 0.05)
    for k in range(100):
        noise = [rng.gauss(0.0, 0.01) for _ in range(3)]
        pose = [x + noise[0], y + noise[1], yaw + 0.1 * noise[2]]
        if rng.random() < 0.02:
            pose[0] += 40.0
        dt = 0.05 if rng.random() < 0.8 else rng.uniform(0.005, 0.1)
        answer = pair.step(*pose, speed, dt)
        assert answer is not None
        backwards = answer.rust.reverse
        queue.append(answer.rust.steer)
        wheel += 0.4 * (queue.pop(0) + offset - wheel)
        speed += 0.1 * ((-3.0 if backwards else 3.0) - speed)
        x, y, turned, _ = popsteer.paper.kinematic_bicycle(
            x, y, yaw + slip, speed, popsteer.paper.saturate(gain * wheel, -1.2, 1.2), 0.0, 3.0, dt
        )
        yaw = turned - slip
        if k % 10 == 9:
            pair.restore(pair.state())


@each_law
@long_drives()
@given(
    vehicle=CALM_VEHICLES,
    estimate=ESTIMATES,
    seed=SEEDS,
    way=st.sampled_from(["forward", "backward", "cusps"]),
)
def test_law_with_a_vehicle_matches_reference_random(
    law: Law, vehicle: dict[str, Any], estimate: dict[str, float], seed: int, way: str
) -> None:
    path = _cusps(seed)
    if way != "cusps":
        xy = Shape("smooth", count=40, seed=seed).build().xy
        path = Waypoints(xy, None, closed=False, reverse=[way == "backward"] * 40)
    pair = controller(law, path, {}, 400, vehicle, estimate)
    _drive(pair, path, vehicle, seed)


def test_law_with_the_papers_search_on_long_segments_matches_reference() -> None:
    # 10,000,000 points of the grid, of which a step stores none, and visits few.
    path = Waypoints([(0.0, 0.0), (1e5, 0.0), (1e5, 1e5)], None, closed=False)
    for law in (POP, PURE_PURSUIT):
        pair = controller(law, path, {"exact_lookahead": False}, most=10**8)
        check_steps(pair, [(5.0 * k, 0.5, 0.0, 5.0, 0.05) for k in range(3)])


def test_law_on_a_long_path_finds_its_place_as_the_reference() -> None:
    turns = [0.003 * k for k in range(4000)]
    knot = [(400.0 * math.sin(t) + 0.5 * t, 300.0 * math.sin(1.7 * t + 0.3)) for t in turns]
    rng = random.Random(8)
    for closed in (False, True):
        pair = controller(STANLEY, Waypoints(knot, None, closed), {})
        for k in range(40):
            (x, y), angle = knot[67 * k % 4000], rng.uniform(-4.0, 4.0)
            far = rng.choice([0.0, 3.0, 60.0, 2000.0])
            pose = (x + far * math.cos(angle), y + far * math.sin(angle), rng.uniform(-4.0, 4.0))
            check_steps(pair, [(*pose, 5.0, 0.05)])
