"""Paths of ROS 2: the points that messages have, by their bytes where they are many, and frames."""

from __future__ import annotations

import math
import struct
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from popsteer import Path, PathError
from popsteer.adapters.ros2 import messages
from popsteer.adapters.ros2.conversions import MessageError, check_frame_name
from popsteer.adapters.ros2.messages import decode

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

Pose = tuple[float, float, float]
"""x, y [m] and yaw [rad], of a frame or a vehicle, in a frame."""


def placed(first: Pose, then: Pose) -> Pose:
    """Give a pose that is given in the frame whose own pose is `first`.

    Examples
    --------
    >>> [round(number, 3) for number in placed((1.0, 0.0, math.pi / 2), (2.0, 0.0, 0.5))]
    [1.0, 2.0, 2.071]
    """
    (x, y, yaw), (ahead, left, turn) = first, then
    c, s = math.cos(yaw), math.sin(yaw)
    return x + c * ahead - s * left, y + s * ahead + c * left, math.remainder(yaw + turn, math.tau)


def inverse(pose: Pose) -> Pose:
    """Give the pose of the frame that a pose is given in, in the frame of that pose.

    Examples
    --------
    >>> pose = (3.0, 2.0, 0.3)
    >>> max(map(abs, placed(pose, inverse(pose)))) < 1e-15
    True
    """
    x, y, yaw = pose
    c, s = math.cos(yaw), math.sin(yaw)
    return -c * x - s * y, s * x - c * y, -yaw


class Points(NamedTuple):
    """What a message says of a path."""

    xy: NDArray[np.float64]
    """Places, shape (N, 2) [m]."""
    speed: NDArray[np.float64] | None
    """Speeds, shape (N,) [m/s]; negative where the path from the point on is driven backwards."""
    reverse: NDArray[np.bool_] | None
    """The same of a path without speeds, shape (N,); None where all of it is driven forwards."""
    frame: str
    """What the places are in."""

    def path(self, *, closed: bool = False, seen_from: Pose | None = None) -> Path:
        """Make the path, in the frame in which that of the points has the pose `seen_from`."""
        xy = self.xy
        if seen_from is not None:
            x, y, yaw = seen_from
            c, s = math.cos(yaw), math.sin(yaw)
            xy = np.column_stack((x + xy @ (c, -s), y + xy @ (s, c)))
        reverse = None if self.reverse is None else self.reverse.tolist()
        try:
            return Path(xy, speed=self.speed, reverse=reverse, closed=closed)
        except PathError as error:
            raise MessageError(str(error)) from error


def path_of(message: Any, *, closed: bool = False) -> tuple[Path, str]:  # noqa: ANN401
    """Give the path of a path or trajectory message.

    The speeds of a trajectory are negative where it is driven backwards. A ``nav_msgs/Path`` has no
    speeds: it is driven backwards where its orientations point against the way from one pose to the
    next, and forwards where all but the last are left as they are when nobody sets them. The path
    itself takes no heading of either: many planners turn each towards the next point, not along the
    path there. Points that coincide count once.

    Parameters
    ----------
    message : nav_msgs/msg/Path or autoware_planning_msgs/msg/Trajectory
        The message.
    closed : bool, default False
        Whether the last point joins the first.

    Returns
    -------
    tuple of Path and str
        The path, and the frame it is in.

    Raises
    ------
    MessageError
        It makes no path: fewer than two points, or a number that is not finite.

    Examples
    --------
    >>> from popsteer.adapters.ros2 import path_message
    >>> message = path_message([0.0, 3.0], [0.0, 4.0], [0.0, 0.0], 0, "map")
    >>> path, frame = path_of(message)
    >>> path.length, frame
    (5.0, 'map')
    """
    points = points_of(message)
    return points.path(closed=closed), points.frame


def points_of(message: Any) -> Points:  # noqa: ANN401
    """Give the points of a path or trajectory message; MessageError where its frame is none."""
    frame = check_frame_name(message.header.frame_id)
    if message.__msgtype__ == messages.TRAJECTORY:
        speed = [float(point.longitudinal_velocity_mps) for point in message.points]
        xy = numbers_of(message.points)[:, :2]
        return Points(xy, np.array(speed, dtype=np.float64), None, frame)
    return points_of_poses(numbers_of(message.poses), frame)


def points_of_bytes(kind: str, data: bytes) -> Points:
    """Do what `points_of` does, 50 times faster; MessageError, or whatever rosbags raises."""
    found = _trajectory(data) if kind == messages.TRAJECTORY else _poses(data)
    return points_of(decode(kind, data)) if found is None else found


def points_of_poses(poses: NDArray[np.float64], frame: str) -> Points:
    """Give the points of poses, shape (N, 7): places and orientations as messages have them."""
    xy = np.ascontiguousarray(poses[:, :2])
    return Points(xy, None, _reverse(xy, poses[:, 3:]), check_frame_name(frame))


def numbers_of(stamped: Iterable[Any]) -> NDArray[np.float64]:
    """Give the poses of messages that have one each, shape (N, 7): place and orientation."""
    poses = [(each.pose.position, each.pose.orientation) for each in stamped]
    rows = [(at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w) for at, turn in poses]
    return np.array(rows, dtype=np.float64).reshape(-1, 7)


def _reverse(xy: NDArray[np.float64], turns: NDArray[np.float64]) -> NDArray[np.bool_] | None:
    """Say where orientations, shape (N, 4), point against the way to the next point.

    A message that nobody has turned is (0, 0, 0, 1); planners of places alone turn the last one.
    """
    if len(xy) < 2 or not (turns[:-1] != (0.0, 0.0, 0.0, 1.0)).any():
        return None
    x, y, z, w = turns.T
    heading = np.column_stack((w * w + x * x - y * y - z * z, 2.0 * (w * z + x * y)))
    along = ((heading[:-1] + heading[1:]) * np.diff(xy, axis=0)).sum(axis=1)
    reverse = np.append(along < 0.0, along[-1:] < 0.0)
    return reverse if reverse.any() else None


def _poses(data: bytes) -> Points | None:
    """Give the points of a ``nav_msgs/Path`` by its bytes; None where they are none.

    Of each pose: a time of 8 bytes, the name of its frame, and 7 numbers at a multiple of 8.
    """
    try:
        order, body, frame, count, begin = _head(data)
        length = struct.Struct(f"{order}I").unpack_from
        named = length(body, begin + 8)[0]
        first, stride = begin + named + 19 & -8, (named + 19 & -8) + 56
        if not 0 < 56 * count <= len(body):
            return None
        even = first + (count - 1) * stride + 56 == len(body)
        # Where the names from the second pose on are as long as the first.
        if even and (_column(body, f"{order}u4", 1, first + 64, stride, count - 1) == named).all():
            poses = _column(body, f"{order}f8", 7, first, stride, count)
        else:
            found, at = [], begin
            for _ in range(count):
                found.append(at + length(body, at + 8)[0] + 19 & -8)
                at = found[-1] + 56
            if at != len(body):
                return None
            numbers = np.frombuffer(body, f"{order}f8")
            poses = numbers[np.array(found)[:, None] // 8 + np.arange(7)]
    except (struct.error, ValueError, TypeError, IndexError):
        return None
    return points_of_poses(poses.astype(np.float64), frame)


def _trajectory(data: bytes) -> Points | None:
    """Give the points of a trajectory by its bytes; None where they are none.

    Of each point: a time of 8 bytes, at a multiple of 8 a pose, and 6 numbers of 4 bytes.
    """
    try:
        order, body, frame, count, begin = _head(data)
        first, stride = begin + 15 & -8, 88
        if not 0 < 80 * count <= len(body) or first + (count - 1) * stride + 80 != len(body):
            return None
        xy = _column(body, f"{order}f8", 2, first, stride, count).astype(np.float64)
        speed = _column(body, f"{order}f4", 1, first + 56, stride, count)[:, 0].astype(np.float64)
    except (struct.error, ValueError, TypeError):
        return None
    return Points(xy, speed, None, check_frame_name(frame))


def _head(data: bytes) -> tuple[str, memoryview, str, int, int]:
    """Give byte order, body, frame, number of points and where they begin."""
    order, body = "<" if data[1:2] == b"\1" else ">", memoryview(data)[4:]
    end = 12 + struct.unpack_from(f"{order}I", body, 8)[0]
    frame = bytes(body[12 : end - 1]).decode()
    begin = end + 3 & -4
    return order, body, frame, struct.unpack_from(f"{order}I", body, begin)[0], begin + 4


def _column(body: memoryview, kind: str, width: int, at: int, stride: int, count: int) -> Any:  # noqa: ANN401
    return np.ndarray((count, width), kind, body, at, (stride, int(kind[2:])))
