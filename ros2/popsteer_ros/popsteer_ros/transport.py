"""Readers and writers over rclpy, as `popsteer.adapters.ros2.Node` takes them: of plain bytes."""

from __future__ import annotations

from collections import deque
from contextlib import ExitStack
from importlib import import_module
from typing import TYPE_CHECKING, Any

from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos import QoSPolicyKind as Kind
from rclpy.qos_overriding_options import QoSOverridingOptions
from std_srvs.srv import Trigger

from popsteer.adapters.ros2.messages import ODOMETRY

if TYPE_CHECKING:
    from collections.abc import Callable

    from rclpy.node import Node

_DEPTH = 10
_HEARD = Duration(seconds=0.3)  # how long a subscriber may take to acknowledge the last command
_OVERRIDES = QoSOverridingOptions((Kind.HISTORY, Kind.DEPTH, Kind.RELIABILITY, Kind.DURABILITY))


def get_message(kind: str) -> Any:
    """Give the class of messages of a type, such as ``nav_msgs/msg/Path``."""
    package, part, name = kind.split("/")
    return getattr(import_module(f"{package}.{part}"), name)


class Reader(deque[bytes]):
    """What has come in on a topic."""

    def take(self) -> list[bytes]:
        """Take it, the oldest first."""
        found = list(self)
        self.clear()
        return found


class Writer:
    """A publisher of bytes."""

    def __init__(self, publisher: Any) -> None:
        self._publisher = publisher
        self.write = publisher.publish

    @property
    def peers(self) -> int:
        """How many subscribers hear it."""
        return int(self._publisher.get_subscription_count())


class Transport(ExitStack):
    """What the node needs of a member of a domain, over the node of rclpy.

    `came` is called when there is odometry to step on. To close it takes all away that it made.
    """

    def __init__(self, node: Node, came: Callable[[], object]) -> None:
        super().__init__()
        self.node, self.namespace = node.get_name(), node.get_namespace()
        self.graph = self  # rclpy's node knows the graph
        self._node, self._came = node, came
        self._published: set[str] = set()

    def reader(self, topic: str, kind: str) -> Reader:
        """Subscribe to all publishers of a topic."""
        return self._subscribe(topic, kind, ReliabilityPolicy.BEST_EFFORT)

    def latest(self, topic: str, kind: str) -> Reader:
        """Subscribe to the reliable publishers of a path; to kept ones by a QoS override alone."""
        return self._subscribe(topic, kind, ReliabilityPolicy.RELIABLE)

    def _subscribe(self, topic: str, kind: str, reliability: Any) -> Reader:
        reader = Reader(maxlen=_DEPTH)

        def take(data: bytes) -> None:
            reader.append(bytes(data))
            if kind == ODOMETRY:
                self._came()

        profile, node = QoSProfile(depth=_DEPTH, reliability=reliability), self._node
        found = node.create_subscription(
            get_message(kind), topic, take, profile, raw=True, qos_overriding_options=_OVERRIDES
        )
        self.callback(node.destroy_subscription, found)
        return reader

    def writer(self, topic: str, kind: str, *, latched: bool = False, depth: int = 1) -> Writer:
        """Publish on a topic, reliably."""
        kept = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        profile = QoSProfile(depth=depth, durability=kept)
        found = self._node.create_publisher(
            get_message(kind), topic, profile, qos_overriding_options=_OVERRIDES
        )
        self.callback(self._node.destroy_publisher, found)
        self.callback(found.wait_for_all_acked, _HEARD)  # or Fast DDS would lose the last message
        self._published.add(topic)
        return Writer(found)

    def service(self, name: str, do: Callable[[], str]) -> Reader:
        """Offer a service that answers with what `do` says; rclpy calls it, so nothing waits."""

        def answer(_: Any, response: Any) -> Any:
            response.success, response.message = True, do()
            return response

        found = self._node.create_service(Trigger, name, answer)
        self.callback(self._node.destroy_service, found)
        return Reader()

    def look(self) -> None:
        """Nothing to do: rclpy looks by itself."""

    def others(self, topic: str) -> int:
        """Count the publishers of a topic that are not this node's."""
        return int(self._node.count_publishers(topic)) - (topic in self._published)
