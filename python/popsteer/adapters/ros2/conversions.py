"""Every conversion between the messages of ROS 2 and popsteer; units and signs are the same.

ROS 2 has metres, seconds and radians, x forward, y to the left and angles counter-clockwise, as
popsteer has (REP 103). What differs: headings are quaternions, times are seconds and nanoseconds,
and the speed of an ``AckermannDrive`` is negative backwards while its acceleration is a magnitude.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

from popsteer import PopsteerError
from popsteer.adapters.ros2 import messages
from popsteer.adapters.ros2.messages import make

if TYPE_CHECKING:
    from collections.abc import Iterable

    from popsteer import Vehicle

_SECOND = 10**9
# Names of frames are repeated in commands and diagnostics; ROS's own names are no longer.
_LONGEST = 255
# A quaternion has norm 1, but for rounding; all zeros is one that nobody has set.
_NORM = (0.9, 1.1)
# Below so many wheelbases a second a yaw rate's noise of 0.02 rad/s is that of 0.04 rad and more.
_SLOW = 0.5


class MessageError(PopsteerError, ValueError):
    """A message cannot be used; says what in it."""


class Measured(NamedTuple):
    """What an odometry message says."""

    x: float
    """Position [m]."""
    y: float
    """Position [m]."""
    yaw: float
    """Heading [rad]."""
    speed: float
    """Speed along the heading [m/s], negative backwards."""
    stamp: int
    """When it was measured [ns]; 0 where the message does not say."""
    frame: str
    """What the position is in."""
    child_frame: str
    """The vehicle's own."""
    yaw_rate: float = 0.0
    """Yaw rate [rad/s]; 0 where the message does not say."""


def nanoseconds_of(time: Any) -> int:  # noqa: ANN401
    """Give the time of a stamp [ns]."""
    return int(time.sec) * _SECOND + int(time.nanosec)


def time_message(nanoseconds: int) -> Any:  # noqa: ANN401
    """Make a stamp of a time [ns]."""
    seconds, rest = divmod(int(nanoseconds), _SECOND)
    return make("builtin_interfaces/msg/Time", sec=seconds, nanosec=rest)


def yaw_of(quaternion: Any) -> float:  # noqa: ANN401
    """Give the heading of an orientation.

    Parameters
    ----------
    quaternion : geometry_msgs/msg/Quaternion
        The orientation.

    Returns
    -------
    float
        Its yaw [rad], counter-clockwise.

    Raises
    ------
    MessageError
        It is no rotation: a number is not finite, or its norm is not 1.

    Examples
    --------
    >>> yaw_of(make("geometry_msgs/msg/Quaternion", z=1.0)) == math.pi
    True
    """
    x, y, z, w = (float(getattr(quaternion, name)) for name in "xyzw")
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    if not _NORM[0] <= norm <= _NORM[1]:
        raise MessageError(f"orientation is no rotation: its norm is {norm:.3g}")
    return math.atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)


def measured_of(odometry: Any) -> Measured:  # noqa: ANN401
    """Give pose and speed of an odometry message.

    Parameters
    ----------
    odometry : nav_msgs/msg/Odometry
        The message.

    Returns
    -------
    Measured
        Its pose and speed.

    Raises
    ------
    MessageError
        A number is not finite, or the orientation is no rotation.

    Examples
    --------
    >>> message = odometry_message(1.0, 2.0, 0.5, 3.0, 7, "map")
    >>> measured_of(message)[:4]
    (1.0, 2.0, 0.5, 3.0)
    """
    place, yaw_rate = odometry.pose.pose.position, float(odometry.twist.twist.angular.z)
    found = Measured(
        float(place.x),
        float(place.y),
        yaw_of(odometry.pose.pose.orientation),
        float(odometry.twist.twist.linear.x),
        nanoseconds_of(odometry.header.stamp),
        check_frame_name(odometry.header.frame_id),
        check_frame_name(odometry.child_frame_id),
        yaw_rate if math.isfinite(yaw_rate) else 0.0,
    )
    for name in ("x", "y", "speed"):
        value = getattr(found, name)
        if not math.isfinite(value):
            raise MessageError(f"{name} is {value}")
    return found


def shown_steer(car: Vehicle, measured: Measured) -> float:
    """Give the wheels' angle that the yaw rate shows [rad]; 0 where the vehicle is too slow to."""
    rate, speed = measured.yaw_rate, measured.speed
    if rate == 0.0 or abs(speed) < _SLOW * car.wheelbase:
        return 0.0
    return math.atan(rate * car.turning_length(speed) / speed) - car.steer_offset


def odometry_message(
    x: float,
    y: float,
    yaw: float,
    speed: float,
    nanoseconds: int,
    frame: str,
    child_frame: str = "base_link",
) -> Any:  # noqa: ANN401
    """Make an odometry message.

    Parameters
    ----------
    x, y : float
        Position [m].
    yaw : float
        Heading [rad].
    speed : float
        Speed along the heading [m/s], negative backwards.
    nanoseconds : int
        When it was measured [ns].
    frame : str
        What the position is in.
    child_frame : str, default "base_link"
        The vehicle's own.

    Returns
    -------
    nav_msgs/msg/Odometry
        The message.

    Examples
    --------
    >>> odometry_message(0.0, 0.0, 0.0, 3.0, 0, "map").twist.twist.linear.x
    3.0
    """
    return make(
        messages.ODOMETRY,
        header=_header(nanoseconds, frame),
        child_frame_id=child_frame,
        pose={"pose": _pose(x, y, yaw)},
        twist={"twist": {"linear": {"x": float(speed)}}},
    )


def path_message(
    x: Iterable[float], y: Iterable[float], yaw: Iterable[float], nanoseconds: int, frame: str
) -> Any:  # noqa: ANN401
    """Make a path message.

    Parameters
    ----------
    x, y : iterable of float
        Positions [m].
    yaw : iterable of float
        Headings [rad].
    nanoseconds : int
        Its time [ns].
    frame : str
        What the positions are in.

    Returns
    -------
    nav_msgs/msg/Path
        The message.

    Examples
    --------
    >>> len(path_message([0.0, 1.0], [0.0, 0.0], [0.0, 0.0], 0, "map").poses)
    2
    """
    header = _header(nanoseconds, frame)
    poses = [
        make("geometry_msgs/msg/PoseStamped", header=header, pose=_pose(*each))
        for each in zip(x, y, yaw, strict=True)
    ]
    return make(messages.PATH, header=header, poses=poses)


def ackermann_message(
    steer: float, speed: float, acceleration: float, nanoseconds: int, frame: str
) -> Any:  # noqa: ANN401
    """Make a drive command.

    Parameters
    ----------
    steer : float
        Angle of the front wheels [rad], positive to the left.
    speed : float
        Speed [m/s], negative backwards.
    acceleration : float
        Largest change of the speed [m/s²], up or down; its sign does not count.
    nanoseconds : int
        Its time [ns].
    frame : str
        The vehicle's own.

    Returns
    -------
    ackermann_msgs/msg/AckermannDriveStamped
        The message.

    Examples
    --------
    >>> ackermann_message(0.1, 2.0, -3.0, 0, "base_link").drive.acceleration
    3.0
    """
    drive = {"steering_angle": steer, "speed": speed, "acceleration": abs(acceleration)}
    return make(messages.ACKERMANN, header=_header(nanoseconds, frame), drive=drive)


def control_message(
    steer: float, speed: float, acceleration: float, nanoseconds: int, *, steer_rate: float = 0.0
) -> Any:  # noqa: ANN401
    """Make a control command of Autoware: angle [rad], speed [m/s], acceleration [m/s²], time [ns].

    The acceleration is in the direction of driving, as Autoware's own controllers and simulator
    have it; negative brakes. `steer_rate` is how fast the commanded angle changes [rad/s]. The
    command is to take effect at once: its times are all the same.

    Examples
    --------
    >>> control_message(0.1, -2.0, -3.0, 0).longitudinal.acceleration
    -3.0
    """
    now = time_message(nanoseconds)
    times = {"stamp": now, "control_time": now}
    lateral = {
        **times,
        "steering_tire_angle": steer,
        "steering_tire_rotation_rate": steer_rate,
        "is_defined_steering_tire_rotation_rate": True,
    }
    longitudinal = {
        **times,
        "velocity": speed,
        "acceleration": acceleration,
        "is_defined_acceleration": True,
    }
    return make(messages.CONTROL, **times, lateral=lateral, longitudinal=longitudinal)


def twist_message(speed: float, yaw_rate: float) -> Any:  # noqa: ANN401
    """Make a twist of a speed [m/s], negative backwards, and a yaw rate [rad/s].

    Examples
    --------
    >>> twist_message(2.0, 0.5).angular.z
    0.5
    """
    return make(messages.TWIST, linear={"x": float(speed)}, angular={"z": float(yaw_rate)})


def twist_stamped_message(twist: Any, nanoseconds: int, frame: str) -> Any:  # noqa: ANN401
    """Make a twist with its time [ns] and the vehicle's frame."""
    return make(messages.TWIST_STAMPED, header=_header(nanoseconds, frame), twist=twist)


def _pose(x: float, y: float, yaw: float) -> dict[str, dict[str, float]]:
    turned = {"z": math.sin(0.5 * yaw), "w": math.cos(0.5 * yaw)}
    return {"position": {"x": float(x), "y": float(y)}, "orientation": turned}


def _header(nanoseconds: int, frame: str) -> Any:  # noqa: ANN401
    return make("std_msgs/msg/Header", stamp=time_message(nanoseconds), frame_id=frame)


def check_frame_name(name: str) -> str:
    """Give the name of a frame without the slash of ROS 1; MessageError where it is none."""
    if len(name) > _LONGEST:
        raise MessageError(f"name of a frame of {len(name)} characters")
    return name.lstrip("/")
