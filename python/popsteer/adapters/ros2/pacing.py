"""The node's clock: a steady rate in real time, or the ticks of a simulation."""

from __future__ import annotations

import gc
import time
from typing import TYPE_CHECKING

from popsteer.adapters.ros2.conversions import nanoseconds_of
from popsteer.adapters.ros2.messages import CLOCK, decode
from popsteer.adapters.ros2.waiting import why_silent
from popsteer.errors import PopsteerError

if TYPE_CHECKING:
    from collections.abc import Callable

    from popsteer.adapters.ros2.dds import Participant, Reader
    from popsteer.adapters.ros2.node import Node

_SECOND = 10**9
_JUMP = 0.1  # the clock against the machine's steady one [s]; NTP slews far less in a cycle
_SIM_JUMP = 1.0  # from one tick of a simulation to the next [s]
_LAST = (2**31 - 1) * _SECOND  # what a stamp can say [ns]
_PATIENCE = 0.05
_STILL = 1.0  # without a tick [s]


def spin(node: Node, participant: Participant, stopped: Callable[[], bool]) -> None:
    """Run a node until it is stopped; its last command is a speed of 0.

    `participant` is the node's, `stopped` is asked in each cycle. Raises PopsteerError where
    nothing to drive by has come in within the time-out.
    """
    now = [0]
    # The collector would look through all that has been loaded in mid-drive, for nothing.
    gc.collect()
    gc.freeze()
    try:
        if node.options.sim_time:
            _spin_simulated(node, participant, stopped, now)
        else:
            _spin_real(node, stopped, now)
    finally:
        gc.unfreeze()
        node.finish(now[0])


def _spin_real(node: Node, stopped: Callable[[], bool], at: list[int]) -> None:
    period = round(node.options.period * _SECOND)
    begun = before = base = time.monotonic_ns()
    offset = time.time_ns() - begun
    came = False
    while not stopped():
        # It steps on the odometry, which is given half a period longer where it came the last time.
        due = base + (period * 3 // 2 if came else period)
        time.sleep(max(base + period * 3 // 4 - time.monotonic_ns(), 0) / _SECOND)
        came = node.odometry_reader.wait(max(due - time.monotonic_ns(), 0) / _SECOND)
        steady, at[0] = time.monotonic_ns(), time.time_ns()
        jump, offset = at[0] - steady - offset, at[0] - steady
        if abs(jump) > _JUMP * _SECOND:
            node.jumped(jump / _SECOND)
        missed = max(steady - due, 0) // period
        node.cycle(at[0], (steady - before) / _SECOND, missed)
        before, base = steady, steady if came else due + missed * period
        node.check_silence((steady - begun) / _SECOND)


def _spin_simulated(
    node: Node, participant: Participant, stopped: Callable[[], bool], at: list[int]
) -> None:
    clock = participant.reader(node.options.topics.clock, CLOCK)
    period = round(node.options.period * _SECOND)
    begun = heard = time.monotonic()
    before: int | None = None
    due = 0
    while not stopped():
        clock.wait(_PATIENCE)
        for now in _ticks(clock):
            if before is None:
                before, due = now - period, now
            elif now < before or now - before > max(_SIM_JUMP * _SECOND, 5 * period):
                node.jumped((now - before) / _SECOND)
                before, due = now - period, now
            heard = time.monotonic()
            if now >= due:
                missed = (now - due) // period
                due += (missed + 1) * period
                at[0] = now
                node.cycle(now, (now - before) / _SECOND, missed)
                before = now
        waited = time.monotonic() - begun
        if before is not None and time.monotonic() - heard > _STILL:
            node.note(f"paused: time stands still on {node.options.topics.clock}")
        if before is None and waited >= node.options.timeout:
            topic = node.options.topics.clock
            raise PopsteerError(
                f"no {CLOCK} on {topic} in domain {participant.domain} within"
                f" {node.options.timeout:g} s: {why_silent(topic, CLOCK, clock, participant)}"
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
