"""A clock that is set, back or on: docs/loop.md's two loops and the driver hold one command."""

from __future__ import annotations

import itertools
import math
import re
from typing import Any

import pytest

import popsteer
from popsteer import controllers
from tests.helpers import ROOT

CAR = popsteer.Vehicle(wheelbase=2.7, dead_time=0.1)
PATH = popsteer.Path([(float(k), 0.002 * k * k) for k in range(100)])
JUMPS = (-2.0, -60.0, -1e5, 1000.0, 2000.0, 1e5)


def drive(jump: float) -> list[tuple[float, tuple[float, float, float, float]]]:
    """The differences of the stamps, and the poses that come with them."""
    stamps = [0.05 * k + (jump if k > 100 else 0.0) for k in range(400)]
    poses = [(0.2 * k, 0.1, 0.0008 * k, 4.0) for k in range(1, 400)]
    return list(zip([b - a for a, b in itertools.pairwise(stamps)], poses, strict=True))


@pytest.mark.parametrize("jump", JUMPS)
def test_loops_of_the_page_hold_one_command_and_give_the_same_angles(jump: float) -> None:
    page = (ROOT / "docs" / "loop.md").read_text(encoding="utf-8")
    found = re.search(r"```python\n(passed \+= .*?)\n\n(command = .*?)\n```", page, re.DOTALL)
    assert found
    strict, holding = (compile(each, "docs/loop.md", "exec") for each in found.groups())
    one, other = popsteer.PreviewPop(PATH, CAR), popsteer.PreviewPop(PATH, CAR)
    names: dict[str, Any] = {"popsteer": popsteer, "passed": 0.0}
    held = 0
    for dt, pose in drive(jump):
        names |= {"pose": pose, "dt": dt, "controller": one, "command": None}
        exec(strict, names)
        answer = names["command"]
        names["controller"] = other
        exec(holding, names)
        assert answer == names["command"]
        assert names["passed"] == 0.0
        held += popsteer.Status.INPUT_HELD in answer.status
    assert held == 1
    assert one.state == other.state


@pytest.mark.parametrize("name", controllers.names())
@pytest.mark.parametrize("jump", [-2.0, -60.0, 2000.0])
def test_loop_that_tries_again_holds_one_cycle_of_each_of_its_steps(name: str, jump: float) -> None:
    path = popsteer.Path([(float(k), 0.0) for k in range(400)])
    car = popsteer.Vehicle(wheelbase=2.7)
    controller = controllers.get(name).controller(path, car)
    speeds, passed, last, held = popsteer.SpeedTracker(path, car), 0.0, 0.0, []
    for k in range(1, 2001):
        now = 0.05 * k + (jump if k > 200 else 0.0)
        passed, last = passed + now - last, now
        command = controller.step(0.1 * k, 0.0, 0.0, 2.0, passed)
        pace = speeds.step(0.1 * k, 0.0, 0.0, 2.0, passed)
        passed = 0.0
        if k == 200:
            before = command, pace
        known = (command.status, pace.status)
        if any(popsteer.Status.INPUT_HELD in status for status in known):
            assert set(known) == {popsteer.Status.INPUT_HELD}
            assert (command.steer, pace.acceleration) == (before[0].steer, before[1].acceleration)
            held.append(k)
    assert held == [201]


def driven(jump: float) -> tuple[list[float], set[str | None]]:
    """How far off its path a car drives whose clock is set after 10 s, and what its driver said."""
    driver, x, y, yaw, speed = popsteer.Driver(PATH, CAR), 0.0, 0.1, 0.0, 4.0
    flight, wheels, off, said = [0.0, 0.0], 0.0, [], set()
    for dt, _ in drive(jump):
        answer = driver.step(x, y, yaw, speed, dt)
        off.append(answer.cross_track_error)
        said.add(answer.fault)
        flight.append(answer.steer)
        for _ in range(10):
            wheels += 0.05 * (flight[-3] - wheels)
            x += 0.005 * speed * math.cos(yaw)
            y += 0.005 * speed * math.sin(yaw)
            yaw += 0.005 * speed * math.tan(wheels) / CAR.wheelbase
            speed = max(speed + 0.005 * answer.acceleration, 0.0)
    return off, said


@pytest.mark.parametrize("jump", JUMPS)
def test_driver_drives_on_where_the_clock_is_set(jump: float) -> None:
    wanted, _ = driven(0.0)
    off, said = driven(jump)
    assert said == {None}
    assert max(abs(a - b) for a, b in zip(off, wanted, strict=True)) < 0.01
