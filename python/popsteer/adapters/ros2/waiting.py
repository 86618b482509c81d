"""What is known about a topic that stays silent."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from popsteer.adapters.ros2.dds import Participant, Reader
    from popsteer.adapters.ros2.intake import Counted

__all__ = ["why_none_is_usable", "why_silent"]


def why_none_is_usable(
    count: Counted, topic: str, kind: str, readers: Sequence[Reader], participant: Participant
) -> str:
    """Say why no message of a topic can be used.

    Parameters
    ----------
    count : Counted
        How many have come in.
    topic, kind : str
        The topic and its type.
    readers : sequence of Reader
        The subscriptions.
    participant : Participant
        The member of the domain.

    Returns
    -------
    str
        Why the last one was refused; without one, what is known about the publishers.
    """
    if not count.refused:
        return why_silent(topic, kind, readers, participant)
    hint = ""
    if count.reason.startswith("stamp is"):
        hint = "; the clocks have to agree, and simulated time needs --sim-time"
    return f"{count.refused} of {count.received} messages refused, the last: {count.reason}{hint}"


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
