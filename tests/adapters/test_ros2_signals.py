"""What the node hears beside odometry and paths: limits, the wheels' angle, who drives."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import Any

import pytest

pytest.importorskip("rosbags", reason='the extra "ros2" is not installed')
pytest.importorskip("cyclonedds", reason='the extra "ros2" is not installed')

from popsteer.adapters.ros2 import messages
from popsteer.adapters.ros2.dds import Participant
from popsteer.adapters.ros2.signals import Signals
from popsteer.adapters.ros2.topics import Topics
from tests.adapters.ros2_domain import domain
from tests.helpers import PATIENCE


def test_limits_angles_and_modes_are_heard_beside_odometry_and_paths() -> None:
    topics = replace(Topics.of_autoware(), speed_limit="/speed_limit")
    member = Participant(domain(), local=True)
    signals = Signals(member, topics)
    recorded: list[str] = []
    writers: dict[str, Any] = {}

    def heard(topic: str, **fields: Any) -> tuple[bool, bool]:
        """Send a message; say what is new when it has come."""
        kind = topics.types()[topic]
        writer = writers.setdefault(topic, member.writer(topic, kind))
        count, end = len(recorded), time.monotonic() + PATIENCE
        while not writer.peers and time.monotonic() < end:
            time.sleep(0.01)
        writer.write(messages.encode(messages.make(kind, **fields)))
        while len(recorded) == count and time.monotonic() < end:
            signals.take(5.0, lambda *taken: recorded.append(taken[0]))
        assert recorded[count:] == [topic]
        return signals.limited, signals.released or signals.engaged

    assert heard("/speed_limit", speed_limit=50.0) == (True, False)
    assert (signals.slowed(80.0), signals.slowed(20.0)) == (50.0, 20.0)
    assert heard("/speed_limit", speed_limit=50.0) == (False, False)
    # The same number is another limit in percent.
    assert heard("/speed_limit", speed_limit=50.0, percentage=True) == (True, False)
    assert signals.slowed(80.0) == 40.0
    for number in (-5.0, math.nan):
        assert heard("/speed_limit", speed_limit=number) == (False, False)
        assert signals.slowed(80.0) == 40.0
    assert heard("/speed_limit", speed_limit=0.0) == (True, False)
    assert signals.slowed(80.0) == 80.0
    assert heard(topics.operation_mode, mode=2) == (False, False)
    assert heard(topics.operation_mode, mode=2, is_autoware_control_enabled=True) == (False, True)
    assert heard(topics.operation_mode, mode=2, is_autoware_control_enabled=True) == (False, False)
    assert heard(topics.mode, mode=1) == (False, True)
    assert heard(topics.release) == (False, True)
    assert signals.steer(5.0, 0.3) is None
    heard(topics.steering, steering_tire_angle=0.125)
    assert signals.steer(5.2, 0.3) == 0.125
    # An angle of a time that is over, or of one that begins anew, is none of now.
    assert (signals.steer(5.4, 0.3), signals.steer(1.0, 0.3)) == (None, None)
    heard(topics.steering, steering_tire_angle=math.nan)
    assert signals.steer(5.2, 0.3) == 0.125
