from __future__ import annotations

import math
import random
from math import inf, nan, nextafter
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from tests.parity.checks import HELD_DTS, check_params
from tests.parity.compare import make
from tests.parity.laws import COUPLED, SPEED_PID
from tests.parity.strategies import DTS, SEEDS, SPEEDS

BAD_SPEEDS = (nan, inf, -inf, nextafter(1e4, inf), -nextafter(1e4, inf), None)
BAD_DTS = (nan, inf, -inf, None)


@given(
    params=COUPLED.params(),
    inputs=st.lists(st.tuples(SPEEDS, st.floats(-math.pi, math.pi)), min_size=1, max_size=20),
)
def test_coupled_longitudinal_matches_reference_random(
    params: dict[str, Any], inputs: list[tuple[float, float]]
) -> None:
    pair = make("CoupledLongitudinal", make("CoupledLongitudinalParams", **params))
    pair.get("params")
    for speed, steer in inputs:
        pair.call("step", speed, steer)


def test_coupled_longitudinal_matches_reference_edges() -> None:
    check_params(COUPLED)
    pair = make("CoupledLongitudinal")
    for speed in BAD_SPEEDS:
        assert pair.call("step", speed, 0.1) is None
        assert pair.call("step", speed, nan if speed is not None else None) is None
    for steer in (nan, inf, -inf, nextafter(math.pi, 4.0), -nextafter(math.pi, 4.0), None):
        assert pair.call("step", 1.0, steer) is None
    for speed in (0.0, -0.0, 69.44, 4.0 * 69.44, 1e4, -1e4, 5):
        for steer in (0.0, -0.0, 1.22, -1.22, math.pi, -math.pi):
            assert pair.call("step", speed, steer) is not None


@given(
    params=SPEED_PID.params(),
    inputs=st.lists(st.tuples(SPEEDS, SPEEDS, DTS), min_size=1, max_size=20),
)
def test_speed_pid_matches_reference_random(
    params: dict[str, Any], inputs: list[tuple[float, float, float]]
) -> None:
    pair = make("SpeedPid", make("SpeedPidParams", **params))
    pair.get("params")
    for speed, target, dt in inputs:
        pair.call("step", speed, target, dt)
        pair.get("state")


@given(params=SPEED_PID.params(), seed=SEEDS, steps=st.integers(200, 300))
def test_speed_pid_matches_reference_rollout(params: dict[str, Any], seed: int, steps: int) -> None:
    rng = random.Random(seed)
    pair = make("SpeedPid", make("SpeedPidParams", **params))
    speed = 0.0
    for k in range(steps):
        if k == steps - 20:
            pair.call("reset")
        dt = rng.uniform(0.001, 0.2)
        pedals = pair.call("step", speed, 20.0 + 15.0 * math.sin(0.05 * k), dt)
        assert pedals is not None
        throttle, brake = pedals.rust
        speed += (6.0 * throttle - 8.0 * brake - 0.1 * speed + rng.gauss(0.0, 0.5)) * dt
        if rng.random() < 0.05:
            assert pair.call("step", speed, inf, dt) is None
        pair.get("state")


def test_speed_pid_matches_reference_edges() -> None:
    check_params(SPEED_PID)
    pair = make("SpeedPid")
    for _ in range(2):
        before = pair.get("state")
        for speed in BAD_SPEEDS:
            assert pair.call("step", speed, 1.0, 0.05) is None
            assert pair.call("step", 1.0, speed, 0.05) is None
        for dt in BAD_DTS:
            assert pair.call("step", 1.0, 2.0, dt) is None
        for dt in HELD_DTS:
            assert pair.call("step", 1.0, 2.0, dt) is not None
        assert pair.call("step", nan, nan, nan) is None
        assert pair.call("step", 1.0, nan, nan) is None
        assert pair.call("step", 1.0, 2.0) is None
        assert pair.get("state").rust == before.rust
        assert pair.call("step", 1.0, 20.0, 0.05) is not None
