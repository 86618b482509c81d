"""The node's clock: measured periods, cycles that are missed, time that jumps or stands still."""

from __future__ import annotations

import itertools
import time
from typing import TYPE_CHECKING, Any

import pytest

pytest.importorskip("rosbags", reason='the extra "ros2" is not installed')
pytest.importorskip("cyclonedds", reason='the extra "ros2" is not installed')

from popsteer.adapters.ros2 import messages, pacing
from popsteer.adapters.ros2.conversions import time_message
from tests.adapters.ros2_domain import PERIOD, START, Bench

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable


class Clocks:
    """In the place of the module `time`: nothing waits, and the test moves both clocks."""

    def __init__(self) -> None:
        self.steady, self.wall = 5 * 10**9, START

    def monotonic_ns(self) -> int:
        return self.steady

    def time_ns(self) -> int:
        return self.wall

    def sleep(self, seconds: float) -> None:
        self.pass_by(seconds)

    def pass_by(self, seconds: float) -> None:
        self.steady += round(seconds * 1e9)
        self.wall += round(seconds * 1e9)


def spun(
    bench: Bench,
    monkeypatch: pytest.MonkeyPatch,
    each: Callable[[int, Clocks], None],
    count: int,
    waits: Iterable[float] = (),
) -> list[tuple[float, int]]:
    """Run in real time that is not: periods and missed cycles, and `each` before each cycle.

    Odometry comes after `waits` of the node for it [s]; then it stays away.
    """
    clocks, found, turns = Clocks(), [], iter(range(count + 1))
    monkeypatch.setattr(pacing, "time", clocks)
    comes = iter(waits)

    def wait(seconds: float) -> bool:
        after = next(comes, 1.0)
        clocks.pass_by(min(after, seconds))
        return after <= seconds

    monkeypatch.setattr(bench.node.odometry_reader, "wait", wait)
    cycle = bench.node.cycle

    def counted(now: int, dt: float, missed: int = 0) -> Any:
        found.append((dt, missed))
        return cycle(now, dt, missed)

    def stopped() -> bool:
        turn = next(turns)
        bench.now = clocks.wall
        each(turn, clocks)
        return turn == count

    monkeypatch.setattr(bench.node, "cycle", counted)
    pacing.spin(bench.node, bench.member, stopped)
    return found


def test_period_is_measured_and_late_cycles_are_not_caught_up_with(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bench = Bench()

    def each(turn: int, clocks: Clocks) -> None:
        if turn == 5:
            clocks.pass_by(0.07)  # something took three periods and a half

    found = spun(bench, monkeypatch, each, 8)
    assert [missed for _, missed in found] == [0, 0, 0, 0, 0, 2, 0, 0]
    # The late one is 10 ms late; the next is on time again.
    periods = [0.02, 0.02, 0.02, 0.02, 0.02, 0.07, 0.01, 0.02]
    assert [dt for dt, _ in found] == pytest.approx(periods)
    assert bench.node.loop.missed == 2


def test_steps_follow_the_odometry_and_a_timer_where_it_stays_away(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bench = Bench()
    # A step is taken 15 ms after the last at the earliest; odometry then comes after these waits.
    found = spun(bench, monkeypatch, lambda _turn, _clocks: None, 7, [0.003, 0.009, 0.0, 0.004])
    assert [dt for dt, _ in found] == pytest.approx([0.018, 0.024, 0.015, 0.019, 0.03, 0.02, 0.02])
    assert bench.node.loop.missed == 0


@pytest.mark.parametrize("seconds", [-40.0, 40.0])
def test_wall_clock_that_is_set_is_noticed_and_no_period(
    monkeypatch: pytest.MonkeyPatch, seconds: float
) -> None:
    bench = Bench()
    states = []

    def each(turn: int, clocks: Clocks) -> None:
        if turn == 20:
            clocks.wall += round(seconds * 1e9)
            bench.now = clocks.wall
        elif turn == 1:
            bench.send_path()
        if turn != 21:
            bench.send_pose()
        states.append(bench.state)

    jumped, said = bench.node.jumped, []

    def told(by: float) -> None:
        said.append(by)
        jumped(by)

    monkeypatch.setattr(bench.node, "jumped", told)
    found = spun(bench, monkeypatch, each, 30)
    assert [dt for dt, _ in found] == pytest.approx([0.02] * 30)
    assert bench.node.loop.jumps == 1
    assert said == pytest.approx([seconds])
    assert "driving" in states[:20]
    assert any(f"time jumped by {seconds:+.2f} s" in line for line in bench.lines) or (
        states[21] == "driving"  # a pose of the new time has come in the same cycle
    )
    assert states[-1] == "driving"


def test_slewed_clock_is_no_jump(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench()

    def each(turn: int, clocks: Clocks) -> None:
        clocks.wall += 10**6  # 50 ms a second, far more than NTP does

    spun(bench, monkeypatch, each, 50)
    assert bench.node.loop.jumps == 0


def test_stamps_are_as_far_apart_as_the_periods_though_clocks_are_read_one_after_the_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bench, stamps = Bench(), []
    cycle = bench.node.cycle

    def kept(now: int, dt: float, missed: int = 0) -> Any:
        stamps.append(now)
        return cycle(now, dt, missed)

    def each(turn: int, clocks: Clocks) -> None:
        clocks.pass_by(1e-4 * (turn % 3))
        clocks.wall += (-1) ** turn * 300_000

    monkeypatch.setattr(bench.node, "cycle", kept)
    found = spun(bench, monkeypatch, each, 30)
    between = [(b - a) / 1e9 for a, b in itertools.pairwise(stamps)]
    assert between == [dt for dt, _ in found[1:]]
    assert abs(stamps[-1] - START) < 10**9


def ticking(bench: Bench, times: list[int], pause: float = 0.0) -> None:
    """Run on the clock's topic; poses come with the ticks."""
    clock = bench.member.writer("/clock", messages.CLOCK, latched=True)
    left = iter(times)

    def stopped() -> bool:
        at = next(left, None)
        if at is None:
            return True
        bench.now = at
        if at:
            bench.send_pose()
            clock.write(messages.encode(messages.make(messages.CLOCK, clock=time_message(at))))
        else:
            time.sleep(pause)
        return False

    bench.send_path()
    pacing.spin(bench.node, bench.member, stopped)


def test_simulated_time_gives_periods_and_misses() -> None:
    bench = Bench(sim_time=True)
    start = 10**9
    ticking(bench, [start + k * PERIOD for k in (0, 1, 2, 3, 3, 6, 7, 8)])
    assert bench.node.loop.cycles == 7
    assert bench.node.loop.missed == 2
    assert bench.state == "driving"


def test_simulation_that_begins_anew_is_a_jump_and_gone_on_with() -> None:
    bench = Bench(sim_time=True)
    one = [10**9 + k * PERIOD for k in range(10)]
    ticking(bench, [*one, *one])
    assert bench.node.loop.jumps == 1
    assert bench.node.loop.missed == 0
    assert bench.state == "driving"


def test_simulated_time_that_runs_back_a_little_is_no_jump() -> None:
    bench = Bench(sim_time=True)
    ticking(bench, [10**9 + round(k * PERIOD) for k in (0, 1, 2, 1.95, 3, 2.5, 4)])
    assert (bench.node.loop.jumps, bench.node.loop.cycles) == (0, 5)


def test_simulated_time_that_stands_still_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pacing, "_STILL", 0.1)
    bench = Bench(sim_time=True)
    ticking(bench, [10**9, 10**9 + PERIOD, 0, 0, 0], pause=0.1)
    assert bench.lines[-1] == "paused: time stands still on /clock"


def test_altered_ticks_do_not_end_the_node() -> None:
    bench = Bench(sim_time=True)
    clock = bench.member.writer("/clock", messages.CLOCK)
    seconds = iter([2**31 - 1, -(2**31), 0, -1, 5])
    turns = iter(range(6))

    def stopped() -> bool:
        stamp = messages.make(
            "builtin_interfaces/msg/Time", sec=next(seconds, 6), nanosec=2**32 - 1
        )
        clock.write(messages.encode(messages.make(messages.CLOCK, clock=stamp)))
        return next(turns) == 5

    pacing.spin(bench.node, bench.member, stopped)
    assert bench.node.loop.cycles >= 2


def test_pace_of_a_simulation_begins_anew_where_its_time_jumps() -> None:
    pace = pacing.Pace(PERIOD, START, START)
    now = START
    for by, said in ((PERIOD, 0.0), (-5 * 10**9, -5.0), (PERIOD, 0.0), (3 * 10**9, 3.0)):
        now += by
        assert pace.jump(now, now) == pytest.approx(said)
        assert now >= pace.earliest
        passed, missed = pace.step(now, came=True)
        assert (round(passed, 9), missed) == (0.02, 0)
    assert pace.due == now + PERIOD * 3 // 2
