"""A simulated vehicle for `popsteer ros2`: it drives in real time over ROS 2 topics.

In one terminal: popsteer ros2 --vehicle paper --localhost --max-speed 12
In another: python examples/ros2_vehicle.py
"""

from __future__ import annotations

import argparse
import sys
import time

import popsteer
from popsteer import PopsteerError, paper, tracks
from popsteer.adapters import ros2

CAR = popsteer.vehicles.get("paper")
DRIVE = "ackermann_msgs/msg/AckermannDriveStamped"
PERIOD = 0.02  # between two odometry messages [s]


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--track", default="slalom", help="a track of popsteer")
    parser.add_argument("--timeout", type=float, default=10.0, help="wait for a command [s]")
    options = parser.parse_args()
    path = popsteer.Path(tracks.get(options.track).xy)
    member, topics = ros2.Participant(local=True), ros2.Topics()
    odometry = member.writer(topics.odometry, "nav_msgs/msg/Odometry")
    commands = member.reader(topics.command, DRIVE)
    plan = member.writer(topics.path, "nav_msgs/msg/Path", latched=True)
    yaws = [0.0] * len(path)
    plan.write(ros2.encode(ros2.path_message(path.x, path.y, yaws, time.time_ns(), "map")))

    x, y, yaw, speed = path.x[0], path.y[0], path.path_yaw_behind(1), 0.0
    steer = wheels = farthest = 0.0
    heard = before = time.monotonic()
    while path.project(x, y).arc_length < path.length - 0.5 or speed > 0.01:
        time.sleep(PERIOD)
        dt, before = time.monotonic() - before, time.monotonic()  # longer on a machine that is busy
        for data in commands.take():
            drive = ros2.decode(DRIVE, data).drive
            speed, steer, heard = drive.speed, drive.steering_angle, time.monotonic()
        if time.monotonic() - heard > options.timeout:
            raise PopsteerError(f"no command on {topics.command} for {options.timeout:g} s")
        wheels += (steer - wheels) * min(dt / CAR.steer_lag, 1.0)
        x, y, yaw, _ = paper.kinematic_bicycle(x, y, yaw, speed, wheels, 0.0, CAR.wheelbase, dt)
        farthest = max(farthest, abs(path.project(x, y).cross_track_error))
        message = ros2.odometry_message(x, y, yaw, speed, time.time_ns(), "map")
        odometry.write(ros2.encode(message))
    print(f"At the end of {options.track}; never farther than {farthest:.2f} m from it.")


if __name__ == "__main__":
    try:
        main()
    except PopsteerError as error:
        print(f"ros2_vehicle: {error}", file=sys.stderr)
        sys.exit(2)
