"""Sensors that fail: what is reported, how soon, and what is never called a fault."""

from __future__ import annotations

import itertools
import math
import random
from typing import TYPE_CHECKING

import numpy as np
import pytest

import popsteer
from tests.trust.car import (
    START,
    TOLD,
    Car,
    bends,
    drive,
    freezing,
    glitching,
    jitter,
    somebody,
    straight,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tests.trust.car import Pose

STALE, OUTLIER = popsteer.Status.POSE_STALE, popsteer.Status.OUTLIER


@pytest.mark.parametrize("course", [bends(), straight()], ids=["bends", "straight"])
def test_frozen_pose_is_rolled_forward_and_then_a_fault(course: NDArray[np.float64]) -> None:
    healthy = drive(course=course, fresh=True)
    short = drive(course=course, fresh=True, sense=freezing(0.5))
    assert short.largest() < healthy.largest() + 0.15
    assert short.first(STALE) == pytest.approx(START + 0.05, abs=0.06)
    assert short.first_fault() == math.inf
    long = drive(course=course, fresh=True, sense=freezing(3.0))
    assert long.first_fault() < START + 1.0
    assert long.error_at(long.first_fault()) < 0.5


@pytest.mark.parametrize(("rate", "poses"), [(50, 40), (100, 25), (200, 10)])
def test_frozen_pose_is_never_believed_in_a_loop_faster_than_the_poses(
    rate: int, poses: int
) -> None:
    """The last pose is given again with its age; from 1.6 s on the localisation repeats itself."""
    steering = popsteer.PreviewPop(popsteer.Path(straight()), TOLD)
    for k in range(int(2.6 * rate)):
        time = k / rate
        stamp = int(time * poses + 1e-9) / poses
        x = 10.0 * min(stamp, 1.6)
        command = steering.step(x, 0.0, 0.0, 10.0, 1 / rate, pose_age=time - stamp)
        if time > 1.6 + 1.5 / poses:
            assert STALE in command.status
            assert command.distance_to_stop == pytest.approx(300.35 - 10.0 * time, abs=0.02)
        if not 2.1 < time < 2.5:
            assert steering.fault == (None if time < 2.2 else "position"), time


def test_glitches_are_outliers_and_no_faults() -> None:
    healthy = drive(fresh=True)
    for times, aside, turned in (
        ([10.0], 2.0, 0.0),
        ([10.0], 0.0, 0.3),
        ([10.0, 10.05, 10.1], 2.0, 0.0),
    ):
        drove = drive(fresh=True, sense=glitching(times, aside, turned))
        assert drove.first_fault() == math.inf
        assert drove.first(OUTLIER) == pytest.approx(10.0, abs=0.01)
        assert drove.largest() < healthy.largest() + 0.01
        steps = zip(drove.steers, healthy.steers, strict=False)
        assert max(abs(one[1] - other[1]) for one, other in steps) < 0.02
    rng = random.Random(3)

    def sometimes(_: float, pose: Pose) -> Pose:
        if rng.random() < 0.01:
            x, y, yaw, speed = pose
            return x + rng.uniform(-5, 5), y + rng.uniform(-5, 5), yaw + rng.uniform(-1, 1), speed
        return pose

    drove = drive(fresh=True, sense=sometimes, noise=(0.05, 0.01, 0.05))
    assert drove.first_fault() == math.inf
    assert drove.largest() < 0.15


@pytest.mark.parametrize(("jump", "within"), [(0.5, 0.3), (2.0, 0.6), (5.0, 1.0)])
def test_lasting_jump_is_believed(jump: float, within: float) -> None:
    def sense(time: float, pose: Pose) -> Pose:
        return pose if time < START else (pose[0], pose[1] + jump, *pose[2:])

    drove = drive(course=straight(), sense=sense, seconds=20.0)
    doubted = [time for time, status in drove.statuses if OUTLIER in status]
    assert all(START - 0.01 <= time < START + within for time in doubted)
    # By its poses the car drives along the road in the end, `jump` beside where it was.
    assert drove.errors[-1][1] == pytest.approx(-jump, abs=0.05)


@pytest.mark.parametrize("wrong", [50.0, -50.0, 5000.0])
def test_one_wrong_speed_in_a_while_changes_next_to_nothing(wrong: float) -> None:
    for controller in (popsteer.PreviewPop, popsteer.Stanley, popsteer.Pid):
        calls = itertools.count()

        def sense(_time: float, pose: Pose, calls: itertools.count[int] = calls) -> Pose:
            return (*pose[:3], pose[3] + (wrong if next(calls) % 43 == 42 else 0.0))

        healthy, drove = drive(controller), drive(controller, sense=sense)
        assert drove.first_fault() == math.inf
        assert drove.largest() < healthy.largest() + 0.02


def test_healthy_cars_have_no_fault() -> None:
    for seed in range(25):
        rng = random.Random(seed)
        car = somebody(rng)
        drove = drive(
            car=car,
            speed=rng.uniform(3.0, 9.0),
            fresh=True,
            noise=(0.05, 0.01, 0.05),
            loss=0.2,
            periods=jitter(0.5),
            seed=seed,
        )
        assert drove.first_fault() == math.inf, seed
        assert drove.first(OUTLIER) == math.inf, seed


def test_drift_of_the_position_is_reported_only_where_it_is_fast() -> None:
    # docs/loop.md says so: below that only a second source of the position shows it.
    for rate, reported in ((0.3, False), (2.0, True)):

        def sense(time: float, pose: Pose, rate: float = rate) -> Pose:
            return (pose[0], pose[1] + rate * max(0.0, time - START), *pose[2:])

        drove = drive(course=straight(500.0), sense=sense, seconds=40.0, noise=(0.05, 0.01, 0.05))
        assert (drove.first_fault() < START + 1.0) == reported
        # It is driven with; of what is reported, which are outliers, no slip is learnt.
        assert abs(drove.errors[-1][1]) > (28.0 if reported else 29.0) * rate


class Deaf(Car):
    """A car that stops to obey at `START`: its wheels go straight, or stay where they are."""

    straight = False

    def command(self, steer: float) -> None:
        if self.time < START:
            super().command(steer)
        elif self.straight:
            super().command(0.0)


def test_car_that_stops_to_obey_is_reported_before_half_a_metre() -> None:
    for speed, law, straight_on in itertools.product(
        (8.0, 15.0), (popsteer.PreviewPop, popsteer.Stanley, popsteer.PurePursuit), (False, True)
    ):
        car = Deaf()
        car.straight = straight_on
        course = bends(stretch=2.0 if speed > 9.0 else 1.0)
        drove = drive(law, car=car, course=course, speed=speed, fresh=True, seconds=14.0)
        case = (law, speed, straight_on, drove.first_fault())
        assert START < drove.first_fault() < START + 3.0, case
        assert drove.error_at(drove.first_fault()) < 0.5, case


def test_steering_offset_is_no_fault_where_the_car_can_drive_with_it() -> None:
    for degrees, speed, noise in ((7.0, 3.0, 0.0), (-7.0, 3.0, 0.01), (4.0, 8.0, 0.01)):
        for law in (popsteer.PreviewPop, popsteer.Stanley):
            car = Car(offset=math.radians(degrees))
            drove = drive(law, car=car, speed=speed, fresh=True, noise=(0.0, noise, 0.0))
            assert drove.first_fault() == math.inf, (degrees, law, drove.first_fault())
            assert drove.largest(15.0) < 0.25, (degrees, law)


@pytest.mark.parametrize("degrees", [1.0, 2.0, 3.0])
def test_play_of_the_steering_is_no_fault(degrees: float) -> None:
    for law in (popsteer.PreviewPop, popsteer.Stanley, popsteer.PurePursuit):
        drove = drive(law, car=Car(play=math.radians(degrees)), fresh=True)
        assert drove.first_fault() == math.inf, law


def test_play_of_a_degree_is_not_implausible_at_speed_either() -> None:
    for law in (popsteer.PreviewPop, popsteer.Stanley, popsteer.Pop):
        for speed, stretch in ((15.0, 3.0), (20.0, 5.0)):
            course = bends(length=600.0, stretch=stretch)
            car = Car(play=math.radians(1.0))
            drove = drive(law, car=car, course=course, speed=speed, fresh=True)
            assert drove.first(popsteer.Status.IMPLAUSIBLE) == math.inf, (law, speed)


def test_path_that_jumps_away_is_reported_and_one_that_begins_ahead_is_not() -> None:
    course = straight()

    def deviates(aside: float, begin: int) -> bool:
        steering = popsteer.PreviewPop(popsteer.Path(course), TOLD)
        steering.step(50.0, 0.0, 0.0, 8.0, 0.05)
        steering.set_path(popsteer.Path(course[begin:] + np.array((0.0, aside))))
        status = steering.step(50.4, 0.0, 0.0, 8.0, 0.05).status
        return popsteer.Status.DEVIATING in status

    assert deviates(12.0, 0)
    assert not deviates(2.0, 0)
    assert not deviates(12.0, 58)
    limit = popsteer.MonitorParams(join_limit=20.0)
    steering = popsteer.PreviewPop(
        popsteer.Path(course + np.array((0.0, 12.0))), TOLD, monitor=limit
    )
    assert steering.step(50.0, 0.0, 0.0, 8.0, 0.05).status.level != "fault"
