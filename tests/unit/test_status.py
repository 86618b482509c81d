"""Every status of a command, by a case made for it, and what the library then does.

The table "What a status says" of docs/loop.md is held to these cases.
"""

from __future__ import annotations

import contextlib
import math
import sys
import threading
import time
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pytest

import popsteer
from popsteer import InputError, Status, Vehicle, controllers
from popsteer.sim import Settings, Simulation
from tests.helpers import ROOT, looped

if TYPE_CHECKING:
    from popsteer.controllers import Controller

PAGE = (ROOT / "docs" / "loop.md").read_text(encoding="utf-8")
MAX_STEER = 0.3
NAMES = controllers.names()
AIMING = ("pop", "pure-pursuit")
"""The controllers that aim at a point on the lookahead circle."""
CAR = Vehicle(max_steer=MAX_STEER)
CONDITIONS = tuple(status for status in Status if status)
GAP = 2.0
"""After so long [s] any pose is believed: the vehicle can have gone anywhere."""


class Case(NamedTuple):
    """Where a vehicle comes to have a status: pose [m, m, rad] and speed [m/s]."""

    x: float
    y: float
    yaw: float = 0.0
    speed: float = 5.0

    def step(self, law: Controller, *, steps: int = 1, dt: float = 0.05) -> popsteer.Command:
        for _ in range(steps):
            command = law.step(self.x, self.y, self.yaw, self.speed, dt)
        return command


def straight() -> popsteer.Path:
    """100 m along x, a waypoint every 5 m."""
    return popsteer.Path([(5.0 * k, 0.0) for k in range(21)])


def controller(name: str, **car: Any) -> Controller:
    return controllers.get(name).controller(straight(), CAR.replace(**car))


def assert_sound(command: popsteer.Command) -> None:
    numbers = (command.steer, command.cross_track_error, command.heading_error, *command.target)
    assert all(map(math.isfinite, numbers))
    assert abs(command.steer) <= MAX_STEER


def test_status_table_of_the_page_has_every_condition_and_its_level() -> None:
    text = PAGE.partition("<!-- table: status -->\n")[2].partition("\n\n")[0]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines()]
    said = {row[0].strip("`"): row[1] for row in rows[2:]}
    assert said == {str(status): status.level for status in (Status.OK, *CONDITIONS)}


def test_status_is_a_set_of_conditions_with_a_bit_each() -> None:
    assert [int(status) for status in CONDITIONS] == [1 << k for k in range(15)]
    both = Status.SATURATED | Status.END_OF_PATH
    assert Status.SATURATED in both
    assert Status.OFF_PATH not in both
    assert (str(both), both.names) == ("saturated|end-of-path", ("saturated", "end-of-path"))
    assert (str(Status.OK), Status.OK.names, Status(0)) == ("ok", (), Status.OK)
    assert [status.level for status in (Status.OK, both, both | Status.INPUT_LOST)] == [
        *("ok", "degraded", "fault")
    ]


def test_status_of_a_command_is_one_object_for_each_set() -> None:
    commands = [Case(20.0, 0.02, -0.01).step(controller("stanley")) for _ in range(2)]
    assert commands[0].status is commands[1].status is Status.OK
    fields = commands[0].__getnewargs_ex__()[1]
    for chosen in range(2 ** len(CONDITIONS)):
        bits = sum(each for k, each in enumerate(CONDITIONS) if chosen >> k & 1)
        status = popsteer.Command(**{**fields, "status": Status(bits)}).status
        assert type(status) is Status
        assert status == bits


def test_status_of_records_are_the_bits() -> None:
    path = popsteer.Path([(0.0, 0.0), (30.0, 0.0)])
    simulation = Simulation(path, "kinematic-bicycle", start=(3.0, 9.0, 0.0), speed=5.0)
    law = popsteer.Pop(path, CAR)
    simulation.drive(law)
    law.reset()
    records = simulation.records()
    poses = zip(*(records[column] for column in ("x", "y", "yaw", "speed")), strict=True)
    statuses = [law.step(x, y, yaw, speed, 0.05).status for x, y, yaw, speed in poses]
    assert len(set(statuses)) > 1
    assert records["status"].dtype == np.uint32
    assert [Status(bits) for bits in records["status"].tolist()] == statuses


@looped("name", NAMES)
def test_status_near_the_path_is_ok(name: str) -> None:
    command = Case(20.0, 0.02, -0.01).step(controller(name))
    assert_sound(command)
    assert command.status is Status.OK


@looped("name", AIMING)
@looped("side", [1.0, -1.0])
def test_status_farther_off_than_the_lookahead_aims_beside(name: str, side: float) -> None:
    law = controller(name)
    command = Case(20.0, 15.0 * side).step(law)
    assert_sound(command)
    assert Status.LOOKAHEAD_LOST in command.status
    assert command.target == pytest.approx((20.0 + law.tracked_point, 0.0))
    assert command.steer * side < 0.0


@looped("name", AIMING)
def test_status_of_the_papers_search_aims_at_the_last_point_that_it_looks_at(name: str) -> None:
    law = controllers.get(name)
    params: Any = law.params(exact_lookahead=False)  # type: ignore[call-arg]
    command = Case(20.0, 15.0).step(law.controller(straight(), CAR, params))
    assert_sound(command)
    assert Status.LOOKAHEAD_LOST in command.status
    # 20 m of arc on from the nearest waypoint.
    assert command.target == pytest.approx((45.0 if name == "pop" else 40.0, 0.0))


@looped("name", AIMING)
def test_status_on_a_closed_path_within_the_circle_aims_a_quarter_on(name: str) -> None:
    law = controllers.get(name)
    small = popsteer.Path([(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)], closed=True)
    command = Case(0.5, 0.0).step(law.controller(small, CAR))
    assert_sound(command)
    assert Status.LOOKAHEAD_LOST in command.status
    assert command.target in {(2.0, 0.0), (2.0, 2.0)}


_SATURATING: dict[str, dict[str, Any]] = {
    "preview-pop": {"steer_span_rate": 100.0},
}


@looped("name", NAMES)
@looped("side", [1.0, -1.0])
def test_status_where_more_is_wanted_than_the_limit_is_the_limit(name: str, side: float) -> None:
    law = controllers.get(name)
    params: Any = law.params(**_SATURATING.get(name, {}))
    car = CAR.replace(max_lateral_acceleration=None)
    steered = law.controller(straight(), car, params)
    command = Case(20.0, 4.0 * side, 0.7 * side).step(steered, steps=20)
    assert_sound(command)
    assert Status.SATURATED in command.status
    assert command.steer == -MAX_STEER * side


@looped("name", NAMES)
def test_status_beyond_the_lateral_acceleration_is_limited_to_it(name: str) -> None:
    law = controller(name, max_lateral_acceleration=0.5)
    command = Case(20.0, 4.0, 0.4, speed=10.0).step(law, steps=20)
    assert_sound(command)
    assert Status.SATURATED in command.status
    # The limit is kept with the gain that is measured, by the estimates or by the monitor.
    gain = law.estimate.gain if law.adapt else law.state.monitor.gain.mean[0]
    wheel = command.steer + law.estimate.steer_offset
    assert wheel == pytest.approx(-math.atan(3.0 * 0.5 / 10.0**2 / gain))


@looped("name", NAMES)
def test_status_of_slow_wheels_keeps_their_rate(name: str) -> None:
    law = controller(name, max_steer_rate=0.1)
    command = Case(20.0, 2.0, 0.1).step(law)
    assert_sound(command)
    assert Status.SATURATED in command.status
    assert command.steer == pytest.approx(-0.1 * 0.05)


@looped("name", NAMES)
def test_status_saturated_past_the_end_says_both(name: str) -> None:
    law = controller(name, max_steer_rate=0.001)
    Case(97.0, 0.5).step(law)
    command = Case(104.0, 0.8, 0.2).step(law, dt=GAP)
    assert Status.SATURATED | Status.END_OF_PATH in command.status
    assert command.status.level == "degraded"


@looped("name", NAMES)
def test_status_past_the_end_follows_the_last_segment_on(name: str) -> None:
    law = controller(name)
    Case(97.0, 0.5).step(law)
    command = Case(104.0, 0.5).step(law, dt=GAP)
    assert_sound(command)
    assert Status.END_OF_PATH in command.status
    assert command.cross_track_error == pytest.approx(0.5)
    assert command.heading_error == 0.0
    assert command.steer < 0.0
    assert command.target[0] > 103.9


@looped("name", NAMES)
def test_status_beyond_the_lost_distance_is_off_path_and_found_anew(name: str) -> None:
    law = controller(name)
    Case(20.0, 0.0).step(law)
    # Farther than ten wheelbases from where it may be: a jump along the path, then far to the side.
    jumped = Case(80.0, 1.0).step(law, dt=GAP)
    assert_sound(jumped)
    assert Status.OFF_PATH in jumped.status
    assert jumped.cross_track_error == pytest.approx(1.0)
    assert Status.OFF_PATH not in Case(80.25, 1.0).step(law).status
    far = Case(80.0, 31.0).step(law, dt=GAP)
    assert_sound(far)
    assert Status.OFF_PATH in far.status
    assert far.cross_track_error == pytest.approx(31.0)


@looped("name", NAMES)
@looped("side", [1.0, -1.0])
def test_status_beyond_the_deviation_limit_is_deviating_once_it_was_within(
    name: str, side: float
) -> None:
    law = controller(name)
    # From within the limit of 1.5 m little by little beyond it: what jumps may be noise.
    aside = [1.6, *(1.4 + 0.05 * k for k in range(10)), 1.4]
    beside = [Case(20.0, side * y).step(law) for y in aside]
    deviating = [Status.DEVIATING in each.status for each in beside]
    assert not any(deviating[:4])
    assert deviating[-2:] == [True, False]
    assert beside[-2].status.level == "fault"
    assert_sound(beside[-2])
    # Another path that begins farther off is another task.
    Case(20.0, side).step(law)
    law.set_path(popsteer.Path([(0.0, -3.0 * side), (100.0, -3.0 * side)]))
    assert Status.DEVIATING not in Case(20.25, side).step(law).status
    law.set_path(straight())
    assert Status.DEVIATING not in Case(20.5, side).step(law).status
    # One that is the same but for its points is not.
    law.set_path(popsteer.Path([(0.1, 0.0), (99.0, 0.0)]))
    for k in range(11):
        command = Case(20.75, (1.0 + 0.1 * k) * side).step(law)
    assert Status.DEVIATING in command.status
    law.relocalise(20.0, 1.6 * side, 0.0)
    assert Status.DEVIATING not in Case(21.0, 1.6 * side).step(law).status


@looped("name", NAMES)
@looped("side", [1.0, -1.0])
def test_status_deviating_where_the_vehicle_turns_round_is_so_on_its_way_back(
    name: str, side: float
) -> None:
    way = [(5.0 * k, 0.0) for k in (0, 1, 2, 3, 4, 3, 2, 1, 0)]
    path = popsteer.Path(way, reverse=[False] * 4 + [True] * 5)
    law = controllers.get(name).controller(path, CAR)
    y = 1.8 * side
    Case(10.0, 0.0).step(law)
    out = [Case(x, y).step(law, dt=GAP) for x in (15.0, 18.0)]
    back = [Case(x, y, speed=-1.0).step(law, dt=GAP) for x in (20.2, 19.9, 15.0)]
    assert [each.reverse for each in out + back] == [False, False, True, True, True]
    for command in out + back:
        assert Status.DEVIATING in command.status
        assert_sound(command)


@looped("name", NAMES)
@looped("side", [1.0, -1.0])
def test_status_of_a_vehicle_that_turns_uncommanded_is_implausible_for_two_seconds(
    name: str, side: float
) -> None:
    law = controller(name)
    case = Case(20.0, 0.0)
    for _ in range(20):
        case = case._replace(x=case.x + 0.25)
        assert Status.IMPLAUSIBLE not in case.step(law).status
    for _ in range(6):
        yaw = case.yaw + 0.05 * side
        case = Case(case.x + 0.25 * math.cos(yaw), case.y + 0.25 * math.sin(yaw), yaw)
        turned = case.step(law)
    assert Status.IMPLAUSIBLE in turned.status
    assert turned.status.level == "fault"
    assert_sound(turned)
    law.relocalise(20.0, 0.0, 0.0)
    said = [Status.IMPLAUSIBLE in Case(20.0, 0.0, speed=0.0).step(law).status for _ in range(60)]
    assert all(said[:38])
    assert not any(said[40:])


_BAD = [
    *((place, value) for place in range(5) for value in (math.nan, math.inf, -math.inf)),
    *((place, 1e308) for place in range(4)),
    *((place, sign * 10**400) for place in range(5) for sign in (1, -1)),
]
_NO_TIMES = (0.0, -0.05, 5e-324, -60.0, 2000.0, 1e308)


@looped("name", NAMES)
@looped("dead_time", [0.0, 0.2])
def test_status_of_refused_input_is_held_then_lost(name: str, dead_time: float) -> None:
    for place, value in _BAD:
        law = controller(name, dead_time=dead_time)
        good = (20.0, 0.4, 0.05, 5.0, 0.05)
        before = law.step_or_hold(*good)
        assert before.status.level != "fault"
        x, y, yaw, speed, dt = (value if k == place else good[k] for k in range(5))
        with pytest.raises(InputError):
            law.step(x, y, yaw, speed, dt)
        for status in (Status.INPUT_HELD, Status.INPUT_HELD, Status.INPUT_LOST, Status.INPUT_LOST):
            held = law.step_or_hold(x, y, yaw, speed, dt, hold_limit=2)
            assert_sound(held)
            assert held.status is status
            fields = held.__getnewargs_ex__()[1]
            assert {**fields, "status": before.status} == before.__getnewargs_ex__()[1]
        after = law.step_or_hold(*good, hold_limit=2)
        assert_sound(after)
        assert after.status.level != "fault"
        assert law.state.held == 0


@looped("name", NAMES)
@looped("dead_time", [0.0, 0.2])
def test_status_of_a_step_in_no_time_is_held_then_lost(name: str, dead_time: float) -> None:
    law = controller(name, dead_time=dead_time)
    first = law.step(20.0, 0.4, 0.05, 5.0, 0.0)
    assert_sound(first)
    assert (first.status, first.distance_to_stop) == (Status.INPUT_HELD, 0.0)
    before = law.step(20.0, 0.4, 0.05, 5.0, 0.05)
    known, fields = law.state, before.__getnewargs_ex__()[1]
    for held, dt in enumerate(_NO_TIMES * 3, 1):
        command = law.step(20.0 + held, 0.9, 0.0, 5.0, dt)
        assert command.status is (Status.INPUT_LOST if held > 10 else Status.INPUT_HELD)
        assert {**command.__getnewargs_ex__()[1], "status": before.status} == fields
        assert law.state == known.replace(held=held)
    after = law.step(20.25, 0.4, 0.05, 5.0, 0.05)
    assert after.status.level != "fault"
    assert (law.state.held, law.state.period) == (0, 0.05)


@looped("name", NAMES)
def test_status_of_refused_input_on_the_way_back_holds_the_direction(name: str) -> None:
    path = popsteer.Path([(5.0 * k, 0.0) for k in range(21)], reverse=[True] * 21)
    law = controllers.get(name).controller(path, CAR)
    first = law.step_or_hold(math.nan, 0.0, 0.0, 0.0, 0.05)
    assert (first.reverse, first.target, first.cross_track_error) == (False, (0.0, 0.0), 0.0)
    before = law.step(20.0, 0.4, math.pi, -3.0, 0.05)
    held = law.step_or_hold(math.nan, 0.0, 0.0, 0.0, 0.05)
    assert before.reverse
    assert held.reverse
    assert (held.steer, held.cross_track_error) == (before.steer, before.cross_track_error)


@looped("name", NAMES)
def test_status_of_any_hold_limit_is_held_or_lost(name: str) -> None:
    for limit, status in (
        (10**30, Status.INPUT_HELD),
        (1, Status.INPUT_HELD),
        (0, Status.INPUT_LOST),
        (-(10**30), Status.INPUT_LOST),
    ):
        assert controller(name).step_or_hold(0, 0, 0, 10**400, 0.05, limit).status is status
    no_counts: tuple[Any, ...] = (1.0, "1", None)
    for no_count in no_counts:
        with pytest.raises(TypeError):
            controller(name).step_or_hold(0, 0, 0, 0, 0.05, no_count)


@looped("name", NAMES)
def test_controller_stepped_by_two_threads_takes_whole_steps(name: str) -> None:
    steps = 2000
    shared, alone = controller(name), controller(name)
    together = threading.Barrier(2)
    refused: list[Exception] = []

    def drive() -> None:
        together.wait()
        for _ in range(steps):
            while True:
                try:
                    assert_sound(Case(20.0, 0.4, 0.05).step(shared))
                    break
                except RuntimeError as error:  # where there is no lock around the interpreter
                    refused.append(error)

    threads = [threading.Thread(target=drive) for _ in range(2)]
    usual = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    finally:
        sys.setswitchinterval(usual)
    assert all("borrowed" in str(error) for error in refused)
    Case(20.0, 0.4, 0.05).step(alone, steps=2 * steps)
    assert shared.state == alone.state


@pytest.mark.parametrize("name", ["pop", "preview-pop"])
def test_relocalise_in_one_thread_and_set_path_in_another_keep_the_waypoint_on_the_path(
    name: str,
) -> None:
    short = popsteer.Path([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)])
    count = 2_000_000
    xy = np.column_stack((np.arange(float(count)), np.zeros(count)))
    for _ in range(5):
        long = popsteer.Path(xy)  # a new one each time: it may do more at its first use
        controller = controllers.get(name).controller(long)
        begun = threading.Event()

        def jump(controller: Controller = controller, begun: threading.Event = begun) -> None:
            begun.set()
            for _ in range(50):
                # Where there is no lock around the interpreter it may be refused.
                with contextlib.suppress(RuntimeError):
                    controller.relocalise(count - 5.0, 0.3, 0.0)

        thread = threading.Thread(target=jump)
        thread.start()
        begun.wait()
        time.sleep(0.001)
        controller.set_path(short)
        thread.join()
        place = controller.state.place
        assert place is None or place.segment < len(short)
        assert_sound(Case(0.5, 0.2).step(controller))


def test_simulation_used_while_it_drives_says_so() -> None:
    path = straight()
    said: list[str] = []

    def look(_share: float) -> None:
        with pytest.raises(RuntimeError) as caught:
            simulation.step(0.0)
        said.append(str(caught.value))

    settings = Settings(dt=2e-5, keep_records=False)  # long enough to be looked at
    simulation = Simulation(path, start=(3.0, 0.0, 0.0), settings=settings)
    simulation.drive(popsteer.Pop(path), progress=look)
    assert said
    assert all("borrowed" in words for words in said)
    assert simulation.is_finished
