"""What comes in beside odometry and paths: who drives, how fast at most, where the wheels are."""

from __future__ import annotations

import math
from contextlib import suppress
from functools import reduce
from typing import TYPE_CHECKING, Any

from popsteer.adapters.ros2 import messages
from popsteer.logs.messages import STEERING

if TYPE_CHECKING:
    from collections.abc import Callable

    from popsteer.adapters.ros2.dds import Participant
    from popsteer.adapters.ros2.topics import Topics


class Signals:
    """The topics `release`, `speed_limit`, `steering`, `mode` and `operation_mode` that there are.

    `take` takes what they bring, and says what is new of it. Bytes that are no message say nothing.

    Attributes
    ----------
    released, engaged : bool
        Whether somebody said that a fault is over; whether the vehicle was handed over.
    limited : bool
        Whether another limit of the speed was said.
    """

    def __init__(self, participant: Participant, topics: Topics) -> None:
        self.released = self.limited = self.engaged = False
        self._topics, self._types = topics, topics.types()
        names = topics.release, topics.speed_limit, topics.steering, topics.mode
        self._readers = {
            topic: participant.reader(topic, self._types[topic])
            for topic in (*names, topics.operation_mode)
            if topic
        }
        self._engaged: dict[str, bool] = {}
        self._limit: Any = None
        self._wheel = math.nan, -math.inf

    def take(self, now: float, record: Callable[[str, bytes], None]) -> None:
        """Take what has come in at `now` [s]; `record` is called with each topic and its bytes."""
        self.released = self.limited = self.engaged = False
        for topic, reader in self._readers.items():
            for data in reader.take():
                record(topic, data)
                with suppress(Exception):
                    self._hear(topic, messages.decode(self._types[topic], data), now)

    def slowed(self, most: float) -> float:
        """Give the lower of a speed and the limit, which may be in percent of it [m/s]."""
        limit = 0.0 if self._limit is None else self._limit.speed_limit
        if not limit > 0.0:
            return most
        return min(most, 0.01 * limit * most if self._limit.percentage else limit)

    def steer(self, now: float, stale: float) -> float | None:
        """Give the measured angle of the wheels [rad]; None where it is older than `stale` [s]."""
        angle, at = self._wheel
        return angle if abs(now - at) <= stale else None  # time may begin anew

    def _hear(self, topic: str, message: Any, now: float) -> None:  # noqa: ANN401
        topics, kind = self._topics, self._types[topic]
        if topic == topics.speed_limit:
            if not message.speed_limit >= 0.0:
                return  # a number that is no limit ends none
            before, self._limit = self._limit, message
            self.limited |= before is None or any(
                getattr(before, name) != getattr(message, name)
                for name in ("speed_limit", "percentage")
            )
        elif topic == topics.steering:
            angle = float(reduce(getattr, STEERING[kind].angle, message))
            if abs(angle) < 0.5 * math.pi:
                self._wheel = angle, now
        elif topic == topics.release:
            self.released = True
        else:
            if topic == topics.mode:
                engaged = message.mode == 1
            else:
                engaged = message.mode == message.AUTONOMOUS and message.is_autoware_control_enabled
            self.engaged |= engaged and not self._engaged.get(topic, False)
            self._engaged[topic] = engaged
