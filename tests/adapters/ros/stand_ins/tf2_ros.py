"""What popsteer_ros uses of tf2_ros, which has no wheel: the same names, in plane geometry.

Links are kept for `cache_time`; a place between two is interpolated, one outside of them refused.
The latest time that a chain of frames knows is 0 where nothing in it moves. All as tf2 has it.
"""

from __future__ import annotations

import bisect
import cmath
import math
from typing import TYPE_CHECKING, Any, NamedTuple

from geometry_msgs.msg import TransformStamped
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.time import Time
from tf2_msgs.msg import TFMessage

if TYPE_CHECKING:
    from rclpy.duration import Duration


class TransformException(Exception):  # noqa: N818 - tf2's name
    """A transform is not known."""


class _Link(NamedTuple):
    """Where a frame is in its parent: place and heading, that of norm 1, as complex numbers."""

    stamp: int
    place: complex
    turn: complex


class Buffer:
    """What has been heard of frames."""

    def __init__(self, cache_time: Duration | None = None) -> None:
        self._kept = 10**10 if cache_time is None else cache_time.nanoseconds
        self._parents: dict[str, str] = {}
        self._moving: dict[str, list[_Link]] = {}
        self._fixed: dict[str, _Link] = {}

    def clear(self) -> None:
        """Forget the links that move."""
        for links in self._moving.values():
            links.clear()

    def set_transform(self, found: Any, _: str) -> None:
        self._add(found, fixed=False)

    def set_transform_static(self, found: Any, _: str) -> None:
        self._add(found, fixed=True)

    def _add(self, found: Any, *, fixed: bool) -> None:
        to, q = found.transform.translation, found.transform.rotation
        turn = cmath.rect(1.0, 2.0 * math.atan2(q.z, q.w))
        link = _Link(Time.from_msg(found.header.stamp).nanoseconds, complex(to.x, to.y), turn)
        child = found.child_frame_id
        self._parents[child] = found.header.frame_id
        if fixed:
            self._fixed[child] = link
            return
        links = self._moving.setdefault(child, [])
        if links and link.stamp < links[-1].stamp - self._kept:
            return  # older than what is kept
        bisect.insort(links, link, key=lambda each: each.stamp)
        while links[0].stamp < links[-1].stamp - self._kept:
            del links[0]

    def lookup_transform(self, target: str, source: str, time: Time) -> TransformStamped:
        """Give a frame in another, at a time or at the latest that all links between know."""
        up, down = self._chain(source), self._chain(target)
        while up and down and up[-1] == down[-1]:
            up.pop()
            down.pop()
        moving = [each for each in (*up, *down) if each not in self._fixed]
        if empty := [each for each in moving if not self._moving.get(each)]:
            raise TransformException(f"{empty[0]!r} passed to lookupTransform has no transforms")
        at = time.nanoseconds
        if at == 0 and moving:
            at = min(self._moving[each][-1].stamp for each in moving)
        place, turn = self._sum(down, at)
        to, turned = self._sum(up, at)
        found = TransformStamped()
        found.header.stamp, found.header.frame_id = Time(nanoseconds=at).to_msg(), target
        found.child_frame_id = source
        to, turned = (to - place) * turn.conjugate(), turned * turn.conjugate()
        found.transform.translation.x, found.transform.translation.y = to.real, to.imag
        half = 0.5 * cmath.phase(turned)
        found.transform.rotation.z, found.transform.rotation.w = math.sin(half), math.cos(half)
        return found

    def _chain(self, frame: str) -> list[str]:
        found = [frame]
        while found[-1] in self._parents:
            found.append(self._parents[found[-1]])
        if len(found) == 1 and frame not in self._parents.values():
            raise TransformException(f"{frame!r} passed to lookupTransform does not exist")
        return found

    def _sum(self, chain: list[str], at: int) -> tuple[complex, complex]:
        place, turn = 0j, 1 + 0j
        for frame in chain:
            if frame not in self._parents:
                raise TransformException(f"{frame!r} is not in the same tree")
            link = self._fixed.get(frame) or self._between(frame, at)
            place, turn = link.place + link.turn * place, link.turn * turn
        return place, turn

    def _between(self, frame: str, at: int) -> _Link:
        links = self._moving[frame]
        k = bisect.bisect_left(links, at, key=lambda each: each.stamp)
        if k < len(links) and links[k].stamp == at:
            return links[k]
        if k in (0, len(links)):
            where = "past" if k == 0 else "future"
            raise TransformException(
                f"lookup of {frame!r} would require extrapolation into the {where}"
            )
        before, after = links[k - 1 : k + 1]
        share = (at - before.stamp) / (after.stamp - before.stamp)
        turned = cmath.phase(after.turn * before.turn.conjugate())
        place = before.place + share * (after.place - before.place)
        return _Link(at, place, before.turn * cmath.rect(1.0, share * turned))


_KEPT = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class TransformListener:
    """Fills a buffer with what is published."""

    def __init__(self, buffer: Buffer, node: Any) -> None:
        self._node = node

        def taking(take: Any) -> Any:
            return lambda message: [take(each, "") for each in message.transforms]

        self._subscriptions = [
            node.create_subscription(TFMessage, "/tf", taking(buffer.set_transform), 100),
            node.create_subscription(
                TFMessage, "/tf_static", taking(buffer.set_transform_static), _KEPT
            ),
        ]

    def unregister(self) -> None:
        """Hear no more."""
        for each in self._subscriptions:
            self._node.destroy_subscription(each)


class TransformBroadcaster:
    """Publishes links that move."""

    topic, profile = "/tf", QoSProfile(depth=100)

    def __init__(self, node: Any) -> None:
        self._publisher = node.create_publisher(TFMessage, self.topic, self.profile)
        self._sent: dict[str, Any] = {}

    def sendTransform(self, sent: Any) -> None:  # noqa: N802 - tf2's name
        """Publish one or several."""
        found = sent if isinstance(sent, list) else [sent]
        self._publisher.publish(TFMessage(transforms=found))


class StaticTransformBroadcaster(TransformBroadcaster):
    """Publishes links that stay, all of them each time."""

    topic, profile = "/tf_static", _KEPT

    def sendTransform(self, sent: Any) -> None:  # noqa: N802 - tf2's name
        """Publish one or several beside those before."""
        found = sent if isinstance(sent, list) else [sent]
        self._sent |= {each.child_frame_id: each for each in found}
        self._publisher.publish(TFMessage(transforms=list(self._sent.values())))
