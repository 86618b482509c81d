from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from popsteer import ConfigError, Path, Vehicle, planning, tracks
from popsteer.cli import inputs, plan
from popsteer.planning import SpeedLimits
from tests.cli import command
from tests.helpers import looped

if TYPE_CHECKING:
    from pathlib import Path as FilePath


@pytest.fixture
def waypoints(tmp_path: FilePath) -> FilePath:
    file = tmp_path / "waypoints.csv"
    tracks.get("slalom").to_csv(file)
    return file


def test_plan_writes_the_course_and_says_what_limits_it(
    capsys: pytest.CaptureFixture[str], waypoints: FilePath, tmp_path: FilePath
) -> None:
    car, out = (
        Vehicle(wheelbase=2.7, max_steer_rate=0.2, max_speed=15.0),
        tmp_path / "new" / "c.csv",
    )
    car.save(tmp_path / "car.toml")
    options = ("--vehicle", str(tmp_path / "car.toml"), "--out", str(out))
    outcome = command.call(capsys, "plan", str(waypoints), *options)
    assert outcome.status == 0
    expected = planning.speed_profile(Path.from_csv(waypoints), vehicle=car)
    course = Path.from_csv(out)
    assert course.speed is not None
    assert course.speed.tolist() == expected.speed.tolist()
    assert f"in {expected.time:.2f} s" in outcome.out
    for share in expected.shares().values():
        assert f"{100.0 * share:.1f}" in outcome.out
    assert f"Written to {out}" in outcome.out


@pytest.mark.usefixtures("_blank_figures")
def test_plan_takes_limits_tables_and_speed_limits(
    capsys: pytest.CaptureFixture[str], waypoints: FilePath, tmp_path: FilePath
) -> None:
    out = tmp_path / "course.csv"
    limits = ("--set", "max_lateral_acceleration=2", "--set", "end_speed=5")
    tables = ("--driving", "0:3,10:1", "--braking", "0:2")
    # Where two limits meet the lower one counts, whichever is given first.
    bounds = ("--speed-limit", "50:80:6", "--speed-limit", "60:70:9")
    kept = ("--keep-speeds", "--out", str(out))
    outcome = command.call(capsys, "plan", str(waypoints), *limits, *tables, *bounds, *kept)
    assert outcome.status == 0
    path = Path.from_csv(waypoints)
    assert path.speed is not None
    most = path.speed.copy()
    touched = np.flatnonzero((path.s[1:] > 50.0) & (path.s[:-1] < 80.0))
    for ends in (touched, touched + 1):  # of the segments that the zone touches
        most[ends] = np.minimum(6.0, most[ends])
    expected = planning.speed_profile(
        path,
        SpeedLimits(
            max_lateral_acceleration=2.0,
            end_speed=5.0,
            max_acceleration=[(0.0, 3.0), (10.0, 1.0)],
            max_deceleration=[(0.0, 2.0)],
        ),
        speed_limits=most,
    )
    course = Path.from_csv(out)
    assert course.speed is not None
    assert course.speed.tolist() == expected.speed.tolist()


@pytest.mark.usefixtures("_blank_figures")
def test_plan_keeps_a_stop_and_a_zone_between_waypoints(
    capsys: pytest.CaptureFixture[str], tmp_path: FilePath
) -> None:
    recorded, out = tmp_path / "course.csv", tmp_path / "planned.csv"
    rows = [(10.0 * k, 0.0, 0.0 if k == 20 else 12.0) for k in range(41)]
    np.savetxt(recorded, rows, delimiter=",", header="x,y,speed")
    zones = ("--speed-limit", "102:108:5", "--speed-limit", "299:301:3")
    options = ("--keep-speeds", *zones, "--out", str(out))
    assert command.call(capsys, "plan", str(recorded), *options).status == 0
    speed = Path.from_csv(out).speed
    assert speed is not None
    assert speed[20] == 0.0
    assert speed[[10, 11]].max() <= 5.0
    assert speed[[29, 30, 31]].max() <= 3.0
    assert speed[15] > 8.0
    assert (speed[19], speed[21]) > (1.0, 1.0)


@pytest.mark.usefixtures("_blank_figures")
def test_plan_smooths_a_recording_first(
    capsys: pytest.CaptureFixture[str], tmp_path: FilePath
) -> None:
    rng = np.random.default_rng(1)
    xy = np.column_stack((np.arange(0.0, 60.0, 0.2), np.zeros(300)))
    xy = np.insert(xy + rng.normal(0.0, 0.05, xy.shape), 100, xy[100], axis=0)
    recorded, out = tmp_path / "recorded.csv", tmp_path / "course.csv"
    np.savetxt(recorded, xy, delimiter=",")
    options = ("--smooth", "0.1", "--out", str(out))
    assert command.call(capsys, "plan", str(recorded), *options).status == 0
    assert np.abs(Path.from_csv(out).y).max() < 0.1


def test_plan_draws_on_both_backgrounds(
    capsys: pytest.CaptureFixture[str], waypoints: FilePath, tmp_path: FilePath
) -> None:
    out = tmp_path / "course.csv"
    outcome = command.call(capsys, "plan", str(waypoints), "--closed", "--out", str(out))
    assert outcome.status == 0
    for name in ("course.png", "course-dark.png"):
        assert (tmp_path / name).read_bytes()[1:4] == b"PNG"
        assert name in outcome.out
    assert f"Written to {out}" in outcome.out


def test_plan_tells_of_bends_that_the_wheels_cannot_take(
    capsys: pytest.CaptureFixture[str], waypoints: FilePath
) -> None:
    outcome = command.call(capsys, "plan", str(waypoints), "--set-vehicle", "max_steer=0.05")
    assert outcome.status == 0
    assert "bend more sharply than the wheels turn" in outcome.out


@looped(
    ("options", "words"),
    [
        (("--set", "max_sped=1"), "unknown parameter of the limits 'max_sped'"),
        (("--set", "max_speed=30", "--set-vehicle", "max_speed=20"), "at most the vehicle's, 20.0"),
        (("--set", "start_speed=24"), "start_speed must be at most 12.7"),
        (("--set", "exponent=0"), "exponent must be in [1, inf]"),
        (("--driving", "fast"), "--driving must be pairs SPEED:ACCELERATION"),
        (("--braking", "0:3,0:2"), "max_deceleration must be a table whose speeds increase"),
        (("--speed-limit", "1:2"), "--speed-limit must be written FROM:TO:SPEED"),
        (("--speed-limit", "3:2:1"), "--speed-limit must be from a distance to one farther on"),
        (("--speed-limit", "2:2:1"), "--speed-limit must be from a distance to one farther on"),
        (("--speed-limit", "1:2:nan"), "--speed-limit must be a speed"),
        (("--speed-limit", "900:999:5"), "--speed-limit must be within the path, 307."),
        (("--smooth", "0"), "tolerance must be in"),
        (("--smooth", "0.1", "--keep-speeds"), "--keep-speeds must be left out"),
        (("--figure", "plan.png"), "No such option: --figure; it is --out now"),
        (("--out", "plan.svg"), "--out must be another file than what it is made of or drawn"),
        (("--vehicle", "truck"), "unknown vehicle 'truck'"),
        (("--out", "/dev/null/course.csv"), "/dev/null"),
    ],
)
def test_plan_refuses_in_one_line_and_writes_nothing(
    capsys: pytest.CaptureFixture[str],
    waypoints: FilePath,
    tmp_path: FilePath,
    options: tuple[str, ...],
    words: str,
) -> None:
    given = options if "--out" in options else (*options, "--out", str(tmp_path / "course.csv"))
    outcome = command.call(capsys, "plan", str(waypoints), *given)
    assert outcome.status == 2
    assert outcome.out == ""
    assert len(outcome.err.splitlines()) == 1
    assert words in outcome.err
    assert [file.name for file in tmp_path.iterdir()] == ["waypoints.csv"]


def test_plan_of_a_path_too_short_or_without_an_extra_says_so(
    capsys: pytest.CaptureFixture[str],
    waypoints: FilePath,
    tmp_path: FilePath,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    (tmp_path / "short.csv").write_text("0,0\n1,0\n", encoding="utf-8")
    outcome = command.call(capsys, "plan", str(tmp_path / "short.csv"))
    assert (outcome.status, outcome.out) == (2, "")
    assert "short.csv is 1 m long, and the vehicle 3 m from axle to axle" in outcome.err


def test_speeds_at_the_ends_are_kept_but_for_a_stop_and_a_limit_begins_before_the_end() -> None:
    path = Path([(10.0 * k, 0.0) for k in range(4)], speed=[0.0, 5.0, 5.0, 0.0])
    for texts, bounds in (([], [1e4, 5.0, 5.0, 1e4]), (["29:30:2"], [1e4, 5.0, 2.0, 2.0])):
        found = plan._bounds(path, texts, keep_speeds=True)
        assert np.asarray(found).tolist() == bounds
    with pytest.raises(ConfigError, match=r"must be within the path, 30\.0 m long"):
        plan._bounds(path, ["30:31:2"], keep_speeds=False)


def test_speed_limit_crosses_the_seam_of_a_lap(
    tmp_path: FilePath, capsys: pytest.CaptureFixture[str]
) -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 101)[:-1]
    x, y = 50.0 * np.cos(turn), 50.0 * np.sin(turn)
    file, out = tmp_path / "lap.csv", tmp_path / "out.csv"
    file.write_text("x,y\n" + "".join(f"{a},{b}\n" for a, b in zip(x, y, strict=True)))
    length = 100 * 2.0 * 50.0 * np.sin(np.pi / 100)
    speeds = []
    for text in (f"{length - 60}:{length + 40}:3", f"{length - 60}:40:3"):
        words = ["plan", str(file), "--closed", "--speed-limit", text, "--out", str(out)]
        assert command.call(capsys, *words).status == 0
        speeds.append(np.asarray(Path.from_csv(out, closed=True).speed))
    assert (speeds[0] == speeds[1]).all()
    assert (speeds[0][:13] <= 3.0).all()  # 40 m of waypoints 3.14 m apart
    assert (speeds[0][-20:] <= 3.0).all()
    assert (speeds[0][16:-22] > 3.0).all()
    for text in ("60:40:3", f"{length - 10}:{length + 10}:3"):
        done = command.call(capsys, "plan", str(file), "--speed-limit", text)
        assert (done.status == 2) == (text == "60:40:3")


def test_origin_may_be_a_pole_or_on_the_date_line_and_no_farther() -> None:
    for text, found in (("90,180", (90.0, 180.0)), ("-90, -180", (-90.0, -180.0))):
        assert inputs.place(text) == found
    for text in ("90.1,0", "0,-180.1", "0", "1,2,3", "nan,0"):
        with pytest.raises(ConfigError, match="--origin must be LAT,LON in degrees"):
            inputs.place(text)
