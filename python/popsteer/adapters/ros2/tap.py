"""Records what others exchange: the topics of a node, as they are on the wire."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from popsteer.adapters.ros2.messages import PATH, TRAJECTORY
from popsteer.errors import PopsteerError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from popsteer.adapters.ros2.dds import Participant
    from popsteer.adapters.ros2.recording import Recording

_PERIOD = 0.01


def tap(
    participant: Participant,
    topics: Mapping[str, str],
    recording: Recording,
    stopped: Callable[[], bool],
    *,
    timeout: float = 10.0,
    seconds: float = float("inf"),
) -> dict[str, int]:
    """Record topics, given with their types, until it is stopped; gives how many messages of each.

    Waits `timeout` [s] for the first message, else PopsteerError; ends after `seconds`.
    """
    # Only a path may have been published before it matters; the others may be of best effort.
    readers = {
        topic: (participant.latest if kind in (PATH, TRAJECTORY) else participant.reader)(
            topic, kind
        )
        for topic, kind in topics.items()
    }
    counts = dict.fromkeys(topics, 0)
    begun = time.monotonic()
    while not stopped() and time.monotonic() - begun < seconds:
        time.sleep(_PERIOD)
        for topic, kind in topics.items():
            for data in readers[topic].take():
                recording.add_bytes(topic, kind, data, time.time_ns())
                counts[topic] += 1
        participant.graph.look()
        if not any(counts.values()) and time.monotonic() - begun >= timeout:
            why = "; ".join(
                f"{topic}: {participant.graph.why_silent(topic, kind, readers[topic])}"
                for topic, kind in topics.items()
            )
            raise PopsteerError(
                f"no message in domain {participant.domain} within {timeout:g} s: {why}"
            )
    return counts
