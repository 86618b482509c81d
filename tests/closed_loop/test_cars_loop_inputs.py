"""Inputs that fail to come: the first good step takes the time that has really passed."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import Status, controllers
from studies.cars_loop import CAR
from studies.layout import table
from studies.replanning import (
    COURSE,
    DT,
    SPEED,
    STEPS,
    drive,
    every_second,
    gaps,
    input_lines,
    jitter,
    make,
    whole,
)

NAMES = controllers.names()
PATTERNS = {"every second": every_second, "gaps": gaps}

each_law = pytest.mark.parametrize("name", NAMES)
each_tracking = pytest.mark.parametrize("name", NAMES)


def _is_calm(controller: Any) -> bool:
    """Whether no estimate has moved by more than a tenth of its bound."""
    estimate, car = controller.estimate, controller.vehicle
    return bool(
        0.94 < estimate.gain < 1.15
        and abs(estimate.steer_offset - car.steer_offset) <= 0.015
        and abs(estimate.dead_time - car.dead_time) <= 0.05 * car.dead_time
        and abs(estimate.slip) <= 0.015
        and abs(estimate.slip_length) <= 0.1 * car.wheelbase
    )


@each_tracking
@pytest.mark.parametrize("pattern", PATTERNS)
def test_lost_inputs_cost_little(name: str, pattern: str) -> None:
    calm = []

    def step(controller: Any, seen: Any, dt: float) -> Any:
        command = controller.step_or_hold(*seen, dt)
        calm.append(_is_calm(controller))
        return command

    run = drive(make(name), STEPS, course=COURSE, arrives=PATTERNS[pattern], step=step)
    assert run.mean <= 1.2 * whole(name).mean + 0.03
    assert all(calm)


@each_tracking
def test_dt_that_jitters_by_half_is_no_event(name: str) -> None:
    controller = make(name)
    run = drive(controller, STEPS, course=COURSE, dts=jitter())
    assert run.mean <= 1.2 * whole(name).mean + 0.03
    assert _is_calm(controller)


def _loops(name: str, car: popsteer.Vehicle, lost: set[int]) -> tuple[Any, Any]:
    """The same drive with `step`, which is given the time that has passed, and `step_or_hold`."""
    stepped, held = make(name, car=car), make(name, car=car)
    passed = 0.0
    for k in range(121):
        s = COURSE.points(np.array([0.4 * k, 0.4 * k + 0.1]))
        yaw = math.atan2(*(s[1] - s[0])[::-1])
        pose = (s[0][0], s[0][1] + 0.3 * math.cos(0.2 * k), yaw, SPEED)
        passed += DT
        if k in lost:
            before = stepped.state
            with pytest.raises(popsteer.InputError):
                stepped.step(math.nan, *pose[1:], DT)
            assert stepped.state == before
            command = held.step_or_hold(math.nan, *pose[1:], DT)
            assert command.status == Status.INPUT_HELD
            assert command.steer == stepped.state.steer
        else:
            one, other = stepped.step(*pose, passed), held.step_or_hold(*pose, DT)
            passed = 0.0
            assert one == other, k
    return stepped, held


@each_law
@pytest.mark.parametrize("missed", [1, 5, 9])
@pytest.mark.parametrize("late", [False, True])
def test_both_loops_give_the_same_angles(name: str, missed: int, late: bool) -> None:
    car = CAR if late else popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35)
    # A rate limit knows that the wheels do not turn while a command is held; see the next test.
    car = car.replace(max_steer_rate=None)
    lost = {k for k in range(5, 120) if k % (missed + 7) >= 7}
    stepped, held = _loops(name, car, lost)
    assert stepped.state == held.state


@each_law
@pytest.mark.parametrize("wheelbase", [0.16, 2.7, 12.0])
@pytest.mark.parametrize("missed", [1, 5, 40])
def test_wheels_turn_in_no_time_that_was_held(name: str, missed: int, wheelbase: float) -> None:
    car = popsteer.Vehicle(wheelbase=wheelbase, max_steer=0.6, max_steer_rate=0.3)
    path = popsteer.Path([(wheelbase * k, 0.0) for k in range(60)])
    law = controllers.get(name).controller(path, car)
    speed = 2.0 * wheelbase
    # It comes back after the gap a wheelbase beside the path, and wants to turn far.
    for k in range(20 + missed):
        x = math.nan if k >= 20 else speed * DT * k
        before = law.step_or_hold(x, 0.0, 0.0, speed, DT).steer
    after = law.step_or_hold(speed * DT * k, wheelbase, 0.0, speed, DT).steer
    assert abs(after - before) <= 0.3 * DT + 1e-12


@pytest.mark.parametrize("missed", [1, 5, 9])
def test_pid_after_missing_inputs_is_far_from_full_lock(missed: int) -> None:
    # Slanting off at 10 m/s: 0.5 m a second to the side.
    path = popsteer.Path([(-10.0, 0.0), (300.0, 0.0)])
    pid = popsteer.Pid(path, popsteer.Vehicle(wheelbase=2.7, max_lateral_acceleration=None))
    steers = []
    for k in range(40):
        t = DT * k
        x = math.nan if 20 <= k < 20 + missed else 10.0 * t
        steers.append(pid.step_or_hold(x, 0.5 * t, 0.05, 10.0, DT).steer)
    # The derivative is that of the motion, whatever fails to come.
    moves = np.abs(np.diff(steers))
    assert moves[3:].max() <= 0.01 * (missed + 1)


def test_nothing_is_estimated_across_a_gap() -> None:
    # Preview POP, which learns from all motion, sees one of another curvature in the gap.
    controller = popsteer.PreviewPop(COURSE.whole(), CAR)
    for k in range(40):
        controller.step(0.4 * k, 0.0, 0.0, SPEED, DT)
    before = controller.estimate
    for _ in range(25):
        controller.step_or_hold(math.nan, 0.0, 0.0, SPEED, DT)
    controller.step(0.4 * 65, 0.4, 0.3, SPEED, DT)
    assert controller.estimate == before


@pytest.mark.parametrize("dt", [0.0, -0.04, -60.0, 2000.0, math.nan, math.inf])
def test_dt_that_is_refused_counts_as_no_time(dt: float) -> None:
    one, other = (popsteer.Pid(COURSE.whole(), CAR) for _ in range(2))
    for controller in (one, other):
        controller.step(0.0, 0.2, 0.0, SPEED, 0.04)
    for _ in range(100):
        held = other.step_or_hold(0.4, 0.2, 0.0, SPEED, dt, hold_limit=100)
        assert held.status == Status.INPUT_HELD
    assert other.state.held_time == 0.0
    # The next stamp tells all of it.
    assert one.step(0.8, 0.1, 0.0, SPEED, 0.08) == other.step(0.8, 0.1, 0.0, SPEED, 0.08)
    assert other.state.period == 0.08


@pytest.mark.parametrize("ticks", [2, 3, 5])
@pytest.mark.parametrize("period", [0.004, 0.01, 0.02])
def test_clock_that_repeats_its_stamps_counts_the_time_that_passes(
    ticks: int, period: float
) -> None:
    controller = popsteer.PreviewPop(popsteer.Path([(0.0, 0.0), (100.0, 0.0)]), CAR)
    for k in range(300):
        dt = 0.0 if k % ticks else ticks * period
        command = controller.step_or_hold(6.0 * period * k, 0.0, 0.0, 6.0, dt)
        assert command.status.level != "fault"
        if k % ticks == 0:
            assert controller.state.period == pytest.approx(ticks * period)


def test_time_held_for_ever_is_bounded() -> None:
    pid = popsteer.Pid(COURSE.whole(), CAR)
    for _ in range(4):
        pid.step_or_hold(math.nan, 0.0, 0.0, SPEED, 900.0)
    assert pid.state.held_time == 1e3
    assert math.isfinite(pid.step(0.0, 0.1, 0.0, SPEED, 900.0).steer)


def test_page_table_of_inputs_is_what_is_driven() -> None:
    rows = input_lines()
    assert table("loop.md", "missing inputs") == rows
