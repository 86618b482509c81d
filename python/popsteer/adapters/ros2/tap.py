"""Records what others exchange: the topics of a node, as they are on the wire."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from popsteer.adapters.ros2.waiting import why_silent
from popsteer.errors import PopsteerError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from popsteer.adapters.ros2.dds import Participant
    from popsteer.adapters.ros2.recording import Recording

__all__ = ["tap"]

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
    """Record topics until it is stopped.

    Parameters
    ----------
    participant : Participant
        The member of the domain.
    topics : mapping of str to str
        Types by topic.
    recording : Recording
        Where the messages go.
    stopped : callable
        Says whether to stop.
    timeout : float, default 10.0
        How long to wait for the first message [s].
    seconds : float, optional
        How long to record [s]; by default without end.

    Returns
    -------
    dict of str to int
        How many messages of each topic were recorded.

    Raises
    ------
    PopsteerError
        Nothing has come in within the time-out.
    """
    # A latched path is heard by the second kind alone if it was sent before.
    readers = {
        topic: [participant.reader(topic, kind), participant.reader(topic, kind, latched=True)]
        for topic, kind in topics.items()
    }
    counts, last = dict.fromkeys(topics, 0), dict.fromkeys(topics, b"")
    begun = time.monotonic()
    while not stopped() and time.monotonic() - begun < seconds:
        time.sleep(_PERIOD)
        for topic, kind in topics.items():
            for data in (each for reader in readers[topic] for each in reader.take()):
                if data != last[topic]:
                    recording.add_bytes(topic, kind, data, time.time_ns())
                    counts[topic] += 1
                last[topic] = data
        if not any(counts.values()) and time.monotonic() - begun >= timeout:
            why = "; ".join(
                f"{topic}: {why_silent(topic, kind, readers[topic], participant)}"
                for topic, kind in topics.items()
            )
            raise PopsteerError(
                f"no message in domain {participant.domain} within {timeout:g} s: {why}"
            )
    return counts
