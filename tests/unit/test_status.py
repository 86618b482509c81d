"""Every status of a command, by a case made for it, and what the library then does.

The table "What a status says" of docs/edges.md is held to these cases.
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
from popsteer import Actuator, InputError, Status, laws
from popsteer.sim import Settings, Simulation
from tests.helpers import ROOT

if TYPE_CHECKING:
    from popsteer.laws import Controller

PAGE = (ROOT / "docs" / "edges.md").read_text(encoding="utf-8")
MAX_STEER = 0.3
NAMES = laws.names()
AIMING = ("pop", "pure-pursuit")
"""The laws that aim at a point on the lookahead circle."""


class Case(NamedTuple):
    """Where a vehicle comes to have a status: pose [m, m, rad] and speed [m/s]."""

    x: float
    y: float
    yaw: float = 0.0
    speed: float = 5.0

    def step(self, law: Controller, *, steps: int = 1) -> popsteer.Command:
        for _ in range(steps):
            command = law.step(self.x, self.y, self.yaw, self.speed, 0.05)
        return command


def straight() -> popsteer.Path:
    """100 m along x, a waypoint every 5 m."""
    return popsteer.Path([(5.0 * k, 0.0) for k in range(21)])


def controller(name: str, **options: Any) -> Controller:
    law = laws.get(name)
    params = law.params(max_steer=MAX_STEER)
    return law.controller(straight(), params, **options)  # type: ignore[arg-type]


def assert_sound(command: popsteer.Command) -> None:
    numbers = (command.steer, command.cross_track_error, command.heading_error, *command.target)
    assert all(map(math.isfinite, numbers))
    assert abs(command.steer) <= MAX_STEER


def test_status_table_of_the_page_has_every_status_and_its_level() -> None:
    text = PAGE.partition("<!-- table: status -->\n")[2].partition("\n\n")[0]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines()]
    assert {row[0].strip("`"): row[1] for row in rows[2:]} == {s.value: s.level for s in Status}


def test_status_codes_of_records_are_places_in_the_list() -> None:
    path = popsteer.Path([(0.0, 0.0), (30.0, 0.0)])
    simulation = Simulation(path, "kinematic-bicycle", start=(3.0, 9.0, 0.0), speed=5.0)
    law = popsteer.Pop(path, popsteer.PopParams(max_steer=MAX_STEER))
    simulation.drive(law)
    law.reset()
    records = simulation.records()
    poses = zip(*(records[column] for column in ("x", "y", "yaw", "speed")), strict=True)
    statuses = [law.step(x, y, yaw, speed, 0.05).status for x, y, yaw, speed in poses]
    assert len(set(statuses)) > 1
    assert [tuple(Status)[code] for code in records["status"]] == statuses


@pytest.mark.parametrize("name", NAMES)
def test_status_near_the_path_is_ok(name: str) -> None:
    command = Case(20.0, 0.02, -0.01).step(controller(name))
    assert_sound(command)
    assert command.status is Status.OK


@pytest.mark.parametrize("name", AIMING)
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_status_farther_off_than_the_lookahead_aims_at_the_foot(name: str, side: float) -> None:
    law = controller(name)
    command = Case(20.0, 15.0 * side).step(law)
    assert_sound(command)
    assert command.status is Status.LOOKAHEAD_LOST
    assert command.target == pytest.approx((20.0 + law.reference_offset, 0.0))
    assert command.steer * side < 0.0


@pytest.mark.parametrize("name", AIMING)
def test_status_of_the_papers_search_aims_at_the_last_point_that_it_looks_at(name: str) -> None:
    law = laws.get(name)
    params = law.params(exact_lookahead=False, max_steer=MAX_STEER)  # type: ignore[call-arg]
    command = Case(20.0, 15.0).step(law.controller(straight(), params))  # type: ignore[arg-type]
    assert_sound(command)
    assert command.status is Status.LOOKAHEAD_LOST
    # 20 m of arc on from the nearest waypoint.
    assert command.target == pytest.approx((45.0 if name == "pop" else 40.0, 0.0))


@pytest.mark.parametrize("name", AIMING)
def test_status_on_a_closed_path_within_the_circle_aims_a_quarter_on(name: str) -> None:
    law = laws.get(name)
    small = popsteer.Path([(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)], closed=True)
    params = law.params(max_steer=MAX_STEER)
    command = Case(0.5, 0.0).step(law.controller(small, params))  # type: ignore[arg-type]
    assert_sound(command)
    assert command.status is Status.LOOKAHEAD_LOST
    assert command.target in {(2.0, 0.0), (2.0, 2.0)}


_SATURATING: dict[str, dict[str, Any]] = {
    "bang-bang": {"amplitude": 0.5},
    "preview-pop": {"steer_span": 1.0, "max_steer_rate": 100.0},
}


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_status_where_more_is_wanted_than_the_limit_is_the_limit(name: str, side: float) -> None:
    law = laws.get(name)
    params = law.params(max_steer=MAX_STEER, **_SATURATING.get(name, {}))
    steered = law.controller(straight(), params)  # type: ignore[arg-type]
    command = Case(20.0, 4.0 * side, 0.7 * side).step(steered, steps=20)
    assert_sound(command)
    assert command.status is Status.SATURATED
    assert command.steer == -MAX_STEER * side


def test_status_beyond_the_lateral_acceleration_is_limited_to_it() -> None:
    params = popsteer.PreviewPopParams(max_lateral_acceleration=1.0, wheelbase=3.0)
    law = popsteer.PreviewPop(straight(), params)
    command = Case(20.0, 4.0, 0.4, speed=10.0).step(law, steps=20)
    assert command.status is Status.SATURATED
    assert command.steer == pytest.approx(-math.atan(3.0 * 1.0 / 10.0**2))


@pytest.mark.parametrize("name", NAMES)
def test_status_behind_a_slow_actuator_keeps_its_rate(name: str) -> None:
    law = controller(name, actuator=Actuator(max_rate=0.1))
    command = Case(20.0, 2.0, 0.1).step(law)
    assert_sound(command)
    assert command.status is Status.SATURATED
    assert command.steer == pytest.approx(-0.1 * 0.05)


@pytest.mark.parametrize("name", NAMES)
def test_status_past_the_end_follows_the_last_segment_on(name: str) -> None:
    law = controller(name)
    Case(97.0, 0.5).step(law)
    command = Case(104.0, 0.5).step(law)
    assert_sound(command)
    assert command.status is Status.END_OF_PATH
    assert command.cross_track_error == pytest.approx(0.5)
    assert command.heading_error == 0.0
    assert command.steer < 0.0
    assert command.target[0] > 103.9


@pytest.mark.parametrize("name", NAMES)
def test_status_beyond_the_lost_distance_is_off_path_and_found_anew(name: str) -> None:
    law = controller(name)
    Case(20.0, 0.0).step(law)
    # Farther than ten wheelbases from where it may be: a jump along the path, then far to the side.
    jumped = Case(80.0, 1.0).step(law)
    assert_sound(jumped)
    assert jumped.status is Status.OFF_PATH
    assert jumped.cross_track_error == pytest.approx(1.0)
    assert Case(80.0, 1.0).step(law).status is not Status.OFF_PATH
    far = Case(80.0, 31.0).step(law)
    assert_sound(far)
    assert far.status is Status.OFF_PATH
    assert far.cross_track_error == pytest.approx(31.0)


_BAD = [
    *((place, value) for place in range(5) for value in (math.nan, math.inf, -math.inf, 1e308)),
    *((4, value) for value in (0.0, -0.05, 5e-324)),
]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("actuator", [None, Actuator(dead_time=0.2, lag=0.1, learning_time=10.0)])
def test_status_of_refused_input_is_held_then_lost(name: str, actuator: Actuator | None) -> None:
    for place, value in _BAD:
        law = controller(name, actuator=actuator)
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
            assert held.steer == before.steer
            errors = (held.cross_track_error, held.heading_error, *held.target)
            assert errors == (0.0, 0.0, 0.0, 0.0)
        after = law.step_or_hold(*good, hold_limit=2)
        assert_sound(after)
        assert after.status.level != "fault"
        assert law.state.held == 0


@pytest.mark.parametrize("name", NAMES)
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
        controller = laws.get(name).controller(long)
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
        waypoint = controller.state.waypoint
        assert waypoint is None or waypoint < len(short)
        assert_sound(Case(0.5, 0.2).step(controller))


def test_simulation_used_while_it_drives_says_so() -> None:
    path = straight()
    said: list[str] = []

    def look(_share: float) -> None:
        with pytest.raises(RuntimeError) as caught:
            simulation.step(0.0)
        said.append(str(caught.value))

    settings = Settings(dt=0.001)
    simulation = Simulation(path, start=(3.0, 0.0, 0.0), settings=settings)
    simulation.drive(popsteer.Pop(path), progress=look)
    assert said
    assert all("borrowed" in words for words in said)
    assert simulation.is_finished
