"""Logs as people have them: each kind read right, or refused with the option that settles it."""

from __future__ import annotations

import math
import re
from datetime import datetime, timedelta
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from popsteer import Path as Course
from popsteer import logs
from popsteer.logs import Log, LogError, csv_log
from tests.bags import START, write_bag
from tests.fuzz import mutated_files
from tests.helpers import ROOT, looped

if TYPE_CHECKING:
    from pathlib import Path

CASES = ROOT.parent / "shared" / "cases" / "logs"
# A car of 3.1 m on bends to both sides, 25 rows a second.
N = 200
T = 0.04 * np.arange(N)
SPEED = 6.0 + np.sin(T)
STEER = 0.25 * np.sin(0.9 * T)
YAW = 0.7 + np.concatenate(([0.0], np.cumsum(SPEED * np.tan(STEER) / 3.1 * 0.04)))[:-1]
X = 12.0 + np.concatenate(([0.0], np.cumsum(SPEED * np.cos(YAW) * 0.04)))[:-1]
Y = -7.0 + np.concatenate(([0.0], np.cumsum(SPEED * np.sin(YAW) * 0.04)))[:-1]
QZ, QW = np.sin(0.5 * YAW), np.cos(0.5 * YAW)
EPOCH = 1_700_000_000
FAR = 1_200_000.0


def _rows(*columns: Any, separator: str = ",") -> str:
    return "".join(
        separator.join(each if isinstance(each, str) else f"{each:.9f}" for each in row) + "\n"
        for row in zip(*columns, strict=True)
    )


def _write(folder: Path, text: str, name: str = "drive.csv") -> Path:
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return file


def _agrees(log: Log, within: float = 1e-6, far: float = 0.0) -> None:
    assert len(log) == N
    assert log.t - log.t[0] == pytest.approx(T, abs=1e-6)
    for name, values in {"x": far + X, "y": far + Y, "speed": SPEED, "steer": STEER}.items():
        assert getattr(log, name) == pytest.approx(values, abs=within), name
    off = (log.yaw - YAW + np.pi) % (2.0 * np.pi) - np.pi
    assert np.abs(off).max() < max(within, 1e-6)


def _stamps(unit: int) -> list[str]:
    return [str((EPOCH * 10**9 + 40_000_000 * k) // unit) for k in range(N)]


def _clock(form: str) -> list[str]:
    begun = datetime(2024, 5, 1, 23, 59, 58)  # past midnight  # noqa: DTZ001
    return [(begun + timedelta(seconds=0.04 * k)).strftime(form) for k in range(N)]


def _grouped(mark: str, point: str = ",") -> str:
    """Write a log as spreadsheets do, with a mark between thousands, far from the origin."""
    columns = T, FAR + X, FAR + Y, YAW, SPEED, STEER
    rows = (";".join(f"{each:_.6f}" for each in row) for row in zip(*columns, strict=True))
    return "".join(row.replace(".", point).replace("_", mark) + "\n" for row in rows)


HEAD = "t,x,y,yaw,speed,steer\n"
MOTEC = (
    '"Format","MoTeC CSV File",,,"Workbook",""\n"Venue","oval",,,"Worksheet",""\n'
    '"Sample Rate","25.000","Hz"\n\n'
    '"Time","Ground Speed","Steering Angle","Car Coord X","Car Coord Y","Heading"\n'
    '"s","km/h","deg","m","m","deg"\n\n'
)
READ: dict[str, str] = {
    "plain": HEAD + _rows(T, X, Y, YAW, SPEED, STEER),
    "comment": "# " + HEAD + _rows(T, X, Y, YAW, SPEED, STEER),
    "spaces": HEAD.replace(",", ", ") + _rows(T, X, Y, YAW, SPEED, STEER, separator=", "),
    "other names": "time,pos_x,pos_y,heading,velocity,steering_angle\n"
    + _rows(T, X, Y, YAW, SPEED, STEER),
    "quaternion, s and ns": ",s,ns,x,y,q.x,q.y,q.z,q.w,V,delta\n"
    + _rows(
        [str(k) for k in range(N)],
        [str(EPOCH + k // 25) for k in range(N)],
        [str(k % 25 * 40_000_000) for k in range(N)],
        *(X, Y, 0 * X, 0 * X, QZ, QW, SPEED, STEER),
    ),
    "a share beside the angle": HEAD.replace("steer", "steer_normalized,steering_angle_rad")
    + _rows(T, X, Y, YAW, SPEED, STEER / 0.6, STEER),
    "ms": HEAD + _rows([str(40 * k) for k in range(N)], X, Y, YAW, SPEED, STEER),
    "ms by name": HEAD.replace("t,", "t [ms],") + _rows(1e3 * T, X, Y, YAW, SPEED, STEER),
    "ms since 1970": HEAD + _rows(_stamps(10**6), X, Y, YAW, SPEED, STEER),
    "us since 1970": HEAD + _rows(_stamps(10**3), X, Y, YAW, SPEED, STEER),
    "ns since 1970": HEAD + _rows(_stamps(1), X, Y, YAW, SPEED, STEER),
    "ISO": HEAD + _rows(_clock("%Y-%m-%dT%H:%M:%S.%f"), X, Y, YAW, SPEED, STEER),
    "ISO, UTC": HEAD + _rows(_clock("%Y-%m-%d %H:%M:%S.%fZ"), X, Y, YAW, SPEED, STEER),
    "slashes in a date": HEAD + _rows(_clock("%Y/%m/%d %H:%M:%S.%f"), X, Y, YAW, SPEED, STEER),
    "clock with its zone": HEAD + _rows(_clock("%H:%M:%S.%f-05:00"), X, Y, YAW, SPEED, STEER),
    "clock past midnight": HEAD + _rows(_clock("%H:%M:%S.%f"), X, Y, YAW, SPEED, STEER),
    "day first": HEAD + _rows(_clock("%d.%m.%Y %H:%M:%S.%f"), X, Y, YAW, SPEED, STEER),
    "month first, to noon": HEAD
    + _rows(_clock("%m/%d/%Y %I:%M:%S.%f %p"), X, Y, YAW, SPEED, STEER),
    "hours left out": HEAD + _rows(_clock("%M:%S.%f"), X, Y, YAW, SPEED, STEER),
    "times of MATLAB": HEAD + _rows([f"{t:.8g} sec" for t in T], X, Y, YAW, SPEED, STEER),
    "dates of MATLAB": HEAD + _rows(_clock("%d-%b-%Y %H:%M:%S.%f"), X, Y, YAW, SPEED, STEER),
    "dates as C writes them": HEAD
    + _rows(_clock("%a %b %d %H:%M:%S.%f %Y"), X, Y, YAW, SPEED, STEER),
    "dates in words": HEAD + _rows(_clock("%a %d %B %Y %I:%M:%S.%f %p"), X, Y, YAW, SPEED, STEER),
    "times of pandas": HEAD + _rows(_clock("0 days %H:%M:%S.%f"), X, Y, YAW, SPEED, STEER),
    "Go's dates": HEAD + _rows(_clock("%Y-%m-%d %H:%M:%S.%f +0000 UTC"), X, Y, YAW, SPEED, STEER),
    "a unit behind each time": HEAD
    + _rows([f"{1e3 * t:.6f}ms" for t in T], X, Y, YAW, SPEED, STEER),
    "days of a spreadsheet": HEAD
    + _rows([f"{0.5 + t / 86400:.12f}" for t in T], X, Y, YAW, SPEED, STEER),
    "s and us": HEAD.replace("t,", "tv_sec,tv_usec,")
    + _rows(
        [str(EPOCH + k // 25) for k in range(N)],
        [str(k % 25 * 40_000) for k in range(N)],
        *(X, Y, YAW, SPEED, STEER),
    ),
    "s and ms": HEAD.replace("t,", "seconds,milliseconds,")
    + _rows(
        [str(EPOCH + k // 25) for k in range(N)],
        [str(k % 25 * 40) for k in range(N)],
        *(X, Y, YAW, SPEED, STEER),
    ),
    "milliseconds beside a clock": HEAD.replace("t,", "millis,")
    + _rows([str(1000 * EPOCH + 40 * k) for k in range(N)], X, Y, YAW, SPEED, STEER),
    "velocity to the east and north": "t,x,y,yaw,velocity_east,VelNorth [km/h],steer\n"
    + _rows(T, X, Y, YAW, SPEED * np.cos(YAW), 3.6 * SPEED * np.sin(YAW), STEER),
    "names below titles": "header,secs,nsecs,pose,position,x,y,orientation,x,y,z,w,linear,x,y,"
    "steer\n"
    + _rows(
        [""] * N,
        [str(EPOCH + k // 25) for k in range(N)],
        [str(k % 25 * 40_000_000) for k in range(N)],
        *([""] * N, [""] * N, X, Y, [""] * N, 0 * X, 0 * X, QZ, QW, [""] * N, SPEED, 0 * X, STEER),
    ),
    "decimal commas": HEAD.replace(",", ";")
    + _rows(T, X, Y, YAW, SPEED, STEER, separator=";").replace(".", ","),
    "thousands with dots": HEAD.replace(",", ";") + _grouped("."),
    "thousands with commas": HEAD.replace(",", ";") + _grouped(",", "."),
    "thousands with commas, in quotes": HEAD
    + re.sub(r"[^;\n]+", r'"\g<0>"', _grouped(",", ".")).replace(";", ","),
    "thousands with narrow spaces": HEAD.replace(",", ";") + _grouped("\u202f"),
    "OxTS": "Date (UTC),Time (UTC),PosLocalX (m),PosLocalY (m),VelForward (m/s),AngleHeading (deg),"
    "Steer (deg)\n"
    + _rows(
        *(["2024-05-01"] * N, _clock("%H:%M:%S.%f"), X, Y, SPEED),
        *(90.0 - np.degrees(YAW), np.degrees(STEER)),
    ),
    "phyphox": '"Time (s)","X (m)","Y (m)","Velocity (m/s)","Direction (°)","Steer (°)"\n'
    + _rows(T, X, Y, SPEED, 90.0 - np.degrees(YAW), np.degrees(STEER)),
    "AirData": "time(millisecond),x,y,speed(mph),compass_heading(degrees),steer\n"
    + _rows(1e3 * T, X, Y, SPEED / 0.44704, 90.0 - np.degrees(YAW), STEER),
    "month in letters": HEAD + _rows(_clock("%d-%b-%Y %H:%M:%S.%f"), X, Y, YAW, SPEED, STEER),
    "PlotJuggler": "__time,/odom/pose/pose/position/x,/odom/pose/pose/position/y,"
    "/odom/pose/pose/orientation/yaw,/odom/twist/twist/linear/x,/drive/drive/steering_angle\n"
    + _rows(EPOCH + T, X, Y, YAW, SPEED, STEER),
    "rostopic echo -p": "%time,field.header.seq,field.header.stamp,field.pose.pose.position.x,"
    "field.pose.pose.position.y,field.pose.pose.orientation.z,field.pose.pose.orientation.w,"
    "field.twist.twist.linear.x,steer\n"
    + _rows(_stamps(1), [str(k) for k in range(N)], _stamps(1), X, Y, QZ, QW, SPEED, STEER),
    "RaceChrono": "This file is made by a logger\nFormat,3\n\n"
    "timestamp,x,y,speed,bearing,steering_angle\nunix time,m,m,m/s,deg,deg\n"
    ",100: gps,100: gps,100: gps,100: gps,200: obd\n"
    + _rows(EPOCH + T, X, Y, SPEED, 90.0 - np.degrees(YAW), np.degrees(STEER)),
    "RaceChrono, several speeds": "This file is made by a logger\nFormat,3\n\n"
    "timestamp,x,y,speed,speed,bearing,steering_angle,speed\nunix time,m,m,m/s,m/s,deg,deg,m/s\n"
    ",100: gps,100: gps,calc,100: gps,100: gps,200: obd,200: obd\n"
    + _rows(
        *(EPOCH + T, X, Y, 0.9 * SPEED, SPEED, 90.0 - np.degrees(YAW), np.degrees(STEER)),
        0.8 * SPEED,
    ),
    "MoTeC": MOTEC
    + "".join(
        ",".join(f'"{each:.9f}"' for each in row) + "\n"
        for row in zip(T, 3.6 * SPEED, np.degrees(STEER), X, Y, np.degrees(YAW), strict=True)
    ),
    "units in brackets": "t [s],x [cm],y [cm],yaw [deg],speed [km/h],steer [deg]\n"
    + _rows(T, 100 * X, 100 * Y, np.degrees(YAW), 3.6 * SPEED, np.degrees(STEER)),
    "km/h without a unit": HEAD + _rows(T, X, Y, YAW, 3.6 * SPEED, STEER),
    "mph without a unit": HEAD + _rows(T, X, Y, YAW, SPEED / 0.44704, STEER),
    "hours without a unit": HEAD
    + _rows([f"{t / 3600.0:.12f}" for t in T], X, Y, YAW, SPEED, STEER),
    "knots without a unit": HEAD + _rows(T, X, Y, YAW, SPEED * 3600.0 / 1852.0, STEER),
    "degrees without a unit": HEAD + _rows(T, X, Y, np.degrees(YAW), SPEED, STEER),
    "velocity over ground": "t,x,y,yaw,vx,vy,steer\n"
    + _rows(T, X, Y, YAW, SPEED * np.cos(YAW), SPEED * np.sin(YAW), STEER),
    "velocity of the car": "t,x,y,yaw,vx,vy,steer\n"
    + _rows(T, X, Y, YAW, SPEED, 0.01 * STEER, STEER),
    "velocity over ground in km/h": "t,x,y,yaw_deg,vx_kmh,vy_kmh,steer\n"
    + _rows(
        T, X, Y, *(np.degrees(YAW), 3.6 * SPEED * np.cos(YAW), 3.6 * SPEED * np.sin(YAW)), STEER
    ),
    "compass": HEAD + _rows(T, X, Y, np.degrees(np.pi / 2 - YAW) % 360.0, SPEED, STEER),
}


@looped("kind", list(READ))
def test_log_of_each_kind_is_read_right(tmp_path: Any, kind: str) -> None:
    log = logs.read(_write(tmp_path, READ[kind]))
    _agrees(log, far=FAR if "thousands" in kind else 0.0)
    if "since" in kind or "ns" in kind:  # more digits than a number of seconds since 1970 has room
        assert log.t == pytest.approx(T, abs=1e-9)
    assert log.source.startswith(f"drive.csv: {N} rows of t, x")
    assert "\n" not in log.source


def test_vbox_is_read_with_its_minutes_west_and_compass(tmp_path: Any) -> None:
    pytest.importorskip("pyproj")
    lat, lon = 47.0 + Y / 111319.49, 9.0 + X / (111319.49 * math.cos(math.radians(47.0)))
    head = (
        "File created on 01/05/2024 at 12:00:00\n\n[header]\nsatellites\ntime\n\n[column names]\n"
        "sats time lat long velocity heading Steering_Angle\n\n[data]\n"
    )
    clock = [f"{120000 + t:010.3f}" for t in T]
    compass = np.degrees(np.pi / 2 - YAW) % 360.0
    text = head + _rows(
        ["012"] * N, clock, 60 * lat, -60 * lon, 3.6 * SPEED, compass, STEER, separator=" "
    )
    log = logs.read(_write(tmp_path, text, "drive.vbo"), origin=(47.0, 9.0))
    assert log.x == pytest.approx(X, rel=6e-3)
    assert log.y == pytest.approx(Y, rel=6e-3)
    assert np.cos(log.yaw - YAW) == pytest.approx(np.ones(N))
    assert log.speed == pytest.approx(SPEED, abs=1e-6)
    assert log.t == pytest.approx(43200.0 + T, abs=1e-6)


def test_topics_of_one_table_and_files_of_one_clock_are_put_together(tmp_path: Any) -> None:
    blank = [""] * N
    fast = 2.0 * T / 2.0 + 0.01
    rows = _rows(T, X, Y, YAW, blank, blank) + _rows(fast, blank, blank, blank, SPEED, blank)
    later = T + 0.02
    rows += _rows(later, blank, blank, blank, blank, STEER)
    lines = sorted(rows.splitlines(), key=lambda line: float(line.split(",")[0]))
    log = logs.read(_write(tmp_path, HEAD + "\n".join(lines)))
    assert log.x == pytest.approx(X[1:])
    assert log.speed == pytest.approx(SPEED[1:] - 0.01 * np.cos(T[1:]), abs=1e-3)
    assert log.steer == pytest.approx(STEER[:-1])
    assert "speed, steer put on the position's clock" in log.source
    pose = _write(tmp_path, "stamp,x,y,yaw\n" + _rows(_stamps(1), X, Y, YAW), "pose.csv")
    speed = _write(tmp_path, "s,ns,v\n" + _rows(*_seconds(), SPEED), "speed.csv")
    steer = _write(tmp_path, "stamp,delta\n" + _rows(_stamps(1), STEER), "steer.csv")
    log = logs.read([pose, speed, steer])
    _agrees(log)
    with pytest.raises(LogError, match="none of 2 files has a column 'speed'"):
        logs.read([pose, steer])


def _seconds() -> tuple[list[str], list[str]]:
    stamps = [EPOCH * 10**9 + 40_000_000 * k for k in range(N)]
    return [str(each // 10**9) for each in stamps], [str(each % 10**9) for each in stamps]


def test_pose_and_speed_of_topics_of_their_own(tmp_path: Any) -> None:
    pytest.importorskip("rosbags")
    columns = {"t": T, "x": X, "y": Y, "yaw": YAW, "speed": SPEED, "steer": STEER}
    more = ("geometry_msgs/msg/PoseStamped", "autoware_vehicle_msgs/msg/VelocityReport")
    file = write_bag(tmp_path / "bag", columns, more=more)
    assert START > 0.0
    log = logs.read(file, topics={"pose": "/vehicle_pose", "speed": "/vehicle_speed"})
    assert log.x == pytest.approx(X + 1.0)  # where that topic has it
    assert log.yaw == pytest.approx(YAW)
    assert log.speed == pytest.approx(SPEED + 0.5, abs=1e-6)
    assert "pose (/vehicle_pose), speed (/vehicle_speed), steer (/control/drive)" in log.source
    assert logs.read(file).x == pytest.approx(X)
    with pytest.raises(LogError, match=r"pose must be of nav_msgs"):
        logs.read(file, topics={"pose": "/control/drive"})


def test_values_that_never_change_are_said(tmp_path: Any) -> None:
    log = logs.read(_write(tmp_path, HEAD + _rows(T, X, Y, YAW, SPEED, 0.0 * T)))
    assert log.remarks == ("steer never changes",)
    for still, said in ((0.0, ("speed never changes",)), (6.0, ())):
        log = logs.read(_write(tmp_path, HEAD + _rows(T, X, Y, YAW, 0.0 * SPEED + still, STEER)))
        assert log.remarks == said
    frozen = [np.where(np.arange(N) < 120, each, each[120]) for each in (X, Y)]
    log = logs.read(_write(tmp_path, HEAD + _rows(T, *frozen, YAW, SPEED, STEER)))
    gone = float(np.sum(0.04 * SPEED[120:-1]))
    stands = f"the position stands for 3.2 s from t = 4.80 s on, in which speed says {gone:.3g} m"
    assert log.remarks == (stands,)
    log = logs.read(_write(tmp_path, HEAD + _rows(T, 0 * X, 0 * Y, YAW, SPEED, STEER)))
    assert log.remarks == ("the position never changes",)


def test_unit_of_speed_is_found_on_laps_shorter_than_a_stretch_of_the_log(tmp_path: Any) -> None:
    t = 0.02 * np.arange(60_000)  # laps of 5.2 s, for 20 min
    yaw = 1.2 * t
    noise = np.random.default_rng(5).normal(0.0, 0.02, (2, len(t)))
    xy = 5.0 * np.array((np.sin(yaw), -np.cos(yaw))) + noise
    for speed, unit in ((6.0, {}), (21.6, {"speed": "km/h"})):
        text = _rows(t, *xy, yaw, speed + 0.0 * t, 0.5 + 0.0 * t)
        log = logs.read(_write(tmp_path, HEAD + text))
        assert log.shown == unit
        assert log.speed == pytest.approx(6.0 + 0.0 * t)


def test_speed_that_is_turns_of_the_motor_is_refused_with_its_scale(tmp_path: Any) -> None:
    file = _write(tmp_path, HEAD + _rows(T, X, Y, YAW, 4600.0 * SPEED, STEER))
    with pytest.raises(
        LogError, match=r"speed says 46\d\d times as far .* --unit speed=(\S+) scales"
    ) as e:
        logs.read(file)
    scale = re.findall(r"speed=(\S+)", str(e.value))
    assert logs.read(file, units={"speed": scale[0]}).speed == pytest.approx(SPEED, rel=0.01)


def test_some_rows_of_many_show_what_the_heading_is(
    tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(csv_log, "_ENOUGH", N // 8)
    compass = 90.0 - np.degrees(YAW)
    rows = "t,x,y,yaw,speed,steer\n" + _rows(T, X, Y, compass, SPEED, STEER)
    log = logs.read(_write(tmp_path, rows))
    _agrees(log)
    assert log.shown == {"yaw": "deg-north"}
    still = "t,x,y,yaw,speed,steer\n" + _rows(T, X, Y, 0.0 * YAW, SPEED, STEER)
    assert "yaw never changes" in logs.read(_write(tmp_path, still)).remarks


@looped("noise", [0.0, 2e-3])
def test_unit_of_an_angle_is_shown_on_a_straight_or_said(tmp_path: Any, noise: float) -> None:
    steer = 0.002 * np.sin(0.9 * T) + 0.001  # with an offset, which turns nothing
    yaw = 0.7 + np.concatenate(([0.0], np.cumsum(SPEED * np.tan(steer - 0.001) / 3.1 * 0.04)))[:-1]
    x, y = (
        np.concatenate(([0.0], np.cumsum(0.04 * SPEED * f(yaw))))[:-1] for f in (np.cos, np.sin)
    )
    yaw += noise * np.sin(1e3 * np.arange(N) ** 2)
    file = _write(tmp_path, HEAD + _rows(T, x, y, yaw, SPEED, np.degrees(steer)))
    if noise == 0.0:
        with pytest.raises(LogError, match="wheelbase of 179 m: --unit steer=deg, or"):
            logs.read(file)
        file = _write(tmp_path, HEAD + _rows(T, x, y, yaw, SPEED, steer))
        assert "taken" not in logs.read(file).source
    else:
        assert logs.read(file).source.endswith("steer is taken for rad: the drive does not tell")
        assert "taken" not in logs.read(file, units={"steer": "deg"}).source


def test_unit_of_time_that_is_not_known_is_refused_with_a_remedy(tmp_path: Any) -> None:
    file = _write(tmp_path, HEAD.replace("t,", "t [tick],") + _rows(T, X, Y, YAW, SPEED, STEER))
    with pytest.raises(LogError, match=r"drive.csv: t \[tick\]: the unit 'tick' of t is not known"):
        logs.read(file)


def test_rows_of_several_vehicles_are_refused(tmp_path: Any) -> None:
    rows = "track_id," + HEAD + _rows(["7"] * 150 + ["8"] * 50, T, X, Y, YAW, SPEED, STEER)
    for name in ("track_id", "id"):
        with pytest.raises(LogError, match=f"{name} says 7, 8: rows of 2 vehicles"):
            logs.read(_write(tmp_path, rows.replace("track_id", name)))


def test_date_that_is_not_known_is_refused_with_the_one_that_is_read(tmp_path: Any) -> None:
    # Hours between hyphens may be a day, and 5 ms without zeros would be half a second.
    for form in ("%Y-%m-%d %H-%M-%S", "%Y%m%dT%H%M%S.%f", "%H:%M:%S:5"):
        text = HEAD + _rows(_clock(form), X, Y, YAW, SPEED, STEER)
        with pytest.raises(LogError, match=r"line 2, column 1: .* is no time: .* as 2024-05-01T"):
            logs.read(_write(tmp_path, text))


def test_stamp_that_is_no_number_of_a_clock_is_refused_in_one_line(tmp_path: Any) -> None:
    for wrong in ("9" * 400, "9" * 5000, "\u00b2"):  # superscript two is a digit, and no number
        stamps = [*_stamps(1)[:-1], wrong]
        text = HEAD + _rows(stamps, X, Y, YAW, SPEED, STEER)
        with pytest.raises(LogError, match=f"line {N + 1}, column 1: .* is no whole number"):
            logs.read(_write(tmp_path, text))
        assert len(Course.from_csv(_write(tmp_path, text)).x) == N


def test_a_row_a_second_or_a_day_asks_for_the_unit_of_time() -> None:
    five = np.zeros(5)
    for t in (2.0 * np.arange(5.0), np.array([0.0, 0.1, 0.2, 0.3, 9e4])):
        with pytest.raises(LogError, match="in what unit is t"):
            Log(t, five, five, five, five, five)
    assert len(Log(np.arange(5.0), five, five, five, five, five)) == 5


def test_mutated_files_are_read_or_refused_in_one_line() -> None:
    read, longest = mutated_files.run(320, 7)
    assert 0 < read < 320
    assert longest < 10.0


@pytest.mark.skipif(not CASES.is_dir(), reason="needs the cases beside the checkout")
def test_cases_are_read_right_or_refused_with_the_remedy() -> None:
    pytest.importorskip("pyproj")
    good = logs.read(CASES / "log_good.csv")
    for file in sorted(CASES.iterdir()):
        said = ""
        try:
            log = logs.read(file)
        except LogError as error:
            said = str(error)
        if said:
            assert "--" in said, file.name
            continue
        for name in ("x", "y", "yaw", "speed", "steer"):
            count = min(len(log), len(good))
            off = np.abs(getattr(log, name)[:count] - getattr(good, name)[:count])
            assert off.max() < 2e-3, (file.name, name)
        assert log.t - log.t[0] == pytest.approx(0.05 * np.arange(len(log)), abs=1e-5), file.name


def test_columns_that_are_left_out_and_units_are_said_as_the_file_has_them(tmp_path: Any) -> None:
    head = "time [s],lap,x,y,heading [deg],speed,steer,battery\n"
    north = 90.0 - np.degrees(YAW)
    log = logs.read(_write(tmp_path, head + _rows(T, 0.0 * T, X, Y, north, SPEED, STEER, T)))
    _agrees(log)
    assert "ignored: lap, battery; yaw is in deg, from north, clockwise, as the" in log.source


def test_gear_gives_a_speed_without_signs_its_own(tmp_path: Any) -> None:
    back = (T > 3.0) & (T < 5.0)
    for name, words in (
        ("gear", ("D", "R")),
        ("reverse", ("False", "True")),
        ("gear", ("1", "-1")),
    ):
        gears = np.where(back, words[1], words[0]).tolist()
        text = f"t,x,y,yaw,speed,steer,{name}\n" + _rows(T, X, Y, YAW, SPEED, STEER, gears)
        log = logs.read(_write(tmp_path, text))
        assert log.speed == pytest.approx(np.where(back, -SPEED, SPEED), abs=1e-6)
        assert f"speed is negative where {name} says backwards" in log.source
    # A speed with signs has them itself, and words of a gearbox that are not known say nothing.
    for speed, gears in ((-SPEED, ["R"] * N), (SPEED, ["S3"] * N), (SPEED, ["3"] * N)):
        text = "t,x,y,yaw,speed,steer,gear\n" + _rows(T, X, Y, YAW, speed, STEER, gears)
        log = logs.read(_write(tmp_path, text))
        assert log.speed == pytest.approx(speed, abs=1e-6)
        assert "backwards" not in log.source


def test_topics_that_ros2_echoes_as_csv_are_known_by_their_fields(tmp_path: Any) -> None:
    stamp = (
        [str(EPOCH + 40 * k // 1000) for k in range(N)],
        [str(40_000_000 * k % 10**9) for k in range(N)],
    )
    none, one = 0.0 * T, 1.0 + 0.0 * T
    frames = ["odom"] * N, ["base_link"] * N
    odometry = (*stamp, *frames, X, Y, none, none, none, QZ, QW, *[one] * 36)
    rows = _rows(*odometry, SPEED, *[none] * 5, *[one] * 36)
    files = [
        _write(tmp_path, rows, "odom.csv"),
        _write(tmp_path, _rows(*stamp, frames[1], STEER, *[none] * 4), "drive.csv"),
    ]
    _agrees(logs.read(files))
    # Of another number of columns, or without frames, they are no such topics.
    for fewer in (rows.replace(",odom,", ","), rows.replace(",odom,", ",4,")):
        with pytest.raises(LogError, match="columns without names"):
            logs.read(_write(tmp_path, fewer))
