from __future__ import annotations

import gc
import io
import json
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import pytest
from rich.console import Console

import popsteer
from popsteer import ConfigError, PopsteerError, reference
from popsteer.bench import latency, states
from popsteer.bench.latency import Percentiles
from popsteer.bench.laws import EMPTY_CALL, POP_COMMAND, POP_STEP, REFERENCE_STEP, Driver, lineup
from popsteer.bench.timing import time_calls

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from popsteer.bench.latency import LatencyReport
    from popsteer.bench.states import Drive

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
    path = reference.Path(zip(drive.path.x.tolist(), drive.path.y.tolist(), strict=True))
    front, rear = drive.front_offset, drive.rear_offset
    pop_params = reference.PopParams(reference_offset=front)
    pursuit = reference.PurePursuitParams(reference_offset=rear)
    stanley = reference.StanleyParams(reference_offset=front)
    return {
        POP_STEP: reference.Pop(path, pop_params).steer,
        REFERENCE_STEP: reference.Pop(path, pop_params).steer,
        "pid_step_ns": reference.Pid(path, reference.PidParams(reference_offset=front)).steer,
        "pure_pursuit_step_ns": reference.PurePursuit(path, pursuit).steer,
        "stanley_step_ns": reference.Stanley(path, stanley).steer,
    }


def test_lineup_calls_give_the_angles_of_the_reference(drive: Drive) -> None:
    drivers = {name: make() for name, make in lineup(drive).items()}
    references = _references(drive)
    assert drivers.keys() == references.keys() | {POP_COMMAND, EMPTY_CALL}
    angles: dict[str, list[object]] = {}
    for name, steer in references.items():
        angles[name] = [steer(*state, DT) for state in drive.states]
        assert [drivers[name].call(*state, DT) for state in drive.states] == angles[name], name
        assert len(set(angles[name])) > 10
    commands: list[Any] = [drivers[POP_COMMAND].call(*state, DT) for state in drive.states]
    assert [command.steer for command in commands] == angles[POP_STEP]


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


def test_measure_report_is_whole_and_ordered(report: LatencyReport) -> None:
    assert report.results.keys() == {
        "pop_step_ns",
        "pop_command_ns",
        "pid_step_ns",
        "pure_pursuit_step_ns",
        "stanley_step_ns",
        "empty_call_ns",
        "reference_step_ns",
    }
    for name, row in report.results.items():
        assert 0.0 < row.p50 <= row.p99 <= row.p999 <= row.max, name
        assert report.timing["calls"][name] >= (64 if name == REFERENCE_STEP else 600)
    assert report.states["count"] == 150


def test_to_json_holds_the_schema(report: LatencyReport) -> None:
    written = json.loads(latency.to_json(report))
    assert written["build_profile"] == "release"
    for row in written["results"].values():
        assert list(row) == ["p50", "p99", "p999", "max"]
    step, empty, plain = (
        written["results"][name]["p50"] for name in (POP_STEP, EMPTY_CALL, REFERENCE_STEP)
    )
    assert written["ratios"] == {
        "reference_over_step": plain / step,
        "step_over_empty_call": step / empty,
        "paper_over_step": 3.239e6 / step,
    }
    assert set(written["machine"]) == {"cpu", "python", "platform"}
    assert set(written["states"]) == {"source", "count"}
    timing = {"calls", "batch", "timer_floor_ns", "loop_ns", "singles_p50_ns"}
    assert set(written["timing"]) == timing


def test_measure_debug_build_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(popsteer, "build_profile", "debug")
    with pytest.raises(
        ConfigError, match=r"build_profile must be 'release'.*got 'debug'"
    ) as caught:
        latency.measure()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["calls", "reference_calls"])
def test_measure_no_calls_are_refused(
    drive: Drive, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(popsteer, "build_profile", "release")
    arguments: dict[str, Any] = {name: 0}
    with pytest.raises(ConfigError, match=f"^{name} must be a count"):
        latency.measure(drive, **arguments)


def test_measure_time_that_vanishes_is_an_error(
    drive: Drive, report: LatencyReport, monkeypatch: pytest.MonkeyPatch
) -> None:
    def coarse(*args: object) -> object:
        result = time_calls(lineup(drive), dict.fromkeys(lineup(drive), 1), drive, DT)
        nothing = Percentiles(0.0, 0.0, 0.0, 0.0)
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


def test_run_prints_the_table_and_writes_the_file(
    drive: Drive, report: LatencyReport, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(latency, "at_hand", lambda _data: drive)
    monkeypatch.setattr(latency, "_CALLS", 320)
    file = tmp_path / "new" / "latency.json"
    shown = io.StringIO()
    returned = latency.run(file, Console(file=shown, width=80))
    assert file.read_text(encoding="utf-8") == latency.to_json(returned)
    for word in ("p99.9", "POP, angle", "PID", "pure pursuit", "Stanley", "empty call", "150"):
        assert word in shown.getvalue()
    assert "…" not in shown.getvalue()  # nothing is cut off in a terminal of the usual width


def test_run_file_that_cannot_be_written_leaves_nothing(
    drive: Drive, report: LatencyReport, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(latency, "measure", lambda *_args, **_kwargs: report)
    monkeypatch.setattr(latency, "at_hand", lambda _data: drive)
    (tmp_path / "taken").write_text("", encoding="utf-8")
    with pytest.raises(OSError, match="taken"):
        latency.run(tmp_path / "taken" / "latency.json", Console(file=io.StringIO()))
    assert [entry.name for entry in tmp_path.iterdir()] == ["taken"]


@pytest.mark.parametrize(
    ("nanoseconds", "written"),
    [(23.4, "23 ns"), (999.0, "999 ns"), (4210.0, "4.21 µs"), (33_520.0, "33.5 µs"),
     (335_383.0, "335 µs"), (3.239e6, "3.24 ms"), (2.5e9, "2.50 s")],
)  # fmt: skip
def test_table_durations_are_short(nanoseconds: float, written: str) -> None:
    assert latency._duration(nanoseconds) == written
