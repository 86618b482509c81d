"""A domain of one's own, and a node in it that the test steps itself."""

from __future__ import annotations

import fcntl
import gc
import itertools
import struct
import tempfile
import time
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import popsteer
from popsteer.adapters import ros2
from popsteer.adapters.ros2 import messages
from popsteer.adapters.ros2.commands import signed_speed
from popsteer.adapters.ros2.dds import Participant
from popsteer.adapters.ros2.node import Node, Options
from tests.adapters.ros2_plant import CAR
from tests.helpers import PATIENCE

if TYPE_CHECKING:
    from collections.abc import Callable

_NUMBERS = itertools.count()
_BLOCK = 12  # so that the last is 96: above 101 the ports may be other programs'
PERIOD = 20_000_000
SLOW = CAR.replace(max_speed=4.0)
START = 1_700_000_000 * 10**9


def domain() -> int:
    """A domain with nobody in it: no other process of tests on this machine, nor earlier tests."""
    number = domain_kept() + 1 + next(_NUMBERS) % (_BLOCK - 1)
    if _members(number):
        gc.collect()  # what earlier tests have left to the collector
    assert _members(number) == 0, number
    return number


def _members(number: int) -> int:
    """How many participants of this process are in a domain."""
    from cyclonedds import internal

    found = internal.DDS._dll_handle.dds_lookup_participant(number, None, 0)
    return max(int(found), 0)  # below 0 where the domain has never been


def domain_kept() -> int:
    """The domain of this process for all of its life."""
    return 1 + _BLOCK * _block()


@cache
def _block() -> int:
    """Which of eight blocks of domains is this process's, for as long as it lives."""
    folder = Path(tempfile.gettempdir()) / "popsteer-domains"
    folder.mkdir(exist_ok=True)
    until = time.monotonic() + PATIENCE
    while time.monotonic() < until:
        for number in range(8):
            lock = (folder / str(number)).open("w")
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                lock.close()
                continue
            _HELD.append(lock)
            return number
        time.sleep(0.5)
    raise TimeoutError("all blocks of domains are taken")


_HELD: list[Any] = []


class Client:
    """Calls a Trigger service as `rmw_cyclonedds_cpp` does: with its id and a number in front."""

    def __init__(self, member: Participant, name: str) -> None:
        kind = "std_srvs/srv/Trigger"
        self._requests = member.writer(f"{name}Request", f"{kind}_Request", prefix="rq")
        answer = f"{kind}_Response"
        self._answers = member.reader(f"{name}Reply", answer, reliable=True, prefix="rr")
        self._calls = 0

    def call(self, meanwhile: Callable[[], object]) -> tuple[bool, str]:
        self._calls += 1
        header = struct.pack("<Qq", 4711, self._calls)
        self._requests.write(b"\0\1\0\0" + header + b"\0")
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until:
            meanwhile()
            for data in self._answers.take():
                assert data[4:20] == header
                found = messages.decode("std_srvs/srv/Trigger_Response", data[:4] + data[20:])
                return found.success, found.message
            time.sleep(0.002)
        raise AssertionError("no answer")


class Bench:
    """A node, its surroundings in the same process, and a clock that the test moves.

    Its car drives at the speed that is commanded, at 4 m/s before the first. What is written is
    there when the call returns: DDS hands it over itself where both are in one process.
    """

    def __init__(self, make: Any = None, **options: Any) -> None:
        self.member = Participant(domain(), local=True)
        self.lines: list[str] = []
        made = make or (lambda path: popsteer.Driver(path, SLOW, popsteer.StanleyParams()))
        self.node = Node(self.member, made, Options(**options), say=self.lines.append)
        topics = self.node.options.topics
        self.odometry = self.member.writer(topics.odometry, messages.ODOMETRY)
        self.path = self.member.writer(topics.path, topics.path_type)
        self.drive = self.member.reader(topics.command, topics.command_type, reliable=True)
        self.reports = self.member.reader(topics.diagnostics, messages.DIAGNOSTICS, reliable=True)
        self.now = START
        self.x, self.speed = 0.0, 4.0

    def send(self, writer: Any, message: Any) -> None:
        writer.write(messages.encode(message))

    def send_path(self, frame: str = "map", length: float = 400.0, y: float = 0.0) -> None:
        xs = [float(x) for x in range(0, int(length) + 1, 5)]
        count = len(xs)
        message = ros2.path_message(xs, [y] * count, [0.0] * count, self.now, frame)
        self.send(self.path, message)

    def send_pose(
        self, speed: float | None = None, frame: str = "map", at: int | None = None, y: float = 0.1
    ) -> None:
        stamp, speed = self.now if at is None else at, self.speed if speed is None else speed
        self.send(self.odometry, ros2.odometry_message(self.x, y, 0.0, speed, stamp, frame))

    def cycle(self) -> popsteer.Drive | None:
        self.now += PERIOD
        drive = self.node.cycle(self.now, 0.02)
        if drive is not None:
            self.speed = signed_speed(drive)
            self.x += 0.02 * self.speed
        return drive

    def until(self, wanted: Callable[[], bool], at: int | None = None) -> bool:
        """Send poses and cycle until something holds."""
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until:
            self.send_pose(at=at)
            self.cycle()
            if wanted():
                return True
            time.sleep(0.001)
        return False

    def begin(self) -> None:
        """Send a path, and drive."""
        self.send_path()
        self.begin_on()

    def begin_on(self) -> None:
        """Drive along a path that has been sent."""
        for _ in range(100):
            self.send_pose()
            if self.cycle() is not None and self.state == "driving":
                return
        raise AssertionError(self.lines)

    def run(self, cycles: int, **pose: Any) -> None:
        """Drive on, with odometry."""
        for _ in range(cycles):
            self.send_pose(**pose)
            self.cycle()

    @property
    def state(self) -> str:
        return self.node.state

    @property
    def reason(self) -> str:
        return self.node.reason

    def report(self) -> dict[str, Any]:
        """The last diagnostics: statuses by name, and all values."""
        self.node._reported = 0
        self.cycle()
        found: list[bytes] = []
        until = time.monotonic() + PATIENCE
        while not found and time.monotonic() < until:
            time.sleep(0.002)
            found = self.reports.take()
        statuses = messages.decode(messages.DIAGNOSTICS, found[-1]).status
        values = {each.key: each.value for status in statuses for each in status.values}
        return {status.name: status for status in statuses} | {"values": values}
