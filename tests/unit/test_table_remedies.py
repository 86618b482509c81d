"""What a refusal names is what settles it: its option is taken out of the message, and applied."""

from __future__ import annotations

import re
import shlex
from pathlib import Path as FilePath
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from popsteer import Path, PathError, logs
from popsteer.errors import PopsteerError
from tests.helpers import ROOT, looped
from tests.unit import test_table_logs as of_logs
from tests.unit.test_table_kinds import (
    HEIGHT,
    NONE,
    ONE,
    SPEED,
    WRAPPED,
    YAW,
    N,
    S,
    X,
    Y,
    _agrees,
    _rows,
    _write,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

CASES = ROOT.parent / "shared" / "cases"
_GOOD = CASES / "logs" / "log_good.csv"
_OPTION = re.compile(r"--(columns|unit|topic|origin) ('[^']*'|[^\s;)]+)( (?=--))?")


def _remedies(message: str, names: dict[str, str]) -> Iterator[dict[str, Any]]:
    """Give what the options in a message say, those without a word between them together.

    `names` are what stands for NAME of a quantity; RATIO is 15, and ANGLE 0.55.
    """
    given: dict[str, Any] = {}
    for option, text, more in _OPTION.findall(message):
        (value,) = shlex.split(text.rstrip(",:."))
        for key, name in names.items():
            value = value.replace(f"{key}=NAME", f"{key}={name}")
        value = value.replace("RATIO", "15").replace("ANGLE", "0.55")
        if option in ("unit", "topic"):
            key, _, value = value.partition("=")
            given.setdefault(f"{option}s", {})[key] = value
        else:
            given[option] = value
        if not more or text.endswith(","):
            yield given
            given = {}


REFUSED: dict[str, tuple[str, str, str, str]] = {
    # text, what is said, the option that settles it, what is then read
    "speed alone": (_rows((X, Y, SPEED)), r"column 3 \(3.5 to 3.5\)", "x,y,speed", "v"),
    "width alone": (_rows((X, Y, 1.1 * ONE)), r"column 3 \(1.1 to 1.1\)", "x,y,-", ""),
    "two widths": (_rows((X, Y, 1.1 * ONE, 1.2 * ONE)), "column 3 .*, column 4", "x,y,-,-", ""),
    "a count, or x": (_rows((np.arange(N) * ONE, X, Y)), "column 3", "-,x,y", ""),
    "a time, or x": (_rows((S / 3.5, X, Y)), "column 3", "-,x,y", ""),
    "a count, or x, before a speed": (
        _rows((np.arange(N) * ONE, X, Y, SPEED)),
        "column 3 .*, column 4",
        "-,x,y,speed",
        "v",
    ),
    "a height beside a speed that times show": (
        _rows((S / 3.5, X, Y, HEIGHT, SPEED)),
        "column 4 .* is: nothing that is needed",
        "-,x,y,-,speed",
        "v",
    ),
    "throttle": (_rows((X, Y, 0.2 + 0.02 * np.sin(S))), "column 3", "x,y,-", ""),
    "Autoware 1": (_rows((X, Y, 85.7 * ONE, SPEED)), "column 3 .*, column 4", "x,y,-,speed", "v"),
    "Autoware 2": (
        _rows((X, Y, 85.7 * ONE, YAW, SPEED)),
        "column 3 .*, column 5",
        "x,y,-,yaw,speed",
        "vy",
    ),
    "cones": (
        _rows((["yellow", "blue"] * (N // 2), X, Y, NONE, NONE)),
        "column 1 is text .'yellow'.",
        "-,x,y,-,-",
        "",
    ),
    "boundaries": (
        "x,y,type\n" + _rows((X, Y, ["left"] * (N // 2) + ["right"] * (N // 2))),
        "type says left and right: lists of two sides",
        "x=x,y=y",
        "",
    ),
    "whole numbers that never change": (
        _rows((X, Y, 2.0 * ONE, 2.0 * ONE)),
        "column 3 .*, column 4",
        "x,y,-,-",
        "",
    ),
    "notes in empty columns behind a time": (
        _rows((1.7e9 + S, X, Y, YAW, *([""] * N,) * 2, ["", "slow"] * (N // 2))),
        "column 7 is text",
        "-,x,y,-,-,-,-",
        "",
    ),
    "one side's cones": (
        _rows((X, Y, ["blue"] * N)),
        "column 3 is text .'blue'.",
        "x,y,-",
        "",
    ),
    "a unit in each row": (
        _rows((X, Y, 3.6 * SPEED, ["km/h"] * N)),
        "column 4 is text .'km/h'.",
        "x,y,speed [km/h],-",
        "v",
    ),
    "Autoware's saver, km/h": (
        "x,y,z,yaw,velocity,change_flag\n" + _rows((X, Y, HEIGHT, WRAPPED, 3.6 * SPEED, NONE)),
        "velocity beside change_flag is km/h",
        "speed=velocity [km/h]",
        "vy",
    ),
    "no unit of speed": (
        "x,y,speed [furlong]\n" + _rows((X, Y, SPEED)),
        r"speed \[furlong\]: the unit 'furlong' of speed is not known",
        "speed=speed [furlong] [m/s]",
        "v",
    ),
    "two of one kind": (
        "/a/pose/position/x,/b/pose/position/x,y\n" + _rows((X, 9.0 + X, Y)),
        "two columns could be x",
        "x=/a/pose/position/x",
        "",
    ),
    "two positions": (
        "map_x,map_y,odom_x,odom_y\n" + _rows((X, Y, 9.0 + X, 9.0 + Y)),
        "two columns could be x",
        "x=map_x,y=map_y",
        "",
    ),
    "a name given twice": (
        "x,x,y\n" + _rows((X, X + 9.0, Y)),
        "two columns are named x",
        "x=1",
        "",
    ),
    "a comma in a name": (
        '"map, x","odom, x",y\n' + _rows((X, X + 9.0, Y)),
        "two columns could be x",
        "x=1",
        "",
    ),
    "more columns than names": (
        "x\ty\tvelocity[m]\n" + _rows((X, Y, SPEED, NONE), "\t"),
        "3 names above 4 columns",
        "x,y,speed,-",
        "v",
    ),
    "an index without a name, as R writes it": (
        "x y speed\n" + _rows(([str(k + 1) for k in range(N)], X, Y, SPEED), " "),
        "3 names above 4 columns",
        "-,x,y,speed",
        "v",
    ),
    "two unknown units": (
        "x [furlong],y [furlong],v\n" + _rows((X, Y, SPEED)),
        "the unit 'furlong' of x is not known",
        "x=x [furlong] [m],y=y [furlong] [m]",
        "v",
    ),
    "more columns than a path has": (
        _rows((X, Y, *(k * ONE for k in range(45)))),
        "no two of 47 columns without names are waypoints",
        "x,y",
        "",
    ),
    "stamps before two positions": (
        _rows((1.7e9 + np.round(S), 1e9 * (S % 1.0), X, Y, -X, 2.0 - Y, HEIGHT)),
        "no two of 7 columns without names are waypoints",
        "-,-,x,y",
        "",
    ),
    "a height that is called y": (
        "pos_x,pos_y,pos_z,speed\n" + _rows((X, HEIGHT, Y, SPEED)),
        "pos_y may be the height, as pos_z climbs steeper",
        "x=pos_x,y=pos_z",
        "v",
    ),
    "another name": ("abscissa,y\n" + _rows((X, Y)), "no column is named x", "x=abscissa", ""),
}


@looped("kind", list(REFUSED))
def test_path_that_says_too_little_is_read_right_with_the_option_that_is_named(
    tmp_path: Any, kind: str
) -> None:
    text, said, columns, what = REFUSED[kind]
    file = _write(tmp_path, text)
    with pytest.raises(PathError, match=said) as refused:
        Path.from_csv(file)
    message = str(refused.value)
    assert "\n" not in message
    names = {"x": "abscissa"} if kind == "another name" else {}
    remedies = list(_remedies(message, names))
    assert {"columns": columns} in remedies, remedies
    _agrees(Path.from_csv(file, columns=columns), what)
    if "=" not in columns:
        _agrees(Path.from_csv(file, columns=columns.split(",")), what)


T, STEER = of_logs.T, of_logs.STEER
EACH = (of_logs.X, of_logs.Y, of_logs.YAW, of_logs.SPEED, of_logs.STEER)
HAND = (*EACH[:4], 15.0 * EACH[4])
HEAD = of_logs.HEAD
REFUSED_LOGS: dict[str, tuple[str, str, dict[str, str]]] = {
    # text, what is said, what stands for NAME
    "milliseconds, and km/h": (
        HEAD + of_logs._rows(1e3 * T, *EACH[:3], 3.6 * EACH[3], EACH[4]),
        "in what unit is t",
        {},
    ),
    "hand wheel in degrees": (
        HEAD + of_logs._rows(T, *HAND[:4], np.degrees(HAND[4])),
        "no front wheels'.*--unit steer=deg/RATIO",
        {},
    ),
    "hand wheel in degrees, as named": (
        HEAD.replace("steer", "steer [deg]") + of_logs._rows(T, *HAND[:4], np.degrees(HAND[4])),
        "no front wheels'.*--unit steer=deg/RATIO",
        {},
    ),
    "hand wheel": (
        HEAD + of_logs._rows(T, *HAND),
        "no front wheels'.*--unit steer=rad/RATIO",
        {},
    ),
    "degrees": (
        HEAD + of_logs._rows(T, *EACH[:4], np.degrees(EACH[4])),
        "no front wheels'.*--unit steer=deg, or --unit steer=deg/RATIO",
        {},
    ),
    "centimetres": (
        HEAD + of_logs._rows(T, 100.0 * EACH[0], 100.0 * EACH[1], *EACH[2:]),
        "x and y are in cm",
        {},
    ),
    "other names": (
        HEAD.replace("steer", "angle").replace("yaw", "direction of travel")
        + of_logs._rows(T, *EACH),
        "no column is named yaw or steer; there are: t, x, y, direction of travel, speed, angle",
        {"yaw": "direction of travel", "steer": "angle"},
    ),
    "no names": (of_logs._rows(T, *EACH), "6 columns without names", {}),
    **{
        name: (
            HEAD.replace("steer", name) + of_logs._rows(T, *EACH[:4], EACH[4] / 0.55 * full),
            f"{re.escape(name)} is a share of the largest angle",
            {},
        )
        for name, full in {
            "steering_pct": 100.0,
            "Steer [%]": 100.0,
            "steer_percent": 100.0,
            "steering [-1..1]": 1.0,
            "steer_norm": 1.0,
        }.items()
    },
    "percent": (
        HEAD + of_logs._rows(T, *EACH[:4], EACH[4] / 0.55 * 100.0),
        "no front wheels'.*ANGLE at 100 % in rad, where it is in percent",
        {},
    ),
    "an unknown unit": (
        HEAD.replace("speed", "speed [furlong]") + of_logs._rows(T, *EACH),
        "unit 'furlong' of speed is not known",
        {},
    ),
}


@looped("kind", list(REFUSED_LOGS))
def test_log_that_says_too_little_is_read_right_with_the_option_that_is_named(
    tmp_path: Any, kind: str
) -> None:
    text, said, names = REFUSED_LOGS[kind]
    file = of_logs._write(tmp_path, text)
    with pytest.raises(logs.LogError, match=said) as refused:
        logs.read(file)
    assert "\n" not in str(refused.value)
    found = [logs.read(file, **given) for given in _remedies(str(refused.value), names)]
    right = [log for log in found if log.steer == pytest.approx(STEER, abs=1e-6)]
    right = [log for log in right if log.t[-1] == pytest.approx(T[-1])]
    several = {"milliseconds, and km/h": 3, "degrees": 3, "hand wheel": 3, "percent": 3}
    assert len(found) == several.get(kind, 1)
    (log,) = right
    of_logs._agrees(log)


def test_share_of_an_angle_is_never_one_itself(tmp_path: Any) -> None:
    text = HEAD.replace("steer", "out") + of_logs._rows(T, *EACH[:4], EACH[4] / 0.55 * 100.0)
    file = of_logs._write(tmp_path, text)
    with pytest.raises(logs.LogError, match=r"out is a share .*--unit steer=ANGLE/100 with"):
        logs.read(file, columns="steer=out [%]")
    for full in (1.0, 100.0):  # none is exactly 1 rad, or 100 degrees
        steer = EACH[4] / np.abs(EACH[4]).max()
        other = of_logs._write(tmp_path, HEAD + of_logs._rows(T, *EACH[:4], full * steer))
        with pytest.raises(logs.LogError, match=f"steer reaches {full:g}, as a share") as refused:
            logs.read(other)
        share, angle = _remedies(str(refused.value), {})
        assert logs.read(other, **share).steer == pytest.approx(0.55 * steer, abs=1e-6)
        assert angle == {"units": {"steer": "rad" if full == 1.0 else "deg"}}
    file.write_text(text, encoding="utf-8")
    with pytest.raises(logs.LogError, match="unit of steer must be rad, deg, mrad, a number"):
        logs.read(file, columns="steer=out", units={"steer": "%"})
    of_logs._agrees(logs.read(file, columns="steer=out [%]", units={"steer": "0.55/100"}))


@pytest.mark.skipif(not CASES.is_dir(), reason="needs the cases beside the checkout")
def test_cases_that_are_refused_are_read_with_the_option_that_is_named() -> None:
    pytest.importorskip("pyproj")
    yaw = 0.1 * np.arange(60)
    arc, good = 20.0 * np.column_stack((np.sin(yaw), 1.0 - np.cos(yaw))), logs.read(_GOOD)
    refused = 0
    for file in sorted((*(CASES / "paths").iterdir(), *(CASES / "logs").iterdir())):
        of_a_log = file.parent.name == "logs"
        read: Any = logs.read if of_a_log else Path.from_csv
        try:
            read(file)
        except PopsteerError as error:
            said = str(error)
        else:
            continue
        if "=NAME" in said:  # an export of one topic, which has no steer
            assert "no column is named steer; there are: time, field.header" in said
            continue
        remedies = list(_remedies(said, {}))
        refused += 1
        found = [read(file, **given) for given in remedies]
        if of_a_log:
            log = found[0]
            for name, most in {"x": 0.3, "y": 0.3, "speed": 2e-3, "steer": 2e-3}.items():
                values, wanted = getattr(log, name), getattr(good, name)[: len(log)]
                off = values - wanted - (values - wanted)[0] * (most > 0.1)
                assert np.abs(off).max() < most, (file.name, name)
        elif file.stem not in ("lap_small_open", "fsds_cones"):  # courses of their own
            off = [np.column_stack((p.x, p.y))[:60] - (p.x[0], p.y[0]) - arc for p in found]
            right = [p for p, each in zip(found, off, strict=True) if np.abs(each).max() < 0.2]
            assert right, file.name
            assert any(p.speed is None or np.ptp(p.speed) < 0.2 for p in right)
    assert refused > 9


def test_bag_that_says_too_little_is_refused_with_the_topics_that_there_are() -> None:
    pytest.importorskip("rosbags")
    from popsteer.logs import bag
    from popsteer.logs.messages import ODOMETRY, POSES, SPEEDS

    def remedies(*kinds: str) -> list[dict[str, Any]]:
        there = [
            SimpleNamespace(topic=f"/{k}", msgtype=kind, msgcount=3) for k, kind in enumerate(kinds)
        ]
        with pytest.raises(logs.LogError) as refused:
            bag._choose(FilePath("drive"), there, "odometry", [ODOMETRY], {})
        return list(_remedies(str(refused.value), {}))

    pose, speed = (next(kind for kind in each if kind != ODOMETRY) for each in (POSES, SPEEDS))
    assert remedies(ODOMETRY, ODOMETRY) == [{"topics": {"odometry": "/0"}}]
    assert remedies(speed, pose) == [{"topics": {"pose": "/1", "speed": "/0"}}]
    assert remedies(speed) == []
