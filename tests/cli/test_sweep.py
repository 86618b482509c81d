"""``popsteer sweep``, and ``compare`` of one of its runs."""

from __future__ import annotations

import errno
import json
import os
from pathlib import Path

import pytest

import popsteer
from popsteer.lab.sweep import rows as files
from tests.cli import command
from tests.helpers import looped

pytest.importorskip("scipy")

SHORT = ("--track", "slalom", "--controller", "pop", "--runs", "20")


@pytest.mark.usefixtures("_blank_figures")
def test_sweep_writes_rows_and_figures_and_a_run_repeats(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = tmp_path / "new" / "sweep.csv"
    escaped = tmp_path / "\x1b[31m.csv"
    outcome = command.call(capsys, "sweep", *SHORT, "--out", str(out))
    assert (outcome.status, outcome.err) == (0, "")
    names = {f"sweep{dark}.{kind}" for dark in ("", "-dark") for kind in ("png", "svg")}
    assert {file.name for file in out.parent.iterdir()} == names | {"sweep.csv"}
    assert "of 20 runs succeeded" in outcome.out
    assert "95 % confidence" in outcome.out
    assert f"popsteer sweep --run {out}:" in outcome.out
    again = command.call(capsys, "sweep", *SHORT, "--out", str(out))
    assert again.out == outcome.out
    other = command.call(capsys, "sweep", "--run", f"{out}:17", "--controller", "stanley")
    assert (other.status, other.out) == (2, "")
    assert "--controller must be that of the sweep, pop, got 'stanley'" in other.err
    drawn = tmp_path / "run"
    replay = command.call(capsys, "sweep", "--run", f"{out}:17", "--out", str(drawn))
    assert (replay.status, replay.err) == (0, "")
    assert f"Run 17 of {out} is to the last bit what its row says" in replay.out
    (driven,) = json.loads((drawn / "metrics.json").read_text())["controllers"].values()
    assert (driven["tuning"], driven["errors_at"]) == ("run 17 of sweep.csv", "front")
    out.rename(escaped)
    replay = command.call(capsys, "sweep", "--run", f"{escaped}:17")
    assert "run 17 of \\x1b[31m.csv" in replay.out
    assert "\x1b" not in replay.out


@pytest.mark.usefixtures("_blank_figures")
def test_sweep_takes_the_vehicle_the_tuning_and_the_distributions_of_files(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35).save(tmp_path / "car.toml")
    popsteer.PopParams(min_lookahead=5.0).save(tmp_path / "tuned.toml")
    (tmp_path / "vary.toml").write_text('steer_lag = "uniform(0.05,0.2)"\nstart_offset = 0.5\n')
    out = tmp_path / "sweep.csv"
    outcome = command.call(
        capsys,
        *("sweep", "--track", "slalom", "--runs", "4", "--out", str(out)),
        *("--vehicle", str(tmp_path / "car.toml"), "--params", str(tmp_path / "tuned.toml")),
        *("--distributions", str(tmp_path / "vary.toml"), "--vary", "start_offset=none"),
        *("--vary", "noise_yaw=0.002"),
    )
    assert (outcome.status, outcome.err) == (0, "")
    job, rows = files.read(out)
    assert job.controller == "pop"
    assert job.params == popsteer.PopParams(min_lookahead=5.0)
    assert job.given == job.whole.vehicle == popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35)
    assert {name: str(each) for name, each in job.vary.items()} == {
        "steer_lag": "uniform(0.05,0.2)",
        "noise_yaw": "0.002",
    }
    assert {row["noise_yaw"] for row in rows} == {0.002}


@looped(
    ("options", "said"),
    [
        (("--vary", "friction=uniform(0,1)"), "unknown quantity that varies 'friction'; known: w"),
        (("--vary", "steer_lag"), "--vary must be written NAME=DISTRIBUTION, got 'steer_lag'"),
        (("--vary", "steer_lag=gamma(1)"), "steer_lag must be a number, uniform(LOW,HIGH)"),
        (("--vary", "steer_lag=normal(0,1)"), ": steer_lag must be in"),
        (("--distributions", "nowhere.toml"), "nowhere.toml: No such file"),
        (("--params", "nowhere.toml"), "nowhere.toml: No such file"),
        (("--out", "sweep.txt"), "--out must be a file *.parquet or *.csv"),
        (("--out", "/dev/null/sweep.csv"), "/dev/null/sweep.csv: Not a directory"),
        (("--runs", "0"), "runs must be a count in"),
        (("--deviation", "0"), "deviation must be in (0, 1000]"),
        (("--dask", "nowhere"), "--dask nowhere: no scheduler answers"),
        (("--workers", "0"), "--workers must be a count in"),
        (
            ("--start-offset", "5"),
            "start_offset must be left out where start_offset is drawn (--va",
        ),
        (
            ("--vary", "start_speed=uniform(2,4)", "--speed", "3"),
            "speed must be left out where start_speed is drawn (--vary start_speed=none), got 3.0",
        ),
        (("--controller", "lqr"), "unknown controller 'lqr'"),
    ],
)
def test_sweep_refuses_in_one_line(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    options: tuple[str, ...],
    said: str,
) -> None:
    if "--dask" in options:
        pytest.importorskip("distributed")
    monkeypatch.chdir(tmp_path)
    outcome = command.call(capsys, "sweep", *SHORT, *options)
    assert (outcome.status, outcome.out) == (2, "")
    assert said in outcome.err
    assert outcome.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@looped(
    ("text", "said"),
    [
        ("nowhere.csv:1", "nowhere.csv: No such file"),
        ("sweep.csv", "--run must be written FILE:RUN"),
        ("sweep.csv:1", "sweep.csv: no sweep of popsteer"),
    ],
)
def test_replay_of_no_run_is_one_line(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    text: str,
    said: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("sweep.csv").write_text("a,b\n1,2\n")
    outcome = command.call(capsys, "sweep", "--run", text)
    assert (outcome.status, outcome.out) == (2, "")
    assert said in outcome.err
    assert outcome.err.count("\n") == 1
    outcome = command.call(capsys, "sweep", "--run", text, "--dt", "0.1")
    assert "--dt must be left out where --run is given" in outcome.err


@pytest.mark.usefixtures("_blank_figures")
def test_full_disk_is_one_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    out = tmp_path / "sweep.csv"
    with monkeypatch.context() as patch:
        patch.setattr("popsteer.lab.sweep.rows.os.fsync", full)
        outcome = command.call(capsys, "sweep", *SHORT, "--out", str(out))
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err == f"popsteer: {out}.part: No space left on device\n"
    assert not out.exists()
    assert command.call(capsys, "sweep", *SHORT, "--out", str(out)).status == 0


def test_journal_that_is_a_device_is_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "sweep.csv.part").symlink_to("/dev/zero")
    outcome = command.call(capsys, "sweep", *SHORT, "--out", str(tmp_path / "sweep.csv"))
    assert (outcome.status, outcome.out) == (2, "")
    assert "sweep.csv.part: is no regular file" in outcome.err
