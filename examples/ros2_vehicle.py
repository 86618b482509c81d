"""A vehicle for `popsteer ros2`, for want of a real one: it drives in real time over ROS 2 topics.

Start the node in one terminal and this in another:

    popsteer ros2 --vehicle paper --localhost
    python examples/ros2_vehicle.py
"""

from __future__ import annotations

import argparse
import sys
import time
from typing import Any

import popsteer
from popsteer import paper, tracks
from popsteer.adapters import ros2

DT = 0.02
FRAME = "map"


class Vehicle:
    """A kinematic bicycle: its wheels turn with a lag, its drive does at once what it is told."""

    def __init__(self, x: float, y: float, yaw: float) -> None:
        self.car = popsteer.vehicles.get("paper")
        self.x, self.y, self.yaw, self.speed = x, y, yaw, 0.0
        self.steer = self.wheels = 0.0

    def obey(self, command: Any) -> None:
        self.speed, self.steer = command.drive.speed, command.drive.steering_angle

    def advance(self) -> None:
        self.wheels += (self.steer - self.wheels) * DT / self.car.steer_lag
        self.x, self.y, self.yaw, _ = paper.kinematic_bicycle(
            self.x, self.y, self.yaw, self.speed, self.wheels, 0.0, self.car.wheelbase, DT
        )


def main() -> int:
    parser = argparse.ArgumentParser(description="Drive a simulated vehicle over ROS 2 topics.")
    parser.add_argument("--track", default="slalom", help="a track of popsteer")
    parser.add_argument("--domain", type=int, help="DDS domain; that of ROS_DOMAIN_ID by default")
    parser.add_argument("--timeout", type=float, default=10.0, help="wait for a command [s]")
    options = parser.parse_args()
    track = tracks.get(options.track)
    path = popsteer.Path(track.xy)
    x, y = track.xy[0]
    vehicle = Vehicle(float(x), float(y), path.path_yaw_behind(1))
    topics = ros2.Topics()
    member = ros2.Participant(options.domain, local=True)
    odometry = member.writer(topics.odometry, "nav_msgs/msg/Odometry")
    plan = member.writer(topics.path, "nav_msgs/msg/Path", latched=True)
    commands = member.reader(topics.command, "ackermann_msgs/msg/AckermannDriveStamped")
    yaws = [0.0] * len(path)
    plan.write(ros2.encode(ros2.path_message(path.x, path.y, yaws, time.time_ns(), FRAME)))
    heard = time.monotonic()
    farthest = 0.0
    while True:
        time.sleep(DT)
        for data in commands.take():
            vehicle.obey(ros2.decode("ackermann_msgs/msg/AckermannDriveStamped", data))
            heard = time.monotonic()
        if time.monotonic() - heard > options.timeout:
            raise popsteer.PopsteerError(
                f"no command on {topics.command} for {options.timeout:g} s"
            )
        vehicle.advance()
        pose = vehicle.x, vehicle.y, vehicle.yaw
        at = time.time_ns()
        odometry.write(ros2.encode(ros2.odometry_message(*pose, vehicle.speed, at, FRAME)))
        here = path.project(vehicle.x, vehicle.y)
        farthest = max(farthest, abs(here.cross_track_error))
        if here.arc_length > path.length - 0.5 and vehicle.speed < 0.01:
            print(f"At the end of {track.name}; never farther than {farthest:.2f} m from it.")
            return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except popsteer.PopsteerError as error:
        print(f"ros2_vehicle: {error}", file=sys.stderr)
        sys.exit(2)
