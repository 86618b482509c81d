"""Kills planner, car and node in mid-drive, and sends altered messages; prints what either does.

In a ROS installation, or with the wheels of the group "ros": python ros2/faults.py

Car, planner and node are processes of their own, ended by SIGKILL and started again after 5 s.
"""

from __future__ import annotations

import argparse
import math
import random
import subprocess
import sys
import tempfile
import time
from signal import SIGKILL
from typing import Any

from lap import BARE, Steering, World  # it makes ROS ready

# isort: split
import rclpy
from ackermann_msgs.msg import AckermannDriveStamped
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message
from std_msgs.msg import Empty

TRACK = "racetrack"


class Observer:
    """Hears what the car does and what it is commanded."""

    def __init__(self) -> None:
        self.node = rclpy.create_node("observer")
        self.commanded = self.driven = self.largest = self.heading = math.nan
        self.commands = 0
        self.said = ""
        self.path = World(TRACK, parts=()).path
        self.node.create_subscription(AckermannDriveStamped, "drive", self._hear, 10)
        self.node.create_subscription(Odometry, "odom", self._see, 10)
        self.node.create_subscription(DiagnosticArray, "diagnostics", self._read, 10)

    def _hear(self, message: Any) -> None:
        self.commanded = message.drive.speed
        self.commands += 1

    def _see(self, message: Any) -> None:
        pose = message.pose.pose
        yaw = 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)
        if not abs(pose.position.x) + abs(pose.position.y) + abs(yaw) < 1e6:
            return  # of an altered message
        x, y = pose.position.x - 1.35 * math.cos(yaw), pose.position.y - 1.35 * math.sin(yaw)
        self.driven, self.heading = message.twist.twist.linear.x, yaw
        self.largest = max(self.largest, abs(self.path.project(x, y).cross_track_error), key=_known)

    def _read(self, message: Any) -> None:
        self.said = message.status[0].message

    def until(self, holds: Any, seconds: float) -> float:
        """Wait until something holds; gives how long that took [s], or infinity."""
        begun = time.monotonic()
        while time.monotonic() - begun < seconds:
            rclpy.spin_once(self.node, timeout_sec=0.05)
            if holds():
                return time.monotonic() - begun
        return math.inf


def _known(value: float) -> float:
    return -1.0 if math.isnan(value) else value


class Part:
    """The car or the planner, as a process."""

    def __init__(self, name: str) -> None:
        self._process = subprocess.Popen([sys.executable, __file__, "--be", name])

    def end(self, kind: int = SIGKILL) -> None:
        """End it, and wait for that."""
        self._process.send_signal(kind)
        self._process.wait()


def kill(name: str, command: str, what: str, log: Any) -> None:
    """Drive, kill a part, start it again, and print what was seen."""
    seen = Observer()
    starts = {
        "planner": lambda: Part("plan"),
        "car": lambda: Part("car"),
        "node": lambda: Steering(name, command, log),
    }
    parts: dict[str, Any] = {each: start() for each, start in starts.items()}
    seen.until(lambda: _known(seen.driven) > 8.0, 40.0)
    straight = seen.heading
    if seen.until(lambda: abs(math.remainder(seen.heading - straight, math.tau)) > 0.5, 40.0) > 40:
        print(f"{name}: does not drive into a bend; {seen.said}")
    parts[what].end(SIGKILL)
    before = seen.commands
    stands = {
        "planner": lambda: False,  # the last path is driven on
        "car": lambda: seen.commanded == 0.0,
        "node": lambda: seen.driven < 0.01,
    }
    after = seen.until(stands[what], 15.0 if what == "car" else 5.0)
    said, lasting = seen.said, seen.driven
    seen.until(lambda: False, max(5.0 - after, 0.0))
    heard = seen.commands - before
    seen.driven = math.nan
    parts[what] = starts[what]()
    again = seen.until(lambda: _known(seen.driven) > 8.0, 40.0)
    stood = f"stood after {after:.2f} s" if after < math.inf else f"drove on at {lasting:.1f} m/s"
    print(
        f"{name}: {what} killed: {stood}, {heard} commands, said {said!r}; 8 m/s again"
        f" {again:.1f} s after its return, said {seen.said!r}; error {seen.largest:.3f} m at most"
    )
    for part in parts.values():
        part.end(SIGKILL)
    seen.node.destroy_node()


def alter(name: str, command: str, count: int, log: Any) -> None:
    """Send altered messages while it drives; it is to drive on after them."""
    seen = Observer()
    world, planner, steering = Part("car"), Part("plan"), Steering(name, command, log)
    seen.until(lambda: _known(seen.driven) > 8.0, 40.0)
    other = World(TRACK, parts=("plan",))
    odometry = other.node.create_publisher(Odometry, "odom", 10)
    originals = (odometry, serialize_message(Odometry())), (other.plan, other.message)
    chance = random.Random(0)  # noqa: S311
    for _ in range(count):
        publisher, message = chance.choice(originals)
        data = bytearray(message)
        for _ in range(chance.randint(1, 30)):
            data[chance.randrange(4, len(data))] = chance.randrange(256)
        publisher.publish(bytes(data))
        rclpy.spin_once(seen.node, timeout_sec=0.0)
    other.close()
    release = seen.node.create_publisher(Empty, "/popsteer/release", 1)
    seen.until(lambda: release.get_subscription_count() > 0, 10.0)
    release.publish(Empty())
    seen.driven = math.nan
    again = seen.until(lambda: seen.said == "driving" and _known(seen.driven) > 5.0, 60.0)
    print(f"{name}: {count} altered messages: drives {again:.1f} s after them, says {seen.said!r}")
    for part in (world, planner, steering):
        part.end(SIGKILL)
    seen.node.destroy_node()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--popsteer", default=BARE, help="the command, for the bare node")
    parser.add_argument("--nodes", nargs="+", default=["bare", "rclpy"])
    parser.add_argument("--kill", nargs="*", default=["planner", "car", "node"])
    parser.add_argument("--altered", type=int, default=10_000, help="altered messages")
    parser.add_argument("--be", help=argparse.SUPPRESS)
    options = parser.parse_args()
    rclpy.init()
    if options.be:
        World(TRACK, parts=(options.be,)).drive(400.0)
        return
    with tempfile.TemporaryFile("w+", encoding="utf-8") as log:
        for name in options.nodes:
            for what in options.kill:
                kill(name, options.popsteer, what, log)
            if options.altered:
                alter(name, options.popsteer, options.altered, log)
        log.seek(0)
        print(*(line for line in log if "Traceback" in line), sep="")
    rclpy.shutdown()


if __name__ == "__main__":
    main()
