"""Sweeps: the same rows whoever drives them, none lost or twice."""

from __future__ import annotations

import gc
import json
import math
import os
import signal
import subprocess
import sys
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any

import pytest

import popsteer
from popsteer import sim, tracks
from popsteer.errors import ConfigError, PopsteerError
from popsteer.lab import sweep
from popsteer.lab.common.theme import THEMES
from popsteer.lab.common.varied import distribution
from popsteer.lab.report.sweep import quantity_figures
from popsteer.lab.sweep import rows as files
from popsteer.lab.sweep import runs as workers
from popsteer.lab.sweep.figure import sweep_figure
from popsteer.lab.sweep.job import from_text
from popsteer.lab.sweep.summary import (
    ERROR,
    caption,
    influence,
    notes,
    success_rate,
    tables,
    worst,
)
from tests.helpers import looped

if TYPE_CHECKING:
    from pathlib import Path

pytest.importorskip("scipy")

VARY = {
    "steer_lag": "uniform(0.05,0.3)",
    "dead_time": "uniform(0,0.2)",
    "noise_position": "uniform(0,0.05)",
    "start_offset": "uniform(-1,1)",
}


def _job(runs: int = 12, **changes: Any) -> sweep.Job:
    track = tracks.get("slalom")
    path = popsteer.Path(track.xy, speed=track.speed)
    vary = {name: distribution(name, text) for name, text in VARY.items()}
    given: dict[str, Any] = {"plant": "carla-identified", "vary": vary, "path": path, **changes}
    return sweep.Job(controller="pop", params=popsteer.PopParams(), runs=runs, seed=5, **given)


@pytest.fixture(scope="module")
def rows() -> list[dict[str, Any]]:
    return sweep.run(_job())


def test_rows_are_single_runs_bit_for_bit(rows: list[dict[str, Any]]) -> None:
    job = _job()
    for k in (0, 7):
        metrics = vars(sweep.repeat(job, k).metrics)
        assert {name: rows[k][name] for name in metrics} == metrics
        assert {name: rows[k][name] for name in VARY} == job.drawn(k)
    assert len({row["seed"] for row in rows}) == len(rows)


def test_rows_do_not_depend_on_order_threads_or_text(rows: list[dict[str, Any]]) -> None:
    again = from_text(_job().text)
    assert again.text == _job().text
    assert sweep.drive(again, [7, 3], threads=1) == [rows[7], rows[3]]


def test_success_is_to_finish_within_the_deviation_and_without_a_fault(
    rows: list[dict[str, Any]],
) -> None:
    tight = sweep.run(_job(deviation=0.3))
    for row, other in zip(rows, tight, strict=True):
        sound = row["finished"] and row["faults"] == 0
        assert row["success"] == (sound and row[ERROR] <= 0.5)
        assert other["success"] == (sound and row[ERROR] <= 0.3)
    lost = sweep.run(_job(2, settings=sim.Settings(time_limit=1.0)))
    assert not any(row["finished"] or row["success"] for row in lost)


def test_run_that_is_off_by_just_what_is_allowed_succeeds(rows: list[dict[str, Any]]) -> None:
    row = max((row for row in rows if row["success"]), key=lambda row: row[ERROR])
    run, off = row["run"], row[ERROR]
    (just,) = sweep.drive(_job(deviation=off), [run], threads=1)
    (less,) = sweep.drive(_job(deviation=math.nextafter(off, 0.0)), [run], threads=1)
    assert (just["success"], less["success"]) == (True, False)


@pytest.mark.parametrize("text", ["uniform(0.3,0.58)", "uniform(-0.58,-0.3)"])
def test_draw_out_of_range_at_either_end_is_refused_before_a_run(text: str) -> None:
    """Of a plant in Python the least and the greatest draws are tried."""
    pytest.importorskip("vehiclemodels")
    vary = {"steer_offset": distribution("steer_offset", text)}
    job = _job(12, vary=vary, plant="commonroad-st-2")
    done: list[str] = []
    with pytest.raises(popsteer.ConfigError, match="steer_offset"):
        sweep.run(job, progress=lambda said, _: done.append(said))
    assert not done


def test_no_evidence_is_no_success() -> None:
    # 40 m of straight, over before anything has settled, from up to 8 m beside it.
    straight = popsteer.Path([(0.0, 0.0), (40.0, 0.0)], speed=[15.0, 15.0])
    far = {"start_offset": distribution("start_offset", "uniform(-8,8)")}
    short = _job(8, vary=far, path=straight, constant_speed=15.0)
    # Less than a control period of it.
    stub = popsteer.Path([(0.0, 0.0), (3.1, 0.0)])
    for job, words in (
        (short, "runs lasted no longer than the first 5 s"),
        (_job(8, path=stub, vary={}, constant_speed=90.0), "Is it a lap (--closed)?"),
    ):
        found = sweep.run(job)
        assert not any(row["success"] for row in found)
        assert all(math.isnan(row[ERROR]) for row in found)
        said = notes(job, found)
        assert any(words in each for each in said), said
        assert said[-1].startswith("Drawn from seed")
        assert "0 of 8 runs succeeded, 0 % (95 % confidence: 0 to 32 %)" in caption(job, found)
        # Percentiles say over how many runs they are.
        assert next(iter(tables(job, found)[0].columns[1].cells)) == "0"


@looped(
    ("vary", "given", "words"),
    [
        (
            {"start_offset": "uniform(-1,1)"},
            {},
            "left of the path by start_offset uniform(-1.0,1.0) m",
        ),
        ({"start_offset": 0.5}, {}, "0.50 m left of the path"),
        ({}, {}, "on the path, at its first waypoint, at 0 m/s; "),
        ({}, {"start_offset": -0.3}, "0.30 m right of the path"),
        (
            {"start_yaw": "normal(0,0.1)"},
            {},
            "waypoint, turned by start_yaw normal(0.0,0.1) rad, at 0",
        ),
        ({"start_speed": "uniform(2,4)"}, {}, ", at start_speed uniform(2.0,4.0) m/s; "),
        ({"start_speed": 3}, {}, ", at 3 m/s; "),
        ({}, {"speed": 2.5}, ", at 2.5 m/s; "),
    ],
)
def test_start_is_told_as_it_is_driven(
    vary: dict[str, Any], given: dict[str, Any], words: str
) -> None:
    drawn = {name: distribution(name, text) for name, text in vary.items()}
    job = _job(2, vary=drawn, **given)
    (said,) = [each for each in notes(job, sweep.run(job)) if each.startswith("Starts ")]
    assert words in said


@pytest.mark.parametrize("vary", [{"steer_lag": "uniform(0.05,0.2)"}, VARY])
def test_title_of_the_figure_stays_inside_it(vary: dict[str, str]) -> None:
    drawn = {name: distribution(name, text) for name, text in vary.items()}
    job = _job(12, vary=drawn, course="a road of a long name", label="a car of a longer name yet")
    figure = sweep_figure(job, sweep.run(job), THEMES["light"])
    figure.draw_without_rendering()
    (title,) = [each for each in figure.texts if each.get_text().startswith("pop on")]
    box = title.get_window_extent()
    assert 0.0 <= box.x0 < box.x1 <= figure.bbox.width
    assert box.y1 <= figure.bbox.height
    drawn_on = [panel for panel in figure.axes if panel.collections]
    assert drawn_on
    for panel in drawn_on:  # the points are drawn over the grid
        assert panel.xaxis.get_zorder() < min(each.get_zorder() for each in panel.collections)


def test_page_tells_influence_as_the_terminal_does(rows: list[dict[str, Any]]) -> None:
    job = _job()
    fine = [{**row, "success": True, "faults": 0} for row in rows]
    bad = [{**row, "success": row["run"] > 3} for row in fine]
    for given, what in ((fine, "were the worst tenth"), (bad, "failed")):
        for figure in quantity_figures(job, given):
            shown = json.dumps(figure)
            assert f"distance of the runs that {what} from the others: " in shown
        assert any(f" the runs that {what} from" in each for each in notes(job, given))
    # Of so few, none is told from the others.
    few = [each for figure in quantity_figures(job, fine[:5]) for each in json.dumps(figure)]
    assert "from the others" not in "".join(few)


def test_errors_count_from_ten_wheelbases_on() -> None:
    job = _job(2, vary={}, constant_speed=5.0)
    assert job.joining([job.path]).settling_time == pytest.approx(6.0, abs=0.11)
    short = popsteer.Path([(0.0, 0.0), (40.0, 0.0)])
    assert job.joining([short]).settling_time == pytest.approx(0.5 * 40.0 / 5.0, abs=0.11)
    assert job.settled == "after the first 5 s"
    joined = replace(job, settings=job.joining([job.path]), joined=True)
    said = ", in which the vehicle drives 10 wheelbases (30 m)"
    assert joined.settled.endswith(f" s{said}")
    assert said in notes(joined, sweep.run(joined))[0]


def test_truck_at_rest_does_not_fail_for_its_start() -> None:
    truck = popsteer.Vehicle(wheelbase=6.0, rear_axle=-3.0, max_acceleration=0.5, steer_lag=0.3)
    lag = {"steer_lag": distribution("steer_lag", "uniform(0.25,0.35)")}
    track = tracks.get("slalom")
    job = sweep.Job(
        popsteer.Path(track.xy, speed=track.speed),
        "preview-pop",
        popsteer.PreviewPopParams(),
        sim.KinematicBicycle(truck),
        lag,
        10,
        longitudinal=popsteer.SpeedTrackerParams(),
    )
    assert all(row["success"] for row in sweep.run(job))
    assert not any(row["success"] for row in sweep.run(replace(job, start_offset=-2.44)))
    # Drawn beside the path, it counts from where it has joined it.
    drawn = replace(job, vary={"start_offset": distribution("start_offset", "uniform(-2,2)")})
    joined = drawn.joining([job.path])
    assert not all(row["success"] for row in sweep.run(drawn))
    assert all(row["success"] for row in sweep.run(replace(drawn, settings=joined)))


def test_job_is_read_back_as_it_was_written() -> None:
    job = _job(settings=sim.Settings(keep_records=False, time_limit=30.0))
    assert from_text(job.text).text == job.text
    # Every field is in it, and every one changes it.
    document = json.loads(job.text)
    assert {each.name for each in fields(job)} <= set(document)
    pytest.importorskip("vehiclemodels")
    from popsteer.plants.commonroad import CommonRoad

    plant = CommonRoad("st", 2, dead_time=0.15, steer_offset=0.01)
    again = from_text(_job(plant=plant, vary={}).text)
    assert again.whole.vehicle == plant.vehicle


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_file_says_all_rows_and_the_sweep(
    tmp_path: Path, rows: list[dict[str, Any]], kind: str
) -> None:
    if kind == "parquet":
        pytest.importorskip("pyarrow")
    out = tmp_path / f"sweep.{kind}"
    assert sweep.run(_job(), out) == rows
    job, found = files.read(out)
    assert (job.text, found) == (_job().text, rows)
    assert [file.name for file in tmp_path.iterdir()] == [out.name]
    before = out.stat().st_mtime_ns
    assert sweep.run(_job(), out) == rows
    assert out.stat().st_mtime_ns == before


def test_sweep_goes_on_after_a_torn_row(tmp_path: Path, rows: list[dict[str, Any]]) -> None:
    out = tmp_path / "sweep.csv"
    part = files.journal_of(out)
    lines = [_job().text, *(json.dumps(rows[k]) for k in (4, 2)), json.dumps(rows[3])[:40]]
    part.write_text("\n".join(lines))
    driven: list[int] = []
    asked = sweep.drive

    def watched(job: Any, chunk: Any, *more: Any) -> Any:
        driven.extend(chunk)
        return asked(job, chunk, *more)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(workers, "drive", watched)
        assert sweep.run(_job(), out) == rows
    assert driven == [k for k in range(12) if k not in (4, 2)]


def test_killed_sweep_goes_on_without_a_row_lost_or_twice(tmp_path: Path) -> None:
    out = tmp_path / "sweep.csv"
    program = (
        "import sys, pathlib\n"
        "from popsteer.lab import sweep\n"
        "from popsteer.lab.sweep import runs as workers\n"
        "from popsteer.lab.sweep.job import from_text\n"
        "workers._CORE_CHUNK = 2\n"
        "job = from_text(pathlib.Path(sys.argv[1]).read_text())\n"
        "out, told = pathlib.Path(sys.argv[2]), []\n"
        "def look(*_):\n"
        "    if out.with_name('sweep.csv.part').read_bytes().count(b'\\n') > 5:\n"
        "        print(flush=True)\n"
        "        sys.stdin.read()\n"
        "sweep.run(job, out, progress=look)\n"
    )
    job = _job(400)
    (tmp_path / "job").write_text(job.text)
    part = files.journal_of(out)
    command = [sys.executable, "-c", program, str(tmp_path / "job"), str(out)]
    pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen(command, **pipes) as process:
        assert process.stdout is not None
        # It waits there for what never comes: however slow this process is, it does not end.
        assert process.stdout.readline() == b"\n"
        process.kill()
    kept = part.read_bytes().count(b"\n") - 1
    assert 0 < kept < 400
    found = sweep.run(job, out)
    assert [row["run"] for row in found] == list(range(400))
    assert not part.exists()
    assert found == files.read(out)[1] == sweep.run(job)


def test_file_of_another_sweep_or_version_is_refused_and_kept(tmp_path: Path) -> None:
    out = tmp_path / "sweep.csv"
    sweep.run(_job(2), out)
    before = out.read_bytes()
    with pytest.raises(PopsteerError, match="holds another sweep, which differs in runs"):
        sweep.run(_job(3), out)
    text = out.read_text(encoding="utf-8")
    out.write_text(text.replace('"start_offset":null,', "", 1), encoding="utf-8")
    with pytest.raises(PopsteerError, match=r"which differs in start_offset$"):
        sweep.run(_job(2), out)
    out.write_bytes(before)
    part = files.journal_of(tmp_path / "other.csv")
    part.write_text(_job(2).text.replace('"version":"', '"version":"9.') + "\n")
    with pytest.raises(PopsteerError, match=r"other\.csv\.part: a sweep of popsteer 9\."):
        sweep.run(_job(2), tmp_path / "other.csv")
    (tmp_path / "no.csv").write_text("a,b\n1,2\n")
    with pytest.raises(PopsteerError, match=r"no\.csv: no sweep of popsteer"):
        sweep.run(_job(2), tmp_path / "no.csv")
    assert out.read_bytes() == before


def test_journal_is_written_by_one_process_alone(tmp_path: Path) -> None:
    job = _job(2)
    part = tmp_path / "sweep.csv.part"
    with (
        files.Journal(part, job),
        pytest.raises(PopsteerError, match="another process is writing it"),
        files.Journal(part, job),
    ):
        pass


def test_draw_out_of_range_is_refused_before_anything_is_driven(tmp_path: Path) -> None:
    vary = {"steer_lag": distribution("steer_lag", "normal(0.1,0.2)")}
    with pytest.raises(ConfigError, match=r"run \d+: steer_lag must be in"):
        sweep.run(_job(50, vary=vary), tmp_path / "sweep.csv")
    assert list(tmp_path.iterdir()) == []  # a journal of it would refuse the sweep that is meant


def test_wilson_interval_is_the_published_one() -> None:
    # R. Newcombe, 1998, Table I, method 3: without correction for continuity.
    for good, runs, low, high in [
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
    ]:
        rate = success_rate(good, runs)
        assert (rate.low, rate.high) == pytest.approx((low, high), abs=5e-5)
    assert math.isnan(success_rate(0, 0).share)


def test_worst_runs_and_influence_point_at_the_cause(rows: list[dict[str, Any]]) -> None:
    made = [
        {**rows[k % 12], "run": k, "success": k < 30, "dead_time": k / 40, "steer_lag": (k % 7) / 7}
        for k in range(40)
    ]
    told = influence(_job(), made)
    assert next(iter(told)) == "dead_time"
    assert told["dead_time"] == 1.0
    ordered = worst(made, 3)
    assert ordered[0][ERROR] == max(row[ERROR] for row in made)


def test_processes_give_the_same_rows(
    rows: list[dict[str, Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    # As on macOS, which does not tell which cores a process may use.
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    told: list[float] = []
    found = [
        row for chunk in workers.on_processes(_job(), range(12), None, told.append) for row in chunk
    ]
    assert sorted(found, key=lambda row: int(row["run"])) == rows
    assert told[-1] == 12


def test_killed_process_costs_its_time_alone(rows: list[dict[str, Any]]) -> None:
    import multiprocessing

    found: list[dict[str, Any]] = []
    for chunk in workers.on_processes(_job(), range(12), 1, lambda _: None):
        found += chunk
        if len(found) == 1:
            for child in multiprocessing.active_children():
                os.kill(child.pid or 0, signal.SIGKILL)
    assert sorted(found, key=lambda row: int(row["run"])) == rows


# What the cluster had open towards the killed worker is closed by the collector.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_dask_gives_the_same_rows_with_a_worker_killed_and_after_an_interrupt(
    rows: list[dict[str, Any]],
) -> None:
    pytest.importorskip("distributed")
    from distributed import LocalCluster

    found: list[dict[str, Any]] = []
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster:
        address = cluster.scheduler_address
        ended: Any = workers.on_dask(_job(), range(12), address, lambda _: None)
        next(ended)
        with pytest.raises(KeyboardInterrupt):
            ended.throw(KeyboardInterrupt)
        for chunk in workers.on_dask(_job(), range(12), address, lambda _: None):
            if not found:
                victim = next(iter(cluster.workers.values()))
                os.kill(victim.process.process.pid, signal.SIGKILL)
            found += chunk
    assert sorted(found, key=lambda row: int(row["run"])) == rows
    gc.collect()


def test_scheduler_that_does_not_answer_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr(workers, "_DASK_TIMEOUT", 0.5)
    with pytest.raises(PopsteerError, match=r"--dask tcp://127\.0\.0\.1:9: no scheduler answers"):
        list(workers.on_dask(_job(), range(2), "tcp://127.0.0.1:9", lambda _: None))


def test_job_replaced_is_another(rows: list[dict[str, Any]]) -> None:
    job = _job()
    assert replace(job, seed=6).key != job.key
    assert replace(job, seed=6).drawn(0) != job.drawn(0)
