from __future__ import annotations

import gc
import itertools
import json
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import pytest

import popsteer
from benches.latency import __main__ as program
from benches.latency import measure as latency
from benches.latency import states, timing, yardsticks
from benches.latency.calls import (
    ASIDE_STEP,
    EMPTY_CALL,
    PAPER_REFERENCE_STEP,
    PAPER_STEP,
    POP_COMMAND,
    POP_STEP,
    PREVIEW_POP_STEP,
    REAL_CAR_STEP,
    REFERENCE_STEP,
    SLOW_STEPS,
    lineup,
)
from benches.latency.report import duration, to_json
from benches.latency.timing import Driver, Percentiles, time_calls
from popsteer import ConfigError, PopsteerError, reference
from tests.helpers import looped

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from benches.latency.report import LatencyReport
    from benches.latency.timing import Drive

DT = states.DT


@pytest.fixture(scope="module")
def drive() -> Drive:
    """Some seconds of driving through the first bend."""
    whole = states.embedded()
    return replace(whole, states=whole.states[300:450])


@pytest.fixture(scope="module")
def report(drive: Drive) -> LatencyReport:
    if popsteer.build_profile != "release":
        pytest.skip("needs a release build")
    return latency.measure(drive, calls=600, reference_calls=64)


def _references(drive: Drive) -> dict[str, Callable[..., object]]:
    steps: dict[str, Callable[..., object]]
    path = reference.Path(zip(drive.path.x.tolist(), drive.path.y.tolist(), strict=True))
    car = reference.Vehicle(**drive.vehicle.as_dict())
    paper = reference.Pop(car, reference.PopParams(exact_lookahead=False))
    laws: dict[str, Any] = {
        POP_STEP: reference.Pop(car),
        REFERENCE_STEP: reference.Pop(car),
        PAPER_STEP: paper,
        PAPER_REFERENCE_STEP: paper,
        "pid_step_ns": reference.Pid(car),
        "pure_pursuit_step_ns": reference.PurePursuit(car),
        "stanley_step_ns": reference.Stanley(car),
    }
    steps = {name: reference.Tracker(law, path).steer for name, law in laws.items()}
    # It adapts, which the reference does not.
    real = drive.vehicle.replace(steer_lag=0.15, dead_time=0.15, max_steer_rate=0.4)
    adapting = {PREVIEW_POP_STEP: drive.vehicle, REAL_CAR_STEP: real}
    return steps | {
        name: popsteer.PreviewPop(drive.path, car).steer for name, car in adapting.items()
    }


def test_lineup_calls_give_the_angles_of_the_reference(drive: Drive) -> None:
    drivers = {name: make() for name, make in lineup(drive).items()}
    references = _references(drive)
    assert drivers.keys() == references.keys() | {POP_COMMAND, EMPTY_CALL, ASIDE_STEP}
    angles: dict[str, list[object]] = {}
    for name, steer in references.items():
        angles[name] = [steer(*state, DT) for state in drive.states]
        assert [drivers[name].call(*state, DT) for state in drive.states] == angles[name], name
        assert len(set(angles[name])) > 10
    commands: list[Any] = [drivers[POP_COMMAND].call(*state, DT) for state in drive.states]
    assert [command.steer for command in commands] == angles[POP_STEP]
    aside = drivers[ASIDE_STEP].call.__self__  # type: ignore[attr-defined]
    errors = [abs(aside.step(*state, DT).cross_track_error) for state in drive.states]
    assert sorted(errors)[len(errors) // 2] == pytest.approx(0.5, abs=0.05)
    assert aside.vehicle.max_steer_rate == 0.4


def test_lineup_reset_drivers_start_anew(drive: Drive) -> None:
    for name, make in lineup(drive).items():
        driver = make()
        first = driver.call(*drive.states[0], DT)
        for state in drive.states[:20]:
            driver.call(*state, DT)
        driver.reset()
        assert driver.call(*drive.states[0], DT) == first, name


def test_time_calls_drives_through_the_states_in_order(drive: Drive) -> None:
    seen: list[list[object]] = []

    def make() -> Driver:
        calls: list[object] = []
        seen.append(calls)
        return Driver(lambda *args: calls.append(args), lambda: calls.append("reset"))

    result = time_calls({"often": make, "seldom": make}, {"often": 320, "seldom": 40}, drive, DT)
    lap: list[object] = ["reset", *((*state, DT) for state in drive.states)]
    assert len(seen) == 4
    for calls in seen:
        # One warm-up, then from the start again as often as it takes.
        assert calls.count("reset") >= 2
        second = calls.index("reset", 1)
        assert calls[:second] == lap[:second]
        assert all(a == b for a, b in zip(calls[second:], lap * 3, strict=False))
    assert result.calls["often"] >= 320
    assert 40 <= result.calls["seldom"] < 120
    assert seen[0] == seen[1]
    assert seen[2] == seen[3]


def test_time_calls_parts_a_call_in_stages_where_it_is_timed_one_by_one(drive: Drive) -> None:
    made: list[list[str]] = []

    def make() -> Driver:
        seen: list[str] = []
        made.append(seen)

        def first(*args: float) -> None:
            assert len(args) == 5
            seen.append("first")

        stages = {"first_ns": first, "second_ns": lambda: seen.append("second")}
        return Driver(lambda *_: seen.append("whole"), lambda: None, stages)

    result = time_calls({"whole_ns": make}, {"whole_ns": 150}, drive, DT)
    batched, single = made
    assert set(batched) == {"whole"}
    assert single == ["first", "second"] * (len(single) // 2)
    assert len(single) == 2 * len(batched) > 2 * 150
    assert list(result.percentiles) == ["whole_ns", "first_ns", "second_ns"]
    whole, *parts = result.percentiles.values()
    assert all(part.net_p50 is None and part.p50 <= whole.p50 for part in parts)
    assert result.calls == {"whole_ns": 150}


def test_time_calls_a_slow_call_is_a_batch_by_itself(drive: Drive) -> None:
    # A clock of its own: 20 µs a reading make every call a slow one, whatever the machine.
    readings = itertools.count(0, 20_000)

    def make() -> Driver:
        return Driver(lambda *_: None, lambda: None)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(timing, "perf_counter_ns", lambda: next(readings))
        result = time_calls({"slow_ns": make}, {"slow_ns": 150}, drive, DT)
    row = result.percentiles["slow_ns"]
    assert (row.p50, row.max) == (20_000, 20_000)
    # The loop without a call is slow by this clock as well, so nothing remains.
    assert result.loop_ns == 20_000
    assert row.net_p50 == 0.0


def test_measure_report_is_whole_and_ordered(report: LatencyReport) -> None:
    assert report.results.keys() == {
        "pop_step_ns",
        "pop_command_ns",
        "pop_paper_step_ns",
        "reference_paper_step_ns",
        "preview_pop_step_ns",
        "preview_pop_car_step_ns",
        "preview_pop_aside_step_ns",
        "pid_step_ns",
        "pure_pursuit_step_ns",
        "stanley_step_ns",
        "empty_call_ns",
        "reference_step_ns",
        *yardsticks.ROWS,
    }
    assert report.absent == dict.fromkeys(yardsticks.ROWS, "not asked for")
    for name in report.results.keys() - yardsticks.ROWS:
        row = report.row(name)
        assert 0 < row.p50 <= row.p99 <= row.p999 <= row.max, name
        # One reading of the clock is in the one, none in the other.
        assert row.net_p50 is not None
        assert row.net_p50 > 0.0
        assert report.timing["calls"][name] >= (64 if name in SLOW_STEPS else 600)
    assert report.states["count"] == 150


def test_to_json_holds_the_schema(report: LatencyReport) -> None:
    written = json.loads(to_json(report))
    assert written["build_profile"] == "release"
    absent = {name for name, row in written["results"].items() if row is None}
    assert absent == set(written["absent"]) == set(yardsticks.ROWS)
    for name in written["results"].keys() - absent:
        assert list(written["results"][name]) == ["p50", "p99", "p999", "max", "net_p50"]
    for ratios, column in (("ratios", "p50"), ("net_ratios", "net_p50")):
        step, empty, plain = (
            written["results"][name][column] for name in (POP_STEP, EMPTY_CALL, REFERENCE_STEP)
        )
        of_paper = [written["results"][name][column] for name in (PAPER_REFERENCE_STEP, PAPER_STEP)]
        assert written[ratios] == {
            "reference_over_step": plain / step,
            "reference_over_step_of_paper": of_paper[0] / of_paper[1],
            "step_over_empty_call": step / empty,
            "paper_over_step": 3.239e6 / step,
            "numba_over_step": None,
            "mpc_over_step": None,
        }
    assert set(written["machine"]) == {"cpu", "cores", "python", "platform"}
    assert set(written["states"]) == {"source", "count"}
    assert set(written["timing"]) == {"calls", "batch", "timer_floor_ns", "loop_ns"}


def test_measure_debug_build_is_refused(drive: Drive, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(popsteer, "build_profile", "debug")
    with pytest.raises(
        ConfigError, match=r"build_profile must be 'release'.*got 'debug'"
    ) as caught:
        latency.measure(drive)
    assert "\n" not in str(caught.value)


def test_measure_time_that_vanishes_is_an_error(
    drive: Drive, report: LatencyReport, monkeypatch: pytest.MonkeyPatch
) -> None:
    def coarse(*args: object) -> object:
        result = time_calls(lineup(drive), dict.fromkeys(lineup(drive), 1), drive, DT)
        nothing = Percentiles(0, 0, 0, 0, 0.0)
        return replace(result, percentiles=result.percentiles | {EMPTY_CALL: nothing})

    monkeypatch.setattr(latency, "time_calls", coarse)
    with pytest.raises(PopsteerError, match="clock"):
        latency.measure(drive)


def test_measure_progress_rises_to_one_and_garbage_is_collected_again(
    drive: Drive, report: LatencyReport
) -> None:
    parts: list[float] = []
    was_on: list[bool] = []

    def progress(part: float) -> None:
        parts.append(part)
        was_on.append(gc.isenabled())

    assert gc.isenabled()
    latency.measure(drive, calls=320, reference_calls=1, progress=progress)
    assert parts == sorted(parts)
    assert parts[-1] == 1.0
    assert not any(was_on)
    assert gc.isenabled()


def test_program_writes_the_file(
    drive: Drive,
    report: LatencyReport,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    given: list[object] = []

    def measured(*states: object, **options: object) -> LatencyReport:
        given.extend((*states, options["outside"]))
        return report

    monkeypatch.setattr(program, "at_hand", lambda: drive)
    monkeypatch.setattr(program, "measure", measured)
    monkeypatch.setattr(yardsticks, "at_hand", lambda of: ("yardsticks", of))
    program.main(tmp_path / "new")
    assert given == [drive, ("yardsticks", drive)]
    file = tmp_path / "new" / "latency.json"
    assert file.read_text(encoding="utf-8") == to_json(report)
    assert str(file) in capsys.readouterr().out


@looped(
    ("nanoseconds", "written"),
    [(23.4, "23 ns"), (999.0, "999 ns"), (4210.0, "4.21 µs"), (33_520.0, "33.5 µs"),
     (335_383.0, "335 µs"), (3.239e6, "3.24 ms"), (2.5e9, "2.50 s")],
)  # fmt: skip
def test_table_durations_are_short(nanoseconds: float, written: str) -> None:
    assert duration(nanoseconds) == written
