"""Bags as a car's computer records them, written by rosbags."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pathlib import Path


START = 1_700_000_000.0
"""When the recording began [s]: a clock as a car has it."""


def write_bag(
    folder: Path,
    columns: dict[str, Any],
    *,
    mcap: bool = True,
    steering: str = "ackermann_msgs/msg/AckermannDriveStamped",
    stamped: bool = True,
    topics: tuple[str, str] = ("/localization/odometry", "/control/drive"),
    more: tuple[str, str] | None = None,
    packed: str = "",
) -> Path:
    """Write a log as a bag; the folder, or its file where that is an MCAP.

    `packed` is how: as "STORAGE" (chunks of an MCAP), "FILE" or "MESSAGE". `more` are types of
    poses, 1 m further in x, and of speeds, 0.5 m/s faster, on other topics.
    """
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.rosbag2.enums import CompressionFormat, CompressionMode

    from popsteer.logs.messages import ODOMETRY, typestore

    store = typestore()
    plugin = StoragePlugin.MCAP if mcap else StoragePlugin.SQLITE3
    bag = Writer(folder, version=9, storage_plugin=plugin)
    if packed:
        bag.set_compression(CompressionMode[packed], CompressionFormat.ZSTD)
    with bag as writer:
        odometry = writer.add_connection(topics[0], ODOMETRY, typestore=store)
        drive = writer.add_connection(topics[1], steering, typestore=store)
        if more is not None:
            place = writer.add_connection("/vehicle_pose", more[0], typestore=store)
            pace = writer.add_connection("/vehicle_speed", more[1], typestore=store)
        for row in zip(*columns.values(), strict=True):
            t, x, y, yaw, speed, steer = map(float, row)
            clock = START + t
            recorded = round(clock * 1e9)
            stamp = _stamp(store, clock if stamped else 0.0)
            pose = _odometry(store, stamp, x, y, yaw, speed)
            writer.write(odometry, recorded, store.serialize_cdr(pose, ODOMETRY))
            if more is not None:
                header = store.types["std_msgs/msg/Header"](stamp=stamp, frame_id="map")
                other = _odometry(store, stamp, x + 1.0, y, yaw, speed).pose.pose
                sent: Any = store.types[more[0]](header=header, pose=other)
                writer.write(place, recorded, store.serialize_cdr(sent, more[0]))
                sent = store.types[more[1]](header, speed + 0.5, 0.0, 0.0)
                writer.write(pace, recorded, store.serialize_cdr(sent, more[1]))
            angle = _angle(store, steering, stamp, steer)
            writer.write(drive, recorded, store.serialize_cdr(angle, steering))
    return next(folder.glob("*.mcap")) if mcap else folder


def _stamp(store: Any, clock: float) -> Any:
    kind = store.types["builtin_interfaces/msg/Time"]
    nanoseconds = round(clock * 1e9)
    return kind(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)


def _odometry(store: Any, stamp: Any, x: float, y: float, yaw: float, speed: float) -> Any:
    import numpy as np

    kinds = store.types
    vector = kinds["geometry_msgs/msg/Vector3"]
    none = np.zeros(36)
    turn = kinds["geometry_msgs/msg/Quaternion"](
        x=0.0, y=0.0, z=math.sin(0.5 * yaw), w=math.cos(0.5 * yaw)
    )
    place = kinds["geometry_msgs/msg/Point"](x=x, y=y, z=0.0)
    return kinds["nav_msgs/msg/Odometry"](
        header=kinds["std_msgs/msg/Header"](stamp=stamp, frame_id="map"),
        child_frame_id="base_link",
        pose=kinds["geometry_msgs/msg/PoseWithCovariance"](
            pose=kinds["geometry_msgs/msg/Pose"](position=place, orientation=turn),
            covariance=none,
        ),
        twist=kinds["geometry_msgs/msg/TwistWithCovariance"](
            twist=kinds["geometry_msgs/msg/Twist"](
                linear=vector(x=speed, y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=0.0)
            ),
            covariance=none,
        ),
    )


def _angle(store: Any, kind: str, stamp: Any, steer: float) -> Any:
    kinds = store.types
    if kind.endswith("SteeringReport"):
        return kinds[kind](stamp=stamp, steering_tire_angle=steer)
    drive = kinds["ackermann_msgs/msg/AckermannDrive"](
        steering_angle=steer,
        steering_angle_velocity=0.0,
        speed=0.0,
        acceleration=0.0,
        jerk=0.0,
    )
    if kind.endswith("Stamped"):
        header = kinds["std_msgs/msg/Header"](stamp=stamp, frame_id="base_link")
        return kinds[kind](header=header, drive=drive)
    return drive


def recorded(file: Path, kind: str) -> list[Any]:
    """Give the messages of a type in a recording, in order."""
    from rosbags.highlevel import AnyReader

    from popsteer.adapters.ros2 import messages

    with AnyReader([file], default_typestore=messages.store()) as reader:
        return [
            messages.decode(kind, bytes(data))
            for connection, _, data in reader.messages()
            if connection.msgtype == kind
        ]
