"""The bond with Nav2's lifecycle manager, which is told ten times a second that the node lives."""

from __future__ import annotations

import uuid
from typing import TYPE_CHECKING, Any

from bond.msg import Status

if TYPE_CHECKING:
    from contextlib import ExitStack

_PERIOD, _TIMEOUT = 0.1, 4.0  # as Nav2's own nodes have them [s]


def begin(node: Any, until: ExitStack) -> None:
    """Publish on the topic ``bond`` until that closes; the last message breaks the bond."""
    status = Status(id=node.get_name(), instance_id=str(uuid.uuid4()), active=True)
    status.heartbeat_timeout, status.heartbeat_period = _TIMEOUT, _PERIOD
    publisher = node.create_publisher(Status, "bond", 10)

    def tell() -> None:
        status.header.stamp = node.get_clock().now().to_msg()
        publisher.publish(status)

    def end() -> None:
        node.destroy_timer(timer)
        status.active = False
        tell()
        node.destroy_publisher(publisher)

    timer = node.create_timer(_PERIOD, tell)
    until.callback(end)
