"""Frames and time: paths in one frame and then another, transforms that are old, ahead or gone."""

from __future__ import annotations

import itertools
import math
from typing import Any

import pytest

pytest.importorskip("ready")  # before all that is ROS's

import rclpy
from builtin_interfaces.msg import Time
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from world import Car, path


@pytest.mark.parametrize("origin", [(3.0, 2.0, 0.3), (500.0, -300.0, -2.0)])
def test_paths_that_change_their_frame_a_hundred_times_are_driven_as_one(
    origin: tuple[float, float, float],
) -> None:
    car = Car(origin=origin, stale=1.0).drive()  # a machine that is busy makes it no new drive
    statuses: set[str] = set()
    for k in range(100):
        frame = ("odom", "map")[k % 2]
        car.paths.publish(path(0.0, 400.0, frame, origin if frame == "odom" else (0.0, 0.0, 0.0)))
        intake = car.track.core.intake
        assert car.until(lambda i=intake, f=frame: i.course.frame == f)
        car.rest(0.06)
        statuses |= {car.state, str(car.track.core.drive.status)}
    assert statuses == {"driving", "ok"}
    assert car.speed > 4.0
    assert car.farthest < 0.01
    assert math.hypot(*car.track.core.intake.seen_from[:2]) < 1e-3  # in the map again
    car.close()


def test_long_paths_are_read_by_their_bytes_whatever_the_names_of_their_frames(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # By messages 10,000 poses take a second, where a cycle of 50 Hz is 20 ms.
    def undone(*_: Any) -> Any:
        raise AssertionError

    monkeypatch.setattr("popsteer.adapters.ros2.paths.decode", undone)
    long = path(0.0, 5000.0)
    for k, each in enumerate(long.poses):
        each.header.frame_id = ("map", "another_map", "")[k % 3]
    data = serialize_message(long)  # which takes the car as long
    car = Car(stale=1.0).drive()
    intake = car.track.core.intake
    car.paths.publish(data)
    assert car.until(lambda: intake.course.path.length > 4999.0), intake.course_refused
    assert (intake.courses.refused, car.state) == (0, "driving")
    car.close()


def test_goals_from_rest_in_changing_frames_are_all_reached() -> None:
    origin = (3.0, 2.0, 0.3)
    car = Car(origin=origin).start()
    for k in range(4):
        frame = ("map", "odom")[k % 2]
        goal = path(car.x, 4.0, frame, origin if frame == "odom" else (0.0, 0.0, 0.0))
        assert car.outcome(car.send(goal))[0] == 4
    assert car.farthest < 0.01
    car.close()


@pytest.mark.parametrize("stamps", [True, False])
def test_localisation_that_dies_is_stopped_for_though_its_stamps_are_ahead(*, stamps: bool) -> None:
    car = Car(origin=(3.0, 2.0, 0.3), max_speed=3.0)
    car.ahead, car.stamps = 5.0, stamps
    car.start()
    assert car.until(lambda: car.paths.get_subscription_count() > 0)
    # Before the first transform's time has come it says nothing of now.
    assert car.until(lambda: car.track.core.intake.measured is not None)
    car.paths.publish(path(car.x, 400.0))
    refused = car.track.core.intake.courses
    assert car.until(lambda: "transform" in refused.reason)
    car.rest(5.0)
    car.paths.publish(path(car.x, 400.0))
    assert car.until(lambda: car.speed > 2.0)
    car.localised = False
    assert car.until(lambda: car.state == "braking", 2.0)
    assert "transform from 'odom' to 'map' is" in car.track.core.reason
    car.localised = True
    assert car.until(lambda: car.state == "driving")
    car.close()


def simulated() -> tuple[Car, list[int]]:
    """Give a car whose time is simulated, and the second that it began at, to be changed."""
    car = Car(origin=(3.0, 2.0, 0.3), use_sim_time=True)
    car.node.set_parameters([Parameter("use_sim_time", value=True)])
    clock, ticks, begin = car.node.create_publisher(Clock, "/clock", 1), itertools.count(), [100]

    def tick() -> None:
        now = begin[0] * 10**9 + next(ticks) * 20_000_000
        clock.publish(Clock(clock=Time(sec=now // 10**9, nanosec=now % 10**9)))

    steady = rclpy.clock.Clock(clock_type=rclpy.clock.ClockType.STEADY_TIME)
    car.node.create_timer(0.02, tick, clock=steady)
    assert car.until(lambda: car.track.now() > 100 * 10**9)
    return car, begin


def test_transforms_of_a_time_that_ends_while_it_is_inactive_are_forgotten() -> None:
    car, begin = simulated()
    car.drive()
    car.track.trigger_deactivate()
    assert car.until(lambda: car.speed == 0.0)
    begin[0] = 20
    assert car.until(lambda: car.track.now() < 90 * 10**9)
    car.track.trigger_activate()
    assert car.until(lambda: car.paths.get_subscription_count() > 0)
    assert car.until(lambda: car.track.core.intake.measured is not None)
    car.paths.publish(path(car.x, 100.0))
    assert car.until(lambda: car.speed > 1.0), car.track.core.intake.courses.reason
    car.close()


def test_transforms_of_a_time_that_is_over_are_forgotten_with_it() -> None:
    car, begin = simulated()
    car.drive()
    begin[0] = 20  # it begins anew, and localisation does not come back
    car.localised = False
    assert car.until(lambda: car.track.core.loop.jumps > 0)
    assert car.until(lambda: car.state in ("holding", "braking"), 2.0)
    assert car.until(lambda: "no transform" in said(car), 2.0)
    car.localised = True
    car.origin = (4.0, 2.0, 0.3)  # and it is another one: by the old one the car would be 1 m off
    car.x, car.y = car.x + 1.0, 0.0
    assert car.until(lambda: car.state == "driving")
    assert car.track.core.intake.measured.x == pytest.approx(car.x, abs=0.3)
    car.close()


def said(car: Any) -> str:
    return str(car.track.core.reason)
