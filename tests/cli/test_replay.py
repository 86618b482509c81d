from __future__ import annotations

import csv
import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import controllers
from popsteer.lab.replay import own_path, run
from popsteer.logs import Log, LogError
from tests.cli import command
from tests.helpers import looped

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture(scope="module")
def columns() -> dict[str, Any]:
    return command.drive()


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory, columns: dict[str, Any]) -> Path:
    return command.write_csv(tmp_path_factory.mktemp("log") / "drive.csv", columns)


def test_replay_of_the_controller_that_drove_agrees_with_it(columns: dict[str, Any]) -> None:
    x = 0.5 * np.arange(1600)
    path = popsteer.Path(np.column_stack((x, 12.0 * np.sin(x / 22.0))))
    found = run(Log(**columns), {"stanley": None}, command.CAR, path=path)
    shadow = found.shadows["stanley"]
    # It takes over from a driver at the start, and lets go of that angle by and by.
    assert np.abs(shadow.steer - columns["steer"])[-300:].mean() < 1e-3
    assert shadow.share("fault") == 0.0


def test_replay_gives_each_row_the_angle_that_was_applied_before_it() -> None:
    # Far beside the path POP turns as fast as it may: a neighbourhood away from the last angle.
    t = 0.05 * np.arange(200)
    steer = 0.02 * (-1.0) ** np.arange(200)
    log = Log(t, 8.0 * t, 5.0 + 0.0 * t, 0.0 * t, 8.0 + 0.0 * t, steer)
    path = popsteer.Path([(0.0, 0.0), (100.0, 0.0)])
    car = popsteer.Vehicle()
    shadow = run(log, {"pop": None}, car, path=path).shadows["pop"]
    span = popsteer.PopParams().resolved(car).steer_span
    assert shadow.steer[50:150] == pytest.approx(steer[49:149] - span, abs=1e-9)


def test_replay_of_a_trajectory_driven_twice_stays_on_its_lap() -> None:
    t = 0.05 * np.arange(1600)
    angle = 8.0 * t / 30.0  # two and a half laps of a circle of 30 m radius
    log = Log(
        t, 30.0 * np.sin(angle), 30.0 - 30.0 * np.cos(angle), angle, 8.0 + 0.0 * t, 0.1 + 0.0 * t
    )
    found = run(log, dict.fromkeys(controllers.names()), popsteer.Vehicle(rear_axle=-1.5))
    for shadow in found.shadows.values():
        assert np.abs(shadow.cross_track_error).max() < 0.15, shadow.name
        assert shadow.share("fault") == 0.0, shadow.name


def test_replay_after_a_gap_begins_anew(columns: dict[str, Any]) -> None:
    kept = np.ones(len(columns["t"]), dtype=bool)
    kept[300:340] = False
    log = Log(**{name: values[kept] for name, values in columns.items()})
    found = run(log, {"preview-pop": None, "pid": None}, command.CAR)
    for shadow in found.shadows.values():
        assert np.isfinite(shadow.steer).all()
        assert shadow.share("fault") == 0.0


def test_own_path_of_a_drive_with_a_cusp_goes_backwards_there() -> None:
    t = 0.05 * np.arange(400)
    speed = np.where(t < 10.0, 2.0, -2.0)
    x = np.cumsum(0.05 * speed)
    path = own_path(Log(t, x, 0.0 * x, 0.0 * x, speed, 0.0 * x))
    assert path.reverse is not None
    assert 0.4 < path.reverse.mean() < 0.6
    assert path.x.max() == pytest.approx(20.0, abs=0.3)


def test_replay_along_its_own_circle_has_no_bias() -> None:
    t = 0.05 * np.arange(500)
    for radius, speed, wheelbase in ((25.0, 8.0, 2.7), (1.5, 2.0, 0.33)):
        yaw = speed * t / radius
        steer = np.full_like(t, math.atan(wheelbase / radius))
        x, y = radius * np.sin(yaw), radius - radius * np.cos(yaw)
        log = Log(t, x, y, yaw, np.full_like(t, speed), steer)
        found = run(log, {"stanley": None}, popsteer.Vehicle(wheelbase=wheelbase))
        shadow = found.shadows["stanley"]
        worst = float(np.abs(shadow.cross_track_error).max())
        assert worst < min(0.01, 0.01 * radius)
        assert shadow.share("fault") == 0.0
        # At its ends a smoothed path has no neighbours on one side.
        assert float(np.abs(shadow.steer - log.steer)[9:-9].max()) < 0.005


def test_own_path_of_a_car_that_stands_is_refused() -> None:
    none = np.zeros(100)
    with pytest.raises(LogError, match=r"0\.0 m of driving make no path"):
        own_path(Log(0.1 * np.arange(100), none, none, none, none, none))
    speed = none + 5.0
    speed[40] = 1e20
    with pytest.raises(LogError, match=r"6.25e\+18 m between rows 39 and 40: a position"):
        own_path(Log(0.125 * np.arange(100), none, none, none, speed, none))


def test_replay_prints_a_table_and_writes_files(
    capsys: pytest.CaptureFixture[str], file: Path, tmp_path: Path
) -> None:
    car, out = tmp_path / "car.toml", tmp_path / "out"
    command.CAR.save(car)
    outcome = command.call(
        capsys, "replay", str(file), "--vehicle", str(car), "--out", str(out),
        "--controllers", "stanley,preview-pop",
    )  # fmt: skip
    assert (outcome.status, outcome.err) == (0, "")
    for part in (
        "drive.csv: 40.0 s",
        ", vehicle car.toml\n",
        "driver",
        "Stanley",
        "Preview POP",
        "fault",
    ):
        assert part in outcome.out
    with (out / "replay.csv").open() as stream:
        rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))
    assert len(rows) == 800
    assert float(rows[100]["preview-pop.steer"]) != float(rows[100]["steer"])
    table = (out / "summary.csv").read_text()
    assert [line.split(",")[0] for line in table.splitlines()] == [
        "controller",
        "stanley",
        "preview-pop",
    ]
    assert (out / "replay.png").stat().st_size > 10_000


def test_replay_with_params_of_a_file_uses_them(
    capsys: pytest.CaptureFixture[str], file: Path, tmp_path: Path
) -> None:
    params, tables = tmp_path / "tuned.toml", []
    for gain in (0.2, 0.6):
        params.write_text(f"[pop]\nlookahead_gain = {gain}\n")
        outcome = command.call(capsys, "replay", str(file), "--params", str(params))
        assert outcome.status == 0
        assert "POP" in outcome.out
        # What nobody named is not taken silently.
        assert "trajectory, vehicle paper; no --vehicle says what drove\n" in outcome.out
        tables.append(outcome.out)
    assert tables[0] != tables[1]


@looped(
    ("text", "message"),
    [
        ("lookahead_gain = 0.2\n", "unknown table 'lookahead_gain'"),
        ("[pop]\ngain = 1\n", "unknown key of [pop] 'gain'"),
        ("[pop]\nlookahead_gain = -1\n", "lookahead_gain must be in"),
        ('[pop]\nlookahead_gain = "far"\n', "pop.lookahead_gain must be a number"),
        ("[lqr]\n", "unknown table 'lqr'"),
        ("pop =", "not TOML"),
    ],
)
def test_replay_with_broken_params_is_one_line(
    capsys: pytest.CaptureFixture[str], file: Path, tmp_path: Path, text: str, message: str
) -> None:
    params = tmp_path / "tuned.toml"
    params.write_text(text)
    outcome = command.call(capsys, "replay", str(file), "--params", str(params))
    assert (outcome.status, outcome.out) == (2, "")
    assert message in outcome.err
    assert outcome.err.count("\n") == 1


def test_replay_of_a_missing_log_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    outcome = command.call(capsys, "replay", "none.csv")
    assert (outcome.status, outcome.out) == (2, "")
    assert "none.csv: cannot be read: No such file" in outcome.err
