"""Readers and writers over rclpy, as `popsteer.adapters.ros2.Node` takes them: of plain bytes."""

from __future__ import annotations

from collections import deque
from functools import partial
from typing import TYPE_CHECKING, Any

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from rosidl_runtime_py.utilities import get_message
from std_srvs.srv import Trigger

if TYPE_CHECKING:
    from collections.abc import Callable

    from rclpy.node import Node

_DEPTH = 10


class Reader:
    """What has come in on a topic."""

    def __init__(self) -> None:
        self.queue: deque[bytes] = deque(maxlen=_DEPTH)

    def take(self) -> list[bytes]:
        """Take it, the oldest first."""
        found = list(self.queue)
        self.queue.clear()
        return found


class Writer:
    """A publisher of bytes."""

    def __init__(self, publisher: Any) -> None:
        self._publisher = publisher

    def write(self, data: bytes) -> None:
        """Publish a message."""
        self._publisher.publish(data)

    @property
    def peers(self) -> int:
        """How many subscribers hear it."""
        return int(self._publisher.get_subscription_count())


class Transport:
    """What the node needs of a member of a domain, over the node of rclpy.

    `came` is called when there is odometry to step on.
    """

    def __init__(self, node: Node, came: Callable[[], object]) -> None:
        self.node, self.namespace = node.get_name(), node.get_namespace()
        self.domain = node.context.get_domain_id()
        self.graph = self  # rclpy's node knows the graph
        self.release: Callable[[], str] = str
        self._node, self._came = node, came
        self._closers: list[Callable[[], object]] = []
        self._published: set[str] = set()

    def reader(self, topic: str, kind: str) -> Reader:
        """Subscribe to all publishers of a topic."""
        return self._subscribe(topic, kind, ReliabilityPolicy.BEST_EFFORT, self._came)

    def latest(self, topic: str, kind: str) -> Reader:
        """Subscribe to the reliable publishers of a path.

        The path that a planner has kept comes by the QoS override ``durability: transient_local``
        alone: a subscription of rclpy has one QoS.
        """
        return self._subscribe(topic, kind, ReliabilityPolicy.RELIABLE, lambda: None)

    def _subscribe(
        self, topic: str, kind: str, reliability: Any, came: Callable[[], object]
    ) -> Reader:
        reader = Reader()

        def take(data: bytes) -> None:
            reader.queue.append(bytes(data))
            came()

        found = self._node.create_subscription(
            get_message(kind),
            topic,
            take,
            QoSProfile(depth=_DEPTH, reliability=reliability),
            raw=True,
            qos_overriding_options=QoSOverridingOptions.with_default_policies(),
        )
        self._closers.append(partial(self._node.destroy_subscription, found))
        return reader

    def writer(self, topic: str, kind: str, *, latched: bool = False, depth: int = 1) -> Writer:
        """Publish on a topic, reliably."""
        kept = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        found = self._node.create_publisher(
            get_message(kind),
            topic,
            QoSProfile(depth=depth, durability=kept),
            qos_overriding_options=QoSOverridingOptions.with_default_policies(),
        )
        self._closers.append(partial(self._node.destroy_publisher, found))
        self._published.add(topic)
        return Writer(found)

    def service(self, name: str) -> Reader:
        """Offer the service that forgets a fault; rclpy answers it, so no requests wait here."""

        def answer(_: Any, response: Any) -> Any:
            response.success, response.message = True, self.release()
            return response

        found = self._node.create_service(Trigger, name, answer)
        self._closers.append(partial(self._node.destroy_service, found))
        return Reader()

    def look(self) -> None:
        """Nothing to do: rclpy looks by itself."""

    def others(self, topic: str) -> int:
        """Count the publishers of a topic that are not this node's."""
        return int(self._node.count_publishers(topic)) - (topic in self._published)

    def close(self) -> None:
        """Take all readers, writers and services away."""
        while self._closers:
            self._closers.pop()()
