"""The node's clock: a steady rate in real time, or the ticks of a simulation."""

from __future__ import annotations

import gc
import signal
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING

from popsteer.adapters.ros2.conversions import nanoseconds_of
from popsteer.adapters.ros2.messages import CLOCK, decode
from popsteer.errors import PopsteerError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from popsteer.adapters.ros2.dds import Participant, Reader
    from popsteer.adapters.ros2.node import Node

_SECOND = 10**9
_JUMP = 0.1  # the clock against the machine's steady one [s]; NTP slews far less in a cycle
_APART = 10**6  # what two readings of clocks may differ by without either having moved [ns]
_SIM_JUMP = 1.0  # from one tick of a simulation to the next [s]
_LAST = (2**31 - 1) * _SECOND  # what a stamp can say [ns]
_PATIENCE = 0.05
_STILL = 1.0  # without a tick [s]


def stop_on_signals() -> Callable[[], bool]:
    """Catch Ctrl-C and SIGTERM, each as often as it comes; gives whether one has come."""
    came: list[int] = []
    for kind in (signal.SIGINT, signal.SIGTERM):
        signal.signal(kind, lambda number, _: came.append(number))
    return lambda: bool(came)


@contextmanager
def frozen() -> Iterator[None]:
    """Keep the collector from what is there: it would look through it in mid-drive, for nothing."""
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


def spin(node: Node, participant: Participant, stopped: Callable[[], bool]) -> None:
    """Run a node until it is stopped; its last command is a speed of 0.

    `participant` is the node's, `stopped` is asked in each cycle. Raises PopsteerError where
    nothing to drive by has come in within the time-out.
    """
    now = [0]
    with frozen():
        try:
            if node.options.sim_time:
                _spin_simulated(node, participant, stopped, now)
            else:
                _spin_real(node, stopped, now)
        finally:
            node.finish(now[0])


class Pace:
    """When a node steps: on its odometry, or by a timer where that stays away. All times are in ns.

    It begins at `now` of the clock that measures its periods, where its stamps are of `wall`.
    Stamps are as far apart as periods are long: a recording has these to the nanosecond.
    """

    def __init__(self, period: int, now: int, wall: int) -> None:
        self._period = period
        self._before = self._base = now
        self._offset = wall - now
        self._came = False

    @property
    def earliest(self) -> int:
        """When it steps on odometry."""
        return self._base + self._period * 3 // 4

    @property
    def due(self) -> int:
        """When it steps without; odometry has half a period longer where it came the last time."""
        return self._base + (self._period * 3 // 2 if self._came else self._period)

    def jump(self, now: int, wall: int) -> float:
        """Say by how much a clock has jumped [s], else 0; periods begin anew where theirs has."""
        moved, passed = wall - now - self._offset, now - self._before
        if abs(moved) > _APART:
            self._offset += moved
        leaps = wall == now and passed > max(_SIM_JUMP * _SECOND, 5 * self._period)
        if leaps or passed < -_JUMP * _SECOND:
            self._before = self._base = now - self._period
            moved = passed
        return moved / _SECOND if abs(moved) > _JUMP * _SECOND else 0.0

    def cycle(self, node: Node, now: int, wall: int, *, came: bool) -> bool:
        """Let a node do a cycle, if it is time for one; says whether it was."""
        if jump := self.jump(now, wall):
            node.jumped(jump)
        if now < (self.earliest if came else self.due):
            return False
        node.cycle(now + self._offset, *self.step(now, came=came))
        return True

    def step(self, now: int, *, came: bool) -> tuple[float, int]:
        """Step, on odometry if it `came`; give the time since the last [s], and steps missed."""
        due = self.due
        missed = max(now - due, 0) // self._period
        passed = (now - self._before) / _SECOND
        self._before, self._base = now, now if came else due + missed * self._period
        self._came = came
        return passed, missed


def _spin_real(node: Node, stopped: Callable[[], bool], at: list[int]) -> None:
    begun = time.monotonic_ns()
    pace = Pace(round(node.options.period * _SECOND), begun, time.time_ns())
    while not stopped():
        time.sleep(max(pace.earliest - time.monotonic_ns(), 0) / _SECOND)
        came = node.odometry_reader.wait(max(pace.due - time.monotonic_ns(), 0) / _SECOND)
        steady, at[0] = time.monotonic_ns(), time.time_ns()
        pace.cycle(node, steady, at[0], came=came)
        node.check_silence((steady - begun) / _SECOND)


def _spin_simulated(
    node: Node, participant: Participant, stopped: Callable[[], bool], at: list[int]
) -> None:
    clock = participant.reader(node.options.topics.clock, CLOCK)
    period = round(node.options.period * _SECOND)
    begun = heard = time.monotonic()
    pace: Pace | None = None
    while not stopped():
        clock.wait(_PATIENCE)
        for now in _ticks(clock):
            pace = pace or Pace(period, now - period, now - period)
            heard, at[0] = time.monotonic(), now
            pace.cycle(node, now, now, came=False)
        waited = time.monotonic() - begun
        if pace is not None and time.monotonic() - heard > _STILL:
            node.note(f"paused: time stands still on {node.options.topics.clock}")
        if pace is None and waited >= node.options.timeout:
            topic = node.options.topics.clock
            why = participant.graph.why_silent(topic, CLOCK, clock)
            raise PopsteerError(
                f"no {CLOCK} on {topic} in domain {participant.domain} within"
                f" {node.options.timeout:g} s: {why}"
            )
        node.check_silence(waited)


def _ticks(clock: Reader) -> list[int]:
    """Give the newest time that has come in: a loop that is late does not run after it."""
    times = []
    for data in clock.take():
        try:
            now = nanoseconds_of(decode(CLOCK, data).clock)
        except Exception:  # noqa: BLE001, S112 - a message that is none
            continue
        if 0 <= now < _LAST:
            times.append(now)
    return times[-1:]
