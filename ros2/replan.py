"""Replans for popsteer_ros as Nav2 does: FollowPath, 1,000 poses a second; prints what it costs.

In a ROS installation, or with the wheels of the group "ros": python ros2/replan.py --seconds 3600

Each goal begins where the car is and preempts the one before. A row for each minute: the memory of
the node, the longest time between two commands as the car hears them, and beside it the longest
between two ticks of bare timers of 20 ms, one on each processor, which is how long this machine
makes any process wait.
"""

from __future__ import annotations

import argparse
import math
import os
import tempfile
import time
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from lap import CAR, DT, Steering, World, warnings  # it makes ROS ready

# isort: split
import numpy as np
import rclpy
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import FollowPath
from nav_msgs.msg import Odometry
from rclpy.action import ActionClient

import popsteer
from popsteer import tracks

LAP = popsteer.Path(tracks.get("racetrack").xy, closed=True)
APART = 0.5  # of poses [m]
HEAD = "minute", "goals", "memory [MiB]", "gap [ms]", "of a timer [ms]", "step [ms]", "off path [m]"


class Circuit(World):
    """The car on a lap without an end."""

    def __init__(self) -> None:
        super().__init__("racetrack", parts=("car",))
        self.path = LAP

    def move(self) -> None:
        super().move()
        self.finished = False


def plan(poses: int, goals: Any) -> None:
    """Send a goal each second from where the car is, and ask for its result."""
    rclpy.init()
    node = rclpy.create_node("planner")
    client, place = ActionClient(node, FollowPath, "follow_path"), [0.0]
    x, y = (np.append(each, each[0]) for each in (LAP.x, LAP.y))
    arcs = np.append(LAP.s, LAP.length)

    def see(message: Any) -> None:
        pose = message.pose.pose
        yaw = 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)
        ahead = CAR.rear_axle * math.cos(yaw), CAR.rear_axle * math.sin(yaw)
        here = LAP.project(pose.position.x + ahead[0], pose.position.y + ahead[1])
        place[0] = here.arc_length

    def send() -> None:
        along = (place[0] + APART * np.arange(poses)) % LAP.length
        goal = FollowPath.Goal()
        goal.path.header.frame_id = "map"
        for east, north in zip(np.interp(along, arcs, x), np.interp(along, arcs, y), strict=True):
            pose = PoseStamped()
            pose.header.frame_id = "map"
            pose.pose.position.x, pose.pose.position.y = float(east), float(north)
            goal.path.poses.append(pose)
        client.send_goal_async(goal).add_done_callback(answered)

    def answered(future: Any) -> None:
        if future.result().accepted:
            goals.value += 1
            future.result().get_result_async()

    node.create_subscription(Odometry, "odom", see, 1)
    client.wait_for_server()
    node.create_timer(1.0, send)
    rclpy.spin(node)


def tick(processor: int, longest: Any) -> None:
    """Keep the longest time between two ticks of a timer on a processor."""
    os.sched_setaffinity(0, {processor})
    due = before = time.monotonic()
    while True:
        due = max(due + DT, before)
        time.sleep(max(due - time.monotonic(), 0.0))
        now = time.monotonic()
        longest.value, before = max(longest.value, now - before), now


def memory(process: int) -> float:
    """Give the resident memory of a process [MiB]."""
    text = Path(f"/proc/{process}/status").read_text(encoding="utf-8")
    return int(text.split("VmRSS:")[1].split()[0]) / 1024


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=3600.0)
    parser.add_argument("--poses", type=int, default=1000)
    options = parser.parse_args()
    start = get_context("spawn")
    goals, timers = start.Value("l", 0), [start.Value("d", 0.0) for _ in os.sched_getaffinity(0)]
    others = [start.Process(target=plan, args=(options.poses, goals), daemon=True)]
    others += [
        start.Process(target=tick, args=each, daemon=True)
        for each in zip(os.sched_getaffinity(0), timers, strict=True)
    ]
    rclpy.init()
    with tempfile.TemporaryFile("w+", encoding="utf-8") as log:
        car, steering = Circuit(), Steering("rclpy", "", log)
        for each in others:
            each.start()
        try:
            drive(car, options.seconds, goals, timers, steering.number)
        finally:
            for each in others:
                each.kill()
            steering.end()
            car.close()
            rclpy.shutdown()
        print(*warnings(log)[:10], sep="\n")


def drive(car: Circuit, seconds: float, goals: Any, timers: list[Any], process: int) -> None:
    """Drive, and print a row for each minute."""
    begun = time.monotonic()
    while not car.times and time.monotonic() - begun < 60.0:
        car.drive(0.1)
    print(f"| {' | '.join(HEAD)} |", "|---" * len(HEAD) + "|", sep="\n", flush=True)
    begun = time.monotonic()
    for minute in range(1, math.ceil(seconds / 60.0) + 1):
        car.times, car.errors, car.delays, car.longest = car.times[-1:], [], [0.0], 0.0
        for each in timers:
            each.value = 0.0
        car.drive(begun + min(60.0 * minute, seconds) - time.monotonic())
        print(
            f"| {minute} | {goals.value} | {memory(process):.1f} |"
            f" {1e3 * max(np.diff(car.times), default=math.nan):.0f} |"
            f" {1e3 * max(each.value for each in timers):.0f} | {1e3 * car.longest:.1f} |"
            f" {max(car.errors, default=math.nan):.3f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
