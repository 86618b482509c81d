"""Plain functions and the vehicle of the core and of the reference."""

from __future__ import annotations

import math
from math import inf, nan, nextafter
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.parity.checks import check_ranges
from tests.parity.compare import call, make
from tests.parity.strategies import DTS, SPEEDS, VEHICLE_OPTIONAL, VEHICLE_RANGES, VEHICLES

ANGLES = st.one_of(
    st.floats(-10.0, 10.0),
    st.floats(-1e6, 1e6),
    # Whole and half turns, to within rounding.
    st.builds(
        lambda halves, nudge: halves * math.pi + nudge,
        st.integers(-300_000, 300_000),
        st.sampled_from([0.0, 1e-15, -1e-15]),
    ),
)
COORDINATES = st.one_of(
    st.floats(-1e3, 1e3), st.floats(-1e9, 1e9), st.sampled_from([0.0, -0.0, 1e9, -1e9])
)
POINTS = st.tuples(COORDINATES, COORDINATES)
STEERS = st.one_of(st.floats(-1.6, 1.6), st.floats(-math.pi, math.pi))
CHANGES = st.one_of(st.floats(-5.0, 5.0), st.floats(-1e6, 1e6))

GOOD_MOTION = (1.0, 2.0, 0.5, 10.0, 0.1)
BEYOND = {
    "x": math.nextafter(1e9, inf),
    "y": -math.nextafter(1e9, inf),
    "yaw": math.nextafter(1e6, inf),
    "speed": -math.nextafter(1e4, inf),
    "steer": math.nextafter(math.pi, inf),
}


@given(angle=ANGLES)
def test_wrap_matches_reference_random(angle: float) -> None:
    call("wrap", angle)


def test_wrap_matches_reference_edges() -> None:
    for angle in (0.0, -0.0, math.pi, -math.pi, math.tau, 1e6, -1e6, 5e-324, 3, -7):
        for nudged in (angle, math.nextafter(angle, inf), math.nextafter(angle, -inf)):
            assert call("wrap", angle) is not None
            call("wrap", nudged)
    for refused in (nan, inf, -inf, math.nextafter(1e6, inf), None):
        assert call("wrap", refused) is None
    assert call("wrap") is None


@given(value=st.floats(), ends=st.tuples(st.floats(), st.floats()))
def test_saturate_matches_reference_random(value: float, ends: tuple[float, float]) -> None:
    call("saturate", value, *ends)


@given(a=POINTS, b=POINTS)
def test_get_distance_matches_reference_random(
    a: tuple[float, float], b: tuple[float, float]
) -> None:
    call("get_distance", a, b)
    call("get_distance", a, a)


def test_get_distance_matches_reference_edges() -> None:
    good = (1.0, -2.0)
    for value in (nan, inf, -inf, math.nextafter(1e9, inf), None):
        for bad in ((value, 1.0), (1.0, value)):
            assert call("get_distance", bad, good) is None
            assert call("get_distance", good, bad) is None
    assert call("get_distance", good) is None
    assert call("get_distance", (3, 4), (0, 0)) is not None
    assert call("get_distance", (nan, nan), (nan, nan)) is None


@given(point=POINTS, yaw=ANGLES, speed=SPEEDS, steer=STEERS, dt=DTS)
def test_get_predicted_location_matches_reference_random(
    point: tuple[float, float], yaw: float, speed: float, steer: float, dt: float
) -> None:
    call("get_predicted_location", *point, yaw, speed, steer, dt)


@given(
    point=POINTS,
    yaw=ANGLES,
    speed=SPEEDS,
    rates=st.tuples(CHANGES, CHANGES, CHANGES),
    steer=STEERS,
    dt=DTS,
)
def test_state_transition_matches_reference_random(
    point: tuple[float, float],
    yaw: float,
    speed: float,
    rates: tuple[float, float, float],
    steer: float,
    dt: float,
) -> None:
    call("state_transition", (*point, yaw, speed, rates[0]), rates[1:], steer, dt)


@pytest.mark.parametrize("zero", [0.0, -0.0])
def test_state_transition_of_zeros_matches_reference_cases(zero: float) -> None:
    # The sign of a zero tells in which order products were added, and to what.
    call("state_transition", (zero,) * 5, (zero, zero), zero, 0.5)
    call("state_transition", (zero,) * 5, (-zero, -zero), -zero, 0.5)


@given(
    point=POINTS,
    yaw=ANGLES,
    speed=SPEEDS,
    steer=STEERS,
    acceleration=CHANGES,
    wheelbase=st.floats(1e-3, 1e3),
    dt=DTS,
)
def test_kinematic_bicycle_matches_reference_random(
    point: tuple[float, float],
    yaw: float,
    speed: float,
    steer: float,
    acceleration: float,
    wheelbase: float,
    dt: float,
) -> None:
    call("kinematic_bicycle", *point, yaw, speed, steer, acceleration, wheelbase, dt)


def test_motion_matches_reference_edges() -> None:
    good = dict(zip(("x", "y", "yaw", "speed", "steer"), GOOD_MOTION, strict=True))
    cases = [{name: value} for name in good for value in (nan, inf, -inf, BEYOND[name])]
    for dt in (nan, inf, 0.0, -0.05, math.nextafter(1e-6, 0.0), math.nextafter(1e3, inf)):
        _refuse(good, dt)
    for changes in [*cases, dict.fromkeys(good, nan)]:
        _refuse({**good, **changes}, 0.05)
    for rates in ((nan, 0.0, 0.0), (0.0, inf, 0.0), (0.0, 0.0, -1e7), (nan, nan, nan)):
        assert call("state_transition", (*GOOD_MOTION[:4], rates[0]), rates[1:], 0.1, 0.05) is None
    assert call("state_transition", GOOD_MOTION[:4], (0.0, 0.0), 0.1, 0.05) is None
    assert call("state_transition", GOOD_MOTION, (0.0,), 0.1, 0.05) is None
    for acceleration, wheelbase in ((nan, 3.0), (2e6, 3.0), (1.0, 0.0), (1.0, -3.0), (nan, nan)):
        assert call("kinematic_bicycle", *GOOD_MOTION, acceleration, wheelbase, 0.05) is None
    assert call("kinematic_bicycle", 1, 2, 0, 10, 0, 1, 3, 1) is not None


def _refuse(motion: dict[str, float], dt: float) -> None:
    x, y, yaw, speed, steer = motion.values()
    assert call("get_predicted_location", x, y, yaw, speed, steer, dt) is None
    assert call("state_transition", (x, y, yaw, speed, 0.1), (0.5, 0.1), steer, dt) is None
    assert call("kinematic_bicycle", x, y, yaw, speed, steer, 1.0, 3.0, dt) is None


def test_vehicle_matches_reference_edges() -> None:
    check_ranges("Vehicle", VEHICLE_RANGES, VEHICLE_OPTIONAL)
    car = make("Vehicle", understeer=0.01)
    for speed in (nan, inf, -inf, nextafter(1e4, inf), -nextafter(1e4, inf), 10**400, None):
        assert car.call("turning_length", speed) is None


@given(vehicle=VEHICLES, speed=SPEEDS)
def test_vehicle_matches_reference_random(vehicle: dict[str, Any], speed: float) -> None:
    car = make("Vehicle", **vehicle)
    car.get("front_axle")
    car.call("turning_length", speed)
