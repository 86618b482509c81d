"""The laws and what they answer, as a user meets them."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import InputError, Status
from tests.parity.laws import LATERAL, Law

PATH = popsteer.Path([(float(k), 0.0) for k in range(60)], speed=[10.0] * 60)

each_law = pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)


def _controller(law: Law, **params: Any) -> Any:
    return getattr(popsteer, law.name)(PATH, getattr(popsteer, law.params_name)(**params))


@each_law
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_law_beside_the_path_steers_towards_it(law: Law, side: float) -> None:
    command = _controller(law).step(10.0, side * 0.8, 0.0, 5.0, 0.05)
    assert command.steer * side < 0.0
    assert command.cross_track_error == side * 0.8
    assert command.heading_error == 0.0
    assert command.target[1] == 0.0
    assert command.status is Status.OK


@each_law
def test_law_arguments_may_be_named_in_step_and_not_in_steer(law: Law) -> None:
    named = _controller(law).step(x=10.0, y=1.0, yaw=0.1, speed=5.0, dt=0.05)
    assert named == _controller(law).step(10, 1, 0.1, 5, 0.05)
    assert named.steer == _controller(law).steer(10.0, 1.0, 0.1, 5.0, 0.05)
    with pytest.raises(TypeError):
        _controller(law).steer(x=10.0, y=1.0, yaw=0.1, speed=5.0, dt=0.05)


@each_law
def test_law_takes_numpy_scalars(law: Law) -> None:
    pose = np.array([10.0, 1.0, 0.1, 5.0])
    step = _controller(law).step(*pose, np.float32(0.05))
    assert step == _controller(law).step(*pose.tolist(), float(np.float32(0.05)))
    assert type(step.steer) is float


@each_law
def test_command_shows_compares_and_is_frozen(law: Law) -> None:
    command = _controller(law).step(10.0, 1.0, 0.1, 5.0, 0.05)
    shown = {
        "steer": command.steer,
        "cross_track_error": command.cross_track_error,
        "heading_error": command.heading_error,
        "target": command.target,
        "reverse": command.reverse,
        "status": command.status,
    }
    fields = ", ".join(f"{field}={value!r}" for field, value in shown.items())
    assert repr(command) == f"Command({fields})"
    assert isinstance(command.status, Status)
    assert command == _controller(law).step(10.0, 1.0, 0.1, 5.0, 0.05)
    assert command != _controller(law).step(10.0, 1.1, 0.1, 5.0, 0.05)
    with pytest.raises(AttributeError):
        command.steer = 0.0
    with pytest.raises(TypeError, match="unhashable"):
        hash(command)


@each_law
def test_law_shows_what_it_was_made_of(law: Law) -> None:
    controller = _controller(law, max_steer=0.5)
    assert controller.path is PATH
    assert controller.params.max_steer == 0.5
    assert repr(controller) == f"{law.name}({PATH!r}, params={controller.params!r})"
    for field in ("path", "params", "reference_offset"):
        with pytest.raises(AttributeError):
            setattr(controller, field, None)


@each_law
@pytest.mark.parametrize("path", [None, [(0.0, 0.0), (1.0, 0.0)], "racetrack"])
def test_law_of_no_path_is_a_type_error(law: Law, path: Any) -> None:
    with pytest.raises(TypeError):
        getattr(popsteer, law.name)(path)


@each_law
@pytest.mark.parametrize(
    ("argument", "bound"), [("x", "1e+09"), ("y", "1e+09"), ("yaw", "1e+06"), ("speed", "10000")]
)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1.1e9])
def test_law_bad_argument_is_refused_by_name(
    law: Law, argument: str, bound: str, value: float
) -> None:
    step = {"x": 10.0, "y": 1.0, "yaw": 0.1, "speed": 5.0, "dt": 0.05, argument: value}
    wanted = f"{argument} must be in [-{bound}, {bound}], got {value!r}"
    with pytest.raises(InputError, match=f"^{re.escape(wanted)}$"):
        _controller(law).step(**step)


@each_law
@pytest.mark.parametrize("dt", [0.0, -0.05, math.nan, math.inf, 9e-7, 1001.0])
def test_law_bad_dt_is_refused_by_name(law: Law, dt: float) -> None:
    wanted = re.escape(f"dt must be in [1e-06, 1000], got {dt!r}")
    with pytest.raises(InputError, match=f"^{wanted}$"):
        _controller(law).step(10.0, 1.0, 0.1, 5.0, dt)


@each_law
@pytest.mark.parametrize("value", ["1.0", None, [1.0], 1j])
def test_law_argument_that_is_no_number_is_a_type_error(law: Law, value: Any) -> None:
    with pytest.raises(TypeError):
        _controller(law).step(10.0, value, 0.1, 5.0, 0.05)
    with pytest.raises(TypeError):
        _controller(law).step(10.0, 1.0, 0.1, 5.0)


def test_status_says_that_the_lookahead_point_is_lost() -> None:
    pop = popsteer.Pop(PATH, popsteer.PopParams(exact_lookahead=False))
    params = popsteer.PurePursuitParams(exact_lookahead=False)
    for law in (pop, popsteer.PurePursuit(PATH, params)):
        command = law.step(30.0, 20.0, 0.0, 5.0, 0.05)
        assert command.status is Status.LOOKAHEAD_LOST
        assert command.target == (PATH.x[PATH.window(law.state.waypoint or 0)[0] + 21], 0.0)


@pytest.mark.parametrize("law", ["Pid", "Stanley", "BangBang"])
def test_status_says_that_the_angle_is_saturated(law: str) -> None:
    kind: Any = getattr(popsteer, law)
    controller = kind(PATH, getattr(popsteer, f"{law}Params")(max_steer=0.1))
    command = controller.step(10.0, 20.0, 0.0, 5.0, 0.05)
    assert (command.steer, command.status) == (-0.1, Status.SATURATED)


def test_pop_steps_to_its_limit_and_says_so() -> None:
    pop = popsteer.Pop(PATH, popsteer.PopParams(max_steer=0.12))
    angles = [pop.step(10.0, 2.0, 0.0, 5.0, 0.05) for _ in range(4)]
    span = popsteer.PopParams().steer_span
    assert [command.steer for command in angles] == [-span, -2.0 * span, -0.12, -0.12]
    assert [command.status for command in angles[1:3]] == [Status.OK, Status.SATURATED]


def test_coupled_longitudinal_gives_the_papers_pedals() -> None:
    law = popsteer.CoupledLongitudinal()
    assert law.step(0.0, 0.0) == (1.0, 0.0)
    throttle, brake = law.step(69.44, 0.0)
    assert (throttle, brake) == (0.5, 0.0)
    throttle, brake = law.step(69.44, -1.22)
    assert (throttle, brake) == (0.0, 0.0)
    assert law.step(speed=4.0 * 69.44, steer=0.0) == (0.0, 1.0)
    assert repr(law) == f"CoupledLongitudinal({law.params!r})"


def test_speed_pid_brakes_throttles_and_never_both() -> None:
    law = popsteer.SpeedPid()
    assert law.step(speed=0.0, target_speed=20.0, dt=0.05) == (1.0, 0.0)
    assert law.step(20.0, 5.0, 0.05)[0] == 0.0
    assert repr(law) == f"SpeedPid({law.params!r})"


def test_status_members_are_the_strings_they_stand_for() -> None:
    assert [status.value for status in Status] == [
        *("ok", "lookahead-lost", "saturated", "end-of-path", "off-path", "input-held"),
        "input-lost",
    ]
    assert Status("saturated") is Status.SATURATED
