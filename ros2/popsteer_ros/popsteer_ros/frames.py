"""Poses in the frame of the path, and of the vehicle's point, by tf2."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rclpy.duration import Duration
from rclpy.time import Time
from tf2_ros import Buffer, TransformException, TransformListener

from popsteer.adapters.ros2 import Measured, MessageError, yaw_of
from popsteer.adapters.ros2.paths import placed

if TYPE_CHECKING:
    from rclpy.node import Node

    from popsteer.adapters.ros2.paths import Pose

_AHEAD = 0.05  # how far clocks may be apart [s]


class Frames:
    """Transforms odometry into another frame, and that of the vehicle's point, `base`.

    A transform older than odometry by more than `stale` [s] is not used, nor one that has brought
    no news for so long: stamps may be ahead. Odometry waits for `axle`.
    """

    def __init__(self, node: Node, stale: float) -> None:
        self.base, self.axle, self.stale = "", "", stale
        self.known: dict[str, float] = {}  # of the vehicle: `rear_axle`, ahead of its point [m]
        self._clock = node.get_clock()
        self._news: dict[tuple[str, str], tuple[int, int]] = {}  # latest stamp, when it came [ns]
        self._buffer = Buffer(cache_time=Duration(seconds=10))
        self._listener = TransformListener(self._buffer, node)

    def clear(self) -> None:
        """Forget what was heard: time has begun anew."""
        self._buffer.clear()
        self._news.clear()

    def find(self, target: str, source: str, stamp: int = 0) -> Pose:
        """Give place and yaw of a frame in another: at a time [ns], or else the last known.

        Raises MessageError where tf does not know them.
        """
        what = f"transform from {source!r} to {target!r}"
        try:
            found = self._buffer.lookup_transform(target, source, Time())
            latest = Time.from_msg(found.header.stamp).nanoseconds  # 0 of what does not move
            if stamp and latest:
                self._check(what, (target, source), latest, stamp)
                try:
                    at = Time(nanoseconds=stamp)
                    found = self._buffer.lookup_transform(target, source, at)
                except TransformException:  # it comes later than odometry, and changes slowly
                    if latest > stamp + _AHEAD * 1e9:
                        raise
        except TransformException as error:
            raise MessageError(f"no {what}: {error}") from error
        to, turn = found.transform.translation, found.transform.rotation
        return to.x, to.y, yaw_of(turn)

    def _check(self, what: str, link: tuple[str, str], latest: int, stamp: int) -> None:
        """Refuse a transform that is too old, by its stamp or by when it came."""
        now = self._clock.now().nanoseconds
        if self._news.get(link, (0, 0))[0] != latest:
            self._news[link] = latest, now
        age = 1e-9 * max(stamp - latest, now - self._news[link][1])
        if age > self.stale:
            raise MessageError(f"{what} is {age:.1f} s old")

    def transform(self, measured: Measured, frame: str) -> Measured:
        """Give what is measured in a frame, of the vehicle's point."""
        pose, child = measured[:3], measured.child_frame
        if measured.frame != frame:
            pose = placed(self.find(frame, measured.frame, measured.stamp), pose)
        if self.base and child and child != self.base:
            pose, child = placed(pose, self.find(child, self.base)), self.base
        if self.axle:
            self.known["rear_axle"] = self.find(child, self.axle)[0]
        return Measured(*pose, *measured[3:5], frame, child, measured.yaw_rate)

    def close(self) -> None:
        """Hear no more of tf."""
        self._listener.unregister()
