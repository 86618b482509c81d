"""Record a drive as a car's computer does: an MCAP log of a drive over the racetrack.

The car is one that nobody has measured: it turns by another wheelbase than its own, its steering
has 1 degree of offset, a lag and a dead time, and its poses and speeds have noise. Stanley drives
it. Beside the log it writes the waypoints, without speeds.

    python examples/recorded_drive.py FOLDER [SECONDS]

Needs popsteer[logs].
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer

import popsteer
from popsteer import sim, tracks
from popsteer.logs.messages import ODOMETRY, typestore

DRIVE = "ackermann_msgs/msg/AckermannDriveStamped"
NOISE = np.array([0.02, 0.02, 0.002, 0.02])  # of x, y [m], yaw [rad] and speed [m/s]
DT = 0.05
CAR = popsteer.Vehicle(
    wheelbase=2.7,
    rear_axle=-1.35,
    max_steer=0.6,
    turning_wheelbase=2.85,
    understeer=0.003,
    steer_offset=math.radians(1.0),
    steer_lag=0.1,
    dead_time=0.15,
)


def recorded(seconds: float) -> np.ndarray:
    """Drive for a time; rows of t, x, y, yaw, speed and the commanded angle."""
    track = tracks.get("racetrack")
    # With all of its speed Stanley has no margin left for the dead time.
    path = popsteer.Path(track.xy, speed=np.maximum(0.75 * track.speed, 5.0), closed=True)
    stanley = popsteer.Stanley(path, CAR)
    pedals = popsteer.SpeedPid(popsteer.SpeedPidParams(kp=1.0, ki=0.5))
    start = sim.default_start(path, vehicle=CAR)
    world = sim.Simulation(path, sim.KinematicBicycle(CAR), start=start, speed=5.0)
    random = np.random.default_rng(13)
    rows = []
    while world.time < seconds:
        measured = np.array(world.state) + NOISE * random.standard_normal(4)
        x, y, yaw, speed = measured.tolist()
        steer = stanley.step(x, y, yaw, speed, DT).steer
        rows.append((world.time, x, y, yaw, speed, steer))
        world.step(steer, *pedals.step(speed, world.reference_speed or 5.0, DT))
    return np.array(rows)


def write_mcap(folder: Path, rows: np.ndarray) -> Path:
    """Write the drive as odometry and commands, and give the file."""
    store = typestore()
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        poses = writer.add_connection("/localization/odometry", ODOMETRY, typestore=store)
        angles = writer.add_connection("/control/drive", DRIVE, typestore=store)
        for t, *pose, steer in rows.tolist():
            clock = round((1.7e9 + t) * 1e9)
            header = _header(store.types, clock)
            odometry = _odometry(store.types, header, *pose)
            writer.write(poses, clock, store.serialize_cdr(odometry, ODOMETRY))
            command = _command(store.types, header, steer)
            writer.write(angles, clock, store.serialize_cdr(command, DRIVE))
    return next(folder.glob("*.mcap"))


def _header(types: Any, clock: int) -> Any:
    stamp = types["builtin_interfaces/msg/Time"](sec=clock // 10**9, nanosec=clock % 10**9)
    return types["std_msgs/msg/Header"](stamp=stamp, frame_id="map")


def _odometry(types: Any, header: Any, x: float, y: float, yaw: float, speed: float) -> Any:
    vector = types["geometry_msgs/msg/Vector3"]
    turn = types["geometry_msgs/msg/Quaternion"]
    point = types["geometry_msgs/msg/Point"]
    unknown = np.zeros(36)  # covariances
    return types[ODOMETRY](
        header=header,
        child_frame_id="base_link",
        pose=types["geometry_msgs/msg/PoseWithCovariance"](
            pose=types["geometry_msgs/msg/Pose"](
                position=point(x=x, y=y, z=0.0),
                orientation=turn(x=0.0, y=0.0, z=math.sin(yaw / 2.0), w=math.cos(yaw / 2.0)),
            ),
            covariance=unknown,
        ),
        twist=types["geometry_msgs/msg/TwistWithCovariance"](
            twist=types["geometry_msgs/msg/Twist"](
                linear=vector(x=speed, y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=0.0)
            ),
            covariance=unknown,
        ),
    )


def _command(types: Any, header: Any, steer: float) -> Any:
    drive = types["ackermann_msgs/msg/AckermannDrive"](
        steering_angle=steer,
        steering_angle_velocity=0.0,
        speed=0.0,
        acceleration=0.0,
        jerk=0.0,
    )
    return types[DRIVE](header=header, drive=drive)


def main() -> None:
    """Write FOLDER/drive.mcap and FOLDER/waypoints.csv."""
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    rows = recorded(float(sys.argv[2]) if len(sys.argv) > 2 else 120.0)
    bag = folder / "drive"
    write_mcap(bag, rows).replace(folder / "drive.mcap")
    (bag / "metadata.yaml").unlink()
    bag.rmdir()
    lines = [f"{x:.3f},{y:.3f}" for x, y in tracks.get("racetrack").xy.tolist()]
    (folder / "waypoints.csv").write_text("\n".join(["# x [m], y [m]", *lines, ""]))
    print(f"{folder / 'drive.mcap'}: {rows[-1, 0]:.1f} s of driving, {len(rows)} rows")


if __name__ == "__main__":
    main()
