"""Drives a lap with either node beside nodes of a ROS installation, and prints what it was like.

In a ROS installation with popsteer_ros built: python ros2/lap.py --popsteer .venv/bin/popsteer

The plant (the chain of `studies`, 50 Hz) and its planner (the whole track, 10 Hz) are of rclpy.
"""

from __future__ import annotations

import argparse
import math
import os
import signal
import statistics
import subprocess
import sys
import time
from pathlib import Path

import rclpy
from ackermann_msgs.msg import AckermannDriveStamped
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from nav_msgs.msg import Path as PathMessage

import popsteer
from popsteer import tracks

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
from studies.chain import Chain

CAR = popsteer.Vehicle(
    wheelbase=2.7,
    rear_axle=-1.35,
    max_steer=0.6,
    max_steer_rate=0.5,
    steer_lag=0.1,
    dead_time=0.1,
    max_lateral_acceleration=6.0,
)
DT = 0.02


class World:
    """The car and its planner; measures how it is driven."""

    def __init__(self, track: str, seconds: float, loss: float) -> None:
        found = tracks.get(track)
        self.path = popsteer.Path(found.xy)
        self.end, self.loss = time.monotonic() + seconds, loss
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
        self.node = rclpy.create_node("world")
        self.odometry = self.node.create_publisher(Odometry, "odom", 1)
        self.plan = self.node.create_publisher(PathMessage, "path", 1)
        self.node.create_subscription(AckermannDriveStamped, "drive", self.obey, 1)
        self.node.create_subscription(DiagnosticArray, "diagnostics", self.diagnose, 10)
        self.message = self.planned()

    def planned(self) -> PathMessage:
        message = PathMessage()
        message.header.frame_id = "map"
        for x, y in zip(self.path.x, self.path.y, strict=True):
            pose = PoseStamped()
            pose.header.frame_id = "map"
            pose.pose.position.x, pose.pose.position.y = float(x), float(y)
            message.poses.append(pose)
        return message

    def obey(self, message: AckermannDriveStamped) -> None:
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
        car = self.car
        car.speed += max(-4.0 * DT, min(self.speed - car.speed, 4.0 * DT))
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
        self.ticks += 1
        if self.loss and self.ticks % round(1.0 / self.loss) == 0:
            return
        self.sent = time.monotonic()
        self.odometry.publish(message)
        if self.ticks % 5 == 0:
            self.message.header.stamp = message.header.stamp
            self.plan.publish(self.message)

    def drive(self) -> None:
        due = time.monotonic()
        while not self.finished and time.monotonic() < self.end:
            due += DT
            while (left := due - time.monotonic()) > 0.0:
                rclpy.spin_once(self.node, timeout_sec=left)
            self.step()


def used(process: int) -> float:
    """Give the processor time of a process [s]."""
    fields = Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def children(process: int) -> list[int]:
    """Give the processes that a process has started."""
    found = Path(f"/proc/{process}/task/{process}/children").read_text(encoding="utf-8")
    return [int(each) for each in found.split()]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--popsteer", default="popsteer", help="the command, for the bare node")
    parser.add_argument("--nodes", nargs="+", default=["bare", "rclpy"])
    parser.add_argument("--track", default="racetrack")
    parser.add_argument("--seconds", type=float, default=150.0, help="give up after this")
    parser.add_argument("--loss", type=float, default=0.0, help="share of odometry that is lost")
    options = parser.parse_args()
    vehicle = Path("car.toml").resolve()
    CAR.save(vehicle)
    bare = [options.popsteer, "ros2", "--vehicle", str(vehicle), "--max-speed", "25"]
    launch = ["ros2", "launch", "popsteer_ros", "track.launch.py", f"vehicle:={vehicle}"]
    commands = {"bare": bare, "rclpy": [*launch, "max_speed:=25.0"]}
    for name in options.nodes:
        rclpy.init()
        world = World(options.track, options.seconds, options.loss)
        environment = dict(os.environ)
        if name == "bare":
            environment.pop("PYTHONPATH", None)
        with subprocess.Popen(
            commands[name], env=environment, stdout=subprocess.DEVNULL, start_new_session=True
        ) as process:
            begun = time.monotonic()
            world.drive()
            seconds = time.monotonic() - begun
            # The launch file starts the node of rclpy as a process of its own.
            of = [process.pid] if name == "bare" else children(process.pid)
            share = sum(map(used, of)) / seconds
            os.killpg(process.pid, signal.SIGINT)
        report(name, world, seconds, share)
        world.node.destroy_node()
        rclpy.shutdown()


def report(name: str, world: World, seconds: float, share: float) -> None:
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
        f" {1e3 * delays[int(0.99 * (len(delays) - 1))]:.2f} ms 99 %; processor {100 * share:.1f} %"
    )


if __name__ == "__main__":
    main()
