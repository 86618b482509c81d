"""The functions of the paper by their equations; the vehicle of the core and of the reference."""

from __future__ import annotations

import math
from fractions import Fraction
from math import inf, nan, nextafter
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from popsteer import InputError, paper
from tests.parity.checks import check_ranges
from tests.parity.compare import bits, make
from tests.parity.strategies import DTS, SPEEDS, VEHICLE_OPTIONAL, VEHICLE_RANGES, VEHICLES

if TYPE_CHECKING:
    from collections.abc import Callable

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
NO_POINTS = ("12", ("1", "2"), b"12", bytearray(b"12"), {1.0, 2.0}, {1.0: 0, 2.0: 0})


@given(angle=ANGLES)
def test_wrap_turns_by_whole_turns_random(angle: float) -> None:
    check_wrap(angle)


def check_wrap(angle: float) -> None:
    """Check that an angle is turned by whole turns, exactly, and only where it has to be."""
    turned = paper.wrap(angle)
    assert type(turned) is float
    assert abs(turned) <= math.pi
    if abs(angle) <= math.pi:
        assert bits(turned) == bits(float(angle))
    # In fractions, without any rounding.
    assert (Fraction(angle) - Fraction(turned)) % Fraction(math.tau) == 0
    assert bits(paper.wrap(-angle)) == bits(-turned)
    assert bits(paper.wrap(turned)) == bits(turned)


def test_wrap_edges() -> None:
    for angle in (0.0, -0.0, math.pi, -math.pi, math.tau, 1e6, -1e6, 5e-324, 3, -7):
        check_wrap(angle)
        for nudged in (math.nextafter(angle, inf), math.nextafter(angle, -inf)):
            if abs(nudged) <= 1e6:
                check_wrap(nudged)
            else:
                refused("angle", paper.wrap, nudged)
    for beyond in (nan, inf, -inf, math.nextafter(1e6, inf), 10**400):
        refused("angle", paper.wrap, beyond)
    refused_as(TypeError, paper.wrap)
    for wrong in (None, "1", b"1", 1j, [1.0]):
        refused_as(TypeError, paper.wrap, wrong)


def refused(field: str, function: Callable[..., Any], *args: Any) -> None:
    """Check that a number is refused by its name."""
    with pytest.raises(InputError, match=rf"^{field} must be in \[.+\], got ") as raised:
        function(*args)
    assert raised.value.field == field


def refused_as(kind: type[Exception], function: Callable[..., Any], *args: Any) -> None:
    """Check that what are no such numbers at all is refused by an error of Python's own."""
    with pytest.raises(kind):
        function(*args)


@given(value=st.floats(), ends=st.tuples(st.floats(), st.floats()))
def test_saturate_random(value: float, ends: tuple[float, float]) -> None:
    low, high = ends
    limited = bits(paper.saturate(value, low, high))
    if value < low:
        assert limited == bits(low)
    elif value > high:
        assert limited == bits(high)
    else:
        assert limited == bits(value)


def test_saturate_edges() -> None:
    assert bits(paper.saturate(3, -1, 2)) == bits(2.0)
    assert bits(paper.saturate(-0.0, 0.0, 1.0)) == bits(-0.0)
    assert math.isnan(paper.saturate(nan, -1.0, 1.0))
    for wrong in (None, "1", b"1"):
        for args in ((wrong, 0.0, 1.0), (0.5, wrong, 1.0), (0.5, 0.0, wrong)):
            refused_as(TypeError, paper.saturate, *args)


@given(a=POINTS, b=POINTS)
def test_get_distance_is_equation_4_random(a: tuple[float, float], b: tuple[float, float]) -> None:
    distance = paper.get_distance(a, b)
    dx, dy = b[0] - a[0], b[1] - a[1]
    assert bits(distance) == bits(math.sqrt(dx * dx + dy * dy))
    assert bits(paper.get_distance(b, a)) == bits(distance)
    assert distance == pytest.approx(math.dist(a, b), rel=1e-15, abs=1e-150)
    assert bits(paper.get_distance(a, a)) == bits(0.0)


def test_get_distance_edges() -> None:
    good = (1.0, -2.0)
    for value in (nan, inf, -inf, math.nextafter(1e9, inf), 10**400):
        for field, bad in (("x", (value, 1.0)), ("y", (1.0, value))):
            refused(field, paper.get_distance, bad, good)
            refused(field, paper.get_distance, good, bad)
    refused("x", paper.get_distance, (nan, nan), (nan, nan))
    refused_as(TypeError, paper.get_distance, good)
    for wrong in (None, 3.0, (None, 1.0), (1.0, None), *NO_POINTS):
        refused_as(TypeError, paper.get_distance, wrong, good)
        refused_as(TypeError, paper.get_distance, good, wrong)
    for shape in ((), (1.0,), [1.0, 2.0, 3.0], np.zeros(3)):
        refused_as(ValueError, paper.get_distance, shape, good)
    assert bits(paper.get_distance((3, 4), (0, 0))) == bits(5.0)


def test_functions_take_lists_and_arrays() -> None:
    for kind in (list, np.array):
        assert bits(paper.get_distance(kind([0.0, 0.0]), kind([3.0, 4.0]))) == bits(5.0)
        moved = paper.state_transition(kind([*GOOD_MOTION[:4], 0.1]), kind([0.5, 0.1]), 0.1, 0.05)
        plain = paper.state_transition((*GOOD_MOTION[:4], 0.1), (0.5, 0.1), 0.1, 0.05)
        assert bits(moved) == bits(plain)
        assert {type(number) for number in moved} == {float}
    state, control = (*GOOD_MOTION[:4], 0.1), (0.5, 0.1)
    for wrong in (None, 3.0, *NO_POINTS):
        refused_as(TypeError, paper.state_transition, state, wrong, 0.1, 0.05)
    for wrong in (None, 3.0, "12345", b"12345", {1.0, 2.0, 3.0, 4.0, 5.0}):
        refused_as(TypeError, paper.state_transition, wrong, control, 0.1, 0.05)


@given(point=POINTS, yaw=ANGLES, speed=SPEEDS, steer=STEERS, dt=DTS)
def test_get_predicted_location_is_equation_6_random(
    point: tuple[float, float], yaw: float, speed: float, steer: float, dt: float
) -> None:
    heading = yaw + steer
    expected = (
        point[0] + math.cos(heading) * dt * speed,
        point[1] + math.sin(heading) * dt * speed,
    )
    assert bits(paper.get_predicted_location(*point, yaw, speed, steer, dt)) == bits(expected)


@given(
    point=POINTS,
    yaw=ANGLES,
    speed=SPEEDS,
    rates=st.tuples(CHANGES, CHANGES, CHANGES),
    steer=STEERS,
    dt=DTS,
)
def test_state_transition_is_equation_6_random(
    point: tuple[float, float],
    yaw: float,
    speed: float,
    rates: tuple[float, float, float],
    steer: float,
    dt: float,
) -> None:
    yaw_rate, longitudinal, lateral = rates
    moved = paper.state_transition((*point, yaw, speed, yaw_rate), rates[1:], steer, dt)
    expected = (
        *paper.get_predicted_location(*point, yaw, speed, steer, dt),
        yaw + dt * yaw_rate,
        speed + longitudinal,
        yaw_rate + lateral,
    )
    # Bit for bit but for the sign of a zero, which the zeros of the matrices decide.
    assert moved == expected
    assert {type(number) for number in moved} == {float}


@pytest.mark.parametrize("zero", [0.0, -0.0])
def test_state_transition_of_zeros_cases(zero: float) -> None:
    # The sign of a zero tells in which order products were added, and to what: with all negative,
    # the row of y alone has a positive one, sin(-0.0) dt times -0.0.
    moved = paper.state_transition((zero,) * 5, (zero, zero), zero, 0.5)
    assert bits(moved) == bits((zero, 0.0, zero, zero, zero))
    moved = paper.state_transition((zero,) * 5, (-zero, -zero), -zero, 0.5)
    assert bits(moved) == bits((0.0,) * 5)


@given(
    point=POINTS,
    yaw=ANGLES,
    speed=SPEEDS,
    steer=STEERS,
    acceleration=CHANGES,
    wheelbase=st.floats(1e-3, 1e3),
    dt=DTS,
)
def test_kinematic_bicycle_random(
    point: tuple[float, float],
    yaw: float,
    speed: float,
    steer: float,
    acceleration: float,
    wheelbase: float,
    dt: float,
) -> None:
    moved = paper.kinematic_bicycle(*point, yaw, speed, steer, acceleration, wheelbase, dt)
    travel = speed * dt
    turn = travel * math.tan(steer) / wheelbase
    middle = yaw + 0.5 * turn
    expected = (
        point[0] + travel * math.cos(middle),
        point[1] + travel * math.sin(middle),
        yaw + turn,
        speed + acceleration * dt,
    )
    assert bits(moved) == bits(expected)


def test_motion_edges() -> None:
    good = dict(zip(("x", "y", "yaw", "speed", "steer"), GOOD_MOTION, strict=True))
    for dt in (nan, inf, 0.0, -0.05, math.nextafter(1e-6, 0.0), math.nextafter(1e3, inf)):
        _refuse("dt", good, dt)
    for name in good:
        for value in (nan, inf, -inf, BEYOND[name], 10**400):
            _refuse(name, {**good, name: value}, 0.05)
    _refuse("x", dict.fromkeys(good, nan), 0.05)
    state, control = (*GOOD_MOTION[:4], 0.1), (0.5, 0.1)
    for field, rates in (
        ("yaw_rate", (nan, 0.0, 0.0)),
        ("longitudinal", (0.0, inf, 0.0)),
        ("lateral", (0.0, 0.0, -1e7)),
        ("yaw_rate", (nan, nan, nan)),
    ):
        refused(field, paper.state_transition, (*state[:4], rates[0]), rates[1:], 0.1, 0.05)
    refused_as(ValueError, paper.state_transition, state[:4], control, 0.1, 0.05)
    refused_as(ValueError, paper.state_transition, state, (0.0,), 0.1, 0.05)
    for field, acceleration, wheelbase in (
        ("acceleration", nan, 3.0),
        ("acceleration", 2e6, 3.0),
        ("wheelbase", 1.0, 0.0),
        ("wheelbase", 1.0, -3.0),
        ("acceleration", nan, nan),
    ):
        refused(field, paper.kinematic_bicycle, *GOOD_MOTION, acceleration, wheelbase, 0.05)
    moved = paper.kinematic_bicycle(1, 2, 0, 10, 0, 1, 3, 1)
    assert bits(moved) == bits((11.0, 2.0, 0.0, 11.0))


def _refuse(field: str, motion: dict[str, float], dt: float) -> None:
    x, y, yaw, speed, steer = motion.values()
    refused(field, paper.get_predicted_location, x, y, yaw, speed, steer, dt)
    refused(field, paper.state_transition, (x, y, yaw, speed, 0.1), (0.5, 0.1), steer, dt)
    refused(field, paper.kinematic_bicycle, x, y, yaw, speed, steer, 1.0, 3.0, dt)


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
