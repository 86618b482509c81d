"""What is known about a topic that stays silent."""

from __future__ import annotations

from typing import TYPE_CHECKING

from popsteer.adapters.ros2.messages import ODOMETRY

if TYPE_CHECKING:
    from collections.abc import Sequence

    from popsteer.adapters.ros2.dds import Participant, Reader
    from popsteer.adapters.ros2.intake import Counted
    from popsteer.adapters.ros2.node import Node

__all__ = ["silence", "why_silent"]


def silence(node: Node, participant: Participant) -> str:
    """Say what a node has waited for in vain.

    Parameters
    ----------
    node : Node
        The node.
    participant : Participant
        Its member of the domain.

    Returns
    -------
    str
        The topic, its type, and what is known about its publishers.
    """
    topics, intake = node.options.topics, node.intake
    if intake.measured is None:
        topic, kind, count, readers = (
            topics.odometry,
            ODOMETRY,
            intake.odometry,
            [node.odometry_reader],
        )
    else:
        topic, kind, count, readers = (
            topics.path,
            topics.path_type,
            intake.courses,
            node.path_readers,
        )
    why = _refusals(count) or why_silent(topic, kind, readers, participant)
    return (
        f"no {kind} that can be used on {topic} in domain {participant.domain} within"
        f" {node.options.timeout:g} s: {why}"
    )


def why_silent(topic: str, kind: str, readers: Sequence[Reader], participant: Participant) -> str:
    """Say why nothing may have come in.

    Parameters
    ----------
    topic : str
        The topic.
    kind : str
        Its type.
    readers : sequence of Reader
        The subscriptions.
    participant : Participant
        The member of the domain.

    Returns
    -------
    str
        Who publishes, as far as that is known.

    Examples
    --------
    >>> from popsteer.adapters.ros2 import messages
    >>> from popsteer.adapters.ros2.dds import Participant
    >>> participant = Participant(76, local=True)
    >>> reader = participant.reader("/clock", messages.CLOCK)
    >>> why_silent("/clock", messages.CLOCK, [reader], participant)
    'nobody publishes it'
    """
    types = participant.types_of(topic)
    if types - {kind}:
        return f"it is published as {', '.join(sorted(types - {kind}))}"
    if any(reader.peers for reader in readers):
        return "its publisher sends nothing"
    if any(reader.refused for reader in readers):
        return "its publisher has a QoS that does not fit (best effort, where reliable is needed)"
    return "nobody publishes it"


def _refusals(count: Counted) -> str:
    if not count.refused:
        return ""
    hint = ""
    if count.reason.startswith("stamp is"):
        hint = "; the clocks have to agree, and simulated time needs --sim-time"
    return f"{count.refused} of {count.received} messages refused, the last: {count.reason}{hint}"
