"""Drives by `popsteer ros2 --record`, plays the file to a fresh node, and compares the commands.

In a ROS installation, or with the wheels of the group "ros": python ros2/bag.py

The second node has the recording's time as its simulated one: it is given what the first one had
taken at each of its steps, then that step's time, and no more before it has commanded. The car of
the recording does not obey it, so whatever differs adds up: nothing does.
"""

from __future__ import annotations

import argparse
import math
import tempfile
import time
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lap import BARE, Steering, World  # it makes ROS ready

# isort: split
import rclpy
from ackermann_msgs.msg import AckermannDriveStamped
from builtin_interfaces.msg import Time
from popsteer_ros.transport import get_message
from rclpy.duration import Duration
from rclpy.serialization import deserialize_message
from rosbags.highlevel import AnyReader
from rosgraph_msgs.msg import Clock

from popsteer.logs.messages import typestore

if TYPE_CHECKING:
    from collections.abc import Iterable

INPUTS = ("/odom", "/path")
PERIOD = 20_000_000  # of the node that records [ns]


def record(command: str, file: Path, track: str, seconds: float, log: Any) -> None:
    """Drive, and record what the node takes and commands."""
    world = World(track)
    steering = Steering("bare", command, log, options=["--record", str(file)])
    begun = time.monotonic()
    while not world.times and time.monotonic() - begun < 20.0:
        world.drive(0.1)
    world.drive(seconds)
    steering.end()
    world.close()


def play(command: str, file: Path, log: Any) -> tuple[list[Any], list[Any]]:
    """Give the commands that were recorded, and those of a node that the file is played to."""
    node = rclpy.create_node("bag")
    recorded: list[Any] = []
    again: list[Any] = []
    node.create_subscription(AckermannDriveStamped, "drive", again.append, 10)
    clock = node.create_publisher(Clock, "/clock", 10)
    with AnyReader([file], default_typestore=typestore()) as reader:
        publishers = {
            each.topic: node.create_publisher(get_message(each.msgtype), each.topic, 10)
            for each in reader.connections
            if each.topic in INPUTS
        }
        # At this rate each of the recorded times is one to step at.
        steering = Steering("bare", command, log, options=["--sim-time", "--rate", "1000"])
        while not all(each.get_subscription_count() for each in (*publishers.values(), clock)):
            rclpy.spin_once(node, timeout_sec=0.1)
        time.sleep(1.0)  # in which the node finds these publishers, too

        def step(now: int, messages: Iterable[Any]) -> None:
            count = len(recorded)
            for connection, _, data in messages:
                if connection.topic in INPUTS:
                    publishers[connection.topic].publish(bytes(data))
                elif connection.topic == "/drive":
                    recorded.append(deserialize_message(bytes(data), AckermannDriveStamped))
            publishers["/path"].wait_for_all_acked(Duration(seconds=1))
            time.sleep(0.01)  # odometry, which nobody acknowledges, is to be there, too
            clock.publish(Clock(clock=Time(sec=now // 10**9, nanosec=now % 10**9)))
            # Where nothing was commanded, nothing says that the step is done.
            until = time.monotonic() + (0.1 if len(recorded) == count else 1.0)
            while now not in by_time(again[-1:]) and time.monotonic() < until:
                rclpy.spin_once(node, timeout_sec=0.01)

        step(reader.start_time - PERIOD, ())
        for now, messages in groupby(reader.messages(), key=lambda each: each[1]):
            step(now, messages)
    steering.end()
    node.destroy_node()
    return recorded[:-1], again  # but for the last one, to stand, at the end of the process


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--popsteer", default=BARE, help="the command")
    parser.add_argument("--track", default="racetrack")
    parser.add_argument("--seconds", type=float, default=20.0)
    options = parser.parse_args()
    rclpy.init()
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryFile("w+") as log:
        file = Path(folder) / "drive.mcap"
        record(options.popsteer, file, options.track, options.seconds, log)
        recorded, again = play(options.popsteer, file, log)
    rclpy.shutdown()
    before, after = by_time(recorded), by_time(again)
    common = [(before[stamp], after[stamp]) for stamp in before if stamp in after]
    steer, speed = (
        max((abs(getattr(a, name) - getattr(b, name)) for a, b in common), default=math.nan)
        for name in ("steering_angle", "speed")
    )
    print(
        f"{len(before)} commands recorded, {len(common)} of the same times played; they differ by"
        f" {steer:.1e} rad and {speed:.1e} m/s at most"
    )


def by_time(commands: list[Any]) -> dict[int, Any]:
    """Give what was commanded at each time."""
    stamps = [each.header.stamp for each in commands]
    return {
        stamp.sec * 10**9 + stamp.nanosec: each.drive
        for stamp, each in zip(stamps, commands, strict=True)
    }


if __name__ == "__main__":
    main()
