"""Readers and writers over rclpy, as `popsteer.adapters.ros2.Node` takes them: of plain bytes."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Any

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from rosidl_runtime_py.utilities import get_message
from std_srvs.srv import Trigger

if TYPE_CHECKING:
    from collections.abc import Callable

    from rclpy.node import Node

_DEPTH = 10


def _qos(*, reliable: bool, latched: bool, depth: int) -> QoSProfile:
    return QoSProfile(
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


class Reader:
    """A subscription, whose messages wait until they are taken."""

    def __init__(
        self, node: Node, topic: str, kind: str, qos: QoSProfile, came: Callable[[], object]
    ) -> None:
        self._queue: deque[bytes] = deque(maxlen=_DEPTH)

        def take(data: bytes) -> None:
            self._queue.append(bytes(data))
            came()

        self.entity = node.create_subscription(
            get_message(kind),
            topic,
            take,
            qos,
            raw=True,
            qos_overriding_options=QoSOverridingOptions.with_default_policies(),
        )

    def take(self) -> list[bytes]:
        """Take what has come in, the oldest first."""
        found = list(self._queue)
        self._queue.clear()
        return found


class Writer:
    """A publisher of bytes."""

    def __init__(self, node: Node, topic: str, kind: str, qos: QoSProfile) -> None:
        options = QoSOverridingOptions.with_default_policies()
        self.entity = node.create_publisher(
            get_message(kind), topic, qos, qos_overriding_options=options
        )

    def write(self, data: bytes) -> None:
        """Publish a message."""
        self.entity.publish(data)

    @property
    def peers(self) -> int:
        """How many subscribers hear it."""
        return int(self.entity.get_subscription_count())


class _Service:
    """A service that rclpy answers by itself."""

    def take(self) -> list[bytes]:
        return []


class Transport:
    """What the node needs of a member of a domain, over the node of rclpy."""

    def __init__(self, node: Node, came: Callable[[], object]) -> None:
        self.node, self.namespace = node.get_name(), node.get_namespace()
        self.domain = node.context.get_domain_id()
        self.graph = self  # rclpy's node knows the graph
        self.release: Callable[[], str] = str
        self._node, self._came = node, came
        self._entities: list[tuple[Callable[[Any], object], Any]] = []
        self._published: set[str] = set()

    def reader(self, topic: str, kind: str, *, reliable: bool = False) -> Reader:
        """Subscribe; `came` is called for what may be stepped on."""
        qos = _qos(reliable=reliable, latched=False, depth=_DEPTH)
        return self._subscribed(Reader(self._node, topic, kind, qos, self._came))

    def latest(self, topic: str, kind: str) -> Reader:
        """Subscribe to the reliable publishers of a path.

        The path that a planner has kept comes by the QoS override ``durability: transient_local``
        alone: a subscription of rclpy has one QoS.
        """
        qos = _qos(reliable=True, latched=False, depth=_DEPTH)
        return self._subscribed(Reader(self._node, topic, kind, qos, lambda: None))

    def _subscribed(self, reader: Reader) -> Reader:
        self._entities.append((self._node.destroy_subscription, reader.entity))
        return reader

    def writer(self, topic: str, kind: str, *, latched: bool = False, depth: int = 1) -> Writer:
        """Publish on a topic, reliably."""
        found = Writer(self._node, topic, kind, _qos(reliable=True, latched=latched, depth=depth))
        self._entities.append((self._node.destroy_publisher, found.entity))
        self._published.add(topic)
        return found

    def service(self, name: str) -> _Service:
        """Offer the service that forgets a fault."""

        def answer(_: Any, response: Any) -> Any:
            response.success, response.message = True, self.release()
            return response

        found = self._node.create_service(Trigger, name, answer)
        self._entities.append((self._node.destroy_service, found))
        return _Service()

    def look(self) -> None:
        """Nothing to do: rclpy looks by itself."""

    def others(self, topic: str) -> int:
        """Count the publishers of a topic that are not this node's."""
        return int(self._node.count_publishers(topic)) - (topic in self._published)

    def close(self) -> None:
        """Take all readers, writers and services away."""
        for destroy, entity in self._entities:
            destroy(entity)
        self._entities.clear()
