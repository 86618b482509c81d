"""A vehicle on the wire: a process that publishes odometry and a path, and obeys drive commands.

It is integrated by `studies.chain`, not by `popsteer.sim`. In lockstep it publishes the
time, too, and waits for the command of each tick; otherwise it runs in real time, whatever comes.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from typing import TYPE_CHECKING, Any

import popsteer
from popsteer import tracks
from popsteer.adapters.ros2 import messages, odometry_message, path_message
from popsteer.adapters.ros2.conversions import nanoseconds_of, time_message
from popsteer.adapters.ros2.dds import Participant
from popsteer.adapters.ros2.topics import Topics
from studies.chain import Chain

if TYPE_CHECKING:
    from collections.abc import Sequence

CAR = popsteer.Vehicle(
    wheelbase=2.7,
    rear_axle=-1.35,
    max_steer=0.6,
    max_steer_rate=0.5,
    steer_lag=0.1,
    dead_time=0.1,
    max_lateral_acceleration=6.0,
)
FRAME = "map"


def course(name: str, laps_end: float | None = None) -> popsteer.Path:
    track = tracks.get(name)
    keep = slice(None)
    if laps_end is not None:
        whole = popsteer.Path(track.xy, closed=track.closed)
        keep = slice(0, int((whole.s < laps_end).sum()))
    speed = track.speed[keep].copy()
    speed[-1] = 0.0
    return popsteer.Path(track.xy[keep], speed=speed)


def trajectory_message(path: popsteer.Path, at: int) -> Any:
    """An Autoware planner's message; `path.speed` is set."""
    assert path.speed is not None
    poses = path_message(path.x, path.y, [0.0] * len(path), at, FRAME)
    points = [
        messages.make(
            "autoware_planning_msgs/msg/TrajectoryPoint",
            pose=each.pose,
            longitudinal_velocity_mps=float(speed),
        )
        for each, speed in zip(poses.poses, path.speed, strict=True)
    ]
    return messages.make(messages.TRAJECTORY, header=poses.header, points=points)


class Car:
    """The chain, with a drive that obeys speeds or accelerations."""

    def __init__(self, pose: tuple[float, float, float], dt: float) -> None:
        self.chain = Chain(CAR, pose, 0.0, dt)
        self.command = self.speed = self.acceleration = 0.0
        self.dt = dt

    def obey(self, message: Any) -> None:
        if message.__msgtype__ == messages.CONTROL:
            longitudinal = message.longitudinal
            self.command = message.lateral.steering_tire_angle
            self.speed, self.acceleration = longitudinal.velocity, longitudinal.acceleration
            return
        drive = message.drive
        self.command, self.speed = drive.steering_angle, drive.speed
        now = self.chain.speed
        change = max(
            -drive.acceleration * self.dt, min(self.speed - now, drive.acceleration * self.dt)
        )
        self.acceleration = change / self.dt

    def advance(self) -> None:
        self.chain.speed = max(self.chain.speed + self.acceleration * self.dt, 0.0)
        self.chain.advance(self.command)


def rear_axle(pose: tuple[float, float, float]) -> tuple[float, float]:
    x, y, yaw = pose
    return x + CAR.rear_axle * math.cos(yaw), y + CAR.rear_axle * math.sin(yaw)


def start_of(path: popsteer.Path) -> tuple[float, float, float]:
    """The rear axle on the first waypoint, along the path."""
    yaw = math.atan2(path.y[1] - path.y[0], path.x[1] - path.x[0])
    x, y = float(path.x[0]), float(path.y[0])
    return x - CAR.rear_axle * math.cos(yaw), y - CAR.rear_axle * math.sin(yaw), yaw


class Link:
    """The topics of the vehicle and of its planner."""

    def __init__(self, domain: int, topics: Topics) -> None:
        self.member = Participant(domain, local=True)
        self.topics = topics
        self.odometry = self.member.writer(topics.odometry, messages.ODOMETRY)
        self.path = self.member.writer(topics.path, topics.path_type, latched=True)
        self.clock = self.member.writer(topics.clock, messages.CLOCK)
        self.drive = self.member.reader(topics.command, topics.command_type, reliable=True)

    def publish_path(self, path: popsteer.Path, at: int) -> None:
        if self.topics.path_type == messages.TRAJECTORY:
            message = trajectory_message(path, at)
        else:
            message = path_message(path.x, path.y, [0.0] * len(path), at, FRAME)
        self.path.write(messages.encode(message))

    def publish_pose(self, car: Car, at: int) -> None:
        message = odometry_message(*car.chain.pose, car.chain.speed, at, FRAME)
        self.odometry.write(messages.encode(message))

    def publish_time(self, at: int) -> None:
        message = messages.make(messages.CLOCK, clock=time_message(at))
        self.clock.write(messages.encode(message))

    def commands(self) -> list[Any]:
        return [messages.decode(self.topics.command_type, data) for data in self.drive.take()]


def stamp_of(message: Any) -> int:
    stamp = message.stamp if message.__msgtype__ == messages.CONTROL else message.header.stamp
    return nanoseconds_of(stamp)


def drive(arguments: argparse.Namespace) -> dict[str, Any]:
    topics = Topics.of_autoware() if arguments.autoware else Topics()
    link = Link(arguments.domain, topics)
    path = course(arguments.track, arguments.metres)
    pose = (
        start_of(path) if arguments.start is None else tuple(map(float, arguments.start.split(",")))
    )
    car = Car(pose, arguments.dt)  # type: ignore[arg-type]
    step = round(arguments.dt * 1e9)
    at = time.time_ns() if not arguments.lockstep else 10**9
    link.publish_path(path, at)
    errors, late, moved, heard, ticks = [], 0, False, False, 0
    begun = time.monotonic()
    while time.monotonic() - begun < arguments.limit:
        if arguments.lockstep:
            link.publish_pose(car, at)
            link.publish_time(at)
            # Before the node is there, time goes on without it.
            answered = _await(link, car, at, arguments.limit if heard else 0.2)
            late += heard and not answered
            heard = heard or answered
            at += step
        else:
            ticks += 1
            time.sleep(max(begun + ticks * arguments.dt - time.monotonic(), 0.0))
            for message in link.commands():
                car.obey(message)
            link.publish_pose(car, time.time_ns())
        car.advance()
        moved = moved or car.chain.speed > 0.5
        here = path.project(*rear_axle(car.chain.pose))
        errors.append(abs(here.cross_track_error))
        if moved and car.chain.speed < 0.01 and path.length - here.arc_length < 1.0:
            break
    return {
        "finished": path.length - here.arc_length < 1.0,
        "remaining": path.length - here.arc_length,
        "largest": max(errors),
        "mean": sum(errors) / len(errors),
        "late": late,
        "steps": len(errors),
        "seconds": time.monotonic() - begun,
    }


def _await(link: Link, car: Car, at: int, seconds: float) -> bool:
    """Wait for the command of a tick."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        link.drive.wait(0.01)
        for message in link.commands():
            car.obey(message)
            if stamp_of(message) >= at:
                return True
    return False


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--domain", type=int, required=True)
    parser.add_argument("--track", default="racetrack")
    parser.add_argument("--metres", type=float)
    parser.add_argument("--dt", type=float, default=0.02)
    parser.add_argument("--limit", type=float, default=300.0)
    parser.add_argument("--start")
    parser.add_argument("--lockstep", action="store_true")
    parser.add_argument("--autoware", action="store_true")
    json.dump(drive(parser.parse_args(arguments)), sys.stdout)


if __name__ == "__main__":
    main()
