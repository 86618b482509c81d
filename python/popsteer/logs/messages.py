"""Message types of steering, which rosbags does not bring: their definitions, as ROS has them."""

from __future__ import annotations

from typing import Any, NamedTuple

ODOMETRY = "nav_msgs/msg/Odometry"
"""The type of poses and speeds."""


def _floats(names: str) -> str:
    return "".join(f"float32 {name}\n" for name in names.split())


_STAMP = "builtin_interfaces/Time stamp\n"
_TIMES = _STAMP + "builtin_interfaces/Time control_time\n"
_REPORT = _STAMP + _floats("steering_tire_angle")
_VELOCITY = "std_msgs/Header header\n" + _floats(
    "longitudinal_velocity lateral_velocity heading_rate"
)
DEFINITIONS = {
    "ackermann_msgs/msg/AckermannDrive": _floats(
        "steering_angle steering_angle_velocity speed acceleration jerk"
    ),
    "ackermann_msgs/msg/AckermannDriveStamped": (
        "std_msgs/Header header\nackermann_msgs/AckermannDrive drive\n"
    ),
    "autoware_vehicle_msgs/msg/SteeringReport": _REPORT,
    "autoware_auto_vehicle_msgs/msg/SteeringReport": _REPORT,
    "autoware_vehicle_msgs/msg/VelocityReport": _VELOCITY,
    "autoware_auto_vehicle_msgs/msg/VelocityReport": _VELOCITY,
    "autoware_control_msgs/msg/Lateral": _TIMES
    + _floats("steering_tire_angle steering_tire_rotation_rate")
    + "bool is_defined_steering_tire_rotation_rate\n",
    "autoware_control_msgs/msg/Longitudinal": _TIMES
    + _floats("velocity acceleration jerk")
    + "bool is_defined_acceleration\nbool is_defined_jerk\n",
    "autoware_control_msgs/msg/Control": _TIMES
    + "autoware_control_msgs/Lateral lateral\nautoware_control_msgs/Longitudinal longitudinal\n",
}
_STAMPED = ("header", "stamp")
_TWIST = ("twist", "linear", "x")
POSES = {
    ODOMETRY: (("pose", "pose"), _STAMPED),
    "geometry_msgs/msg/PoseStamped": (("pose",), _STAMPED),
    "geometry_msgs/msg/PoseWithCovarianceStamped": (("pose", "pose"), _STAMPED),
}
"""The types of poses: where a message has its pose, and where the time of it."""
SPEEDS = {
    ODOMETRY: (("twist", *_TWIST), _STAMPED),
    "geometry_msgs/msg/TwistStamped": (_TWIST, _STAMPED),
    "geometry_msgs/msg/TwistWithCovarianceStamped": (("twist", *_TWIST), _STAMPED),
    "autoware_vehicle_msgs/msg/VelocityReport": (("longitudinal_velocity",), _STAMPED),
    "autoware_auto_vehicle_msgs/msg/VelocityReport": (("longitudinal_velocity",), _STAMPED),
}
"""The types of speeds, likewise."""


class Steering(NamedTuple):
    """Where a message has its angle, and where the time of it."""

    angle: tuple[str, ...]
    stamp: tuple[str, ...] | None
    commanded: bool


_MEASURED = Steering(("steering_tire_angle",), ("stamp",), commanded=False)
STEERING = {
    "ackermann_msgs/msg/AckermannDriveStamped": Steering(
        ("drive", "steering_angle"), ("header", "stamp"), commanded=True
    ),
    "ackermann_msgs/msg/AckermannDrive": Steering(("steering_angle",), None, commanded=True),
    "autoware_control_msgs/msg/Control": Steering(
        ("lateral", "steering_tire_angle"), ("stamp",), commanded=True
    ),
    "autoware_vehicle_msgs/msg/SteeringReport": _MEASURED,
    "autoware_auto_vehicle_msgs/msg/SteeringReport": _MEASURED,
}
"""The types of angles, those that are preferred first: a command tells dead time and lag."""


def typestore() -> Any:  # noqa: ANN401 - rosbags is an extra
    """Give the types of ROS 2 and those above, as rosbags takes them."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in DEFINITIONS.items():
        store.register(get_types_from_msg(text, name))
    return store
