"""What the node records, played to another one."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import pytest

import popsteer

pytest.importorskip("rosbags", reason='the extra "ros2" is not installed')
pytest.importorskip("cyclonedds", reason='the extra "ros2" is not installed')

from rosbags.highlevel import AnyReader

from popsteer.adapters import ros2
from popsteer.adapters.ros2 import messages
from tests.adapters.ros2_domain import Bench
from tests.adapters.ros2_plant import CAR

if TYPE_CHECKING:
    from pathlib import Path


class Taken(list[bytes]):
    """A reader that has what the test gives it."""

    def take(self) -> list[bytes]:
        found = list(self)
        self.clear()
        return found


def test_recording_that_is_played_gives_the_recorded_commands(tmp_path: Path) -> None:
    file, dts = tmp_path / "drive.mcap", itertools.cycle([0.09, 0.02, 0.015, 0.023, 0.0202])
    with ros2.Recording(file) as recording:
        bench = Bench(lambda path: popsteer.Driver(path, CAR))
        bench.node._recording = recording
        bench.send_pose(0.0)
        bench.send_path()
        speed = 0.0
        for k, dt in zip(range(300), dts, strict=False):
            bench.now += round(dt * 1e9)
            drive = bench.node.cycle(bench.now, dt)
            speed += 0.0 if drive is None else 0.1 * (drive.speed - speed)  # it obeys late
            bench.x += speed * dt
            bench.send_pose(speed, y=0.3)
            if k % 5 == 0:
                bench.send_path(y=0.001 * k)
    again = Bench(lambda path: popsteer.Driver(path, CAR)).node
    readers = {"/odom": Taken(), "/path": Taken()}
    again.odometry_reader, again.path_reader = readers["/odom"], readers["/path"]  # type: ignore[assignment]
    before, commanded = 0, 0
    with AnyReader([file], default_typestore=messages.store()) as reader:
        for now, group in itertools.groupby(reader.messages(), key=lambda each: each[1]):
            found = [(each.topic, data) for each, _, data in group]
            for topic, data in found:
                readers.get(topic, Taken()).append(bytes(data))
            # How long before the first one the node had cycled is not in the file.
            drive = again.cycle(now, 1e-9 * (now - before) if before else 0.5)
            before = now
            for topic, data in found:
                if topic == "/drive":
                    told = messages.decode(messages.ACKERMANN, bytes(data)).drive
                    assert drive is not None
                    assert drive.steer == pytest.approx(told.steering_angle, abs=1e-7)
                    assert drive.speed == pytest.approx(told.speed, abs=1e-5)
                    commanded += 1
    assert commanded > 200
