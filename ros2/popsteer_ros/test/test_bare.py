"""The bare node beside a node of rclpy on Fast DDS, ROS's default middleware: topics, release."""

from __future__ import annotations

import os
import time
from typing import TYPE_CHECKING, Any

import pytest

pytest.importorskip("ready")  # before all that is ROS's

import rclpy
from ackermann_msgs.msg import AckermannDriveStamped
from diagnostic_msgs.msg import DiagnosticArray
from nav2_msgs.msg import SpeedLimit
from nav_msgs.msg import Odometry
from nav_msgs.msg import Path as PathMessage
from std_msgs.msg import Empty
from world import path

import popsteer
from popsteer.adapters import ros2
from tests.helpers import PATIENCE

if TYPE_CHECKING:
    from collections.abc import Callable


class Bare:
    """The bare node in this process, and a node of rclpy that is its car and planner."""

    def __init__(self, **options: Any) -> None:
        number = int(os.environ["ROS_DOMAIN_ID"])
        self.member = ros2.Participant(number, local=True)
        car = popsteer.Vehicle(wheelbase=2.7, max_speed=4.0)
        self.node = ros2.Node(
            self.member, lambda found: popsteer.Driver(found, car), ros2.Options(**options)
        )
        self.ros = rclpy.create_node("car")
        self.odometry = self.ros.create_publisher(Odometry, "odom", 1)
        self.paths = self.ros.create_publisher(PathMessage, "path", 1)
        self.x = self.y = self.speed = 0.0
        self.commands: list[Any] = []
        self.reports: list[Any] = []
        self.ros.create_subscription(AckermannDriveStamped, "drive", self.commands.append, 10)
        self.ros.create_subscription(DiagnosticArray, "diagnostics", self.reports.append, 10)
        self.before = time.monotonic()

    def step(self) -> None:
        now = time.monotonic()
        dt, self.before = now - self.before, now
        self.x += dt * self.speed
        message = Odometry()
        message.header.stamp = self.ros.get_clock().now().to_msg()
        message.header.frame_id, message.child_frame_id = "map", "base_link"
        message.pose.pose.position.x, message.pose.pose.position.y = self.x, self.y
        message.twist.twist.linear.x = self.speed
        self.odometry.publish(message)
        time.sleep(0.002)
        self.node.cycle(time.time_ns(), max(dt, 1e-3))
        for _ in range(4):
            rclpy.spin_once(self.ros, timeout_sec=0.002)
        if self.commands:
            self.speed = self.commands[-1].drive.speed

    def until(self, holds: Callable[[], Any], seconds: float = PATIENCE) -> bool:
        end = time.monotonic() + seconds
        while not holds() and time.monotonic() < end:
            self.step()
        return bool(holds())

    @property
    def state(self) -> str:
        return self.node.state

    def begin(self) -> None:
        heard = (self.odometry, self.paths)
        assert self.until(lambda: all(each.get_subscription_count() for each in heard))
        # Each side finds the other by itself, so what is sent at once may be heard by nobody.
        for _ in range(20):
            self.paths.publish(path(0.0, 400.0))
            if self.until(lambda: self.node.intake.course is not None, 1.0):
                break
        assert self.until(lambda: self.speed > 1.0)


@pytest.fixture
def bare() -> Bare:
    return Bare()


def test_fault_is_released_by_a_message_of_any_middleware(bare: Bare) -> None:
    bare.begin()
    release = bare.ros.create_publisher(Empty, "/popsteer/release", 1)
    assert bare.until(lambda: release.get_subscription_count() > 0)
    bare.y = 9.0  # the localisation is elsewhere
    assert bare.until(lambda: bare.state == "standing")
    assert bare.node.driver is not None
    assert bare.node.driver.fault
    bare.y = 0.0
    node: Any = bare.node
    assert bare.until(lambda: node.drive.status.level != "fault")  # it is believed again
    assert not bare.until(lambda: bare.state == "driving", 1.0)
    release.publish(Empty())
    assert bare.until(lambda: bare.state == "driving")


def test_speed_limit_of_a_topic_counts_for_the_bare_node_too(bare: Bare) -> None:
    bare.begin()
    limits = bare.ros.create_publisher(SpeedLimit, "speed_limit", 1)
    assert bare.until(lambda: limits.get_subscription_count() > 0)
    limits.publish(SpeedLimit(percentage=True, speed_limit=50.0))
    assert bare.until(lambda: abs(bare.speed - 2.0) < 0.05), bare.speed
    limits.publish(SpeedLimit())
    assert bare.until(lambda: abs(bare.speed - 4.0) < 0.05), bare.speed


def test_names_of_frames_without_an_end_are_refused_and_repeated_nowhere(bare: Bare) -> None:
    bare.begin()
    long = path(0.0, 400.0)
    long.header.frame_id = "m" * 2_000_000
    bare.paths.publish(long)
    assert bare.until(lambda: bare.node.intake.courses.refused > 0)
    assert bare.node.intake.courses.reason == "name of a frame of 2000000 characters"
    count = len(bare.reports)
    assert bare.until(lambda: len(bare.reports) > count + 2)
    texts = [each.value for status in bare.reports[-1].status for each in status.values]
    assert max(map(len, texts)) < 300
