"""What a vehicle reports beside pose and speed, and what a controller predicts, on both sides."""

from __future__ import annotations

import math
import random
from typing import Any

import pytest

import popsteer
from tests.parity.checks import BAD_STEPS, NAN, controller
from tests.parity.laws import LATERAL, Law
from tests.parity.strategies import Shape, Spot, Waypoints

CARS: list[dict[str, Any]] = [
    {},
    {"wheelbase": 2.7, "rear_axle": -1.35, "dead_time": 0.15, "steer_lag": 0.2, "max_steer": 0.6},
    {"dead_time": 0.31, "max_steer_rate": 0.5, "steer_offset": 0.02, "no_slip_point": 0.5},
    {"max_lateral_acceleration": None, "steer_offset": -0.0, "max_steer": 0.4},
]
each_law = pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)
covered_law = pytest.mark.parametrize(
    "law",
    [
        pytest.param(law, marks=pytest.mark.covers(f"{law.name}.predict"), id=law.name)
        for law in LATERAL
    ],
)
each_car = pytest.mark.parametrize("car", CARS, ids=["plain", "late", "slow", "bare"])


def _path(*, closed: bool, cusps: bool) -> Waypoints:
    made = Shape(count=60, closed=closed).build()
    speeds = [3.0 + 2.0 * math.sin(0.3 * k) for k in range(len(made.xy))]
    if cusps:
        speeds = [-v if k // 20 % 2 else v for k, v in enumerate(speeds)]
        speeds[20] = speeds[40] = speeds[-1] = 0.0
    return Waypoints(made.xy, speeds, closed=closed)


@covered_law
@each_car
@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("cusps", [False, True])
@pytest.mark.parametrize("adapt", ["auto", None])
def test_reports_and_predictions_match_reference_rollout(
    law: Law, car: dict[str, Any], closed: bool, cusps: bool, adapt: Any
) -> None:
    path = _path(closed=closed, cusps=cusps)
    pair = controller(law, path, {}, 200, car, adapt)
    limit = car.get("max_steer", 1.22)
    rng = random.Random(f"{law.name} {car} {closed} {cusps}")
    x, y, yaw, speed, _ = Spot(0.1, 0.3, 0.1).at(path)
    poses = [(x, y, yaw, speed)]
    assert pair.call("predict", 1.0, 0.05) is None
    for k in range(60):
        dt = rng.choice((0.05, 0.02, 0.0004, 0.3))
        age = rng.choice((0.0, 0.05, 0.1, 1.0)) if k > 10 else 0.0
        given: dict[str, Any] = {"pose_age": age} if rng.random() < 0.8 else {}
        if rng.random() < 0.4:
            given["applied_steer"] = rng.uniform(-1.1, 1.1) * limit
        x, y, yaw, speed = poses[-1] if rng.random() < 0.8 else poses[max(-len(poses), -4)]
        if k % 9 == 8:
            held = pair.call("step_or_hold", NAN, y, yaw, speed, dt, **given)
            assert held is not None
        if k % 13 == 12:
            given = {**given, "applied_steer": NAN}
            assert pair.call("step", x, y, yaw, speed, dt, **given) is None
            assert pair.call("step_or_hold", x, y, yaw, speed, dt, **given) is not None
            given = {}
        command = pair.call(("step", "step_or_hold")[k % 2], x, y, yaw, speed, dt, **given)
        assert command is not None
        pair.get("state")
        if k % 12 == 5:
            before = pair.rust.state
            assert pair.call("predict", 0.5, rng.choice((0.05, 0.021))) is not None
            assert pair.rust.state == before
            assert pair.set_state(pair.get("state"))
        gear = -1.0 if command.rust.reverse else 1.0
        pose = popsteer.paper.kinematic_bicycle(
            x, y, yaw, gear * 4.0, command.rust.steer, 0.0, 3.0, min(dt, 0.1)
        )
        poses.append(pose)


@each_law
def test_bad_reports_are_refused_by_the_same_words(law: Law) -> None:
    path = Shape(count=30).build()
    pair = controller(law, path, {}, most=200, vehicle={"max_steer": 0.5})
    good = Spot(0.2, 0.7, 0.1).at(path)
    bad: list[dict[str, Any]] = [
        *({"applied_steer": value} for value in (NAN, math.inf, 1.6, -1.6)),
        *({"pose_age": value} for value in (NAN, math.inf, -0.1, 1.1)),
        {"applied_steer": NAN, "pose_age": NAN},
    ]
    for given in bad:
        before = pair.get("state")
        assert pair.call("step", *good, **given) is None
        assert pair.call("steer", *good, **given) is None
        assert pair.rust.state == before.rust
    argument, value = BAD_STEPS[0]
    spoilt = [*good[:argument], value, *good[argument + 1 :]]
    assert pair.call("step", *spoilt, applied_steer=NAN) is None
    assert pair.call("step", *good, applied_steer=1.5) is not None
    assert pair.call("step", *good, pose_age=1.0) is not None
    for time, dt in ((NAN, 0.05), (-1.0, 0.05), (1001.0, 0.05), (1.0, 0.0), (1.0, 1e-6)):
        assert pair.call("predict", time, dt) is None
    assert pair.call("predict", 0.0, 0.05) is not None
    assert pair.call("predict") is not None
