"""A fresh path every cycle: `set_path` is no event unless the path lies elsewhere."""

from __future__ import annotations

import itertools
import math
import pickle
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import PathError, controllers
from studies.cars_loop import CAR
from studies.layout import table
from studies.replanning import (
    COURSE,
    DT,
    RATES,
    SPEED,
    STEPS,
    Planner,
    drive,
    local,
    replanned,
    replanning_lines,
    whole,
)

NAMES = controllers.names()
FADING = ("pid", "pure-pursuit", "stanley")

each_law = pytest.mark.parametrize("name", NAMES)
each_tracking = pytest.mark.parametrize("name", NAMES)


def _make(name: str, path: popsteer.Path, car: popsteer.Vehicle = CAR, **options: Any) -> Any:
    return controllers.get(name).controller(path, car, **options)


def _copied(path: popsteer.Path) -> popsteer.Path:
    copied: popsteer.Path = pickle.loads(pickle.dumps(path))
    return copied


def _cusps() -> popsteer.Path:
    """Ahead in a bend, back, and ahead again."""
    s = np.arange(0.0, 20.0, 0.5)
    ahead = np.column_stack((s, 0.01 * s * s))
    back = ahead[::-1][1:] + np.column_stack((np.zeros(39), 0.002 * (s[1:] ** 2)))
    xy = np.vstack((ahead, back, back[::-1][1:] - (0.0, 0.02)))
    return popsteer.Path(xy, reverse=[39 <= k < 78 for k in range(len(xy))])


@each_law
@pytest.mark.parametrize("vehicle", ["late", "bare"])
@pytest.mark.parametrize("way", ["course", "cusps", "closed"])
@pytest.mark.parametrize("copies", [False, True])
def test_same_path_at_every_step_changes_nothing(
    name: str, vehicle: str, way: str, copies: bool
) -> None:
    car = CAR if vehicle == "late" else popsteer.Vehicle(wheelbase=2.7)
    circle = [(20.0 * math.sin(0.1 * k), 20.0 - 20.0 * math.cos(0.1 * k)) for k in range(62)]
    paths = {"course": COURSE.whole(), "cusps": _cusps()}
    path = paths.get(way) or popsteer.Path(circle, closed=True)
    adapt = popsteer.AdaptParams() if vehicle == "late" else None
    still, swapped = (_make(name, path, car, adapt=adapt) for _ in range(2))
    for controller in (still, swapped):
        controller.reset(steer=0.1)  # a hand-over is under way at first
    x, y, yaw, speed = 1.0, 0.6, 0.05, 4.0
    for k in range(400):
        swapped.set_path(_copied(path) if copies else path)
        pose = (x, y, yaw, speed if k % 60 else math.nan)
        a, b = still.step_or_hold(*pose, DT), swapped.step_or_hold(*pose, DT)
        assert a == b, k
        assert still.state == swapped.state
        x, y, yaw, speed = popsteer.paper.kinematic_bicycle(x, y, yaw, speed, a.steer, 0.0, 2.7, DT)
        speed += 0.2 * ((-4.0 if a.reverse else 4.0) - speed)


@each_tracking
@pytest.mark.parametrize("hz", RATES)
@pytest.mark.parametrize("behind", [5.0, 0.3])
def test_local_paths_are_tracked_as_the_whole_course(name: str, hz: int, behind: float) -> None:
    run = local(name, hz, behind)
    assert run.mean <= 1.1 * whole(name).mean + 0.005
    assert run.controller.state.handover is None


@each_law
def test_local_path_of_the_same_course_makes_no_hand_over(name: str) -> None:
    handovers: list[object] = []

    def step(controller: Any, seen: Any, dt: float) -> Any:
        handovers.append(controller.state.handover)
        return controller.step(*seen, dt)

    replanned(name, Planner(COURSE, seed=1, noise=0.02), 20, step=step)
    assert set(handovers) == {None}


@each_tracking
@pytest.mark.parametrize(("hz", "behind"), list(itertools.product(RATES, (5.0, 0.3))))
def test_noisy_local_paths_leave_the_angle_calm(name: str, hz: int, behind: float) -> None:
    run, clean, noisy = local(name, hz, behind, 0.02), whole(name), whole(name, 0.02)
    assert np.abs(run.errors).max() <= np.abs(clean.errors).max() + 0.6  # on the course
    assert run.roughness <= (3.5 if name == "pid" else 2.0) * noisy.roughness
    estimate = run.controller.estimate
    assert abs(estimate.gain - 1.0) < 0.15
    assert abs(estimate.steer_offset) < 0.015
    assert abs(estimate.slip) < 0.015
    assert abs(estimate.slip_length) < 0.1 * CAR.wheelbase


@pytest.mark.parametrize("name", FADING)
@pytest.mark.parametrize("hz", [1, 4, 20])
def test_hand_over_to_paths_elsewhere_ends_in_its_time(name: str, hz: int) -> None:
    # Wheels that answer at once show the law's own angle.
    # The poses are those of a car that does not turn: no lateral limit, which is kept as measured.
    car = popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35, max_lateral_acceleration=None)
    straight = [popsteer.Path([(-20.0, y), (500.0, y)]) for y in (0.0, 0.5, 1.0)]
    controller, fresh = (_make(name, straight[0], car) for _ in range(2))
    for k in range(20):
        controller.step(0.4 * k, 0.0, 0.0, SPEED, DT)
    # To and fro, always 0.5 m aside of the last: the first hand-over is over after 1 s.
    every = 20 // hz
    order = itertools.cycle([1, 2])
    before, seen = controller.state.steer, []
    for k in range(20, 45):
        if k < 40 and (k - 20) % every == 0:
            path = straight[next(order)]
            controller.set_path(path)
        steer = controller.step(0.4 * k, 0.0, 0.0, SPEED, DT).steer
        seen.append(steer)
        if k == 20:
            assert abs(steer - before) <= 0.03, "the angle jumps"
    fresh.set_path(path)
    wanted = fresh.step(0.4 * 44, 0.0, 0.0, SPEED, DT).steer
    if name == "pid":  # its integral has gone on
        wanted = pytest.approx(wanted, abs=0.02)
    assert seen[-1] == wanted
    assert controller.state.handover is None


@pytest.mark.parametrize("name", NAMES)
def test_plan_that_jumps_aside_is_gone_over_to_without_a_jump(name: str) -> None:
    planner, aside = Planner(COURSE, seed=3), 0.0

    def replan(k: int, s: float) -> popsteer.Path:
        return planner.path(s, 0.5 if k >= 160 else 0.0)

    run = drive(_make(name, planner.path(1.35)), STEPS, course=COURSE, replan=replan)
    aside = float(np.abs(run.errors[-60:] - 0.5).mean())
    assert aside <= 1.2 * np.abs(whole(name).errors[-60:]).mean() + 0.05
    moves = np.abs(np.diff(run.angles))
    usual = np.abs(np.diff(whole(name).angles)).max()
    assert moves[158:].max() <= max(1.5 * usual, 0.4 * DT + 1e-9)
    estimate = run.controller.estimate
    assert abs(estimate.slip) < 0.01
    assert abs(estimate.gain - 1.0) < 0.1


def test_jump_aside_of_a_plan_is_no_kick_of_the_derivative() -> None:
    car = popsteer.Vehicle(wheelbase=2.7)
    ahead, aside = (popsteer.Path([(-20.0, y), (500.0, y)]) for y in (0.0, 0.2))
    pids = [popsteer.Pid(ahead, car, popsteer.PidParams(kd=kd)) for kd in (0.0, 1.0)]
    for pid in pids:
        pid.step(0.0, 0.0, 0.0, SPEED, DT)
        pid.set_path(aside)
        pid.step(0.4, 0.0, 0.0, SPEED, DT)
    assert pids[0].state.steer == pytest.approx(pids[1].state.steer, abs=1e-12)


def test_integral_carries_on_across_paths() -> None:
    pid = popsteer.Pid(COURSE.whole(), CAR)
    planner = Planner(COURSE, seed=5)
    run = drive(pid, 100, course=COURSE, replan=lambda _k, s: planner.path(s))
    buffer = pid.state.law.buffer
    assert len(buffer.terms) == 100
    assert buffer.sum == pytest.approx(float(np.sum(buffer.terms)), abs=1e-12)
    assert len(run.errors) == 100


@each_law
def test_plan_that_starts_ahead_of_the_vehicle_is_followed(name: str) -> None:
    straight = popsteer.Path([(-20.0, 0.0), (300.0, 0.0)])
    ahead = popsteer.Path([(12.0, 0.0), (14.0, 0.0), (300.0, 0.0)])
    swapped, still = _make(name, straight), _make(name, straight)
    for k in range(60):
        if k == 10:
            swapped.set_path(ahead)
        pose = (0.4 * k, 0.1, 0.0, SPEED)
        a, b = swapped.step(*pose, DT), still.step(*pose, DT)
        assert a.steer == pytest.approx(b.steer, abs=1e-9)
        assert swapped.state.handover is None


@each_law
def test_plan_of_two_points_is_followed(name: str) -> None:
    controller = _make(name, popsteer.Path([(float(k), 0.0) for k in range(60)]))
    still = _make(name, controller.path)
    for k in range(60):
        x = 0.4 * k
        controller.set_path(popsteer.Path([(x - 1.0, 0.0), (x + 25.0, 0.0)]))
        a, b = (each.step(x, 0.1, 0.0, SPEED, DT) for each in (controller, still))
        assert a.steer == pytest.approx(b.steer, abs=1e-9)


@each_law
def test_plan_that_is_refused_leaves_the_old_one(name: str) -> None:
    controller = _make(name, COURSE.whole())
    controller.step(0.0, 0.1, 0.0, SPEED, DT)
    path, state = controller.path, controller.state
    for points in ([(0.0, 0.0)], [(0.0, 0.0), (math.nan, 1.0)], []):
        with pytest.raises(PathError):
            controller.set_path(popsteer.Path(points))
    assert controller.path is path
    assert controller.state == state


@each_law
def test_path_driven_the_other_way_is_begun_anew(name: str) -> None:
    x = np.arange(0.0, 60.0)
    xy = np.column_stack((x, np.zeros_like(x)))
    controller = _make(name, popsteer.Path(xy))
    for k in range(30):
        controller.step(20.0 + 0.1 * k, 0.2, 0.0, 2.0, DT)
    back = popsteer.Path(xy[::-1], reverse=[True] * 60)
    controller.set_path(back)
    assert controller.step(23.0, 0.2, 0.0, 2.0, DT).reverse
    if name == "pid":
        assert len(controller.state.law.buffer.terms) <= 1


@each_law
def test_path_after_a_jump_of_the_vehicle_is_looked_at_as_awhole(name: str) -> None:
    controller = _make(name, COURSE.whole())
    controller.step(5.0, 0.1, 0.0, SPEED, DT)
    (x, y), (x1, y1) = COURSE.points(np.array([60.0, 60.1]))
    yaw = math.atan2(y1 - y, x1 - x)
    controller.relocalise(x, y, yaw)
    controller.set_path(popsteer.Path(COURSE.points(np.arange(2.0, 100.0, 0.7))))
    command = controller.step(x, y, yaw, SPEED, DT)
    assert abs(command.cross_track_error) < 0.2
    assert abs(command.heading_error) < 0.1


def test_local_path_keeps_the_branch_of_a_crossing() -> None:
    # Over a crossing: the path comes back over it square, nearer to the vehicle.
    xy = [(-30.0, 0.0), (30.0, 0.0), (30.0, 30.0), (0.1, 30.0), (0.1, -30.0)]
    controller = popsteer.Stanley(popsteer.Path(xy[:2]), CAR)
    controller.step(0.0, 0.1, 0.0, SPEED, DT)
    controller.set_path(popsteer.Path([(-31.0, 0.0), *xy[1:]]))
    assert controller.state.waypoint == 0
    command = controller.step(0.4, 0.1, 0.0, SPEED, DT)
    assert command.cross_track_error == pytest.approx(0.1)


def test_page_table_of_replanning_is_what_is_driven() -> None:
    rows = replanning_lines()
    assert table("loop.md", "replanning") == rows


def _three_points() -> tuple[Any, list[float]]:
    """Ahead to the left, back to the other side, and ahead again: points and speeds."""
    x, y, yaw, step, points, speeds = 0.0, 0.0, 0.0, 0.2, [], []
    for curvature, sign in ((0.2, 1.0), (-0.2, -1.0), (0.2, 1.0)):
        for _ in range(30):
            points.append((x, y))
            speeds.append(sign)
            yaw += sign * step * curvature
            x, y = x + sign * step * math.cos(yaw), y + sign * step * math.sin(yaw)
    return np.array([*points, (x, y)]), [*speeds, 1.0]


@pytest.mark.parametrize("noise", [None, 0.0, 0.01], ids=["once", "same", "noise"])
def test_turn_of_three_points_planned_in_every_cycle_is_driven_to_its_end(
    noise: float | None,
) -> None:
    # Its wheels turn at rest: a path that is sent again once began to wait for them anew, and one
    # that is a centimetre off at its cusp was taken back to the leg before.
    points, speeds = _three_points()
    car = popsteer.Vehicle(wheelbase=2.7, steers_at_rest=True, max_steer_rate=0.5, steer_lag=0.1)
    driver = popsteer.Driver(popsteer.Path(points, speed=speeds), car)
    rng = np.random.default_rng(0)
    x = y = yaw = speed = wheel = 0.0
    for _ in range(3000):
        if noise is not None:
            off = rng.normal(0.0, noise, points.shape) if noise > 0.0 else 0.0
            driver.set_path(popsteer.Path(points + off, speed=speeds))
        command = driver.step(x, y, yaw, speed, 0.02)
        assert command.fault is None
        wheel += 0.02 * min(max((command.steer - wheel) / 0.1, -0.5), 0.5)
        gear = -1.0 if command.reverse else 1.0
        # Brakes hold, and do not push back.
        driven = max(gear * speed + 0.02 * command.acceleration, 0.0)
        speed = 0.0 if command.hold else gear * driven
        yaw += 0.02 * speed * math.tan(wheel) / 2.7
        x, y = x + 0.02 * speed * math.cos(yaw), y + 0.02 * speed * math.sin(yaw)
    assert command.phase == "standing"
    assert math.dist((x, y), points[-1]) < 0.05
