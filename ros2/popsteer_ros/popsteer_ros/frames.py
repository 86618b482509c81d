"""Poses in the frame of the path, and of the vehicle's point, by tf2."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rclpy.duration import Duration
from rclpy.time import Time
from tf2_ros import Buffer, TransformException, TransformListener

from popsteer.adapters.ros2 import Measured, MessageError, yaw_of

if TYPE_CHECKING:
    from rclpy.node import Node


class Frames:
    """Transforms odometry into another frame, and that of the vehicle's point, `base`.

    A transform older than odometry by more than `stale` [s] is not used; odometry waits for `axle`.
    """

    def __init__(self, node: Node, stale: float) -> None:
        self.base, self.axle, self.stale = "", "", stale
        self.known: dict[str, float] = {}  # of the vehicle: `rear_axle`, ahead of its point [m]
        self._buffer = Buffer(cache_time=Duration(seconds=10))
        self._listener = TransformListener(self._buffer, node)

    def find(self, target: str, source: str, stamp: int = 0) -> tuple[float, ...]:
        """Give place and yaw of a frame in another: at a time [ns], or else the last known.

        Raises MessageError where tf does not know them.
        """
        for at in (stamp, 0):  # localisation comes later than odometry, and changes slowly
            try:
                found = self._buffer.lookup_transform(target, source, Time(nanoseconds=at))
            except TransformException as error:
                said = str(error)
                continue
            known = Time.from_msg(found.header.stamp).nanoseconds  # 0 of what does not move
            age = 1e-9 * (stamp - known) if known else 0.0
            if age > self.stale:
                raise MessageError(f"transform from {source!r} to {target!r} is {age:.1f} s old")
            to, turn = found.transform.translation, found.transform.rotation
            return to.x, to.y, yaw_of(turn)
        raise MessageError(f"no transform from {source!r} to {target!r}: {said}")

    def transform(self, measured: Measured, frame: str) -> Measured:
        """Give what is measured in a frame, of the vehicle's point."""
        pose, child = measured[:3], measured.child_frame
        if measured.frame != frame:
            pose = _after(self.find(frame, measured.frame, measured.stamp), pose)
        if self.base and child and child != self.base:
            pose, child = _after(pose, self.find(child, self.base)), self.base
        if self.axle:
            self.known["rear_axle"] = self.find(child, self.axle)[0]
        return Measured(*pose, *measured[3:5], frame, child)

    def close(self) -> None:
        """Hear no more of tf."""
        self._listener.unregister()


def _after(first: tuple[float, ...], then: tuple[float, ...]) -> tuple[float, ...]:
    """Give a pose that is given in the frame of another pose."""
    (x, y, yaw), (ahead, left, turn) = first, then
    c, s = math.cos(yaw), math.sin(yaw)
    return x + c * ahead - s * left, y + s * ahead + c * left, math.remainder(yaw + turn, math.tau)
