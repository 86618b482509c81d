"""What controllers remember: shown, compared, saved, edited, restored, refused."""

from __future__ import annotations

import copy
import math
import pickle
from math import inf, nan
from typing import Any

import pytest

import popsteer
from popsteer import InputError, State
from tests.helpers import placed
from tests.parity.laws import LATERAL
from tests.unit.state_ranges import LONGER, OWN_RANGES, POSE, RANGES, WHOLE

PATH = popsteer.Path([(float(k), 0.1 * k) for k in range(30)])
STEP = (4.0, 1.0, 0.2, 6.0, 0.05)
DELAYED = popsteer.Vehicle(dead_time=0.2, steer_offset=0.01)
NAMES = [law.name for law in LATERAL]
# What each controller's own part is before the first step.
OWN: dict[str, dict[str, Any]] = {
    "Pop": {"previous_steer": 0.0},
    "PreviewPop": {"previous_steer": 0.0, "reached_limits": 0},
    "Pid": {
        "previous_error": None,
        "previous_position": None,
        "rate": 0.0,
        "buffer": {"length": 500, "terms": (), "next": 0, "sum": 0.0},
    },
    "PurePursuit": {"previous_alpha": 0.0},
    "Stanley": {},
}
ESTIMATE = {
    "gain": 1.0,
    "steer_offset": 0.0,
    "longer_dead_time": 0.0,
    "slip": 0.0,
    "slip_length": 0.0,
    "acceleration": 0.0,
    "speed_scale": 1.0,
}


def _walk(mean: tuple[float, ...], deviations: tuple[float, ...], noise: float) -> dict[str, Any]:
    """A filter before the first period."""
    count = len(mean)
    variances = [0.0] * count**2
    variances[:: count + 1] = [each * each for each in deviations]
    return {
        "level": 0.0,
        "variance": noise,
        "cross": (0.0,) * count,
        "mean": mean,
        "covariance": tuple(variances),
        "noise": {"variance": noise, "last": None, "count": 1.0},
    }


FIRST: dict[str, Any] = {
    **dict.fromkeys(("place", "handover", "answer", "past")),
    "monitor": None,
    "gate": None,
    "in_flight": None,
    "steer": 0.0,
    "held": 0,
    "held_time": 0.0,
    "period": 0.0,
    "estimator": {
        "last_measured": None,
        "unseen": None,
        "turning": _walk((1.0, 0.0, 0.0, 0.0), (0.1, 0.012, 0.05, 0.05), 2.5e-5),
        "sliding": _walk((0.0, 0.0, 0.0), (0.02, 0.1, 0.01), 1.4e-5),
        "pace": _walk((0.0,), (0.5,), 3e-5),
        "driving": _walk((0.0, 0.0), (0.1, 0.1), 1.4e-5),
        "wheel_rate": 0.0,
        "gain_deviation": 0.1,
        "estimate": ESTIMATE,
    },
}


def _controllers(vehicle: popsteer.Vehicle | None = None, steps: int = 0) -> list[Any]:
    """One of each controller, after so many steps; the last with poses that have an age."""
    made = [getattr(popsteer, name)(PATH, vehicle) for name in NAMES]
    for controller in made:
        for k in range(steps):
            controller.step(*STEP, pose_age=0.1 if k == steps - 1 else 0.0)
    return made


def _all_controllers(steps: int = 3) -> list[Any]:
    """Those that steer, without and with a delay, and those that keep a speed."""
    pid, tracker = popsteer.SpeedPid(), popsteer.SpeedTracker(PATH)
    for _ in range(steps):
        pid.step(3.0, 10.0, 0.05)
        tracker.step(*STEP)
    return [*_controllers(None, steps), *_controllers(DELAYED, steps), pid, tracker]


def _edited(value: Any, path: str, new: Any) -> Any:
    """The state or tuple with another value at a place such as ``past.angles.0.1``."""
    name, _, rest = path.partition(".")
    if isinstance(value, tuple):
        place = int(name)
        new = _edited(value[place], rest, new) if rest else new
        return (*value[:place], new, *value[place + 1 :])
    return value.replace(**{name: _edited(getattr(value, name), rest, new) if rest else new})


def _refused(controller: Any, state: Any, field: str) -> InputError:
    """The error of a state that is refused; the controller keeps its own."""
    before = controller.state
    with pytest.raises(InputError) as caught:
        controller.state = state
    assert caught.value.field == field, (field, str(caught.value))
    assert controller.state == before
    return caught.value


_TRACKER_STATE: dict[str, Any] = {
    "waypoint": None,
    "law": {
        **dict.fromkeys(("acceleration", "speed", "still"), 0.0),
        **dict.fromkeys(("drive", "stop", "wheels", "reverse", "passes"), None),
        **dict.fromkeys(("standing", "stopping", "overruns", "rolls", "shifting"), False),
        "observer": {
            "speed": None,
            "slow_drive": 0.0,
            "disturbance": 0.0,
            "pull": 0.0,
            "bias": None,
        },
        "waits": (0.0, 0.0),
        "servo": {"wanted": None, "command": 0.0, "response": 0.0, "sums": (0.0, 0.0)},
    },
    "gate": None,
    "bend": 0.0,
    "heard": None,
    "command": None,
    "held": 0,
}


def test_state_before_the_first_step_is_known_by_name() -> None:
    for name, controller in zip(NAMES, _controllers(), strict=True):
        state = controller.state
        fields = {"controller": name, "law": OWN[name], **FIRST}
        if name == "PreviewPop":  # its wheels are modelled from the beginning
            fields["in_flight"] = {"commands": (), "wheel": 0.0}
        assert state.as_dict() == fields
        assert state == State(**fields)
    for controller, fields in (
        (popsteer.SpeedPid(), {"integral": 0.0, "previous_error": None}),
        (popsteer.SpeedTracker(PATH), _TRACKER_STATE),
    ):
        assert controller.state.as_dict() == {"controller": type(controller).__name__, **fields}


def test_state_with_a_dead_time_begins_with_commands_in_flight() -> None:
    for first, walked in zip(_controllers(DELAYED), _controllers(DELAYED, 3), strict=True):
        assert first.state.in_flight == State(commands=((0.0, 0.2),), wheel=0.01)
        state = walked.state
        in_flight = sum(duration for _, duration in state.in_flight.commands)
        longer = state.estimator.estimate.longer_dead_time
        assert in_flight == pytest.approx(0.2 + longer)
        assert state.place.segment in (4, 7)
        # The pose repeats though the vehicle drives: it is an old one, rolled forward.
        expected, measured = state.gate.believed, state.gate.measured
        assert (measured.x, measured.y) == (4.0, 1.0) != (expected.x, expected.y)
        # It shows nothing of the vehicle.
        seen = state.estimator.last_measured
        assert (seen.x, seen.y, state.past.since) == (4.0, 1.0, pytest.approx(0.1))
        assert state.past.wheel == 0.01


def test_state_after_a_step_is_another_and_shows_it() -> None:
    for controller in _controllers():
        first = controller.state
        command = controller.step(*STEP)
        after = controller.state
        assert after != first
        assert after.place.segment in (4, 7)  # tracked points 0 to 3 m ahead of x = 4
        assert after.waypoint == after.measured_waypoint == after.place.segment
        ahead, yaw = controller.tracked_point, STEP[2]
        tracked = (STEP[0] + ahead * math.cos(yaw), STEP[1] + ahead * math.sin(yaw))
        off = math.dist(after.place.point, tracked)
        assert off == pytest.approx(abs(command.cross_track_error))
        assert first.place is first.waypoint is first.answer is None
        answer = after.answer
        assert answer.ahead.reference_speed is None
        assert answer.ahead.distance_to_stop == command.distance_to_stop
        assert answer.vehicle == State(**dict(zip(("x", "y", "yaw", "speed"), STEP, strict=False)))
        assert answer.measured == answer.predicted
        assert answer.measured.cross_track_error == command.cross_track_error
        assert answer.target == command.target
        assert (answer.measured.yaw, answer.reverse) == (0.2, False)
        assert set(after.as_dict()) == {"controller", "law", *FIRST} <= set(dir(after))


def test_state_copied_pickled_or_made_of_its_fields_goes_on_alike() -> None:
    for controller, other in zip(_all_controllers(), _all_controllers(0), strict=True):
        state = controller.state
        step = (4.2, 1.1, 0.1, 5.0, 0.05)[: 3 if isinstance(controller, popsteer.SpeedPid) else 5]
        for twin in (
            *(copy.copy(state), copy.deepcopy(state), State(**state.as_dict()), state.replace()),
            *(pickle.loads(pickle.dumps(state, protocol)) for protocol in range(2, 6)),
            eval(repr(state), {"State": State, "inf": inf}),
        ):
            assert type(twin) is State
            assert (twin, hash(twin), repr(twin)) == (state, hash(state), repr(state))
            other.state = twin
            assert repr(other.state) == repr(state)
        assert other.step(*step) == controller.step(*step)
        assert repr(other.state) == repr(controller.state)
        # A copy of the controller has its state.
        again = pickle.loads(pickle.dumps(controller)) if len(step) == 5 else controller
        assert again.state == controller.state


def test_state_keeps_every_bit() -> None:
    tiny, below = math.nextafter(0.0, 1.0), math.nextafter(1.0, 0.0)
    pop, preview = popsteer.Pop(PATH), popsteer.PreviewPop(PATH)
    for value in (-0.0, 0.0, tiny, -tiny, below, 0.1):
        pop.state = _edited(pop.state, "law.previous_steer", value)
        kept = pop.state.law.previous_steer
        assert (kept, math.copysign(1.0, kept)) == (value, math.copysign(1.0, value))
    for count in (0, 1, 2**53 + 1, 2**64 - 1):
        preview.state = _edited(preview.state, "law.reached_limits", count)
        assert preview.state.law.reached_limits == count
    closed = popsteer.Path([(0.0, 0.0), (9.0, 0.0), (9.0, 9.0)], closed=True)
    stanley = popsteer.Stanley(closed)
    stanley.step(*STEP)
    stanley.state = stanley.state
    assert stanley.state.answer.ahead.distance_to_stop == inf


def test_state_is_immutable_and_names_its_fields() -> None:
    state = _controllers(steps=1)[0].state
    for change in (
        lambda: setattr(state, "waypoint", 1),
        lambda: setattr(state.law, "previous_steer", 1.0),
        lambda: delattr(state, "waypoint"),
        lambda: state.waypoints,
    ):
        with pytest.raises(AttributeError, match=r"waypoint|previous_steer"):
            change()
    with pytest.raises(TypeError, match="no field 'waypoints'; it has controller, law, place"):
        state.replace(waypoints=1)
    assert state.__eq__(state.as_dict()) is NotImplemented
    fields = state.as_dict()
    fields["law"]["previous_steer"] = 9.0
    assert state.law.previous_steer != 9.0
    assert State(row=[1, [2.0]], inner={"a": 1}) == State(row=(1, (2.0,)), inner=State(a=1))


def test_state_of_another_kind_is_refused_by_name() -> None:
    states = [controller.state for controller in _all_controllers()]
    for controller in _all_controllers(1):
        own = type(controller).__name__
        for state in states:
            if state.controller != own:
                _refused(controller, state, "controller")
        state = controller.state
        _refused(controller, State(), "controller")
        assert _refused(controller, State(controller="Foo"), "controller").value == "Foo"
        fields = state.as_dict()
        first = next(name for name in fields if name != "controller")
        _refused(controller, State(**{**fields, "spam": 1.0}), "state")
        _refused(
            controller, State(**{name: fields[name] for name in fields if name != first}), "state"
        )
        for wrong in (None, fields, 1.0):
            with pytest.raises(TypeError, match=r"popsteer\.State"):
                controller.state = wrong
        with pytest.raises(AttributeError):
            del controller.state
        assert controller.state == state


def test_state_with_a_value_of_another_kind_is_refused_by_its_path() -> None:
    controllers = _controllers(DELAYED, 2)
    for controller in controllers:
        for path, value, required in (
            ("place.segment", -1, "a whole number"),
            ("place.segment", 1.5, "a whole number"),
            ("place.lost", 0, "True or False"),
            ("place", 3, "a State of segment, "),
            ("held", 2**64, "a whole number"),
            ("steer", "0.1", "a number"),
            ("steer", None, "a number"),
            ("steer", 10**400, "a number"),
            ("answer.reverse", 1, "True or False"),
            ("answer.target", (1.0, 2.0, 3.0), "a tuple of 2"),
            ("answer.target", 1.0, "a tuple"),
            ("answer.target.1", None, "a number"),
            ("answer", 3, "a State of measured, "),
            ("estimator", None, "a State of last_measured, "),
            ("in_flight.commands", ((0.0, 0.001),) * 197, "at most 196 entries"),
            ("in_flight.commands.0", (0.1,), "a tuple of 2"),
            ("law", {"spam": 1.0}, "a State of "),
        ):
            state = _edited(controller.state, path, value)
            field = "".join(
                f"[{part}]" if part.isdigit() else f".{part}" for part in path.split(".")
            )
            error = _refused(controller, state, field.removeprefix("."))
            assert error.requirement.startswith(required)
            assert str(error).startswith(f"{error.field} must be {required}")


@pytest.mark.parametrize("name", NAMES)
def test_state_is_restored_within_its_ranges_and_refused_beyond(name: str) -> None:
    controller = getattr(popsteer, name)(PATH)
    whole = controller.state.replace(**WHOLE)
    whole = _edited(whole, "estimator.last_measured", POSE)
    wheels = State(turn=0.01, slope=0.1, change=0.02)
    whole = _edited(whole, "estimator.unseen", State(wheels=wheels, time=0.1, first=0.05))
    if name == "Pid":
        buffer = State(length=500, terms=(0.1, 0.2), next=2, sum=0.3)
        whole = whole.replace(
            law=State(previous_error=0.5, previous_position=(1.0, -2.0), rate=0.1, buffer=buffer)
        )
    for place, low, high, field in RANGES + OWN_RANGES.get(name, LONGER):
        for value in {low, high}:
            controller.state = _edited(whole, place, value)
            controller.step(*STEP)
        for value in (nan, inf, -inf, math.nextafter(high, inf), math.nextafter(low, -inf)):
            error = _refused(controller, _edited(whole, place, value), field or place)
            assert error.value == value or math.isnan(value)
    for lost in (False, True):
        for segment in (0, 29):
            controller.state = whole.replace(place=placed(segment, lost))
            controller.step(*STEP)
        for segment in (30, 31, 10**9):
            error = _refused(
                controller, whole.replace(place=placed(segment, lost)), "place.segment"
            )
            assert (error.value, error.requirement) == (segment, "below 30")
    controller.state = whole.replace(place=None)
    controller.step(*STEP)
    for distance in (nan, -inf, 2e18):
        state = _edited(whole, "answer.ahead.distance_to_stop", distance)
        _refused(controller, state, "answer")
    # The first in the order of the check is the one named.
    order = {"place.segment": 0, "steer": 0.0, "held_time": 0.0}
    spoilt = whole.replace(place=placed(99), steer=nan, held_time=nan)
    for field, good in order.items():
        _refused(controller, spoilt, field)
        spoilt = _edited(spoilt, field, good)
    controller.state = spoilt


def test_state_of_commands_in_flight_that_cannot_be_is_refused() -> None:
    for controller in _controllers(DELAYED, 2):
        whole = controller.state
        for commands in ((), ((0.0, 0.3),), ((1.6, 0.2),), ((nan, 0.2),), ((0.0, nan),) * 2):
            _refused(
                controller, _edited(whole, "in_flight.commands", commands), "in_flight.commands"
            )
        _refused(controller, whole.replace(in_flight=None), "in_flight.commands")
        for commands in (((0.3, 0.2),), ((0.1, 0.1), (0.2, 0.1))):
            state = _edited(whole, "in_flight.commands", commands)
            controller.state = _edited(state, "estimator.estimate.longer_dead_time", 0.0)
            assert controller.state.in_flight.commands == commands
            controller.step(*STEP)
        longer = _edited(whole, "estimator.estimate.longer_dead_time", 0.3)
        _refused(controller, longer, "longer_dead_time")


def test_state_of_a_vehicle_that_is_modelled_goes_to_one_that_is_not() -> None:
    for modelled, other in zip(_controllers(DELAYED, 2), _controllers(), strict=True):
        if other.state.in_flight is None:
            other.state = modelled.state
            assert other.state == modelled.state
            other.step(*STEP)


def test_pid_state_keeps_the_terms_of_the_last_steps_oldest_first() -> None:
    params = popsteer.PidParams(buffer_length=3, integral_with_dt=False)
    pid, other = (popsteer.Pid(PATH, params=params) for _ in range(2))
    errors = [pid.step(4.0, y, 0.0, 5.0, 0.05).cross_track_error for y in (0.5, 1.0, -2.0, 3.0)]
    law = pid.state.law
    assert law.buffer.terms == tuple(errors[1:])
    assert (law.buffer.next, law.previous_error) == (1, errors[-1])
    assert law.buffer.sum == pytest.approx(sum(errors[1:]))
    other.state = pid.state
    for y in (0.3, 0.2, 0.1, 0.0):
        assert other.step(4.0, y, 0.0, 5.0, 0.05) == pid.step(4.0, y, 0.0, 5.0, 0.05)
        assert other.state == pid.state


def test_pid_state_that_no_buffer_could_have_is_refused() -> None:
    pid = popsteer.Pid(PATH)
    pid.step(*STEP)
    state = pid.state
    for changes, field in (
        ({"terms": (0.0,) * 501}, "terms"),
        ({"terms": (1.0,), "next": 0}, "next"),
        ({"terms": (1.0, 2.0), "next": 3}, "next"),
        ({"terms": (0.0,) * 500, "next": 500}, "next"),
        ({"next": -1}, "next"),
        ({"length": 499}, "length"),
        ({"length": 0}, "length"),
    ):
        law = state.law.replace(buffer=state.law.buffer.replace(**changes))
        _refused(pid, state.replace(law=law), f"law.buffer.{field}")


def test_speed_states_are_restored_within_their_ranges_and_refused_beyond() -> None:
    pid, tracker = popsteer.SpeedPid(), popsteer.SpeedTracker(PATH)
    for controller, place, low, high in (
        (pid, "integral", -1.0, 1.0),
        (pid, "previous_error", -2e4, 2e4),
        (tracker, "heard", -1e4, 1e4),
        (tracker, "law.acceleration", -1e4, 1e4),
        (tracker, "law.observer.disturbance", -3.0, 3.0),
        (tracker, "law.still", 0.0, 1e3),
    ):
        first, field = controller.state, place.removeprefix("law.")
        for value in (low, high):
            controller.state = _edited(first, place, value)
            assert controller.state == _edited(first, place, value)
        for value in (nan, inf, -inf, math.nextafter(high, inf), math.nextafter(low, -inf)):
            _refused(controller, _edited(first, place, value), field)
        controller.reset()
        assert controller.state == first
    _refused(tracker, tracker.state.replace(waypoint=30), "waypoint")
    for driven in (tracker, popsteer.Driver(PATH)):
        command = driven.step(*STEP)
        place = "command" if driven is tracker else "pace"
        for number in ("acceleration", "speed", "reference_speed", "distance_to_stop"):
            assert getattr(getattr(driven.state, place), number) == getattr(command, number)
            _refused(driven, _edited(driven.state, f"{place}.{number}", nan), "command")
        _refused(driven, _edited(driven.state, f"{place}.acceleration", inf), "command")
    restored = popsteer.SpeedTracker(PATH)
    restored.state = tracker.state
    assert restored.step(9.0, 0.0, 0.0, 3.0, 0.0) == tracker.step(9.0, 0.0, 0.0, 3.0, 0.0)


def test_reset_forgets_every_step() -> None:
    for controller, fresh in zip(_controllers(steps=5), _controllers(), strict=True):
        controller.reset()
        assert controller.state == fresh.state
        assert controller.step(*STEP) == fresh.step(*STEP)


def test_speed_command_copied_or_pickled_is_equal() -> None:
    command = popsteer.SpeedTracker(PATH).step(2.0, 0.2, 0.1, 3.0, 0.05)
    assert eval(repr(command), vars(popsteer)) == command
    for twin in (copy.copy(command), copy.deepcopy(command), pickle.loads(pickle.dumps(command))):
        assert twin == command
    assert command != popsteer.SpeedTracker(PATH).step(3.0, 0.2, 0.1, 3.0, 0.05)
