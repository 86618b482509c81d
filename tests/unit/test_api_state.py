"""What the laws remember: shown, compared, saved, restored, refused."""

from __future__ import annotations

import copy
import math
import pickle
from typing import Any

import pytest

import popsteer
from popsteer import InputError
from tests.parity.laws import LATERAL, Law

PATH = popsteer.Path([(float(k), 0.1 * k) for k in range(30)])
STEP = (4.0, 1.0, 0.2, 6.0, 0.05)
TAIL: dict[str, Any] = {
    "waypoint": None,
    "measured_waypoint": None,
    "place": None,
    "steer": 0.0,
    "handover_offset": None,
    "handover_remaining": 0.0,
    "held": 0,
    "held_time": 0.0,
    "period": 0.0,
    "wheel": None,
    "commands_in_flight": (),
    "past_angles": (),
    "past_wheel": None,
    "past_since": 0.0,
    "last_measured": None,
    "turn_turn": 0.0,
    "turn_offset": 0.0,
    "offset_offset": 0.0,
    "turn_measured": 0.0,
    "offset_measured": 0.0,
    "turn": 0.0,
    "change": 0.0,
    "gain": 1.0,
    "steer_offset": 0.0,
    "longer_dead_time": 0.0,
    "slip": 0.0,
    "slip_length": 0.0,
    "acceleration": 0.0,
    "answer": None,
    "monitor": None,
}
FIRST: dict[str, dict[str, Any]] = {
    "Pop": {"previous_steer": 0.0, **TAIL},
    # Its wheels are modelled from the beginning.
    "PreviewPop": {"previous_steer": 0.0, "reached_limits": 0, **TAIL, "wheel": 0.0},
    "Pid": {
        "previous_error": None,
        "previous_position": None,
        "terms": (),
        "next": 0,
        "sum": 0.0,
        **TAIL,
    },
    "PurePursuit": {"previous_alpha": 0.0, **TAIL},
    "Stanley": TAIL,
}
DELAYED = popsteer.Vehicle(dead_time=0.2, steer_offset=0.01)

each_law = pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)


def _controller(law: Law, vehicle: popsteer.Vehicle | None = None) -> Any:
    return getattr(popsteer, law.name)(PATH, vehicle)


def _walked(law: Law, steps: int = 3, vehicle: popsteer.Vehicle | None = None) -> Any:
    controller = _controller(law, vehicle)
    for _ in range(steps):
        controller.step(*STEP)
    return controller


@each_law
def test_state_before_the_first_step_is_the_default(law: Law) -> None:
    first = _controller(law).state
    assert first.as_dict() == FIRST[law.name]
    assert first == getattr(popsteer, law.state_name)(wheel=first.wheel)


@each_law
def test_state_with_a_dead_time_begins_with_commands_in_flight(law: Law) -> None:
    first = _controller(law, DELAYED).state
    assert (first.wheel, first.commands_in_flight) == (0.01, ((0.0, 0.2),))
    walked = _walked(law, vehicle=DELAYED).state
    in_flight = sum(duration for _, duration in walked.commands_in_flight)
    assert in_flight == pytest.approx(0.2 + walked.longer_dead_time)
    assert walked.measured_waypoint in (4, 7)
    assert walked.last_measured == (4.0, 1.0, 0.2, 6.0)


@each_law
def test_state_made_without_wheels_has_them_at_rest_under_the_last_command(law: Law) -> None:
    controller = _controller(law, DELAYED)
    controller.state = getattr(popsteer, law.state_name)(steer=0.3)
    state = controller.state
    assert (state.steer, state.wheel) == (0.3, pytest.approx(0.31))
    assert state.commands_in_flight == ((0.3, 0.2),)


@each_law
@pytest.mark.parametrize("left", [0.0, -0.0])
def test_state_of_a_handover_that_is_over_has_none_left(law: Law, left: float) -> None:
    controller = _walked(law)
    controller.state = getattr(popsteer, law.state_name)(handover_remaining=left)
    state = controller.state
    assert (state.handover_offset, math.copysign(1.0, state.handover_remaining)) == (None, 1.0)


_REST = ((0.0, 0.0), False, (None, math.inf), (0.0, 0.0, 0.0, 1.0))
_MADE_UP: list[tuple[dict[str, Any], str]] = [
    ({"steer": 1.3}, "steer"),
    ({"handover_offset": 9.0, "handover_remaining": 0.5}, "handover_offset"),
    ({"handover_remaining": 1.5}, "handover_remaining"),
    ({"handover_remaining": math.nan}, "handover_remaining"),
    ({"measured_waypoint": 30}, "measured_waypoint"),
    ({"place": (math.nan, 0.0, 0.0, 0.0)}, "place"),
    ({"place": (0.0, 0.0, 0.0, 5e9)}, "place"),
    ({"held_time": -1.0}, "held_time"),
    ({"period": math.inf}, "period"),
    ({"wheel": 2.0, "commands_in_flight": ((0.0, 0.2),)}, "wheel"),
    ({"wheel": 0.0}, "commands_in_flight"),
    ({"wheel": 0.0, "commands_in_flight": ((0.0, 0.3),)}, "commands_in_flight"),
    ({"wheel": 0.0, "commands_in_flight": ((0.0, 0.001),) * 200}, "commands_in_flight"),
    ({"last_measured": (math.nan, 0.0, 0.0, 0.0)}, "last_measured"),
    ({"answer": ((math.inf, 0.0, 1.0, 0.0),) * 2 + _REST}, "answer"),
    ({"past_wheel": 2.0}, "past_wheel"),
    ({"past_wheel": 0.0, "past_angles": ((0.0, -1.0),)}, "past_angles"),
    ({"past_wheel": 0.0, "past_since": math.nan}, "past_since"),
    ({"gain": 3.0}, "gain"),
    ({"longer_dead_time": 0.15}, "longer_dead_time"),
    ({"turn_turn": -1.0}, "turn_turn"),
    ({"slip": math.inf}, "slip"),
]


@each_law
@pytest.mark.parametrize(("fields", "field"), _MADE_UP, ids=str)
def test_state_that_no_controller_could_have_is_refused_by_name(
    law: Law, fields: dict[str, Any], field: str
) -> None:
    controller = _walked(law, vehicle=DELAYED)
    before = controller.state
    with pytest.raises(InputError) as caught:
        controller.state = getattr(popsteer, law.state_name)(**fields)
    assert caught.value.field == field
    assert controller.state == before


@each_law
def test_state_after_a_step_is_another_and_shows_it(law: Law) -> None:
    controller = _controller(law)
    first = controller.state
    controller.step(*STEP)
    after = controller.state
    assert after != first
    # Reference points 0 to 3 m ahead of x = 4.
    assert after.waypoint in (4, 7)
    assert first.waypoint is first.answer is None
    (error, yaw, along_x, along_y), predicted, target, reverse, ahead, vehicle = after.answer
    assert ahead[0] is None
    assert ahead[1] > 0.0
    assert vehicle == STEP[:4]
    assert (yaw, predicted, reverse) == (0.2, after.answer[0], False)
    assert along_y / along_x == pytest.approx(0.1)
    assert error != 0.0
    assert len(target) == 2
    assert after.as_dict().keys() == FIRST[law.name].keys()
    for field, value in after.as_dict().items():
        assert getattr(after, field) == value


@each_law
def test_state_repr_evaluates_to_the_same(law: Law) -> None:
    state = _walked(law).state
    assert eval(repr(state), vars(popsteer)) == state


@each_law
@pytest.mark.parametrize("vehicle", [None, DELAYED])
@pytest.mark.parametrize(
    "duplicate",
    [
        copy.copy,
        copy.deepcopy,
        *(lambda s, n=n: pickle.loads(pickle.dumps(s, n)) for n in range(2, 6)),
    ],
)
def test_state_copied_or_pickled_goes_on_alike(law: Law, vehicle: Any, duplicate: Any) -> None:
    controller = _walked(law, vehicle=vehicle)
    saved = duplicate(controller.state)
    assert saved == controller.state
    other = _controller(law, vehicle)
    other.state = saved
    assert other.state == controller.state
    assert other.step(4.2, 1.1, 0.1, 5.0, 0.05) == controller.step(4.2, 1.1, 0.1, 5.0, 0.05)
    assert other.state == controller.state


@each_law
def test_state_is_frozen_and_a_copy(law: Law) -> None:
    controller = _walked(law)
    state = controller.state
    with pytest.raises(AttributeError):
        state.waypoint = 1
    with pytest.raises(TypeError):
        getattr(popsteer, law.state_name)(1)
    controller.step(20.0, 1.0, 0.2, 6.0, 0.05)
    assert controller.state != state


@each_law
def test_reset_forgets_every_step(law: Law) -> None:
    controller, fresh = _walked(law, 5), _controller(law)
    controller.reset()
    assert controller.state == fresh.state
    assert controller.step(*STEP) == fresh.step(*STEP)


@each_law
@pytest.mark.parametrize("waypoint", [30, 31, 10**9])
def test_state_with_a_waypoint_the_path_has_not_is_refused(law: Law, waypoint: int) -> None:
    controller = _walked(law)
    before = controller.state
    with pytest.raises(InputError, match="waypoint must be below 30") as caught:
        controller.state = getattr(popsteer, law.state_name)(waypoint=waypoint)
    assert (caught.value.field, caught.value.value) == ("waypoint", waypoint)
    assert controller.state == before


@each_law
def test_state_of_another_law_is_a_type_error(law: Law) -> None:
    controller = _walked(law)
    before = controller.state
    for state in (popsteer.SpeedPidState(), None, before.as_dict()):
        with pytest.raises(TypeError):
            controller.state = state
    assert controller.state == before
    with pytest.raises(AttributeError):
        del controller.state


def test_pid_state_keeps_the_terms_of_the_last_steps_oldest_first() -> None:
    params = popsteer.PidParams(buffer_length=3, integral_with_dt=False)
    pid = popsteer.Pid(PATH, params=params)
    errors = [pid.step(4.0, y, 0.0, 5.0, 0.05).cross_track_error for y in (0.5, 1.0, -2.0, 3.0)]
    state = pid.state
    assert state.terms == tuple(errors[1:])
    assert (state.next, state.previous_error) == (1, errors[-1])
    assert state.sum == pytest.approx(sum(errors[1:]))


@pytest.mark.parametrize(
    ("fields", "field"),
    [
        ({"terms": (0.0,) * 501}, "terms"),
        ({"terms": (float("nan"),), "next": 1}, "terms"),
        ({"terms": (1.0,), "next": 0}, "next"),
        ({"terms": (0.0,) * 500, "next": 500}, "next"),
        ({"sum": float("inf")}, "sum"),
        ({"previous_error": float("nan")}, "previous_error"),
    ],
)
def test_pid_state_that_no_buffer_could_have_is_refused(fields: dict[str, Any], field: str) -> None:
    pid = popsteer.Pid(PATH)
    pid.step(*STEP)
    before = pid.state
    with pytest.raises(InputError) as caught:
        pid.state = popsteer.PidState(**fields)
    assert caught.value.field == field
    assert pid.state == before


@pytest.mark.parametrize("angle", [1.3, -1.3, float("nan")])
def test_pop_state_with_an_angle_beyond_the_limit_is_refused(angle: float) -> None:
    pop = popsteer.Pop(PATH)
    with pytest.raises(InputError, match="previous_steer"):
        pop.state = popsteer.PopState(previous_steer=angle)
    assert pop.state == popsteer.PopState()


def test_speed_command_copied_or_pickled_is_equal() -> None:
    command = popsteer.SpeedTracker(PATH).step(2.0, 0.2, 0.1, 3.0, 0.05)
    assert eval(repr(command), vars(popsteer)) == command
    for twin in (copy.copy(command), copy.deepcopy(command), pickle.loads(pickle.dumps(command))):
        assert twin == command
    assert command != popsteer.SpeedTracker(PATH).step(3.0, 0.2, 0.1, 3.0, 0.05)


def test_speed_pid_state_saved_and_restored_goes_on_alike() -> None:
    law, other = popsteer.SpeedPid(), popsteer.SpeedPid()
    law.step(3.0, 10.0, 0.05)
    other.state = pickle.loads(pickle.dumps(law.state))
    assert other.state == law.state == popsteer.SpeedPidState(integral=0.035, previous_error=7.0)
    assert other.step(4.0, 10.0, 0.05) == law.step(4.0, 10.0, 0.05)
    before = law.state
    with pytest.raises(InputError, match="integral"):
        law.state = popsteer.SpeedPidState(integral=1.5)
    assert law.state == before
    law.reset()
    assert law.state == popsteer.SpeedPidState()
