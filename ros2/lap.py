"""Drives a lap with either node beside nodes of a ROS installation, and prints what it was like.

In a ROS installation, or with the wheels of the group "ros": python ros2/lap.py

The plant (the chain of `studies`, 50 Hz) and its planner (the whole track, 10 Hz) are of rclpy. On
two machines, here two network namespaces as root:

    ip netns add car; ip netns add steer
    ip link add to-car netns steer type veth peer to-steer netns car
    ip -n car addr add 198.51.100.1/24 dev to-steer; ip -n steer addr add 198.51.100.2/24 dev to-car
    ip -n car link set to-steer up; ip -n steer link set to-car up
    ip netns exec car python ros2/lap.py --prefix "ip netns exec steer"
"""

from __future__ import annotations

import argparse
import math
import os
import random
import shlex
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
from tests.adapters.ros import interfaces

if WHY := interfaces.prepare():
    sys.exit(WHY)

import rclpy
from ackermann_msgs.msg import AckermannDriveStamped
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from nav_msgs.msg import Path as PathMessage
from rclpy.executors import SingleThreadedExecutor
from rclpy.serialization import serialize_message

import popsteer
from popsteer import tracks
from studies.chain import Chain

if TYPE_CHECKING:
    from collections.abc import Iterable

CAR = popsteer.Vehicle(
    wheelbase=2.7,
    rear_axle=-1.35,
    max_steer=0.6,
    max_steer_rate=0.5,
    steer_lag=0.1,
    dead_time=0.1,
    max_lateral_acceleration=6.0,
)
BARE = str(Path(sys.executable).with_name("popsteer"))
DT = 0.02
SILENCE = 0.5  # without a command for longer, the car brakes by itself [s]
DECELERATION = 4.0  # [m/s²]


class World:
    """The car and its planner, or one of them; measures how it is driven."""

    def __init__(
        self, track: str, *, loss: float = 0.0, parts: tuple[str, ...] = ("car", "plan")
    ) -> None:
        self.path = popsteer.Path(tracks.get(track).xy)
        self.loss, self.parts, self.random = loss, parts, random.Random(0)  # noqa: S311
        yaw = math.atan2(self.path.y[1] - self.path.y[0], self.path.x[1] - self.path.x[0])
        x, y = float(self.path.x[0]), float(self.path.y[0])
        start = x - CAR.rear_axle * math.cos(yaw), y - CAR.rear_axle * math.sin(yaw), yaw
        self.car = Chain(CAR, start, 0.0, DT)
        self.steer = self.speed = 0.0
        self.errors: list[float] = []
        self.delays: list[float] = []
        self.times: list[float] = []
        self.loop: dict[str, str] = {}
        self.longest = 0.0
        self.finished, self.ticks, self.sent = False, 0, 0.0
        self.node = rclpy.create_node("_".join(parts) or "none")
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)
        if "car" in parts:
            self.odometry = self.node.create_publisher(Odometry, "odom", 1)
            self.node.create_subscription(AckermannDriveStamped, "drive", self.obey, 1)
            self.node.create_subscription(DiagnosticArray, "diagnostics", self.diagnose, 10)
        if "plan" in parts:
            self.plan = self.node.create_publisher(PathMessage, "path", 1)
            self.message = serialize_message(self.planned())

    def planned(self) -> PathMessage:
        message = PathMessage()
        message.header.frame_id = "map"
        for x, y in zip(self.path.x, self.path.y, strict=True):
            pose = PoseStamped()
            pose.header.frame_id = "map"
            pose.pose.position.x, pose.pose.position.y = float(x), float(y)
            message.poses.append(pose)
        return message

    def lost(self) -> bool:
        """Say whether a message is lost."""
        return self.random.random() < self.loss

    def obey(self, message: AckermannDriveStamped) -> None:
        if self.lost():
            return
        now = time.monotonic()
        self.delays.append(now - self.sent)
        self.times.append(now)
        self.steer, self.speed = message.drive.steering_angle, message.drive.speed

    def diagnose(self, message: DiagnosticArray) -> None:
        values = {each.key: each.value for status in message.status for each in status.values}
        if "missed_cycles" in values:
            self.loop = values
            if self.delays:
                self.longest = max(self.longest, float(values["longest_step_s"]))

    def step(self) -> None:
        self.ticks += 1
        if "car" in self.parts:
            self.move()
        if "plan" in self.parts and self.ticks % 5 == 0 and not self.lost():
            self.plan.publish(self.message)

    def move(self) -> None:
        car = self.car
        if self.times and time.monotonic() - self.times[-1] > SILENCE:
            self.speed = 0.0
        change = DECELERATION * DT
        car.speed += max(-change, min(self.speed - car.speed, change))
        car.advance(self.steer)
        x, y, yaw = car.pose
        axle = x + CAR.rear_axle * math.cos(yaw), y + CAR.rear_axle * math.sin(yaw)
        here = self.path.project(*axle)
        if self.delays:
            self.errors.append(abs(here.cross_track_error))
        self.finished = self.path.length - here.arc_length < 1.0 and car.speed < 0.01
        message = Odometry()
        message.header.stamp = self.node.get_clock().now().to_msg()
        message.header.frame_id, message.child_frame_id = "map", "base_link"
        message.pose.pose.position.x, message.pose.pose.position.y = x, y
        message.pose.pose.orientation.z = math.sin(yaw / 2)
        message.pose.pose.orientation.w = math.cos(yaw / 2)
        message.twist.twist.linear.x = car.speed
        if not self.lost():
            self.sent = time.monotonic()
            self.odometry.publish(message)

    def drive(self, seconds: float) -> None:
        due = time.monotonic()
        end = due + seconds
        while not self.finished and due < end:
            due += DT
            while (remaining := due - time.monotonic()) > 0.0:
                self.executor.spin_once(timeout_sec=remaining)
            self.step()

    def close(self) -> None:
        """End what uses the node, then the node; both before rclpy's context."""
        self.executor.shutdown()
        self.node.destroy_node()


def used(process: int) -> float:
    """Give the processor time of a process [s]."""
    fields = Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


class Steering:
    """A node of popsteer as a process; `log` has what it and the rest of this process print."""

    def __init__(
        self, name: str, popsteer_: str, log: Any, prefix: str = "", options: Iterable[str] = ()
    ) -> None:
        vehicle = Path(tempfile.gettempdir()) / "popsteer-lap.toml"
        CAR.save(vehicle)
        command = [popsteer_, "ros2", "--vehicle", str(vehicle), "--max-speed", "25", *options]
        environment = dict(os.environ)
        if name == "bare":
            environment.pop("PYTHONPATH", None)
        else:
            command = [sys.executable, "-c", "from popsteer_ros.node import main; main()"]
            given = f"vehicle:={vehicle}", "max_speed:=25.0", "autostart:=true"
            command += ["--ros-args", *(word for each in given for word in ("-p", each))]
        self._process = subprocess.Popen(
            [*shlex.split(prefix), *command],
            env=environment,
            stdout=log,
            stderr=log,
            start_new_session=True,
        )
        self.number = self._process.pid

    def end(self, kind: signal.Signals = signal.SIGINT) -> None:
        """End the node, and wait for that."""
        if self._process.poll() is None:
            os.killpg(self._process.pid, kind)
        self._process.wait()


def warnings(log: Any) -> list[str]:
    """Give the warnings and errors that were printed."""
    log.seek(0)
    words = ("warn", "error", "traceback", "fail")
    lines = [line.strip() for line in log if "user interrupted" not in line]  # that was this script
    return [line for line in lines if any(word in line.lower() for word in words)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--popsteer", default=BARE, help="the command, for the bare node")
    parser.add_argument("--nodes", nargs="+", default=["bare", "rclpy"])
    parser.add_argument("--track", default="racetrack")
    parser.add_argument("--seconds", type=float, default=150.0, help="give up after this")
    parser.add_argument("--loss", type=float, default=0.0, help="share of messages that is lost")
    parser.add_argument("--prefix", default="", help="what comes before the node's command")
    options = parser.parse_args()
    for name in options.nodes:
        with tempfile.TemporaryFile("w+", encoding="utf-8") as log:
            mine = os.dup(2)
            os.dup2(log.fileno(), 2)  # rclpy's own warnings are written there
            rclpy.init()
            world = World(options.track, loss=options.loss)
            steering = Steering(name, options.popsteer, log, options.prefix)
            begun = time.monotonic()
            while not world.times and time.monotonic() - begun < 20.0:
                world.drive(0.1)
            before = time.monotonic(), used(steering.number)
            world.drive(options.seconds)
            share = (used(steering.number) - before[1]) / (time.monotonic() - before[0])
            steering.end()
            world.close()
            rclpy.shutdown()
            os.dup2(mine, 2)
            report(name, world, time.monotonic() - begun, share, warnings(log))


def report(name: str, world: World, seconds: float, share: float, warned: list[str]) -> None:
    driven = world.times[-1] - world.times[0] if len(world.times) > 1 else math.nan
    delays = sorted(world.delays) or [math.nan]
    print(
        f"{name}: {'finished' if world.finished else 'NOT finished'} in {seconds:.1f} s;"
        f" error {max(world.errors, default=math.nan):.3f} m at most,"
        f" {statistics.fmean(world.errors or [math.nan]):.4f} m mean;"
        f" {(len(world.times) - 1) / driven:.2f} commands/s;"
        f" {world.loop.get('missed_cycles', '?')} of {world.loop.get('cycles', '?')} cycles missed;"
        f" longest step {1e3 * world.longest:.1f} ms;"
        f" odometry to command {1e3 * statistics.median(delays):.2f} ms median,"
        f" {1e3 * delays[int(0.99 * (len(delays) - 1))]:.2f} ms 99 %;"
        f" processor {100 * share:.1f} %; {len(warned)} warnings",
        *warned[:10],
        sep="\n  ",
    )


if __name__ == "__main__":
    main()
