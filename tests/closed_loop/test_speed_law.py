"""The law of the speed on a vehicle of these tests: stops, gears, jerks, ages and slopes."""

from __future__ import annotations

import math
import random
from typing import Any

import numpy as np
import pytest

import popsteer
from studies import stopping
from tests.helpers import looped

STEP = 0.005


class Rail:
    """A vehicle on the x axis: a delay, a lag, brakes that hold, a gearbox that shifts at rest."""

    def __init__(
        self, x: float, speed: float = 0.0, *, delay: float = 0.1, lag: float = 0.2
    ) -> None:
        self.x, self.speed, self.pull, self.lag = x, speed, 0.0, lag
        self.flight = [0.0] * round(delay / STEP)
        self.gear, self.shift, self.asked = 1.0, 0.0, 0.0
        self.slope, self.share = 0.0, 1.0

    def drive(self, command: popsteer.SpeedCommand | popsteer.Drive, time: float) -> None:
        for _ in range(round(time / STEP)):
            self.flight.append(command.acceleration)
            wanted = self.flight.pop(0)
            wanted *= self.share if wanted < 0.0 else 1.0
            kept = math.exp(-STEP / self.lag) if self.lag else 0.0
            self.pull = wanted + (self.pull - wanted) * kept
            gear = -1.0 if command.reverse else 1.0
            self.asked = 0.0 if gear == self.gear or self.speed != 0.0 else self.asked + STEP
            if self.asked > self.shift:
                self.gear = gear
            free = self.speed + STEP * (self.slope + self.gear * max(self.pull, 0.0))
            braked = STEP * max(-self.pull, 0.0)
            self.speed = math.copysign(max(abs(free) - braked, 0.0), free) + 0.0
            self.x += STEP * self.speed


def line(length: int, speed: float | None = None, stop: int | None = None) -> popsteer.Path:
    speeds = None if speed is None else [0.0 if k == stop else speed for k in range(length + 1)]
    return popsteer.Path([(float(k), 0.0) for k in range(length + 1)], speed=speeds)


def run(tracker: Any, car: Rail, seconds: float, dt: float = 0.05) -> list[popsteer.SpeedCommand]:
    commands = []
    for _ in range(round(seconds / dt)):
        commands.append(tracker.step(car.x, 0.0, 0.0, car.speed, dt))
        car.drive(commands[-1], dt)
    return commands


@looped("told", [True, False])
def test_no_stop_of_many_is_driven_through_or_waited_for(told: bool) -> None:
    for seed in range(60):
        case = stopping.draw(seed, told=told)
        found = stopping.stop(case, seed)
        assert not found.through, (seed, case, found)
        assert found.stands, (seed, case, found)
        if told:
            assert stopping.fails(case, found) == [], (seed, case, found)


@looped("seed", [302, 479, 572, 930, 1273, 1470, 2120, 2376])
def test_weak_brakes_of_a_long_vehicle_are_asked_for_more_until_it_stops(seed: int) -> None:
    case = stopping.draw(seed, told=False)
    found = stopping.stop(case, seed)
    assert stopping.fails(case, found) == [], (case, found)


@looped("seed", [76, 126, 282, 527, 748, 825, 1043, 1149, 1357, 1435, 1611, 1830, 2033, 2900])
def test_weak_brakes_are_found_in_time_to_stop_by(seed: int) -> None:
    case = stopping.draw(seed, told=False)
    found = stopping.stop(case, seed)
    assert stopping.fails(case, found) == [], (case, found)


def _braked(rail: Rail, *, share: float = 1.0, slope: float = 0.0) -> list[float]:
    """What brakes are believed to give beyond what they are told, in a drive to its end."""
    car = popsteer.Vehicle(wheelbase=2.7, drive_delay=0.1, drive_lag=0.2)
    tracker = popsteer.SpeedTracker(line(150, 12.0), car)
    rail.slope, rail.share = slope, share
    found = []
    for _ in range(700):
        command = tracker.step(rail.x, 0.0, 0.0, rail.speed, 0.05)
        rail.drive(command, 0.05)
        bias = tracker.state.law.observer.bias
        found.append(0.0 if bias is None else bias.mean[0])
    assert command.standing
    assert rail.speed == 0.0
    assert abs(rail.x - 150.0) < 0.15
    return found


def test_brakes_that_give_less_are_known_within_their_first_braking() -> None:
    assert min(_braked(Rail(0.0, 12.0))) > -0.02
    found = _braked(Rail(0.0, 12.0), share=0.7)
    first = next(k for k, value in enumerate(found) if value < -0.02)
    assert -0.35 < found[first + 16] < -0.2


@looped("slope", [-0.8, -0.4, 0.4, 0.8])
def test_slope_that_nobody_told_is_not_taken_for_weak_brakes(slope: float) -> None:
    assert min(_braked(Rail(0.0, 12.0), slope=slope)) > -0.1


@looped("delay, lag", [(0.3, 0.2), (0.1, 0.5), (0.0, 0.1)])
def test_drive_that_is_late_or_early_is_not_taken_for_weak_brakes(delay: float, lag: float) -> None:
    found = _braked(Rail(0.0, 12.0, delay=delay, lag=lag))
    assert min(found) > -0.25
    assert found[-1] > -0.15


@looped("speed", [0.05, 0.2, 0.4])
def test_plan_slower_than_a_vehicle_creeps_is_kept(speed: float) -> None:
    tracker = popsteer.SpeedTracker(line(100, speed), popsteer.Vehicle(wheelbase=10.0))
    rail = Rail(0.0, delay=0.0, lag=0.0)
    commands = run(tracker, rail, 60.0)
    assert max(command.reference_speed for command in commands) == pytest.approx(speed)
    assert rail.speed == pytest.approx(speed, abs=0.01)
    assert rail.x == pytest.approx(60.0 * speed, rel=0.1)


@looped("lag", [0.15, 0.45, 0.8])
def test_stop_line_is_stopped_at_as_the_end_of_a_path_is(lag: float) -> None:
    car = popsteer.Vehicle(
        wheelbase=2.7,
        drive_delay=0.3,
        drive_lag=lag,
        max_speed=8.0,
        max_acceleration=0.8,
        max_deceleration=1.0,
    )
    for path in (line(100, 8.0, 60), line(60, 8.0)):
        rail = Rail(0.0, delay=0.3, lag=lag)
        last = run(popsteer.SpeedTracker(path, car), rail, 60.0)[-1]
        assert rail.x == pytest.approx(60.0, abs=0.05)
        assert last.standing
        assert last.phase == "standing"


@pytest.mark.parametrize("left", [1e-300, 1e-12, 9e-4])
def test_speed_of_0_that_rounding_left_over_is_a_stop(left: float) -> None:
    car = popsteer.Vehicle(wheelbase=2.7)
    stop, rounded = ([5.0] * 30 + [at] + [5.0] * 30 for at in (0.0, left))
    plans = [
        popsteer.SpeedTracker(popsteer.Path([(k, 0.0) for k in range(61)], speed=speed), car).plan
        for speed in (stop, rounded)
    ]
    assert (plans[0] == plans[1]).all()
    assert plans[1][30] == 0.0


@looped("lag", [0.3, 0.4, 0.5])
def test_drive_that_answers_later_than_told_is_no_push_that_holds_it_short(lag: float) -> None:
    car = popsteer.Vehicle(wheelbase=2.7, drive_lag=0.2, max_deceleration=3.0)
    tracker, rail = popsteer.SpeedTracker(line(60, 5.0, 30), car), Rail(0.0, lag=lag)
    commands = run(tracker, rail, 20.0)
    assert commands[-1].standing
    assert rail.x == pytest.approx(30.0, abs=0.3)


def test_stop_that_is_overrun_is_stood_at_and_said() -> None:
    car = popsteer.Vehicle(wheelbase=2.7, drive_lag=0.2, max_deceleration=3.0)
    tracker = popsteer.SpeedTracker(line(60, 5.0, 30), car)
    rail = Rail(0.0)
    run(tracker, rail, 20.0)
    rail.x += 0.3  # pushed over its line
    commands = run(tracker, rail, 30.0)
    assert rail.x == pytest.approx(30.3, abs=0.05)
    assert all(command.standing for command in commands)
    assert commands[-1].cannot_stop
    assert commands[-1].distance_to_stop == pytest.approx(30.0 - rail.x)


@looped("shift", [0.0, 0.5, 1.5])
@looped("reported", [True, False])
def test_gearbox_that_shifts_at_rest_passes_the_cusp(shift: float, reported: bool) -> None:
    for size in (0.12, 1.0, 3.0):
        xs = [0.3 * size * k for k in range(51)] + [size * (15 - 0.3 * k) for k in range(1, 34)]
        speeds = [2.0 * size] * 50 + [-2.0 * size] * 34
        path = popsteer.Path([(x, 0.0) for x in xs], speed=speeds)
        car = popsteer.Vehicle(
            wheelbase=2.7 * size, drive_lag=0.2, max_acceleration=1.0, max_deceleration=1.0
        )
        tracker, rail = popsteer.SpeedTracker(path, car), Rail(0.0)
        rail.shift, farthest = shift, 0.0
        for _ in range(1200):
            gear = rail.gear < 0.0 if reported else None
            command = tracker.step(rail.x, 0.0, 0.0, rail.speed, 0.05, reverse_gear=gear)
            rail.drive(command, 0.05)
            farthest = max(farthest, rail.x)
        assert farthest == pytest.approx(15.0 * size, abs=0.15), (size, farthest)
        assert rail.x == pytest.approx(size * 5.1, abs=0.1), (size, rail.x)
        assert command.standing


def test_vehicle_that_rolls_the_other_way_brakes() -> None:
    car = popsteer.Vehicle(wheelbase=2.7, max_acceleration=1.0, max_deceleration=1.5)
    for speed in (3.0, 0.5, 0.1):
        path = popsteer.Path([(20.0 - k, 0.0) for k in range(21)], speed=[-2.0] * 21)
        tracker, rail = popsteer.SpeedTracker(path, car), Rail(20.0, speed)
        first = tracker.step(20.0, 0.0, 0.0, speed, 0.05)
        assert first.acceleration < 0.0
        assert not first.reverse
        assert first.phase == "shifting"
        run(tracker, rail, 40.0)
        assert rail.x == pytest.approx(0.0, abs=0.05)


@pytest.mark.parametrize("resent", [False, True])
def test_phases_follow_each_other_once_in_noise(*, resent: bool) -> None:
    """A stop whose curve is nearly the plan's binds until the vehicle stands."""
    draw = np.random.default_rng(5)
    for wheelbase in (0.6, 2.7, 9.0):
        xs = np.arange(0.0, 121.0)
        path = popsteer.Path(np.c_[xs, 0.0 * xs])
        driver = popsteer.Driver(path, popsteer.Vehicle(wheelbase=wheelbase, max_speed=9.0))
        rail, y, yaw = Rail(0.0), 0.0, 0.0
        phases: list[str] = []
        for _ in range(1000):
            if resent and 60.0 < rail.x < 110.0:
                rest = xs[int(rail.x) - 5 :]
                driver.set_path(popsteer.Path(np.c_[rest, draw.normal(0.0, 0.01, len(rest))]))
            off, aside, faster = draw.normal(0.0, [0.02, 0.02, 0.008])
            answer = driver.step(rail.x + off, y + aside, yaw, rail.speed + faster, 0.05)
            rail.drive(answer, 0.05)
            y += 0.05 * rail.speed * yaw
            yaw += 0.05 * rail.speed * math.tan(answer.steer) / wheelbase
            if phases[-1:] != [answer.phase]:
                phases.append(answer.phase)
        assert phases == ["driving", "stopping", "standing"], (wheelbase, phases)


def test_path_that_is_sent_again_keeps_its_stop() -> None:
    for behind in (2, 1, 0):
        for wheelbase in (0.6, 2.7, 9.0):
            g, speeds = np.arange(0.0, 120.0), np.full(120, 8.0)
            speeds[60] = 0.0
            whole = np.column_stack((g, 0.0 * g))
            tracker = popsteer.SpeedTracker(
                popsteer.Path(whole, speed=speeds), popsteer.Vehicle(wheelbase=wheelbase)
            )
            rail = Rail(0.0, lag=0.0)
            for k in range(900):
                if k % 2:
                    first = min(117, max(0, int(rail.x + 0.5) - behind))
                    tracker.set_path(popsteer.Path(whole[first:], speed=speeds[first:]))
                rail.drive(tracker.step(rail.x, 0.0, 0.0, rail.speed, 0.05), 0.05)
            assert rail.x == pytest.approx(60.0, abs=0.06), (behind, wheelbase)
            # A path without the stop tells it to go on.
            tracker.set_path(popsteer.Path(whole, speed=np.full(120, 8.0)))
            run(tracker, rail, 30.0)
            assert rail.x == pytest.approx(119.0, abs=0.06), (behind, wheelbase)


@looped("age", [0.1, 0.3, 0.5])
def test_old_pose_and_speed_shift_no_stop(age: float) -> None:
    for speed in (5.0, 15.0):
        car = popsteer.Vehicle(wheelbase=2.7, drive_lag=0.2, max_speed=speed, max_deceleration=3.0)
        tracker, rail = popsteer.SpeedTracker(line(100), car), Rail(0.0)
        past: list[tuple[float, float]] = []
        for _ in range(800):
            past.append((rail.x, rail.speed))
            back = min(round(age / 0.05), len(past) - 1)
            x, v = past[-1 - back]
            rail.drive(tracker.step(x, 0.0, 0.0, v, 0.05, pose_age=0.05 * back), 0.05)
        assert rail.x == pytest.approx(100.0, abs=0.05)


@looped("wheelbase", [0.16, 0.33, 1.0, 2.7, 12.0])
def test_motionless_vehicle_is_held_through_noise(wheelbase: float) -> None:
    r = random.Random(1)
    tracker = popsteer.SpeedTracker(
        popsteer.Path([(0.0, 0.0), (3.0, 0.0)]), popsteer.Vehicle(wheelbase=wheelbase)
    )
    stands = [
        tracker.step(3.0 + r.gauss(0.0, 0.02), r.gauss(0.0, 0.02), 0.0, 0.0, 0.05).standing
        for _ in range(12_000)
    ]
    first = stands.index(True)
    assert first < 100
    assert all(stands[first:])


@looped("jerk", [1.0, 2.0, 5.0, 20.0, 100.0])
def test_jerk_is_part_of_the_plan_in_bends_and_at_the_top_speed(jerk: float) -> None:
    s = np.arange(0.0, 400.0, 0.5)
    bend = np.where((s > 250.0) & (s < 281.0), 1.0 / 20.0, 0.0)
    yaw = np.cumsum(bend) * 0.5
    xy = np.column_stack((np.cumsum(np.cos(yaw)), np.cumsum(np.sin(yaw)))) * 0.5
    tracker = popsteer.SpeedTracker(
        popsteer.Path(xy),
        popsteer.Vehicle(wheelbase=2.7, max_speed=15.0, drive_delay=0.0),
        popsteer.SpeedTrackerParams(max_jerk=jerk),
    )
    along = speed = last = side = top = 0.0
    while along < 380.0:
        at = int(along / 0.5)
        command = tracker.step(xy[at, 0], xy[at, 1], yaw[at], speed, 0.05)
        assert abs(command.acceleration - last) <= 0.05 * jerk + 1e-9
        last = command.acceleration
        speed = max(0.0, speed + 0.05 * last)
        along += 0.05 * speed
        side, top = max(side, speed * speed * bend[at]), max(top, speed)
    assert side <= 4.0 * 1.03
    assert top <= 15.0 * 1.03


def test_leg_of_one_segment_is_driven_like_any_other() -> None:
    car = popsteer.Vehicle(wheelbase=2.7, max_speed=5.0)
    for points, reverse in (
        ([(0.0, 0.0), (50.0, 0.0), (0.0, 0.0)], [False, True, True]),
        ([(0.0, 0.0), (50.0, 0.0), (25.0, 0.0), (0.0, 0.0)], [False, True, True, True]),
    ):
        tracker = popsteer.SpeedTracker(popsteer.Path(points, reverse=reverse), car)
        rail, steps = Rail(50.0), 0
        rail.gear = -1.0
        while rail.x > 0.1 and steps < 9000:
            rail.drive(tracker.step(rail.x, 0.0, 0.0, rail.speed, 0.05), 0.05)
            steps += 1
        assert 0.05 * steps < 22.0, points


def test_stop_point_stops_at_its_line_and_a_cusp_is_the_rear_axles() -> None:
    for wheelbase, ahead in ((2.7, 3.6), (7.5, 9.0), (0.33, 0.4)):
        car = popsteer.Vehicle(wheelbase=wheelbase, stop_point=ahead, max_speed=4.0)
        for path in (line(60, 4.0, 30), line(30, 4.0)):
            tracker, rail = popsteer.SpeedTracker(path, car), Rail(0.0, lag=0.0)
            first = tracker.step(0.0, 0.0, 0.0, 0.0, 0.05)
            assert first.distance_to_stop == pytest.approx(30.0 - ahead)
            run(tracker, rail, 40.0)
            assert rail.x + ahead == pytest.approx(30.0, abs=0.05)
        turn = popsteer.Path(
            [(0, 0), (10, 0), (20, 0), (10, 0)], reverse=[False, False, True, True]
        )
        tracker = popsteer.SpeedTracker(turn, car)
        assert tracker.step(0.0, 0.0, 0.0, 0.0, 0.05).distance_to_stop == pytest.approx(20.0)


@looped("grade", [0.08, 0.15])
@looped("told", [True, False])
@looped("reported", [True, False])
def test_start_uphill_after_a_leg_backwards_is_no_gear_that_is_not_in(
    grade: float, told: bool, reported: bool
) -> None:
    back, on = [(-0.5 * k, 0.0) for k in range(41)], [(0.5 * k - 20.0, 0.0) for k in range(1, 61)]
    grades = [grade] * 101 if told else None
    path = popsteer.Path([*back, *on], reverse=[True] * 40 + [False] * 61, grade=grades)
    for wheelbase in (0.5, 2.7, 8.0):
        car = popsteer.Vehicle(wheelbase=wheelbase, drive_lag=0.2, max_speed=2.0)
        tracker, rail, least = popsteer.SpeedTracker(path, car), Rail(0.0), 0.0
        rail.slope = -9.80665 * math.sin(math.atan(grade))
        for _ in range(1600):
            gear = rail.gear < 0.0 if reported else None
            command = tracker.step(rail.x, 0.0, 0.0, rail.speed, 0.05, reverse_gear=gear)
            rail.drive(command, 0.05)
            least = min(least, rail.x)
        assert least > -20.5, (wheelbase, least)
        assert rail.x == pytest.approx(10.0, abs=0.1), (wheelbase, rail.x)
        assert command.standing, wheelbase


@looped("grade", [-0.25, -0.17, 0.17, 0.25])
@looped("told", [True, False])
def test_end_on_a_slope_is_stood_at_where_the_brakes_hold(grade: float, told: bool) -> None:
    for wheelbase in (0.6, 2.7, 9.0):
        path = line(100, 5.0)
        if told:
            path = (
                path.with_grade([grade] * 101)
                if hasattr(path, "with_grade")
                else popsteer.Path(
                    np.column_stack((path.x, path.y)), speed=path.speed, grade=[grade] * 101
                )
            )
        car = popsteer.Vehicle(wheelbase=wheelbase, drive_lag=0.2, max_acceleration=4.0)
        tracker, rail = popsteer.SpeedTracker(path, car), Rail(60.0, 5.0)
        rail.slope = -9.80665 * math.sin(math.atan(grade))
        commands = run(tracker, rail, 60.0)
        assert rail.x == pytest.approx(100.0, abs=0.3), (wheelbase, rail.x)
        assert all(command.standing for command in commands[-200:]), wheelbase
        assert rail.speed == 0.0


def test_fault_of_the_inputs_is_braked_for_and_said() -> None:
    car = popsteer.Vehicle(wheelbase=2.7, max_speed=8.0)
    for fault in ("frozen", "dead speed"):
        tracker, rail = popsteer.SpeedTracker(line(200), car), Rail(0.0)
        run(tracker, rail, 8.0)
        x, said, speeds = rail.x, 0, []
        for _ in range(200):
            if fault == "frozen":
                command = tracker.step(x, 0.0, 0.0, rail.speed, 0.05)
            else:
                command = tracker.step(rail.x, 0.0, 0.0, 0.0, 0.05)
            said += popsteer.Status.IMPLAUSIBLE in command.status
            rail.drive(command, 0.05)
            speeds.append(rail.speed)
        assert said > 10, fault
        # At rest neither shows: it may go on then, and brakes again.
        stood = speeds.index(0.0)
        assert stood < 80, fault
        assert max(speeds[stood:]) < 2.0, fault


def test_operator_stops_the_vehicle_and_lets_it_go() -> None:
    tracker, rail = popsteer.SpeedTracker(line(100), popsteer.Vehicle(wheelbase=2.7)), Rail(0.0)
    run(tracker, rail, 5.0)
    for _ in range(200):
        command = tracker.step(rail.x, 0.0, 0.0, rail.speed, 0.05, stop=True)
        rail.drive(command, 0.05)
    assert rail.speed == 0.0
    assert (command.standing, command.phase) == (True, "stopped")
    run(tracker, rail, 40.0)
    assert rail.x == pytest.approx(100.0, abs=0.05)


def test_delay_told_to_the_tracker_takes_the_place_of_the_vehicles() -> None:
    path = popsteer.Path([(float(x), 0.0) for x in range(41)])

    def driven(delay: float, params: popsteer.SpeedTrackerParams) -> list[float]:
        car = popsteer.Vehicle(drive_delay=delay, drive_lag=0.2)
        tracker, rail, speeds = popsteer.SpeedTracker(path, car, params), Rail(0.0, delay=0.3), []
        for _ in range(600):
            rail.drive(tracker.step(rail.x, 0.0, 0.0, rail.speed, 0.05), 0.05)
            speeds.append(rail.speed)
        assert rail.x == pytest.approx(40.0, abs=0.02)
        return speeds

    told = driven(0.1, popsteer.SpeedTrackerParams(drive_delay=0.3))
    assert told == driven(0.3, popsteer.SpeedTrackerParams())


@looped("wheelbase", [0.33, 1.2, 2.7, 7.5])
def test_end_of_a_path_that_is_resent_with_noise_keeps_the_vehicle_held(wheelbase: float) -> None:
    draw = np.random.default_rng(5)
    car = popsteer.Vehicle(wheelbase=wheelbase, rear_axle=0.0, drive_lag=0.2, max_speed=3.0)
    x = np.arange(31.0)
    tracker, rail = popsteer.SpeedTracker(popsteer.Path(np.c_[x, 0.0 * x]), car), Rail(0.0)
    held = []
    for _ in range(1000):
        tracker.set_path(popsteer.Path(np.c_[x + draw.normal(0.0, 0.01, 31), 0.0 * x]))
        command = tracker.step(rail.x, 0.0, 0.0, rail.speed, 0.05)
        rail.drive(command, 0.05)
        held.append(command.standing)
    assert rail.x == pytest.approx(30.0, abs=0.06)
    assert all(held[-500:])
    # An end that moves away is driven to.
    tracker.set_path(popsteer.Path(np.c_[x + 0.5, 0.0 * x]))
    for _ in range(400):
        rail.drive(tracker.step(rail.x, 0.0, 0.0, rail.speed, 0.05), 0.05)
    assert rail.x == pytest.approx(30.5, abs=0.06)
