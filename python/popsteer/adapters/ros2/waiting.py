"""What is known about a topic that stays silent."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from popsteer.adapters.ros2.dds import Participant, Reader
    from popsteer.adapters.ros2.intake import Counted


def why_none_is_usable(
    count: Counted, topic: str, kind: str, reader: Reader, participant: Participant
) -> str:
    """Say why the last message was refused; without one, what is known about the publishers."""
    if not count.refused:
        return why_silent(topic, kind, reader, participant)
    hint = ""
    if count.reason.startswith("stamp is"):
        hint = "; the clocks have to agree, and simulated time needs --sim-time"
    return f"{count.refused} of {count.received} messages refused, the last: {count.reason}{hint}"


def why_silent(topic: str, kind: str, reader: Reader, participant: Participant) -> str:
    """Say why nothing may have come in on a topic of a type: who publishes it, as far as known."""
    participant.graph.look()
    others = {each.kind for each in participant.graph.of(topic)} - {kind}
    if others:
        return f"it is published as {', '.join(sorted(others))}"
    if reader.peers:
        return "its publisher sends nothing"
    if reader.refused:
        return "its publisher has a QoS that does not fit (best effort, where reliable is needed)"
    return "nobody publishes it"
