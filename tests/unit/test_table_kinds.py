"""Files as people have them: each kind read right, or refused with the option that settles it."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from popsteer import ConfigError, Path, PathError, planning, tracks
from tests.helpers import looped

if TYPE_CHECKING:
    from pathlib import Path as FilePath

# An arc of 14 m radius, 50 waypoints 1.4 m apart along it, from (3, -2) in direction 0.4.
N, RADIUS, STEP, START = 50, 14.0, 1.4, 0.4
S = STEP * np.arange(N)
YAW = START + S / RADIUS
X = 3.0 + RADIUS * (np.sin(YAW) - math.sin(START))
Y = -2.0 - RADIUS * (np.cos(YAW) - math.cos(START))
SPEED = np.full(N, 3.5)
ONE, NONE = np.ones(N), np.zeros(N)
WRAPPED = (YAW + np.pi) % (2.0 * np.pi) - np.pi
QUATERNION = np.sin(0.5 * YAW), np.cos(0.5 * YAW)
FROM_NORTH = np.degrees(np.pi / 2 - YAW) % 360.0
HEIGHT = 41.5 + 0.3 * np.sin(S)


def _rows(columns: tuple[Any, ...], separator: str = ",", style: str = "%.9f") -> str:
    return "".join(
        separator.join(each if isinstance(each, str) else style % each for each in row) + "\n"
        for row in zip(*columns, strict=True)
    )


def _write(folder: FilePath, text: str) -> FilePath:
    file = folder / "path.csv"
    file.write_text(text, encoding="utf-8")
    return file


def _agrees(path: Path, what: str) -> None:
    """Check that a path is the course above, with speed (v), yaw (y) or curvature (k)."""
    assert np.asarray(path.x) == pytest.approx(X, abs=2e-3)
    assert np.asarray(path.y) == pytest.approx(Y, abs=2e-3)
    assert (path.speed is not None) == ("v" in what)
    assert path.speed is None or np.asarray(path.speed) == pytest.approx(SPEED, abs=1e-6)
    assert (path.yaw is not None) == bool(set("yk") & set(what))
    if path.yaw is not None:
        off = (np.asarray(path.yaw) - YAW + np.pi) % (2.0 * np.pi) - np.pi
        assert np.abs(off).max() < (1e-3 if "y" in what else 0.05)
    assert path.reverse is None


K = NONE + 1.0 / RADIUS
SIN, COS = np.sin(YAW), np.cos(YAW)
HALVES = np.sin(YAW / 2), np.cos(YAW / 2)
READ: dict[str, tuple[str, str]] = {
    "head": ("x,y,speed\n" + _rows((X, Y, SPEED)), "v"),
    "popsteer": ("# a comment\n# x [m], y [m], speed [m/s]\n" + _rows((X, Y, SPEED)), "v"),
    "comment, other order": ("# speed [m/s], x [m], y [m]\n" + _rows((SPEED, X, Y)), "v"),
    "TUM raceline": (
        "# 17b4\n# 603f\n# s_m; x_m; y_m; psi_rad; kappa_radpm; vx_mps; ax_mps2\n"
        + _rows((S, X, Y, YAW - np.pi / 2, K, SPEED, NONE), "; "),
        "vyk",
    ),
    "TUM centre line": (
        "# x_m,y_m,w_tr_right_m,w_tr_left_m\n" + _rows((X, Y, 1.3 * ONE, 1.1 * ONE)),
        "",
    ),
    "TUM trajectory planner": (
        "# x_ref_m; y_ref_m; width_right_m; width_left_m; x_normvec_m; y_normvec_m; alpha_m;"
        " s_racetraj_m; psi_racetraj_rad; kappa_racetraj_radpm; vx_racetraj_mps; ax_racetraj_mps2\n"
        + _rows(
            (
                X - 0.7 * np.sin(YAW),
                Y + 0.7 * np.cos(YAW),
                4 * ONE,
                5 * ONE,
                np.sin(YAW),
                -np.cos(YAW),
                0.7 * ONE,
                S,
                YAW - np.pi / 2,
                K,
                SPEED,
                NONE,
            ),
            ";",
        ),
        "vyk",
    ),
    "raceline beside its reference line": (
        "x_ref,y_ref,x_raceline,y_raceline,alpha_m,x_normvec_m,y_normvec_m\n"
        + _rows(
            (
                X - 0.7 * np.sin(YAW),
                Y + 0.7 * np.cos(YAW),
                X,
                Y,
                0.7 * ONE,
                np.sin(YAW),
                -np.cos(YAW),
            )
        ),
        "",
    ),
    "CarMaker": (
        '#Name,"Car.tx","Car.ty","Car.Yaw","Car.vx","Car.FxFL"\n#Unit,"m","m","rad","km/h","N"\n'
        + _rows((X, Y, YAW, 3.6 * SPEED, 99.0 * ONE)),
        "vy",
    ),
    "CarMaker, between tabs": (
        "#Name\tCar.tx\tCar.ty\tCar.vx\n#Unit\tm\tm\tm/s\n#nStates\t0\t0\t0\n"
        + _rows(([""] * N, X, Y, SPEED), "\t"),
        "v",
    ),
    "CarMaker's road": (": x y z q\n#\n# x y z q\n" + _rows((X, Y, NONE, NONE), "\t"), ""),
    "a row between names and units": (
        "tx,ty,Yaw,v\nC1,C1,C1,C1\nm,m,deg,km/h\n,,,\n"
        + _rows((X, Y, np.degrees(YAW), 3.6 * SPEED)),
        "vy",
    ),
    "notes in columns without names": (
        "x,y,v,,,\n" + _rows((X, Y, SPEED, *[["", "a"] * (N // 2)] * 2, [""] * N)),
        "v",
    ),
    "east and north": ("e,n,\n" + _rows((X, Y)), ""),
    "names again and again": (3 * "seq,x,y,v\n" + _rows((S, X, Y, SPEED)), "v"),
    "numbers among names, as pandas has them": (
        ",0,dt,2,x,y,v\n" + _rows((S, S, ["9:59"] * N, ONE, X, Y, SPEED)),
        "v",
    ),
    "a spreadsheet's separator": (
        "sep=;\nx;y;v\n" + _rows((X, Y, SPEED), ";").replace(".", ","),
        "v",
    ),
    "km/h beside a clock": (
        "time,x,y,speed\n"
        + _rows(([f"10:59:{30 + 0.4 * k:05.2f}" for k in range(N)], X, Y, 3.6 * SPEED)),
        "v",
    ),
    "raceline of another tool": (
        "s,raceline_x,raceline_y,psi,kappa,vx,ax\n" + _rows((S, X, Y, YAW, K, SPEED, NONE)),
        "vyk",
    ),
    "F1TENTH raceline without a head": (
        _rows((S, X, Y, YAW - np.pi / 2, K)),
        "yk",
    ),
    "F1TENTH logger": (_rows((X, Y, WRAPPED, SPEED), ", ", "%f"), "vy"),
    "F1TENTH, x, y, yaw": (_rows((X, Y, WRAPPED), ",", "%.18e"), "y"),
    "RaceChrono": (
        'This file is made by a logger\nFormat,3\nSession title,"x"\n\n'
        "timestamp,lap_number,x,y,speed,bearing\nunix time,,m,m,km/h,deg\n"
        ",,100: gps,100: gps,100: gps,100: gps\n" + _rows((S, ONE, X, Y, 3.6 * SPEED, FROM_NORTH)),
        "vy",
    ),
    "ros2 topic echo --csv of poses": (
        _rows((["17"] * N, ["4"] * N, ["map"] * N, X, Y, *[NONE] * 3, *QUATERNION)),
        "y",
    ),
    "ros2 topic echo --csv of odometry": (
        _rows(
            (
                *(["17"] * N, ["4"] * N, ["odom"] * N, ["base_link"] * N, X, Y, *[NONE] * 3),
                *(*QUATERNION, *[ONE] * 36, SPEED, *[NONE] * 5, *[ONE] * 36),
            )
        ),
        "vy",
    ),
    "ids of lanes": ("id,x,y\n" + _rows((np.repeat([1, 2], N // 2), X, Y)), ""),
    "velocity to the east and north": (
        "x,y,velocity_east,VelN [km/h]\n" + _rows((X, Y, 3.5 * COS, 3.6 * 3.5 * SIN)),
        "v",
    ),
    "velocity to the north alone": ("x,y,velocity_north\n" + _rows((X, Y, 3.5 * SIN)), ""),
    "velocity to the east and north beside a speed": (
        "x,y,ve,vn,speed\n" + _rows((X, Y, 3.5 * COS, 3.5 * SIN, SPEED)),
        "v",
    ),
    "NGSIM": (
        "Vehicle_ID,Global_Time,Local_X,Local_Y,Global_X,Global_Y,v_Vel\n"
        + _rows((["2"] * N, S, X / 0.3048, Y / 0.3048, 6e6 + X, 1e6 + Y, SPEED / 0.3048)),
        "v",
    ),
    "EuRoC": (
        "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [],"
        " q_RS_z [], v_RS_R_x [m s^-1], v_RS_R_y [m s^-1]\n"
        + _rows((S, X, Y, ONE, QUATERNION[1], NONE, NONE, QUATERNION[0], 3.5 * COS, 3.5 * SIN)),
        "vy",
    ),
    "a unit for a name": ("x,y,MPH\n" + _rows((X, Y, SPEED / 0.44704)), "v"),
    "a unit in words": (
        "x,y,GPS Speed (Meters/second)\n" + _rows((X, Y, SPEED)),
        "v",
    ),
    "speed beside a time in ms": (
        "millis,x,y,speed\n" + _rows((1e3 * S / 3.5, X, Y, 3.6 * SPEED)),
        "v",
    ),
    "separators of another kind at the ends": (
        "x,y;\n" + _rows((X, Y)).replace("\n", ";\n"),
        "",
    ),
    "blank lines in front": ("\n" * 90 + _rows((X, Y, WRAPPED)), "y"),
    "empty columns at the ends": (_rows((X, Y, WRAPPED, *[[""] * N] * 3)), "y"),
    "names below titles": (
        "header,seq,pose,pose,position,x,y,z,orientation,x,y,z,w,twist,twist,linear,x,y,angular,x,y\n"
        + _rows(
            (
                *([""] * N, ["1"] * N, [""] * N, [""] * N, [""] * N, X, Y, NONE, [""] * N),
                *(NONE, NONE, *QUATERNION, [""] * N, [""] * N, [""] * N, SPEED, NONE),
                *([""] * N, ONE, ONE),
            )
        ),
        "vy",
    ),
    "capstone": (_rows((X, Y, NONE, np.degrees(WRAPPED))), "y"),
    "highway map": (_rows((X, Y, S, np.sin(YAW), -np.cos(YAW)), " "), ""),
    "Unity": (_rows((X, NONE, Y)), ""),
    "time first": (_rows((S / 3.5, X, Y, WRAPPED, SPEED)), "vy"),
    "stamp first": (_rows((1.68e9 + np.round(S), X, Y)), ""),
    "stamp last": (_rows((X, Y, 1.68e9 + np.round(S))), ""),
    "Autoware mini": (
        "x,y,z,yaw,velocity,change_flag,steering_flag\n"
        + _rows((X, Y, HEIGHT, np.degrees(WRAPPED), SPEED, NONE, 3 * ONE)),
        "vy",
    ),
    "Autoware's path saver": (
        "x, y, z, roll[rad], pitch[rad], yaw[rad], linear_velocity[m/s], angular_velocity[rad/s],"
        " linear_acceleration[m/s^2]\n"
        + _rows((X, Y, HEIGHT, NONE, NONE, WRAPPED, SPEED, NONE, NONE)),
        "vy",
    ),
    "Apollo": (
        "x,y,z,speed,acceleration,curvature,curvature_change_rate,time,theta,gear,s,throttle\n"
        + _rows((X, Y, HEIGHT, SPEED, NONE, K, NONE, 1.4e9 + S, WRAPPED, ONE, S, ONE)),
        "vyk",
    ),
    "pandas": (",x,y,speed\n" + _rows(([str(k) for k in range(N)], X, Y, SPEED)), "v"),
    "an index between tabs": (
        "\tyaw\tsog_kn\ty\tx\n"
        + _rows(([str(k) for k in range(N)], YAW, SPEED * 3600 / 1852, Y, X), "\t"),
        "vy",
    ),
    "pandas, of an array": (",0,1\n" + _rows(([str(k) for k in range(N)], X, Y)), ""),
    "pandas, of an array without its index": ("0,1,2\n" + _rows((X, Y, WRAPPED)), "y"),
    "the same with decimal commas": (
        "0;1;2\n" + _rows((X, Y, WRAPPED), ";").replace(".", ","),
        "y",
    ),
    "pandas, of a comment": (
        ",# x_m, y_m, w_tr_right_m, w_tr_left_m\n" + _rows((np.arange(N), X, Y, ONE, ONE)),
        "",
    ),
    "CARLA, x, y, speed, time and a flag": (
        _rows((X, Y, SPEED, [f" {t:6.3f} False" for t in S / 3.5]), ", ", "%.3f"),
        "v",
    ),
    "the same in commas alone, at rest in noise": (
        _rows(
            (
                *(np.append(each[:1], each) for each in (X, Y)),
                np.append(-0.003, SPEED),
                np.append(-0.4, S / 3.5),
            )
        ).split("\n", 1)[1],
        "v",
    ),
    "a frame in each row": (_rows((X, Y, WRAPPED, ["map"] * N)), "y"),
    "names in camel case": (
        "LinkID,PositionX (m),PositionY (m),PositionZ (m),TargetSpeed,YawRate\n"
        + _rows((["A2"] * N, X, Y, HEIGHT, SPEED, NONE)),
        "v",
    ),
    "two widths that never change": (_rows((X, Y, 1.1 * ONE, 1.1 * ONE)), ""),
    "semicolons": ("x;y;speed\n" + _rows((X, Y, SPEED), ";"), "v"),
    "decimal commas": ("x;y;speed\n" + _rows((X, Y, SPEED), ";").replace(".", ","), "v"),
    "tabs": ("x [m]\ty [m]\tspeed\n" + _rows((X, Y, SPEED), "\t"), "v"),
    "quoted": ('"x","y","speed"\n' + _rows((X, Y, SPEED), ",", '"%.9f"'), "v"),
    "km/h": ("x [m],y [m],speed [km/h]\n" + _rows((X, Y, 3.6 * SPEED)), "v"),
    "km/h by a suffix": ("x,y,speed_kmh\n" + _rows((X, Y, 3.6 * SPEED)), "v"),
    "km/h in parentheses": ("x(m),y(m),speed(km/h)\n" + _rows((X, Y, 3.6 * SPEED)), "v"),
    "mph": ("x,y,v_mph\n" + _rows((X, Y, SPEED / 0.44704)), "v"),
    "cm": ("x [cm],y [cm],speed [m/s]\n" + _rows((100 * X, 100 * Y, SPEED)), "v"),
    "degrees": ("x [m],y [m],yaw [deg]\n" + _rows((X, Y, np.degrees(YAW))), "y"),
    "compass": ("x,y,heading,v\n" + _rows((X, Y, FROM_NORTH, SPEED)), "vy"),
    "a name in a column of the course": (
        "course,X Position (m),Y Position (m),target_v\n" + _rows((["oval"] * N, X, Y, SPEED)),
        "v",
    ),
    "psi": ("x,y,psi,v\n" + _rows((X, Y, WRAPPED, SPEED)), "vy"),
    "quaternion": (
        "field.pose.position.x,field.pose.position.y,field.pose.orientation.z,"
        "field.pose.orientation.w\n" + _rows((X, Y, np.sin(YAW / 2), np.cos(YAW / 2))),
        "y",
    ),
    "TUM trajectory without a head": (
        _rows((1.68e9 + 0.4 * S, X, Y, HEIGHT, NONE, NONE, *HALVES), " "),
        "y",
    ),
    "poses, w first": (_rows((X, Y, HEIGHT, HALVES[1], NONE, NONE, HALVES[0])), "y"),
    "poses in the plane": (_rows((X, Y, *HALVES), ";"), "y"),
    "KITTI": (
        # of a camera whose x is -y of the course, y down, z ahead
        _rows((COS, NONE, -SIN, -Y, NONE, ONE, NONE, -HEIGHT, SIN, NONE, COS, X), " "),
        "y",
    ),
    "matrices of a vehicle, numbered": (
        _rows((1 + np.arange(N), COS, -SIN, NONE, X, SIN, COS, NONE, Y, NONE, NONE, ONE, HEIGHT)),
        "y",
    ),
    "the same width twice": (_rows((X, Y, HEIGHT - 40.0, HEIGHT - 40.0)), ""),
    "psi beside pitch and roll": (
        "# x_m; y_m; psi_rad; vx_mps; theta_rad; phi_rad\n"
        + _rows((X, Y, YAW, SPEED, 0.1 * SIN, 0.1 * COS), ";"),
        "vy",
    ),
    "phi alone": ("x(m),y(m),vx(m/s),phi(rad)\n" + _rows((X, Y, SPEED, WRAPPED)), "vy"),
    "an index that pandas called so": (
        "Unnamed: 0,X,Y,v\n" + _rows((np.arange(N), X, Y, SPEED)),
        "v",
    ),
    "decimal commas in quotes": (
        '"x","y","v"\n' + re.sub(r"([^,\n]+)", r'"\1"', _rows((X, Y, SPEED))).replace(".", ","),
        "v",
    ),
    "decimal commas between white space": (
        "x  y  v\n" + _rows((X, Y, SPEED), "  ").replace(".", ","),
        "v",
    ),
    "decimal commas behind commas": (
        _rows((X, Y, YAW), "; ").replace(".", ",").replace(";", ","),
        "y",
    ),
    "axes": ("X-axis,Y-axis\n" + _rows((X, Y)), ""),
    "velocity over ground": (
        "x,y,vx,vy\n" + _rows((X, Y, SPEED * np.cos(YAW), SPEED * np.sin(YAW))),
        "v",
    ),
    "km/h as times show": ("time,x,y,v\n" + _rows((S / 3.5, X, Y, 3.6 * SPEED)), "v"),
    "m/s beside times": ("time,x,y,v\n" + _rows((S / 3.5, X, Y, SPEED)), "v"),
    "km/h by its name, beside times": (
        "time,x,y,v_kmh\n" + _rows((S / 3.5, X, Y, 3.6 * SPEED)),
        "v",
    ),
    "velocity over ground beside a yaw": (
        "x,y,psi_rad,vx,vy\n" + _rows((X, Y, YAW, SPEED * np.cos(YAW), SPEED * np.sin(YAW))),
        "vy",
    ),
    "velocity of the vehicle": (
        "x,y,psi_rad,vx,vy\n" + _rows((X, Y, YAW, SPEED, 0.01 * SIN)),
        "vy",
    ),
}


@looped("kind", list(READ))
def test_path_of_each_kind_of_file_is_read_right(tmp_path: Any, kind: str) -> None:
    text, what = READ[kind]
    path = Path.from_csv(_write(tmp_path, text))
    _agrees(path, what)
    assert path.source is not None
    assert path.source.startswith(f"path.csv: {N} waypoints of x")
    assert "\n" not in path.source


def _separated(text: str, separator: str, style: str, comma: str) -> str | None:
    """Write a file again between other separators; None where its entries hold them."""
    lines = []
    for line in text.splitlines():
        mark = next((m for m in (";", "\t", ",") if m in line), None)
        row = [each.strip().strip('"') for each in line.split(mark)]
        if any((separator.strip(" ") or " ") in (each or " ") for each in row):
            return None
        numbers = [re.fullmatch(r"[-+]?[0-9]+\.[0-9e+-]+", each) for each in row]
        pairs = zip(row, numbers, strict=True)
        row = [(style % float(a)).replace(".", comma) if b else a for a, b in pairs]
        lines.append(separator.join(row))
    return "\n".join(lines)


@looped("kind", [kind for kind in READ if not kind.startswith("decimal commas")])
def test_path_of_each_kind_is_never_misread_between_other_separators(
    tmp_path: Any, kind: str
) -> None:
    text, what = READ[kind]
    read = 0
    between = ((",", "."), (";", ","), ("; ", "."), ("\t", ","), (" ", "."), (" ", ","))
    for separator, comma in between:
        for style in ("%.8f", "%#.9g"):
            again = _separated(text, separator, style, comma)
            if again is not None:
                try:
                    path = Path.from_csv(_write(tmp_path, "\ufeff" + again))
                except PathError:
                    continue
                _agrees(path, what)
                read += 1
    assert read >= 2 or kind == "F1TENTH logger"  # which is known by its %f


@looped(
    ("text", "said"),
    [
        ('{"x": [1, 2]}', "is JSON"),
        ('{"x": [' + "1, " * 400_000 + "2]}", "is JSON"),
        ("<?xml version='1.0'?>\n<kml/>", "is KML"),
        ("<?xml version='1.0'?>\n<OpenDRIVE/>", "is OpenDRIVE"),
        ("waypoints:\n  - x: 1\n", "is YAML"),
        ("- [1, 2]\n- [3, 4]\n", "is YAML"),
        ("(1.0, 2.0)\n(3.0, 4.0)\n", "is a Python list, no table: numpy.savetxt writes it"),
        ("[(1.0, 2.0),\n (3.0, 4.0)]\n", "is a Python list, no table: numpy.savetxt writes it"),
        ("LabVIEW Measurement\t\nWriter_Version\t2\n", "has LabVIEW's preamble: leave out"),
        ("<!DOCTYPE html>\n<html><body>404</body></html>", "is HTML"),
        ('WKT,id\n"POINT (11 48)",1\n', "has its positions as WKT"),
        ("QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t48.1\t11.6\t5\t1\n", "is a mission of ArduPilot"),
        ("version https://git-lfs.github.com/spec/v1\noid sha256:1f\nsize 9\n", "is a pointer"),
        ("\x80\x04\x95", "is a pickle"),
        ("PK\x03\x04", "is a zip"),
    ],
)
def test_file_that_is_no_table_is_named_and_told_what_to_export(
    tmp_path: Any, text: str, said: str
) -> None:
    file = tmp_path / "path.csv"
    file.write_bytes(text.encode("latin-1"))
    with pytest.raises(
        PathError, match=f"{said}.*(: export it|unpack|git lfs pull|as text|above X_Value)"
    ):
        Path.from_csv(file)


def test_text_of_an_older_program_is_read(tmp_path: Any) -> None:
    file = tmp_path / "path.csv"
    rows = _rows((X, Y, np.degrees(YAW), 3.6 * SPEED), ";").replace(".", ",")
    head = "x [m];y [m];Yaw [°];v [km/h];Höhe über dem Fluß\n"
    file.write_bytes((head + rows.replace("\n", ";1\n")).encode("latin-1"))
    _agrees(Path.from_csv(file), "vy")


def test_origin_of_a_file_in_metres_is_refused(tmp_path: Any) -> None:
    with pytest.raises(ConfigError, match="has no latitudes and longitudes"):
        Path.from_csv(_write(tmp_path, _rows((X, Y))), origin=(47.0, 8.0))


def test_columns_that_are_not_known_are_refused() -> None:
    for columns in ("x,y,velo", {"velo": "v"}, ["x", "why"]):
        with pytest.raises(ConfigError, match="columns must be"):
            Path.from_csv("nowhere.csv", columns=columns)


def test_waypoints_at_one_place_are_refused(tmp_path: Any) -> None:
    with pytest.raises(PathError, match="its 50 waypoints are all at one place"):
        Path.from_csv(_write(tmp_path, "x,y\n" + _rows((ONE, ONE))))


def test_grade_is_read_by_its_name_and_unit(tmp_path: Any) -> None:
    text = "x,y,grade [%]\n" + _rows((X, Y, 4.0 * ONE))
    assert np.asarray(Path.from_csv(_write(tmp_path, text)).grade) == pytest.approx(0.04 * ONE)


def test_waypoints_that_meet_their_first_are_said(tmp_path: Any) -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 41)[:-1]
    file = _write(tmp_path, _rows((5.0 * np.cos(turn), 5.0 * np.sin(turn))))
    said = "the last waypoint is 0.78 m from the first"
    assert str(Path.from_csv(file).source).endswith(f"{said}: a lap with --closed")
    assert str(Path.from_csv(file, closed=True).source).endswith(said)
    assert "the last waypoint" not in str(Path.from_csv(_write(tmp_path, _rows((X, Y)))).source)


def test_what_popsteer_writes_is_read_back_to_the_bit(tmp_path: Any) -> None:
    shipped = tracks.get("racetrack")
    shipped.to_csv(tmp_path / "track.csv")
    path = Path.from_csv(tmp_path / "track.csv", closed=shipped.closed)
    assert np.column_stack((path.x, path.y)).tobytes() == shipped.xy.tobytes()
    assert np.asarray(path.speed).tobytes() == shipped.speed.tobytes()
    profile = planning.speed_profile(path)
    profile.to_csv(tmp_path / "plan.csv")
    again = Path.from_csv(tmp_path / "plan.csv", closed=shipped.closed)
    assert np.asarray(again.speed).tobytes() == np.asarray(profile.path.speed).tobytes()


def test_records_of_a_run_are_waypoints_and_a_log_to_the_bit(tmp_path: Any) -> None:
    pytest.importorskip("matplotlib")
    from popsteer import Pop, logs, sim
    from popsteer.lab.compare.files import run_csv

    car = sim.vehicle_of("kinematic-bicycle")
    drive = sim.run(Pop(Path(np.column_stack((X, Y))), car), "kinematic-bicycle", speed=3.0)
    file = _write(tmp_path, run_csv(drive))
    path, log = Path.from_csv(file), logs.read(file)
    assert np.asarray(path.x).tobytes() == np.asarray(drive.records["x"]).tobytes()
    for name in ("x", "y", "yaw", "speed", "steer"):
        assert getattr(log, name).tobytes() == np.asarray(drive.records[name]).tobytes(), name
