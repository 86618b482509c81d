"""A kinematic car at 50 Hz around the node, and how a test waits for what it does."""

from __future__ import annotations

import math
import time
from typing import Any

import rclpy
from ackermann_msgs.msg import AckermannDriveStamped
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, TransformStamped
from nav2_msgs.action import FollowPath
from nav_msgs.msg import Odometry, Path
from popsteer_ros.node import Track
from rclpy.action import ActionClient
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from tf2_ros import TransformBroadcaster

from popsteer.adapters.ros2.paths import inverse, placed
from tests.helpers import PATIENCE

WHEELBASE = 2.7


class Car:
    """A kinematic car at 50 Hz, whose odometry drifts: its frame turns and moves in the map."""

    def __init__(
        self,
        *,
        drifts: bool = False,
        origin: tuple[float, float, float] | None = None,
        outside: bool = False,
        action: Any = FollowPath,
        **parameters: Any,
    ) -> None:
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
        self.obeys = True
        self.origin = (3.0, 0.0, 0.1) if drifts else origin
        self.turns = False  # whether odometry says the yaw rate
        self.ahead, self.stamps = 0.0, True  # of transforms [s]; whether odometry says its time
        self.begun, self.moved = time.monotonic(), self.node.get_clock().now().nanoseconds
        self.odometry = self.node.create_publisher(Odometry, "odom", 1)
        self.paths = self.node.create_publisher(Path, "path", 1)
        self.tf = TransformBroadcaster(self.node)
        self.commands: list[Any] = []
        self.node.create_subscription(AckermannDriveStamped, "drive", self.obey, 1)
        self.node.create_timer(0.02, self.step)
        self.action = action
        self.client = ActionClient(self.node, action, "follow_path")

    def obey(self, message: Any) -> None:
        self.commands.append(message)
        if not self.obeys:
            return
        self.speed, self.steer = message.drive.speed, message.drive.steering_angle

    def frame(self) -> tuple[float, float, float]:
        """The pose of the odometry's frame in the map."""
        x, y, yaw = self.origin or (0.0, 0.0, 0.0)
        passed = time.monotonic() - self.begun if self.drifts else 0.0
        return x + 0.05 * passed, y, yaw + 0.01 * passed

    def step(self) -> None:
        now = self.node.get_clock().now().nanoseconds
        # On a machine that is busy a timer is late; after a jump of the clock nothing has moved.
        dt, self.moved = min(max(1e-9 * (now - self.moved), 0.0), 0.5), now
        self.x += dt * self.speed * math.cos(self.yaw)
        self.y += dt * self.speed * math.sin(self.yaw)
        self.yaw += dt * self.speed * math.tan(self.steer) / WHEELBASE
        self.farthest = max(self.farthest, abs(self.y))
        if not self.publishes:
            return
        clock = self.node.get_clock()
        origin = self.frame()
        if self.origin is not None and self.localised:
            moved = TransformStamped()
            moved.header.stamp = (clock.now() + Duration(seconds=self.ahead)).to_msg()
            moved.header.frame_id, moved.child_frame_id = "map", "odom"
            moved.transform.translation.x, moved.transform.translation.y = origin[:2]
            moved.transform.rotation.z = math.sin(origin[2] / 2)
            moved.transform.rotation.w = math.cos(origin[2] / 2)
            self.tf.sendTransform(moved)
        message = Odometry()
        if self.stamps:
            message.header.stamp = clock.now().to_msg()
        message.header.frame_id = "map" if self.origin is None else "odom"
        message.child_frame_id = "base_link"
        x, y, yaw = placed(inverse(origin), (self.x, self.y, self.yaw))
        message.pose.pose.position.x, message.pose.pose.position.y = x, y
        message.pose.pose.orientation.z = math.sin(yaw / 2)
        message.pose.pose.orientation.w = math.cos(yaw / 2)
        message.twist.twist.linear.x = self.speed
        if self.turns:
            message.twist.twist.angular.z = self.speed * math.tan(self.steer) / WHEELBASE
        self.odometry.publish(message)

    def until(self, holds: Any, seconds: float = PATIENCE) -> bool:
        end = time.monotonic() + seconds
        while not holds() and time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.05)
        return bool(holds())

    def start(self) -> Car:
        self.track.trigger_configure()
        self.track.trigger_activate()
        return self

    def goal(self, length: float = 12.0, frame: str = "map") -> Any:
        return self.send(path(self.x, length, frame))

    def send(self, course: Path, controller: str = "") -> Any:
        """Send a goal, and give its handle."""
        assert self.until(self.client.server_is_ready)
        self.feedback: list[Any] = []
        goal = self.action.Goal(path=course, controller_id=controller)
        sent = self.client.send_goal_async(goal, lambda each: self.feedback.append(each.feedback))
        assert self.until(sent.done)
        return sent.result()

    def outcome(self, handle: Any, seconds: float = PATIENCE) -> tuple[int, int]:
        ended = handle.get_result_async()
        assert self.until(ended.done, seconds)
        return ended.result().status, ended.result().result.error_code

    def drive(self, length: float = 400.0) -> Car:
        """Activate the node, send a path, and wait until it drives."""
        self.start()
        assert self.until(lambda: self.paths.get_subscription_count() > 0)
        assert self.until(lambda: self.track.core.intake.measured is not None)
        self.paths.publish(path(self.x, length))
        assert self.until(lambda: self.speed > 1.0)
        return self

    @property
    def state(self) -> str:
        """What the node does."""
        return str(self.track.core.state)

    def simulate(self) -> Car:
        """Begin a time of the test's own, which `tick` moves on, and activate the node in it."""
        self.node.set_parameters([Parameter("use_sim_time", value=True)])
        self._clock, self.time = self.node.create_publisher(Clock, "/clock", 1), 100 * 10**9
        now = lambda node: node.get_clock().now().nanoseconds  # noqa: E731
        self._await(lambda: now(self.node) == now(self.track) == self.time)
        self.start()
        assert self.until(lambda: self.odometry.get_subscription_count() > 0)
        assert self.until(lambda: self.node.count_publishers("/drive") > 0)
        while self.track.core.intake.measured is None:
            self._await(lambda: self.moved == self.time, 20_000_000)
            self.executor.spin_once(timeout_sec=0.05)
        return self

    def tick(self) -> None:
        """Let 20 ms pass: the car moves, the node steps, and its command comes."""
        core, cycles, commands = self.track.core, self.track.core.loop.cycles, len(self.commands)
        self._await(lambda: self.moved == self.time and core.loop.cycles > cycles, 20_000_000)
        drives = core.state == "driving" and self.obeys
        assert not drives or self.until(lambda: len(self.commands) > commands)

    def _await(self, holds: Any, passes: int = 0) -> None:
        self.time += passes
        seconds, nanoseconds = divmod(self.time, 10**9)

        def told() -> bool:
            # A node hears the time as best it can, and again does no harm.
            self._clock.publish(Clock(clock=Time(sec=seconds, nanosec=nanoseconds)))
            return bool(holds())

        assert self.until(told)

    def stall(self) -> None:
        """Stand, whatever is commanded."""
        self.obeys, self.speed = False, 0.0

    def rest(self, seconds: float) -> None:
        """Let time pass."""
        self.until(lambda: False, seconds)

    def close(self) -> None:
        self.executor.shutdown()
        if hasattr(self, "track"):
            self.track.on_cleanup(None)
            self.track.destroy_node()
        self.node.destroy_node()


def path(
    begin: float,
    length: float,
    frame: str = "map",
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Path:
    """The x axis of the map, in a frame that has the pose `origin` there."""
    found = Path()
    found.header.frame_id = frame
    for k in range(int(2 * length) + 1):
        pose = PoseStamped()
        pose.header.frame_id = frame
        place = placed(inverse(origin), (begin + 0.5 * k, 0.0, 0.0))
        pose.pose.position.x, pose.pose.position.y = place[:2]
        found.poses.append(pose)
    return found
