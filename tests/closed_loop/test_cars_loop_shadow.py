"""What a car reports beside its pose: the angle applied, and how old the pose is; what it intends.

The car is `Chain`, which is none of the library's own plants.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import popsteer
from studies.chain import Chain
from studies.dead_time import CAR as DELAYED
from studies.dead_time import SLALOM, START, age_lines, mean_error
from studies.layout import table

DT = 0.05
PROMPT = DELAYED.replace(dead_time=0.0)
NAMES = ["Pop", "PreviewPop", "Pid", "PurePursuit", "Stanley"]
each_controller = pytest.mark.parametrize("name", NAMES)
each_car = pytest.mark.parametrize("car", [DELAYED, PROMPT], ids=["late", "prompt"])


def _made(name: str, car: popsteer.Vehicle) -> Any:
    return getattr(popsteer, name)(SLALOM, car)


def _log(name: str, car: popsteer.Vehicle, steps: int = 300) -> list[tuple[Any, float]]:
    """Poses and speed of a drive, each with the angle that was commanded then."""
    chain = Chain(car, START, 8.0, DT, substeps=20)
    driver = _made(name, car)
    log = []
    for _ in range(steps):
        inputs = (*chain.pose, chain.speed, DT)
        steer = driver.step(*inputs).steer
        log.append((inputs, steer))
        chain.advance(steer)
    return log


def _watch(controller: Any, log: list[tuple[Any, float]]) -> list[popsteer.Command]:
    """The answers of a controller that only watches."""
    applied = [None, *(steer for _, steer in log)]
    return [
        controller.step(*inputs, applied_steer=steer)
        for (inputs, _), steer in zip(log, applied, strict=False)
    ]


@each_controller
@each_car
def test_shadow_answers_depend_on_the_log_alone(name: str, car: popsteer.Vehicle) -> None:
    log = _log("PreviewPop", car)[1:]
    clean, spoilt = _made(name, car), _made(name, car)
    # Both have seen the same once; one of them would have commanded something else.
    for controller in (clean, spoilt):
        controller.step(*log[0][0])
    spoilt.state = spoilt.state.replace(steer=0.55)
    for (inputs, _), steer in zip(log[1:], (steer for _, steer in log), strict=False):
        answers = [each.step(*inputs, applied_steer=steer) for each in (clean, spoilt)]
        assert answers[0] == answers[1]
    assert clean.state == spoilt.state


@each_controller
@each_car
def test_shadow_of_its_own_commands_is_itself(name: str, car: popsteer.Vehicle) -> None:
    log = _log(name, car)
    shadow = _made(name, car)
    answers = _watch(shadow, log)
    assert [answer.steer for answer in answers] == [steer for _, steer in log]
    alone = _made(name, car)
    for inputs, _ in log:
        alone.step(*inputs)
    assert shadow.state == alone.state


@each_controller
def test_shadow_of_another_controller_knows_the_vehicle_as_that_does(name: str) -> None:
    """The estimate comes from what was applied, not from what the shadow wanted."""
    real = DELAYED.replace(wheelbase=3.1, steer_offset=0.015)
    driver, shadow = popsteer.PreviewPop(SLALOM, DELAYED), _made(name, DELAYED)
    chain = Chain(real, START, 8.0, DT, substeps=20)
    applied = None
    for _ in range(700):
        inputs = (*chain.pose, chain.speed, DT)
        command = driver.step(*inputs)
        shadow.step(*inputs, applied_steer=applied)
        applied = command.steer
        chain.advance(applied)
    assert shadow.estimate.steer_offset == pytest.approx(driver.estimate.steer_offset, abs=1e-12)
    assert shadow.estimate.gain == pytest.approx(driver.estimate.gain, abs=1e-12)
    assert driver.estimate.gain == pytest.approx(2.7 / 3.1, abs=0.02)
    assert shadow.state.in_flight.commands == driver.state.in_flight.commands


@each_controller
def test_applied_angle_is_what_the_rate_limit_goes_on_from(name: str) -> None:
    controller = _made(name, PROMPT)
    controller.step(30.0, 8.0, 0.0, 5.0, DT)
    command = controller.step(30.2, 8.0, 0.0, 5.0, DT, applied_steer=0.3)
    assert abs(command.steer - 0.3) <= 0.8 * DT + 1e-12
    command = controller.step(30.4, 8.0, 0.0, 5.0, DT, applied_steer=1.0)
    assert abs(command.steer - 0.6) <= 0.8 * DT + 1e-12


def test_batch_takes_what_its_vehicles_report() -> None:
    controllers = [_made(name, DELAYED) for name in ("Pop", "Pop", "Pop")]
    batch = popsteer.Batch(controllers)
    rng = np.random.default_rng(3)
    for _ in range(40):
        x, y = rng.uniform(5.0, 15.0, 3), rng.uniform(-1.0, 1.0, 3)
        yaw, speed = rng.uniform(-0.2, 0.2, 3), rng.uniform(4.0, 8.0, 3)
        applied, ages = rng.uniform(-0.5, 0.5, 3), rng.uniform(0.0, 0.3, 3)
        commands = batch.step(x, y, yaw, speed, DT, applied_steer=applied, pose_age=ages)
        for k, controller in enumerate(controllers):
            given = {"applied_steer": applied[k], "pose_age": ages[k]}
            single = controller.step(x[k], y[k], yaw[k], speed[k], DT, **given)
            assert single.steer == commands.steer[k]
    assert batch.states == [controller.state for controller in controllers]
    with pytest.raises(popsteer.InputError, match=r"pose_age\[1\]"):
        batch.steer(x, y, yaw, speed, DT, pose_age=np.array([0.0, 2.0, 0.0]))


def test_batch_of_short_states_takes_poses_that_have_an_age() -> None:
    controller = popsteer.Stanley(SLALOM)
    batch = popsteer.Batch(controller, 2)
    step = (20.0, 3.5, 0.1, 6.0)
    for age in (0.0, 0.1, 0.1, 0.0):
        single = controller.steer(*step, DT, pose_age=age)
        x, y, yaw, speed = (np.full(2, each) for each in step)
        both = batch.steer(x, y, yaw, speed, DT, pose_age=age)
        assert both.tolist() == [single, single]
    assert batch.states[0] == controller.state


@each_controller
@each_car
def test_age_that_is_told_costs_next_to_nothing(name: str, car: popsteer.Vehicle) -> None:
    for speed in (8.0, 12.0):
        kind = getattr(popsteer, name)
        fresh = mean_error(kind, car, 0.0, given=False, speed=speed)
        most = 1.1 * fresh + 0.005
        assert mean_error(kind, car, 0.1, given=True, speed=speed) <= most
        assert mean_error(kind, car, 0.1, given=True, stale=3, speed=speed) <= most


def test_page_shows_what_an_age_costs() -> None:
    assert table("edges.md", "pose age") == age_lines()


def test_age_that_is_not_told_costs_more() -> None:
    # Most of it is found as a dead time: at 0.2 s preview POP loses nothing by it.
    for age in (0.1, 0.3):
        given, found = (
            mean_error(popsteer.PreviewPop, DELAYED, age, given=told) for told in (True, False)
        )
        assert found > 1.05 * given, age


def test_errors_of_an_old_pose_are_those_of_now() -> None:
    path = popsteer.Path([(0.0, 0.0), (200.0, 0.0)])
    controller = popsteer.Stanley(path, popsteer.Vehicle(steer_lag=0.0, max_steer=0.6))
    controller.step(10.0, 1.0, 0.0, 10.0, DT)
    command = controller.step(10.0, 1.0, 0.1, 10.0, DT, applied_steer=0.0, pose_age=0.5)
    # Straight on for half a second at 0.1 rad; the front axle is 3 m ahead.
    assert command.cross_track_error == pytest.approx(1.0 + 8.0 * math.sin(0.1), abs=1e-6)
    assert command.distance_to_stop == pytest.approx(190.0 - 5.0 * math.cos(0.1), abs=0.05)


def test_estimates_do_not_take_an_age_for_a_dead_time() -> None:
    real = DELAYED.replace(wheelbase=3.1)
    for given in (True, False):
        controller = popsteer.PreviewPop(SLALOM, DELAYED)
        chain = Chain(real, START, 8.0, DT, substeps=20)
        poses = [chain.pose] * 2
        for _ in range(900):
            report = {"pose_age": DT} if given else {}
            chain.advance(controller.step(*poses[-2], 8.0, DT, **report).steer)
            poses.append(chain.pose)
        late = controller.estimate.dead_time - 0.15
        assert controller.estimate.gain == pytest.approx(2.7 / 3.1, abs=0.03)
        assert (abs(late) < 0.015) == given


@each_controller
@each_car
def test_prediction_is_what_the_car_then_does(name: str, car: popsteer.Vehicle) -> None:
    controller = _made(name, car)
    chain = Chain(car, START, 8.0, DT, substeps=20)
    poses, predictions = [], []
    for _ in range(300):
        poses.append(chain.pose)
        command = controller.step(*chain.pose, 8.0, DT)
        before = controller.state
        predictions.append(controller.predict(1.0, DT))
        assert controller.state == before
        assert predictions[-1].steer[0] == command.steer
        chain.advance(command.steer)
    for k, ahead in enumerate(predictions[:-20]):
        assert ahead.time[-1] == pytest.approx(1.0)
        for n in (5, 20):
            x, y, yaw = poses[k + n]
            assert math.hypot(ahead.x[n] - x, ahead.y[n] - y) < 0.05
            assert abs(ahead.yaw[n] - yaw) < 0.05


def test_prediction_ends_at_the_stop() -> None:
    path = popsteer.Path([(0.0, 0.0), (20.0, 0.0)])
    controller = popsteer.PreviewPop(path)
    controller.step(15.0, 0.0, 0.0, 5.0, DT)
    ahead = controller.predict(3.0, DT)
    assert ahead.x[-1] == pytest.approx(20.0, abs=0.01)
    assert ahead.speed[-1] == 0.0


def test_prediction_before_the_first_step_says_what_to_do() -> None:
    with pytest.raises(popsteer.InputError, match="take one first"):
        popsteer.Pop(SLALOM).predict(1.0, DT)
