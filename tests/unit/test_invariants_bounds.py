"""What every law holds at every step: limits, finite answers, and a state that is all it knows."""

from __future__ import annotations

import math
import pickle
import sys
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import popsteer
from popsteer import InputError
from tests.parity.checks import BAD_STEPS
from tests.parity.laws import LATERAL, PID, POP, PREVIEW_POP, Law
from tests.parity.strategies import SPOTS, Shape, Spot, Waypoints, fitted, shapes

EPSILON = sys.float_info.epsilon
PATHS = shapes()
RUNS = st.lists(SPOTS, min_size=1, max_size=8)

each_law = pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)


def _controller(law: Law, path: Waypoints, params: dict[str, Any]) -> Any:
    # The Rust core has no need of a coarse grid, but a fine one over 1e6 m has many points.
    params = fitted(params, path, 100_000) if law.searches else params
    made = popsteer.Path(path.xy, speed=path.speed, closed=path.closed)
    return getattr(popsteer, law.name)(made, getattr(popsteer, law.params_name)(**params))


@each_law
@given(shape=PATHS, spots=RUNS, data=st.data())
def test_law_any_input_answers_finite_within_its_limits(
    law: Law, shape: Shape, spots: list[Spot], data: st.DataObject
) -> None:
    path = shape.build()
    controller = _controller(law, path, data.draw(law.params()))
    max_steer = controller.params.max_steer
    for spot in spots:
        command = controller.step(*spot.at(path))
        numbers = (command.steer, command.cross_track_error, command.heading_error)
        assert all(map(math.isfinite, (*numbers, *command.target)))
        assert abs(command.steer) <= max_steer
        assert abs(command.heading_error) <= math.pi
        # Preview POP is held back by the lateral acceleration too, at an angle below the limit.
        if command.status is popsteer.Status.SATURATED and law is not PREVIEW_POP:
            assert abs(command.steer) == max_steer
        assert 0 <= controller.state.waypoint < len(path.xy)


@each_law
@given(shape=PATHS, spots=RUNS, data=st.data())
def test_law_in_the_same_state_answers_the_same_twice(
    law: Law, shape: Shape, spots: list[Spot], data: st.DataObject
) -> None:
    path = shape.build()
    params = data.draw(law.params())
    first, second = _controller(law, path, params), _controller(law, path, params)
    fresh = first.state
    for k, spot in enumerate(spots):
        step = spot.at(path)
        before = first.state
        command = first.step(*step)
        after = first.state
        if k % 2:
            assert second.steer(*step) == command.steer
        else:
            assert second.step(*step) == command
        assert second.state == after
        # Once more, from the state as it was, restored by way of a file.
        first.state = pickle.loads(pickle.dumps(before))
        assert first.step(*step) == command
        assert first.state == after
    first.reset()
    assert first.state == fresh


@each_law
@given(shape=PATHS, spot=SPOTS, bad=st.sampled_from(BAD_STEPS), data=st.data())
def test_law_refused_input_leaves_the_state_untouched(
    law: Law, shape: Shape, spot: Spot, bad: tuple[int, float], data: st.DataObject
) -> None:
    path = shape.build()
    controller = _controller(law, path, data.draw(law.params()))
    step = spot.at(path)
    argument, value = bad
    refused = (*step[:argument], value, *step[argument + 1 :])
    for _ in range(2):
        before = controller.state
        for take in (controller.step, controller.steer):
            with pytest.raises(InputError) as caught:
                take(*refused)
            assert caught.value.field == ("x", "y", "yaw", "speed", "dt")[argument]
            assert repr(caught.value.value) == repr(value)
        assert controller.state == before
        controller.step(*step)


@given(shape=PATHS, params=POP.params(), spots=RUNS)
def test_pop_any_step_turns_by_at_most_its_span(
    shape: Shape, params: dict[str, Any], spots: list[Spot]
) -> None:
    path = shape.build()
    pop = _controller(POP, path, params)
    span = pop.params.steer_span
    for spot in spots:
        previous = pop.state.previous_steer
        steer = pop.steer(*spot.at(path))
        # The sum of angle and offset is rounded once, the difference taken here once more.
        rounding = EPSILON * max(abs(previous), abs(steer), span)
        assert abs(steer - previous) <= span + rounding
        assert pop.state.previous_steer == steer


@given(
    shape=PATHS,
    params=POP.params(),
    spot=SPOTS,
    speed=st.one_of(st.sampled_from([0.0, -0.0]), st.floats(-1e4, 0.0)),
    previous=st.floats(-1.0, 1.0),
)
def test_pop_at_rest_or_rolling_back_keeps_its_angle(
    shape: Shape, params: dict[str, Any], spot: Spot, speed: float, previous: float
) -> None:
    path = shape.build()
    pop = _controller(POP, path, params)
    x, y, yaw, _, dt = spot.at(path)
    angle = previous * pop.params.max_steer
    pop.state = popsteer.PopState(previous_steer=angle)
    for _ in range(3):
        assert pop.steer(x, y, yaw, speed, dt) == angle


@given(shape=PATHS, params=PID.params(), spots=st.lists(SPOTS, min_size=1, max_size=40))
def test_pid_integral_is_bounded_by_its_buffer(
    shape: Shape, params: dict[str, Any], spots: list[Spot]
) -> None:
    path = shape.build()
    length = {"buffer_length": min(params.get("buffer_length", 5), 20)}
    pid = _controller(PID, path, {**params, **length})
    largest = 0.0
    summed = 0
    for taken, spot in enumerate(spots, start=1):
        command = pid.step(*spot.at(path))
        # The buffer is emptied where the vehicle was lost, and sums nothing at rest.
        summed = (0 if command.status is popsteer.Status.OFF_PATH else summed) + (spot.speed > 0.0)
        weight = spot.dt if pid.params.integral_with_dt else 1.0
        largest = max(largest, abs(command.cross_track_error * weight))
        state = pid.state
        assert len(state.terms) == min(summed, pid.params.buffer_length)
        assert all(abs(term) <= largest for term in state.terms)
        # Each of the additions since the sum was last taken anew may have rounded.
        rounding = 2 * taken * EPSILON * largest * len(state.terms)
        assert abs(state.sum) <= len(state.terms) * largest + rounding
        assert abs(state.sum - math.fsum(state.terms)) <= 4 * rounding
