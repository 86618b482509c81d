"""The controllers and what they answer, as a user meets them."""

from __future__ import annotations

import copy
import math
import pickle
import re
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import InputError, Status
from tests.helpers import looped
from tests.parity.laws import LATERAL, Law

PATH = popsteer.Path([(float(k), 0.0) for k in range(60)], speed=[10.0] * 60)

each_law = pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)


CAR = popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35, no_slip_point=-1.0, dead_time=0.15)
ADAPT = popsteer.AdaptParams(turn_time=3.0)
MONITOR = popsteer.MonitorParams(deviation_limit=0.7)


def _controller(law: Law, vehicle: popsteer.Vehicle | None = None, **params: Any) -> Any:
    made = getattr(popsteer, law.params_name)(**params)
    return getattr(popsteer, law.name)(PATH, vehicle, made)


def _copies(thing: Any) -> list[Any]:
    pickled = [pickle.loads(pickle.dumps(thing, protocol)) for protocol in range(2, 6)]
    return [copy.copy(thing), copy.deepcopy(thing), *pickled]


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
    assert eval(repr(command), vars(popsteer)) == command
    assert repr(command).startswith(f"Command(steer={command.steer!r}, cross_track_error=")
    assert all(twin == command and twin is not command for twin in _copies(command)[1:])
    assert isinstance(command.status, Status)
    assert command == _controller(law).step(10.0, 1.0, 0.1, 5.0, 0.05)
    assert command != _controller(law).step(10.0, 1.1, 0.1, 5.0, 0.05)
    with pytest.raises(AttributeError):
        command.steer = 0.0
    with pytest.raises(TypeError, match="unhashable"):
        hash(command)


@pytest.mark.parametrize("bits", [1 << 15, 1 << 31, -1, "ok", None, 1.0])
def test_command_of_no_status_is_refused(bits: Any) -> None:
    command = popsteer.Pop(PATH).step(10.0, 1.0, 0.1, 5.0, 0.05)
    fields = command.__getnewargs_ex__()[1]
    with pytest.raises((ValueError, TypeError, OverflowError)):
        popsteer.Command(**{**fields, "status": bits})
    assert popsteer.Command(**fields) == command


@each_law
def test_law_shows_what_it_was_made_of(law: Law) -> None:
    params = getattr(popsteer, law.params_name)(lost_distance=20.0)
    controller = getattr(popsteer, law.name)(PATH, CAR, params, adapt=ADAPT, monitor=MONITOR)
    assert controller.path is PATH
    assert controller.vehicle is CAR
    assert controller.params is params
    assert controller.adapt is ADAPT
    assert controller.monitor is MONITOR
    assert controller.vehicle_given
    given = f"adapt={ADAPT!r}, monitor={MONITOR!r}"
    assert repr(controller) == f"{law.name}({PATH!r}, {CAR!r}, {params!r}, {given})"
    for field in ("path", "vehicle", "params", "adapt", "monitor", "estimate", "tracked_point"):
        with pytest.raises(AttributeError):
            setattr(controller, field, None)


@each_law
def test_law_of_a_path_alone_has_the_default_vehicle_and_tuning(law: Law) -> None:
    controller = getattr(popsteer, law.name)(PATH)
    assert controller.vehicle == popsteer.Vehicle()
    assert not controller.vehicle_given
    assert controller.params == getattr(popsteer, law.params_name)()
    assert repr(controller).endswith(f", {controller.vehicle!r}, {controller.params!r})")


@each_law
def test_law_adapts_where_an_estimate_counts_unless_told(law: Law) -> None:
    make = getattr(popsteer, law.name)
    usual, late = make(PATH), make(PATH, popsteer.Vehicle(dead_time=0.1))
    assert usual.adapt == (popsteer.AdaptParams() if law.reads_belief else None)
    assert late.adapt == make(PATH, CAR, adapt="auto").adapt == popsteer.AdaptParams()
    assert make(PATH, CAR, adapt=None).adapt is None
    assert make(PATH, adapt=ADAPT).adapt == ADAPT
    for wrong in (True, ..., "none", popsteer.PopParams()):
        with pytest.raises(TypeError, match="adapt must be AdaptParams, None or 'auto', got "):
            make(PATH, adapt=wrong)


@each_law
def test_law_watches_its_vehicle_unless_told(law: Law) -> None:
    make = getattr(popsteer, law.name)
    assert make(PATH).monitor == make(PATH, monitor="auto").monitor == popsteer.MonitorParams()
    assert make(PATH, monitor=None).monitor is None
    for wrong in (True, ..., "none", popsteer.AdaptParams()):
        with pytest.raises(TypeError, match="monitor must be MonitorParams, None or 'auto', got "):
            make(PATH, monitor=wrong)


@each_law
def test_law_tracks_its_point_from_the_pose(law: Law) -> None:
    wanted = {"PurePursuit": -1.35, "PreviewPop": -1.0}.get(law.name, 1.35)
    assert _controller(law, CAR).tracked_point == pytest.approx(wanted)
    at_rear = popsteer.Vehicle(wheelbase=2.5)
    wanted = 0.0 if law.name in ("PurePursuit", "PreviewPop") else 2.5
    assert _controller(law, at_rear).tracked_point == wanted


@each_law
def test_law_estimate_begins_with_what_it_was_told(law: Law) -> None:
    given = CAR.replace(steer_offset=0.01)
    controller = _controller(law, given)
    told = popsteer.Estimate(steer_offset=0.01, dead_time=0.15, steer_lag=given.steer_lag)
    assert controller.estimate == told
    for k in range(40):
        controller.step(10.0 + 0.25 * k, 0.1, 0.02 * math.sin(0.3 * k), 5.0, 0.05)
    estimate, state = controller.estimate, controller.state.estimator.estimate
    assert estimate != told
    # The gain is fitted anew from the sums, whose noise is known a little better by then.
    assert estimate.as_dict() == {
        "gain": pytest.approx(state.gain, rel=1e-4),
        "steer_offset": 0.01 + state.steer_offset,
        "dead_time": 0.15 + state.longer_dead_time,
        "steer_lag": given.steer_lag,
        "slip": state.slip,
        "slip_length": state.slip_length,
        "acceleration": state.acceleration,
        "speed_scale": state.speed_scale,
    }
    assert eval(repr(estimate), vars(popsteer)) == estimate
    assert all(twin == estimate for twin in _copies(estimate))


@each_law
@looped("vehicle", [None, CAR])
@looped(
    "options",
    [{}, {"adapt": None}, {"adapt": ADAPT}, {"monitor": None}, {"monitor": MONITOR}],
)
def test_law_copied_or_pickled_goes_on_alike(law: Law, vehicle: Any, options: Any) -> None:
    params = getattr(popsteer, law.params_name)(lost_distance=20.0)
    controller = getattr(popsteer, law.name)(PATH, vehicle, params, **options)
    for k in range(5):
        controller.step(10.0 + 0.25 * k, 0.5, 0.1, 5.0, 0.05)
    twins = _copies(controller)
    assert twins[0].path is PATH
    assert twins[1].path is not PATH
    before = controller.state
    nexts = [twin.step(11.3, 0.4, 0.1, 5.0, 0.05) for twin in twins]
    assert controller.state == before
    assert nexts == [controller.step(11.3, 0.4, 0.1, 5.0, 0.05)] * len(twins)
    for twin in twins:
        assert type(twin) is type(controller)
        for field in (
            "vehicle",
            "vehicle_given",
            "params",
            "adapt",
            "monitor",
            "estimate",
            "state",
        ):
            assert getattr(twin, field) == getattr(controller, field), field


@each_law
@pytest.mark.parametrize("path", [None, [(0.0, 0.0), (1.0, 0.0)], "racetrack"])
def test_law_of_no_path_is_a_type_error(law: Law, path: Any) -> None:
    with pytest.raises(TypeError):
        getattr(popsteer, law.name)(path)


@each_law
@looped(
    ("argument", "bound"), [("x", "1e+09"), ("y", "1e+09"), ("yaw", "1e+06"), ("speed", "10000")]
)
@looped("value", [math.nan, math.inf, -math.inf, 1.1e9])
def test_law_bad_argument_is_refused_by_name(
    law: Law, argument: str, bound: str, value: float
) -> None:
    step = {"x": 10.0, "y": 1.0, "yaw": 0.1, "speed": 5.0, "dt": 0.05, argument: value}
    wanted = f"{argument} must be in [-{bound}, {bound}], got {value!r}"
    with pytest.raises(InputError, match=f"^{re.escape(wanted)}$"):
        _controller(law).step(**step)


@each_law
@looped("dt", [math.nan, math.inf, -math.inf])
def test_law_bad_dt_is_refused_by_name(law: Law, dt: float) -> None:
    wanted = re.escape(f"dt must be in [1e-06, 1000], got {dt!r}")
    with pytest.raises(InputError, match=f"^{wanted}$"):
        _controller(law).step(10.0, 1.0, 0.1, 5.0, dt)


@each_law
@looped("argument", ["x", "y", "yaw", "speed", "dt"])
@looped("sign", [1, -1])
def test_law_whole_number_beyond_all_floats_is_refused_like_infinity(
    law: Law, argument: str, sign: int
) -> None:
    step = {"x": 10.0, "y": 1.0, "yaw": 0.1, "speed": 5.0, "dt": 0.05}
    controller = _controller(law)
    good = controller.step(**step)
    before = controller.state
    step[argument] = sign * 10**400
    with pytest.raises(InputError) as caught:
        controller.step(**step)
    assert (caught.value.field, caught.value.value) == (argument, sign * math.inf)
    with pytest.raises(InputError):
        controller.steer(*step.values())
    assert controller.state == before
    held = controller.step_or_hold(**step, hold_limit=10**30)
    assert held.status is Status.INPUT_HELD
    assert (held.steer, held.target) == (good.steer, good.target)
    assert controller.step_or_hold(**step, hold_limit=-(10**30)).status is Status.INPUT_LOST


@each_law
def test_law_angle_or_place_beyond_all_floats_is_refused_by_name(law: Law) -> None:
    controller = _controller(law)
    with pytest.raises(InputError, match="steer must be"):
        controller.reset(steer=10**400)
    with pytest.raises(InputError, match="yaw must be"):
        controller.relocalise(0.0, 0.0, 10**400)


@each_law
@pytest.mark.parametrize("value", ["1.0", None, [1.0], 1j])
def test_law_argument_that_is_no_number_is_a_type_error(law: Law, value: Any) -> None:
    with pytest.raises(TypeError):
        _controller(law).step(10.0, value, 0.1, 5.0, 0.05)
    with pytest.raises(TypeError):
        _controller(law).step(10.0, 1.0, 0.1, 5.0)


def test_status_says_that_the_lookahead_point_is_lost() -> None:
    pop = popsteer.Pop(PATH, params=popsteer.PopParams(exact_lookahead=False))
    params = popsteer.PurePursuitParams(exact_lookahead=False)
    for law in (pop, popsteer.PurePursuit(PATH, params=params)):
        command = law.step(30.0, 20.0, 0.0, 5.0, 0.05)
        assert Status.LOOKAHEAD_LOST in command.status
        assert command.target == (PATH.x[PATH.window(law.state.waypoint or 0)[0] + 21], 0.0)


@pytest.mark.parametrize("law", ["Pid", "Stanley"])
def test_status_says_that_the_angle_is_saturated(law: str) -> None:
    kind: Any = getattr(popsteer, law)
    controller = kind(PATH, popsteer.Vehicle(max_steer=0.1))
    command = controller.step(10.0, 8.0, 0.0, 5.0, 0.05)
    assert (command.steer, command.status) == (-0.1, Status.SATURATED | Status.STEER_LIMIT)


def test_pop_steps_to_its_limit_and_says_so() -> None:
    pop = popsteer.Pop(PATH, popsteer.Vehicle(max_steer=0.12))
    angles = [pop.step(10.0 + 0.25 * k, 2.0, 0.0, 5.0, 0.05) for k in range(4)]
    span = popsteer.PopParams().steer_span
    assert [command.steer for command in angles] == [-span, -2.0 * span, -0.12, -0.12]
    limited = Status.SATURATED | Status.STEER_LIMIT
    assert [command.status for command in angles[1:3]] == [Status.OK, limited]


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
