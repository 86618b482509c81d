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
from tests.parity.checks import BAD_STEPS, adapting
from tests.parity.laws import LATERAL, PID, POP, Law
from tests.parity.strategies import (
    ADAPTS,
    CALM_VEHICLES,
    SPOTS,
    VEHICLES,
    Shape,
    Spot,
    Waypoints,
    fitted,
    shapes,
)

EPSILON = sys.float_info.epsilon
PATHS = shapes()
RUNS = st.lists(SPOTS, min_size=1, max_size=8)
CARS = CALM_VEHICLES | VEHICLES
# Such as command what the law wants, within the largest angle, whatever they are else.
UNLIMITED: dict[str, Any] = {
    "max_steer_rate": None,
    "max_lateral_acceleration": None,
    "steer_offset": 0.0,
    "steers_at_rest": False,
}

each_law = pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)


def _controller(
    law: Law,
    path: Waypoints,
    params: dict[str, Any],
    vehicle: dict[str, Any],
    adapt: Any = "auto",
) -> Any:
    # The Rust core has no need of a coarse grid, but a fine one over 1e6 m has many points.
    if law.searches:
        params = fitted(params, path, 100_000, vehicle.get("wheelbase", 3.0))
    made = popsteer.Path(path.xy, speed=path.speed, closed=path.closed, mend=False)
    tuning = getattr(popsteer, law.params_name)(**params)
    given = adapting(adapt)
    return getattr(popsteer, law.name)(made, popsteer.Vehicle(**vehicle), tuning, **given)


def _limits_reached(controller: Any, before: float, speed: float, dt: float) -> list[float]:
    """How near to each limit of the vehicle the command is: 0 where it is there."""
    car, state = controller.vehicle, controller.state
    steer, estimate = state.steer, state.estimator.estimate
    wheel = popsteer.paper.saturate(
        steer + (car.steer_offset + estimate.steer_offset), -car.max_steer, car.max_steer
    )
    left = [car.max_steer - abs(steer), car.max_steer - abs(wheel)]
    if car.max_steer_rate is not None:
        left.append(car.max_steer_rate * dt - abs(steer - before))
    if car.max_lateral_acceleration is not None:
        length = car.turning_length(speed)
        monitor = None if controller.adapt else state.monitor
        gain = estimate.gain if monitor is None else monitor.gain.mean[0]
        # Preview POP plans for the gain that is estimated or given; what is commanded keeps the
        # one that is measured.
        for each in (estimate.gain, gain):
            most = math.atan2(car.max_lateral_acceleration * length, speed * speed * each)
            left.append(most - abs(wheel))
    return left


@each_law
@given(shape=PATHS, spots=RUNS, vehicle=CARS, adapt=ADAPTS, data=st.data())
def test_law_any_input_answers_finite_within_its_limits(
    law: Law,
    shape: Shape,
    spots: list[Spot],
    vehicle: dict[str, Any],
    adapt: Any,
    data: st.DataObject,
) -> None:
    path = shape.build()
    controller = _controller(law, path, data.draw(law.params()), vehicle, adapt)
    car = controller.vehicle
    for spot in spots:
        before = controller.state.steer
        command = controller.step(*spot.at(path))
        errors = (command.cross_track_error, command.heading_error)
        predicted = (command.predicted_cross_track_error, command.predicted_heading_error)
        assert all(map(math.isfinite, (command.steer, *errors, *predicted, *command.target)))
        assert abs(command.steer) <= car.max_steer
        assert abs(command.heading_error) <= math.pi
        assert abs(command.predicted_heading_error) <= math.pi
        state = controller.state
        # A dead time that nobody told may be found.
        longer = state.estimator.estimate.longer_dead_time
        is_predicted = state.in_flight is not None and car.dead_time + longer > 0.0
        if not is_predicted:
            assert predicted == errors
        assert 0 <= state.place.segment < len(path.xy)
        assert not state.place.lost
        _check_limits(controller, before, spot, command)


def _believed(state: Any, spot: Spot) -> float:
    """Give what is believed of a speed: one message alone, as far as the brakes reach."""
    speed: float = spot.speed if state.gate is None else state.gate.believed.speed
    return speed


def _check_limits(controller: Any, before: float, spot: Spot, command: popsteer.Command) -> None:
    """Rate and lateral acceleration are kept, and a limit is reached where one is said to be."""
    car, state = controller.vehicle, controller.state
    if car.max_steer_rate is not None:
        rounding = EPSILON * max(abs(before), abs(command.steer))
        most = car.max_steer_rate * spot.dt
        assert abs(command.steer - before) <= most * (1.0 + EPSILON) + rounding
    bare = all(getattr(car, name) == value for name, value in UNLIMITED.items())
    saturated = popsteer.Status.SATURATED in command.status
    offset = state.estimator.estimate.steer_offset
    if bare and not offset:
        if saturated:
            assert abs(command.steer) == car.max_steer
        return
    dead_time = car.dead_time + state.estimator.estimate.longer_dead_time
    if dead_time > 0.0 and car.max_lateral_acceleration is not None:
        # The speed that counts is the predicted one.
        return
    if state.estimator.estimate.speed_scale != 1.0:
        # The speed that counts is the scaled one.
        return
    left = _limits_reached(controller, before, _believed(state, spot), spot.dt)
    if saturated:
        assert min(map(abs, left)) <= 1e-9
    # Beyond the offset the wheels cannot be brought back, and their rate goes before.
    in_reach = abs(car.steer_offset + offset) <= car.max_steer
    if car.max_lateral_acceleration is not None and car.max_steer_rate is None and in_reach:
        assert left[-1] >= -1e-12


@each_law
@given(shape=PATHS, spots=RUNS, vehicle=CARS, adapt=ADAPTS, data=st.data())
def test_law_in_the_same_state_answers_the_same_twice(
    law: Law,
    shape: Shape,
    spots: list[Spot],
    vehicle: dict[str, Any],
    adapt: Any,
    data: st.DataObject,
) -> None:
    path = shape.build()
    params = data.draw(law.params())
    first, second = (_controller(law, path, params, vehicle, adapt) for _ in range(2))
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
@given(
    shape=PATHS,
    spot=SPOTS,
    bad=st.sampled_from(BAD_STEPS),
    vehicle=CARS,
    adapt=ADAPTS,
    data=st.data(),
)
def test_law_refused_input_leaves_the_state_untouched(
    *,
    law: Law,
    shape: Shape,
    spot: Spot,
    bad: tuple[int, float],
    vehicle: dict[str, Any],
    adapt: Any,
    data: st.DataObject,
) -> None:
    path = shape.build()
    controller = _controller(law, path, data.draw(law.params()), vehicle, adapt)
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


@given(shape=PATHS, params=POP.params(), vehicle=CARS, spots=RUNS)
def test_pop_any_step_turns_by_at_most_its_span(
    shape: Shape, params: dict[str, Any], vehicle: dict[str, Any], spots: list[Spot]
) -> None:
    path = shape.build()
    pop = _controller(POP, path, params, {**vehicle, **UNLIMITED}, adapt=None)
    span = pop.params.steer_span
    for spot in spots:
        previous = pop.state.law.previous_steer
        steer = pop.steer(*spot.at(path))
        # The sum of angle and offset is rounded once, the difference taken here once more.
        rounding = EPSILON * max(abs(previous), abs(steer), span)
        assert abs(steer - previous) <= span + rounding
        assert pop.state.law.previous_steer == steer


@given(
    shape=PATHS,
    params=POP.params(),
    vehicle=CARS,
    spot=SPOTS,
    speed=st.one_of(st.sampled_from([0.0, -0.0]), st.floats(-1e4, 0.0)),
    previous=st.floats(-1.0, 1.0),
)
def test_pop_at_rest_or_rolling_back_keeps_its_angle(
    *,
    shape: Shape,
    params: dict[str, Any],
    vehicle: dict[str, Any],
    spot: Spot,
    speed: float,
    previous: float,
) -> None:
    path = shape.build()
    pop = _controller(POP, path, params, {**vehicle, **UNLIMITED}, adapt=None)
    x, y, yaw, _, dt = spot.at(path)
    angle = previous * pop.vehicle.max_steer
    state = pop.state
    pop.state = state.replace(steer=angle, law=state.law.replace(previous_steer=angle))
    for _ in range(3):
        assert pop.steer(x, y, yaw, speed, dt) == angle


@given(
    shape=PATHS,
    params=PID.params(),
    vehicle=CARS,
    spots=st.lists(SPOTS, min_size=1, max_size=40),
)
def test_pid_integral_is_bounded_by_its_buffer(
    shape: Shape, params: dict[str, Any], vehicle: dict[str, Any], spots: list[Spot]
) -> None:
    path = shape.build()
    length = {"buffer_length": min(params.get("buffer_length", 5), 20)}
    # Not adapting, it expects the speed to stay.
    pid = _controller(PID, path, {**params, **length}, vehicle, adapt=None)
    largest = 0.0
    summed = 0
    car = pid.vehicle
    is_bare = pid.state.in_flight is None and all(
        getattr(car, name) == value for name, value in UNLIMITED.items()
    )
    # Slower than this it stands.
    rest = 0.0 if is_bare else 0.02 * car.wheelbase
    for taken, spot in enumerate(spots, start=1):
        command = pid.step(*spot.at(path))
        # The buffer is emptied where the vehicle was lost, and sums nothing at rest.
        lost = popsteer.Status.OFF_PATH in command.status
        speed = _believed(pid.state, spot)
        summed = (0 if lost else summed) + (speed > 0.0 and speed >= rest)
        weight = spot.dt if pid.params.integral_with_dt else 1.0
        largest = max(largest, abs(command.predicted_cross_track_error * weight))
        buffer = pid.state.law.buffer
        assert len(buffer.terms) == min(summed, pid.params.buffer_length)
        assert all(abs(term) <= largest for term in buffer.terms)
        # Each of the additions since the sum was last taken anew may have rounded.
        rounding = 2 * taken * EPSILON * largest * len(buffer.terms)
        assert abs(buffer.sum) <= len(buffer.terms) * largest + rounding
        assert abs(buffer.sum - math.fsum(buffer.terms)) <= 4 * rounding
