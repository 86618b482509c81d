"""What a driver answers and intends, as messages."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from popsteer._core import _speed_defaults
from popsteer.adapters.ros2 import conversions, messages
from popsteer.adapters.ros2.paths import Pose, inverse, placed

if TYPE_CHECKING:
    from popsteer import Drive, Driver, Prediction

_POSES = 40  # of the intended trajectory, at most


def signed_speed(drive: Drive) -> float:
    """Give the speed that a driver commands [m/s], negative backwards."""
    return -drive.speed if drive.reverse else drive.speed


def command_message(
    kind: str,
    driver: Driver,
    drive: Drive,
    nanoseconds: int,
    frame: str,
    *,
    steer_rate: float = 0.0,
    ends: bool = False,
) -> Any:  # noqa: ANN401
    """Make the message of a type for an answer of a driver; the last one commands to stand.

    An `AckermannDrive` has the acceleration that the vehicle may have, with the reserve of the
    speed law, or as much as the driver asks for. A twist has the yaw rate v tan(angle) / (L +
    understeer v²), where the wheels' angle is the commanded one and the steering offset.
    """
    car, steer, acceleration = driver.vehicle, drive.steer, drive.acceleration
    speed = 0.0 if ends else signed_speed(drive)
    if ends or drive.hold or acceleration < 0.0:
        most = car.max_deceleration or _speed_defaults["max_deceleration"]
    else:
        most = car.max_acceleration or _speed_defaults["max_acceleration"]
    limit = max(most + driver.speed.reserve, -acceleration)
    if kind == messages.CONTROL:
        acceleration = -limit if ends else acceleration
        return conversions.control_message(
            steer, speed, acceleration, nanoseconds, steer_rate=steer_rate
        )
    if kind == messages.ACKERMANN:
        return conversions.ackermann_message(steer, speed, limit, nanoseconds, frame)
    turn = speed * math.tan(steer + car.steer_offset) / car.turning_length(speed)
    twist = conversions.twist_message(speed, turn)
    if kind == messages.TWIST:
        return twist
    return conversions.twist_stamped_message(twist, nanoseconds, frame)


def predicted_message(
    ahead: Prediction, seen_from: Pose | None, nanoseconds: int, frame: str
) -> Any:  # noqa: ANN401
    """Make the path of the intended trajectory, in the frame that has the pose `seen_from`."""
    every = -(-len(ahead.time) // _POSES)
    columns = (values[::every].tolist() for values in (ahead.x, ahead.y, ahead.yaw))
    back = inverse(seen_from or (0.0, 0.0, 0.0))
    poses = [placed(back, pose) for pose in zip(*columns, strict=True)]
    x, y, yaw = zip(*poses, strict=True)
    return conversions.path_message(x, y, yaw, nanoseconds, frame)
