from __future__ import annotations

import math
import random
from math import inf, nan, nextafter
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from popsteer.tracks import edges
from tests.helpers import long_drives
from tests.parity.checks import check_params
from tests.parity.compare import Pair, make
from tests.parity.laws import SPEED_TRACKER
from tests.parity.strategies import SEEDS
from tests.planned import closed_spline, random_course

CARS = st.fixed_dictionaries(
    {"wheelbase": st.sampled_from([0.4, 2.7]), "rear_axle": st.sampled_from([0.0, -1.3])},
    optional={
        "max_speed": st.floats(1.0, 40.0),
        "max_acceleration": st.floats(0.5, 5.0),
        "max_deceleration": st.floats(0.5, 8.0),
        "max_lateral_acceleration": st.none() | st.floats(1.0, 8.0),
        "max_steer_rate": st.floats(0.1, 1.0),
        "understeer": st.sampled_from([0.0, 0.003]),
        "drive_lag": st.floats(0.0, 0.6),
    },
)


def _path(seed: int, kind: str) -> Pair:
    if kind == "cusps":
        way = edges.three_point_turn()
        return make("Path", way.xy.tolist(), speed=way.speed.tolist())
    rng = random.Random(seed)
    closed = kind == "closed"
    xy = closed_spline(seed, 80, 25.0) if closed else random_course(seed, 80)
    speed = [rng.uniform(0.0, 15.0) for _ in xy] if rng.random() < 0.5 else None
    return make("Path", xy.tolist(), speed=speed, closed=closed)


def _shifted(path: Pair) -> Pair:
    """The same path a metre to the side, without its last waypoint."""
    own = path.rust
    xy = [(float(x) + 1.0, float(y)) for x, y in zip(own.x[:-1], own.y[:-1], strict=True)]
    speed = None if own.speed is None else own.speed[:-1].tolist()
    return make("Path", xy, speed=speed, closed=own.closed)


def _drive(pair: Pair, path: Pair, rng: random.Random, steps: int) -> None:
    """Go along the path as the commands say, with noise, and off it."""
    along, speed = 0.0, rng.uniform(0.0, 6.0)
    x, y, s = path.rust.x, path.rust.y, path.rust.s
    saved = pair.get("state")
    for k in range(steps):
        if k == steps // 3:
            saved = pair.get("state")
        elif k == steps // 2:
            assert pair.set_state(saved)
        elif k == 2 * steps // 3:
            # The same path sent anew; and one that is shifted, and back.
            pair.call("set_path", path)
            pair.get("plan")
            pair.call("set_path", _shifted(path))
            pair.call("step", float(x[0]), float(y[0]), 0.0, speed, 0.05)
            pair.call("set_path", path)
        elif k == steps - 9:
            pair.call("reset")
        index = min(int((s <= along).sum()), len(x) - 1)
        yaw = math.atan2(y[index] - y[index - 1], x[index] - x[index - 1])
        share = along - float(s[index - 1])
        pose = (
            float(x[index - 1]) + share * math.cos(yaw) + rng.gauss(0.0, 0.05),
            float(y[index - 1]) + share * math.sin(yaw) + rng.gauss(0.0, 0.05),
            yaw + rng.gauss(0.0, 0.02),
        )
        dt = rng.uniform(0.01, 0.1)
        command = pair.call("step", *pose, speed, dt)
        assert command is not None
        assert math.isfinite(command.rust.acceleration)
        assert command.rust.reference_speed >= 0.0
        speed = max(speed + dt * (command.rust.acceleration + rng.gauss(0.0, 0.3)), 0.0)
        along += dt * max(speed, 0.2)
        if rng.random() < 0.03:
            assert pair.call("step", *pose, inf, dt) is None
        pair.get("state")


@pytest.mark.covers(
    *("SpeedTracker", "SpeedTracker.step", "SpeedTracker.state", "SpeedTracker.plan"),
    *("SpeedTracker.path", "SpeedTracker.vehicle", "SpeedTracker.params", "SpeedTracker.reset"),
    *("SpeedCommand.acceleration", "SpeedTracker.set_path"),
)
@given(
    params=SPEED_TRACKER.params(),
    car=CARS,
    seed=SEEDS,
    kind=st.sampled_from(["open", "closed", "cusps"]),
)
def test_speed_tracker_matches_reference_random(
    params: dict[str, Any], car: dict[str, Any], seed: int, kind: str
) -> None:
    path = _path(seed, kind)
    made = make("SpeedTrackerParams", **params)
    pair = make("SpeedTracker", path, make("Vehicle", **car), made)
    for attribute in ("plan", "params", "vehicle"):
        pair.get(attribute)
    _drive(pair, path, random.Random(seed), 12)


@pytest.mark.covers("SpeedTracker.step", "SpeedTracker.state", "SpeedTracker.reset")
@long_drives()
@given(params=SPEED_TRACKER.params(), car=CARS, seed=SEEDS)
def test_speed_tracker_matches_reference_rollout(
    params: dict[str, Any], car: dict[str, Any], seed: int
) -> None:
    rng = random.Random(seed)
    path = _path(seed, rng.choice(["open", "closed", "cusps"]))
    pair = make("SpeedTracker", path, make("Vehicle", **car), make("SpeedTrackerParams", **params))
    _drive(pair, path, rng, 200)


@pytest.mark.covers("SpeedTracker", "SpeedTrackerParams", "SpeedTracker.step")
def test_speed_tracker_matches_reference_edges() -> None:
    check_params(SPEED_TRACKER)
    path = make("Path", [(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)])
    pair = make("SpeedTracker", path)
    usual = (1.0, 0.1, 0.0, 3.0, 0.05)
    for _ in range(2):
        before = pair.get("state")
        for place, bad in ((0, 1e9), (1, 1e9), (2, 1e6), (3, 1e4)):
            for value in (nan, inf, -inf, nextafter(bad, inf), None):
                given: list[Any] = list(usual)
                given[place] = value
                assert pair.call("step", *given) is None
        for dt in (nan, inf, 0.0, -0.05, nextafter(1e3, inf), None):
            assert pair.call("step", 1.0, 0.1, 0.0, 3.0, dt) is None
        assert pair.get("state").rust == before.rust
        assert pair.call("step", *usual) is not None
    for speed in (0.0, -0.0, -3.0, 1e4, 5):
        for x in (-50.0, 0.0, 19.99, 20.0, 25.0, 1e9):
            assert pair.call("step", x, 0.0, 0.0, speed, 0.05) is not None


@pytest.mark.covers("SpeedTrackerState", "SpeedTracker.state")
def test_speed_tracker_state_matches_reference_edges() -> None:
    pair = make("SpeedTracker", make("Path", [(0.0, 0.0), (10.0, 0.0)]))
    pair.call("step", 1.0, 0.1, 0.0, 3.0, 0.05)
    refused: list[dict[str, Any]] = [
        *({"integral": value} for value in (nan, inf, -1.5, nextafter(1.0, 2.0))),
        *({"acceleration": value} for value in (nan, -inf, nextafter(1e4, inf))),
        {"waypoint": 2},
        {"waypoint": 2, "integral": nan},
    ]
    for fields in refused:
        before = pair.get("state")
        assert not pair.set_state(make("SpeedTrackerState", **fields))
        assert pair.get("state").rust == before.rust
    for fields in ({}, {"waypoint": 1}, {"acceleration": -3.0, "integral": 1.0}):
        assert pair.set_state(make("SpeedTrackerState", **fields))
        pair.call("step", 3.0, 0.0, 0.0, 4.0, 0.05)
        pair.get("state")
