"""A kinematic car at 50 Hz around the node, and how a test waits for what it does."""

from __future__ import annotations

import math
import time
from typing import Any

import rclpy
from ackermann_msgs.msg import AckermannDriveStamped
from geometry_msgs.msg import PoseStamped, TransformStamped
from nav2_msgs.action import FollowPath
from nav_msgs.msg import Odometry, Path
from popsteer_ros.node import Track
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from tf2_ros import TransformBroadcaster

WHEELBASE = 2.7


class Car:
    """A kinematic car at 50 Hz, whose odometry drifts: its frame turns and moves in the map."""

    def __init__(self, *, drifts: bool = False, outside: bool = False, **parameters: Any) -> None:
        self.node = rclpy.create_node("car")
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)
        if not outside:  # else the node is a process of its own
            given = {"vehicle": "paper", **parameters}
            overrides = [Parameter(name, value=value) for name, value in given.items()]
            self.track = Track(parameter_overrides=overrides)
            self.executor.add_node(self.track)
        self.x = self.y = self.yaw = self.speed = self.steer = 0.0
        self.drifts, self.farthest, self.publishes, self.localised = drifts, 0.0, True, True
        self.begun = time.monotonic()
        self.odometry = self.node.create_publisher(Odometry, "odom", 1)
        self.paths = self.node.create_publisher(Path, "path", 1)
        self.tf = TransformBroadcaster(self.node)
        self.commands: list[Any] = []
        self.node.create_subscription(AckermannDriveStamped, "drive", self.obey, 1)
        self.node.create_timer(0.02, self.step)
        self.client = ActionClient(self.node, FollowPath, "follow_path")

    def obey(self, message: Any) -> None:
        self.commands.append(message)
        self.speed, self.steer = message.drive.speed, message.drive.steering_angle

    def step(self) -> None:
        self.x += 0.02 * self.speed * math.cos(self.yaw)
        self.y += 0.02 * self.speed * math.sin(self.yaw)
        self.yaw += 0.02 * self.speed * math.tan(self.steer) / WHEELBASE
        self.farthest = max(self.farthest, abs(self.y))
        if not self.publishes:
            return
        passed = time.monotonic() - self.begun
        turn, shift = (0.1 + 0.01 * passed, 3.0 + 0.05 * passed) if self.drifts else (0.0, 0.0)
        now = self.node.get_clock().now().to_msg()
        if self.drifts and self.localised:
            moved = TransformStamped()
            moved.header.stamp, moved.header.frame_id, moved.child_frame_id = now, "map", "odom"
            moved.transform.translation.x = shift
            moved.transform.rotation.z, moved.transform.rotation.w = (
                math.sin(turn / 2),
                math.cos(turn / 2),
            )
            self.tf.sendTransform(moved)
        message = Odometry()
        message.header.stamp = now
        message.header.frame_id = "odom" if self.drifts else "map"
        message.child_frame_id = "base_link"
        x, y, yaw = self.x - shift, self.y, self.yaw - turn
        place = message.pose.pose.position
        place.x = math.cos(turn) * x + math.sin(turn) * y
        place.y = -math.sin(turn) * x + math.cos(turn) * y
        message.pose.pose.orientation.z = math.sin(yaw / 2)
        message.pose.pose.orientation.w = math.cos(yaw / 2)
        message.twist.twist.linear.x = self.speed
        self.odometry.publish(message)

    def until(self, holds: Any, seconds: float = 20.0) -> bool:
        end = time.monotonic() + seconds
        while not holds() and time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.05)
        return bool(holds())

    def start(self) -> Car:
        self.track.trigger_configure()
        self.track.trigger_activate()
        return self

    def goal(self, length: float = 12.0, frame: str = "map") -> Any:
        assert self.until(self.client.server_is_ready)
        self.feedback: list[Any] = []
        goal = FollowPath.Goal(path=path(self.x, length, frame))
        sent = self.client.send_goal_async(goal, lambda each: self.feedback.append(each.feedback))
        assert self.until(sent.done)
        return sent.result()

    def outcome(self, handle: Any, seconds: float = 30.0) -> tuple[int, int]:
        ended = handle.get_result_async()
        assert self.until(ended.done, seconds)
        return ended.result().status, ended.result().result.error_code

    def close(self) -> None:
        self.executor.shutdown()
        if hasattr(self, "track"):
            self.track.on_cleanup(None)
            self.track.destroy_node()
        self.node.destroy_node()


def path(begin: float, length: float, frame: str = "map") -> Path:
    found = Path()
    found.header.frame_id = frame
    for k in range(int(2 * length) + 1):
        pose = PoseStamped()
        pose.header.frame_id = frame
        pose.pose.position.x = begin + 0.5 * k
        found.poses.append(pose)
    return found
