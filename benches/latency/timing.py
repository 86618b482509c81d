"""How the latency benchmark times calls.

A step takes a fifth of a microsecond to a few, an empty call a twentieth, and reading the clock
about as much, in ticks that are ten nanoseconds wide on some machines. So each call is driven
twice, by two controllers with states of their own:

- one by one: a reading of the clock before and after each single call. **p50**, **p99**, **p99.9**
  and **max** are of these, as read, nothing taken off: they hold one reading of the clock
  (`Result.timer_floor_ns`), and whatever else the machine did meanwhile. In a ratio of two of them
  the clock's own cost is in both numerator and denominator, and draws the ratio towards one.
- in batches: one reading of the clock before and one after some 32 calls in a row. The same loop
  without a call is timed too, its median taken off, and what remains divided by the number of
  calls. The median over the batches is **net p50**, net of clock and loop. It knows nothing of
  tails, and is the stricter one in ratios. A call that takes more than 10 µs is a batch by itself:
  the clock is under 1 % of it, and 32 in a row would catch too much of what else the machine does.

A call that is two stages, such as an update and a solve, is timed in stages where it is timed one
by one: a third reading of the clock, between them, parts it.

The calls take turns, batch by batch, forwards and backwards, so that what disturbs the machine
disturbs them alike; those with fewer calls to make take theirs evenly spread over the run. The
garbage collector is off. All this is the cost of a step in a loop that does nothing else, with warm
caches; what is called twenty times a second between other work finds them colder.
"""

from __future__ import annotations

import gc
from array import array
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from time import perf_counter_ns
from types import FunctionType
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from popsteer._core import Path, Vehicle


@dataclass(frozen=True)
class Percentiles:
    """How long a call takes [ns].

    Median, 99th and 99.9th percentile and greatest are of one distribution, calls timed one by one,
    as the clock read them, with one reading of the clock in each. `net_p50` is the median over
    batches of calls, per call, net of the clock and of the loop around them; None for what is not
    called in batches.
    """

    p50: float
    p99: float
    p999: float
    max: float
    net_p50: float | None

    @classmethod
    def of(cls, singles: Sequence[int], net_p50: float | None) -> Percentiles:
        """Sum up what single calls took [ns], by times that were read, never means of two."""
        p50, p99, p999 = np.percentile(singles, (50.0, 99.0, 99.9), method="higher").tolist()
        net = None if net_p50 is None else round(net_p50, 2)
        return cls(p50, p99, p999, max(singles), net)


BATCH = 32
"""Calls in a batch; the last batches of a drive may have one more."""

_SLOW_NS = 10_000

_Call: TypeAlias = "Callable[[float, float, float, float, float], object]"
_Block: TypeAlias = "list[tuple[float, float, float, float]]"
_Clock: TypeAlias = "Callable[[], int]"
_Record: TypeAlias = "Callable[[int], None]"


class Driver(NamedTuple):
    """A controller as the benchmark drives it.

    `call` is the control step, of (x, y, yaw, speed, dt), and `reset` forgets the steps taken so
    far. `stages` are what `call` does in two parts, in order, each under its name in the report:
    the first takes the arguments, the second none. They are timed apart.
    """

    call: Callable[[float, float, float, float, float], object]
    reset: Callable[[], None]
    stages: Mapping[str, Callable[..., object]] | None = None


@dataclass(frozen=True, eq=False)
class Drive:
    """A drive to replay: the path, and the vehicle's states along it.

    `states` are (x, y, yaw, speed) at each control step, DT apart: pose of the vehicle's point
    [m, m, rad], and its speed [m/s]. `vehicle` was driven, and is what the controllers are given;
    `source` says where the states come from.
    """

    source: str
    path: Path
    states: list[tuple[float, float, float, float]]
    vehicle: Vehicle


@dataclass(frozen=True)
class Result:
    """What the clock said, by name of each call.

    `percentiles` has those of each stage, too; `calls` how many were timed one by one, with as many
    in batches; `singles` what each single one took, as the clock read it [ns]. `timer_floor_ns` is
    what nothing at all takes, timed like a single call, and `loop_ns` what one turn of the batches'
    loop takes without its call, of which net p50 is net [ns].
    """

    percentiles: dict[str, Percentiles]
    calls: dict[str, int]
    timer_floor_ns: float
    loop_ns: float
    singles: Mapping[str, Sequence[int]]


def time_calls(
    makers: Mapping[str, Callable[[], Driver]],
    calls: Mapping[str, int],
    drive: Drive,
    dt: float,
    progress: Callable[[float], object] | None = None,
) -> Result:
    """Time calls on the states of a drive, as this module's head says.

    `makers` and `calls` have by name of a call a maker of its driver, and how many are to be timed
    at least. The drivers are reset where `drive` begins anew, as often as it takes; `dt` is the
    control period [s]. `progress` is called now and then with the part that is done, 0 to 1.
    """
    blocks = _blocks(drive.states)
    rows = {name: _Row(make, _batch, _one_by_one, blocks, dt) for name, make in makers.items()}
    idle = Driver(lambda *_: None, lambda: None)
    nothing = _Row(lambda: idle, _no_batch, _no_call, blocks, dt)
    turns = {name: -(-calls[name] * len(blocks) // len(drive.states)) for name in rows}
    most = max(turns.values())
    order = [*((rows[name], turns[name]) for name in rows), (nothing, most)]
    with _no_garbage_collector():
        for row, own in order:
            row.warm_up(min(own, len(blocks)))
        for turn in range(most):
            for row, own in order if turn % 2 else reversed(order):
                for _ in range(own * turn // most, own * (turn + 1) // most):
                    row.take_turn()
            if progress and 100 * turn // most != 100 * (turn + 1) // most:
                progress((turn + 1) / most)
    loop = float(np.median(nothing.batches))
    percentiles: dict[str, Percentiles] = {}
    for name, row in rows.items():
        percentiles[name] = Percentiles.of(row.singles, float(np.median(row.batches)) - loop)
        for stage, times in row.stages.items():
            percentiles[stage] = Percentiles.of(times, None)
    return Result(
        percentiles=percentiles,
        calls={name: len(row.singles) for name, row in rows.items()},
        timer_floor_ns=float(np.median(nothing.singles)),
        loop_ns=round(loop, 2),
        singles={name: row.singles for name, row in rows.items()},
    )


class _Row:
    """A call on its way over the states, and the times it took [ns]."""

    def __init__(
        self,
        make: Callable[[], Driver],
        batch: Callable[[_Call, _Block, float, _Clock], int],
        one_by_one: Callable[[_Call, _Block, float, _Clock, _Record], None],
        blocks: Sequence[_Block],
        dt: float,
    ) -> None:
        self._batched, self._single = make(), make()
        # The interpreter fits a line of code to what is called there. With code of its own no call
        # pays for what another one left behind.
        self._batch, self._one_by_one = _own(batch), _own(one_by_one)
        self._blocks, self._dt = blocks, dt
        self._slow = False
        self._forget()

    def _forget(self) -> None:
        self._next = 0
        self.batches = array("d")
        self.singles = array("q")  # eight bytes a call, where a list would take forty
        self.stages = {name: array("q") for name in self._single.stages or ()}

    def warm_up(self, turns: int) -> None:
        """Take turns that do not count."""
        for _ in range(turns):
            self.take_turn()
        self._slow = bool(np.median(self.singles) > _SLOW_NS)
        self._forget()

    def take_turn(self) -> None:
        """Drive the next block, call by call and in one batch."""
        if self._next == 0:
            self._batched.reset()
            self._single.reset()
        block = self._blocks[self._next]
        self._next = (self._next + 1) % len(self._blocks)
        # One by one first: that brings the block into the cache, for all calls alike.
        record = self.singles.append
        if self._single.stages is None:
            self._one_by_one(self._single.call, block, self._dt, perf_counter_ns, record)
        else:
            records = (record, *(times.append for times in self.stages.values()))
            _in_stages(tuple(self._single.stages.values()), block, self._dt, records)
        for batch in [[state] for state in block] if self._slow else [block]:
            elapsed = self._batch(self._batched.call, batch, self._dt, perf_counter_ns)
            self.batches.append(elapsed / len(batch))


def _batch(call: _Call, block: _Block, dt: float, clock: _Clock) -> int:
    begin = clock()
    for x, y, yaw, speed in block:
        call(x, y, yaw, speed, dt)
    return clock() - begin


def _no_batch(_call: _Call, block: _Block, _dt: float, clock: _Clock) -> int:
    begin = clock()
    for _x, _y, _yaw, _speed in block:
        pass
    return clock() - begin


def _one_by_one(call: _Call, block: _Block, dt: float, clock: _Clock, record: _Record) -> None:
    for x, y, yaw, speed in block:
        begin = clock()
        call(x, y, yaw, speed, dt)
        record(clock() - begin)


def _in_stages(
    stages: tuple[Callable[..., object], ...], block: _Block, dt: float, records: Sequence[_Record]
) -> None:
    clock, (first, second) = perf_counter_ns, stages
    record, record_first, record_second = records
    for x, y, yaw, speed in block:
        begin = clock()
        first(x, y, yaw, speed, dt)
        middle = clock()
        second()
        end = clock()
        record(end - begin)
        record_first(middle - begin)
        record_second(end - middle)


def _no_call(_call: _Call, block: _Block, _dt: float, clock: _Clock, record: _Record) -> None:
    for _x, _y, _yaw, _speed in block:
        begin = clock()
        record(clock() - begin)


def _own(function: Any) -> Any:  # noqa: ANN401 - a function, of any signature
    """Copy a function together with its code."""
    return FunctionType(function.__code__.replace(), function.__globals__)


def _blocks(states: _Block) -> list[_Block]:
    """Cut the states into blocks of nearly one size, in order."""
    count = max(len(states) // BATCH, 1)
    cuts = [len(states) * k // count for k in range(count + 1)]
    return [states[begin:end] for begin, end in pairwise(cuts)]


@contextmanager
def _no_garbage_collector() -> Iterator[None]:
    was_on = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
