"""The bytes of every message are those of rosbags, and what converts them loses nothing."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import popsteer
from tests.helpers import looped

pytest.importorskip("rosbags", reason='the extra "ros2" is not installed')
pytest.importorskip("cyclonedds", reason='the extra "ros2" is not installed')

from popsteer.adapters import ros2
from popsteer.adapters.ros2 import conversions, messages
from popsteer.adapters.ros2.idl import idl_type
from popsteer.adapters.ros2.topics import Topics
from tests.adapters.ros2_domain import Bench
from tests.adapters.ros2_plant import CAR

SIZES = {"int8": 8, "uint8": 8, "int16": 16, "uint16": 16, "int32": 32, "uint32": 32}


def drawn(random: np.random.Generator, kind: Any, detail: Any) -> Any:
    """A random value of a field."""
    if kind.name == "NAME":
        return message(random, detail)
    if kind.name == "BASE":
        return _base(random, detail[0])
    (inner, of), count = detail
    size = count if kind.name == "ARRAY" else int(random.integers(0, 5))
    values = [drawn(random, inner, of) for _ in range(size)]
    if inner.name != "BASE" or of[0] == "string":
        return values
    return np.array(values, dtype={"byte": "uint8"}.get(of[0], of[0]))


def _base(random: np.random.Generator, name: str) -> Any:
    if name == "string":
        return "".join(random.choice(list("abc/äψ 0"), int(random.integers(0, 12))))
    if name == "bool":
        return bool(random.integers(2))
    if name == "byte":
        return int(random.integers(128))
    if name in SIZES:
        low = 0 if name.startswith("u") else -(2 ** (SIZES[name] - 1))
        return int(random.integers(low, low + 2 ** SIZES[name]))
    value = float(random.standard_normal() * 10.0 ** random.integers(-9, 9))
    return float(np.float32(value)) if name == "float32" else value


def message(random: np.random.Generator, name: str) -> Any:
    fields = messages.store().get_msgdef(name).fields
    return messages.make(name, **{field: drawn(random, *kind) for field, kind in fields})


@looped("name", messages.TYPES)
def test_bytes_of_each_type_equal_those_of_rosbags_both_ways(name: str) -> None:
    random = np.random.default_rng(0)
    idl = idl_type(name).__idl__
    lengths = set()
    for _ in range(50):
        data = messages.encode(message(random, name))
        assert idl.serialize(idl.deserialize(data)) == data
        assert messages.encode(messages.decode(name, idl.serialize(idl.deserialize(data)))) == data
        lengths.add(len(data))
    fixed = name in (
        *(messages.CLOCK, messages.CONTROL, messages.CONTROL_MODE, messages.OPERATION_MODE),
        *(messages.STEERING_REPORT, messages.EMPTY),
    )
    assert (len(lengths) == 1) is fixed


def test_bytes_of_an_empty_message_are_those_of_rosbags() -> None:
    for name in messages.TYPES:
        data = messages.encode(messages.make(name))
        assert idl_type(name).__idl__.serialize(idl_type(name).__idl__.deserialize(data)) == data


def test_planted_swap_of_two_fields_is_seen() -> None:
    from cyclonedds.idl import make_idl_struct, types

    fields = dict.fromkeys(("z", "y", "x", "w"), types.float64)
    swapped = make_idl_struct("Quaternion_", "geometry_msgs.msg.dds_.Quaternion_", fields)
    data = messages.encode(messages.make("geometry_msgs/msg/Quaternion", x=1.0))
    found: Any = swapped.deserialize(data)
    assert found.x != 1.0
    assert idl_type("geometry_msgs/msg/Quaternion").__idl__.deserialize(data).x == 1.0


def test_names_on_the_wire_are_those_of_ros() -> None:
    assert idl_type(messages.CONTROL).__idl_typename__ == "autoware_control_msgs.msg.dds_.Control_"


@looped("yaw", [-3.0, -0.5, 0.0, 1e-9, 2.0, math.pi])
def test_odometry_there_and_back_is_the_same(yaw: float) -> None:
    data = messages.encode(
        ros2.odometry_message(1.5, -2.5, yaw, -3.0, 1_700_000_000_123_456_789, "/map", "base")
    )
    found = ros2.measured_of(messages.decode(messages.ODOMETRY, data))
    assert found.yaw == pytest.approx(yaw, abs=1e-15)
    assert found._replace(yaw=0.0) == (
        *(1.5, -2.5, 0.0, -3.0, 1_700_000_000_123_456_789),
        *("map", "base", 0.0),
    )


def test_yaw_of_a_tilted_vehicle_is_that_of_its_nose() -> None:
    # First pitched by 0.3 rad, then turned by 1 rad.
    a, b = 0.5, 0.15
    tilted = messages.make(
        "geometry_msgs/msg/Quaternion",
        x=-math.sin(a) * math.sin(b),
        y=math.cos(a) * math.sin(b),
        z=math.sin(a) * math.cos(b),
        w=math.cos(a) * math.cos(b),
    )
    assert ros2.yaw_of(tilted) == pytest.approx(1.0)


@looped(
    ("place", "value", "said"),
    [
        ("pose.pose.position.x", math.nan, "x is nan"),
        ("pose.pose.position.y", math.inf, "y is inf"),
        ("twist.twist.linear.x", -math.inf, "speed is -inf"),
        ("pose.pose.orientation.w", 0.0, "orientation is no rotation: its norm is 0"),
        ("pose.pose.orientation.z", math.nan, "orientation is no rotation: its norm is nan"),
    ],
)
def test_odometry_that_cannot_be_is_refused_by_name(place: str, value: float, said: str) -> None:
    odometry = ros2.odometry_message(0.0, 0.0, 0.0, 0.0, 0, "map")
    at: Any = odometry
    *folders, name = place.split(".")
    for folder in folders:
        at = getattr(at, folder)
    setattr(at, name, value)
    with pytest.raises(ros2.MessageError, match=said):
        ros2.measured_of(odometry)


def test_path_with_a_point_twice_has_it_once_and_no_speeds() -> None:
    points = ros2.path_message([0.0, 0.0, 3.0], [0.0, 0.0, 4.0], [0.0] * 3, 0, "map")
    path, frame = ros2.path_of(points)
    assert (len(path), path.speed, frame) == (2, None, "map")


@looped(
    ("x", "said"),
    [([], "2 waypoints|shape"), ([1.0], "at least 2"), ([1.0, math.nan], "got nan")],
)
def test_path_that_is_none_is_refused(x: list[float], said: str) -> None:
    zeros = [0.0] * len(x)
    with pytest.raises(ros2.MessageError, match=said):
        ros2.path_of(ros2.path_message(x, zeros, zeros, 0, "map"))


def test_trajectory_keeps_speeds_and_the_direction_of_driving() -> None:
    def point(x: float, speed: float) -> Any:
        place = messages.make("geometry_msgs/msg/Point", x=x)
        return messages.make(
            "autoware_planning_msgs/msg/TrajectoryPoint",
            pose=messages.make("geometry_msgs/msg/Pose", position=place),
            longitudinal_velocity_mps=speed,
        )

    points = [point(0.0, 2.0), point(5.0, 0.0), point(1.0, -2.0), point(0.0, 0.0)]
    path, _ = ros2.path_of(messages.make(messages.TRAJECTORY, points=points))
    assert path.speed is not None
    assert path.speed.tolist() == [2.0, 0.0, -2.0, 0.0]
    assert path.reverse is not None


def test_commands_carry_signs_and_amounts_as_their_types_have_them() -> None:
    drive = ros2.ackermann_message(-0.3, -2.0, -1.5, 10**9, "base_link").drive
    assert (drive.steering_angle, drive.speed, drive.acceleration) == (-0.3, -2.0, 1.5)
    control = ros2.control_message(-0.3, -2.0, -1.5, 10**9)
    assert control.lateral.steering_tire_angle == -0.3
    assert control.longitudinal.velocity == -2.0
    assert control.longitudinal.acceleration == -1.5
    assert conversions.nanoseconds_of(control.stamp) == 10**9


def test_module_gives_its_errors_as_those_of_popsteer() -> None:
    assert issubclass(ros2.MessageError, popsteer.PopsteerError)


def test_twist_turns_by_the_turning_wheelbase_and_understeer() -> None:
    car = CAR.replace(turning_wheelbase=3.0, understeer=0.01, steer_offset=0.02)
    topics = replace(Topics(command="/cmd_vel"), command_type=messages.TWIST_STAMPED)
    bench = Bench(lambda path: popsteer.Driver(path, car), topics=topics)
    bench.begin()
    bench.run(5)
    drive = bench.cycle()
    twist = messages.decode(messages.TWIST_STAMPED, bench.drive.take()[-1])
    assert drive is not None
    assert (twist.header.frame_id, twist.twist.linear.x) == ("base_link", drive.speed)
    rate = drive.speed * np.tan(drive.steer + 0.02) / (3.0 + 0.01 * drive.speed**2)
    assert twist.twist.angular.z == pytest.approx(rate)
