"""What columns mean: headings, directions, velocities, heights, curvatures, and names."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from popsteer import Path, PathError
from popsteer.tables.quantities import meaning
from tests.helpers import looped
from tests.unit.test_table_kinds import (
    HEIGHT,
    NONE,
    SPEED,
    YAW,
    K,
    S,
    X,
    Y,
    _agrees,
    _rows,
    _write,
)


def test_name_says_of_what_a_value_is() -> None:
    of_others = "/cmd_vel/linear/x", "accel.accel.linear.x", "residual_v_x", "gyroRotationZ"
    assert {meaning(name)[0] for name in (*of_others, "lead_vehicle_velocity_x")} == {None}
    own = "/odom/twist/twist/linear/x", "locationSpeed", "field.twist.twist.linear.x"
    assert {meaning(name)[0] for name in own} == {"speed"}
    assert meaning("/cmd/steering_angle")[0] == "steer"


def test_heading_against_the_waypoints_drives_them_backwards(tmp_path: Any) -> None:
    x = np.concatenate((np.arange(0.0, 20.0), np.arange(19.0, 9.0, -1.0)))
    y, yaw = 0.01 * np.arange(30.0), np.zeros(30)
    path = Path.from_csv(_write(tmp_path, "x,y,yaw\n" + _rows((x, y, yaw))))
    assert path.reverse is not None
    assert np.flatnonzero(path.reverse)[0] in (19, 20)
    assert "% of the length is driven backwards" in str(path.source)
    signs = np.where(np.arange(30) < 20, 1.0, -1.0)
    for name in ("gear", "direction"):
        path = Path.from_csv(_write(tmp_path, f"x,y,{name}\n" + _rows((x, y, signs))))
        assert np.asarray(path.reverse).tolist() == (signs < 0.0).tolist()
    # A column that is called reverse says so by anything but 0.
    path = Path.from_csv(_write(tmp_path, "x,y,reverse\n" + _rows((x, y, 1.0 * (signs < 0.0)))))
    assert np.asarray(path.reverse).tolist() == (signs < 0.0).tolist()


def test_first_row_of_ones_is_a_waypoint_and_no_row_of_units(tmp_path: Any) -> None:
    for rows in ("1,1,1\n", "1,1,1\n1,2,1\n"):
        path = Path.from_csv(_write(tmp_path, f"x,y,speed\n{rows}4,5,1\n6,8,1\n"))
        assert (path.x[0], path.y[0], len(path)) == (1.0, 1.0, 3 + rows.count("2"))


def test_unit_of_a_yaw_is_said_as_the_file_has_it(tmp_path: Any) -> None:
    for name, said in (("yaw [deg]", "deg"), ("yaw", "deg"), ("yaw (°)", "°")):
        rows = _rows((X, Y, 90.0 - np.degrees(YAW)))
        source = str(Path.from_csv(_write(tmp_path, f"x,y,{name}\n{rows}")).source)
        assert f"yaw is in {said}, from north, clockwise" in source


def test_directions_in_words_are_read(tmp_path: Any) -> None:
    x = np.concatenate((np.arange(0.0, 20.0), np.arange(18.0, 9.0, -1.0)))
    back = np.arange(29) >= 20
    for name, ahead, behind in (("gear", "D", "R"), ("reverse", "False", "True")):
        words = np.where(back, behind, ahead).tolist()
        file = _write(tmp_path, f"x,y,{name}\n" + _rows((x, 0.0 * x, words)))
        # The words say how each point was reached: the way back begins at the cusp, one before.
        path = Path.from_csv(file)
        assert np.asarray(path.reverse).tolist() == (np.arange(29) >= 19).tolist()
        assert path.mended == ("moved 1 change of gear to the cusp beside, at waypoint 19",)
    file = _write(tmp_path, "x,y,gear\n" + _rows((x, 0.0 * x, ["D"] * 28 + ["back"])))
    with pytest.raises(PathError, match=r"line 30, column 3: 'back' is none of d, drive, f"):
        Path.from_csv(file)


def test_rows_of_several_vehicles_are_refused(tmp_path: Any) -> None:
    for name in ("track_id", "agentId", "Vehicle ID"):
        head, rows = f"{name},x,y\n", (["7"] * 25 + ["8"] * 25, X, Y)
        with pytest.raises(PathError, match="ays 7, 8: rows of 2 vehicles: keep those of one"):
            Path.from_csv(_write(tmp_path, head + _rows(rows)))
        _agrees(Path.from_csv(_write(tmp_path, head + _rows((["7"] * 50, X, Y)))), "")


def test_a_height_beside_waypoints_is_left_out(tmp_path: Any) -> None:
    for z in (HEIGHT, 0.3 * X):
        _agrees(Path.from_csv(_write(tmp_path, "x,y,z\n" + _rows((X, Y, z)))), "")
    flat = Path.from_csv(_write(tmp_path, "x,y,z\n" + _rows((S, NONE, HEIGHT))))
    assert np.asarray(flat.y) == pytest.approx(NONE)


def test_yaw_in_a_frame_of_its_own_against_all_the_waypoints_shows_nothing(tmp_path: Any) -> None:
    for yaw, reverse in ((YAW + np.pi, True), (YAW + np.pi / 2, False)):
        path = Path.from_csv(_write(tmp_path, "x,y,psi\n" + _rows((X, Y, yaw))))
        assert (path.reverse is not None) == reverse
        assert ("100 % of the length is driven backwards" in str(path.source)) == reverse
        assert (path.yaw is None) == ("yaw (psi) ignored" in str(path.source)) == (not reverse)


def test_yaw_that_is_none_of_the_waypoints_is_left_out_and_said(tmp_path: Any) -> None:
    path = Path.from_csv(_write(tmp_path, "x,y,yaw\n" + _rows((X, Y, 7.0 * np.sin(9.0 * S)))))
    assert path.yaw is None
    assert "yaw ignored" in str(path.source)


def test_slow_speed_that_leads_nowhere_is_no_driving_backwards(tmp_path: Any) -> None:
    x = np.concatenate((X[:1] + 1e-3 * np.arange(5.0)[::-1], X[1:]))
    y, speed = np.concatenate((np.full(4, Y[0]), Y)), np.concatenate((np.full(4, -0.02), SPEED))
    path = Path.from_csv(_write(tmp_path, "x,y,vx\n" + _rows((x, y, speed))))
    assert path.reverse is None
    assert "backwards" not in str(path.source)
    # 10 cm/s is driven, and so is what leads on.
    for back in (-0.2, -0.02):
        speed = np.concatenate((SPEED[:20], np.full(3, back), SPEED[23:]))
        path = Path.from_csv(_write(tmp_path, "x,y,vx\n" + _rows((X, Y, speed))))
        assert "6.12 % of the length is driven backwards" in str(path.source)


def test_velocity_over_ground_along_x_is_told_from_driving_backwards(tmp_path: Any) -> None:
    west = 900.0 - 0.8 * np.arange(14.0)

    def read(head: str, *columns: Any) -> tuple[Path, bool]:
        path = Path.from_csv(_write(tmp_path, head + "\n" + _rows((west, 0.01 * west, *columns))))
        return path, "backwards" in str(path.source)

    vx, vy = np.full(14, -8.0), np.full(14, -0.08)
    for head, more in (("x,y,vx,vy", ()), ("x,y,vx,vy,psi", (np.full(14, -3.13),))):
        path, backwards = read(head, vx, vy, *more)
        assert not backwards
        assert path.speed == pytest.approx(np.hypot(vx, vy))
        assert "speed (of vx and vy)" in str(path.source)
    # It looks to the east, or drives to and fro.
    assert read("x,y,vx,vy,psi", vx, vy, np.full(14, 0.01))[1]
    west = np.concatenate((west, west[-2:5:-1]))
    ways = np.repeat((8.0, -8.0), (14, 7))
    assert read("x,y,vx,vy", ways, 0.01 * ways)[1]


def test_curvature_that_contradicts_the_waypoints_is_left_out_and_said(tmp_path: Any) -> None:
    path = Path.from_csv(_write(tmp_path, "x,y,kappa\n" + _rows((X, Y, -3.0 * K))))
    assert path.curvature is None
    assert "of x, y; curvature ignored: " in str(path.source)


@looped(
    ("name", "found"),
    [
        ("X", ("x", None)),
        ("x_m", ("x", "m")),
        ("v_km_h", ("speed", "km/h")),
        ("psi (deg)", ("yaw", "deg")),
        ("linear_velocity[m/s]", ("speed", "m/s")),
        ("field.twist.twist.linear.x", ("speed", None)),
        ("field.twist.twist.angular.x", (None, None)),
        ("linear_acceleration[m/s^2]", (None, "m/s^2")),
        ("w_tr_right_m", (None, None)),
        ("q.w", ("qw", None)),
        ("kappa_radpm", ("curvature", "radpm")),
        ("Steering Angle", ("steer", None)),
        ("steeringAngle", ("steer", None)),
        ("SteeringWheelAngle", (None, None)),
        ("centerline_x", ("x", None)),
        ("VTarget", ("speed", None)),
        ("WpXCoord_mm", ("x", "mm")),
        ("/control/control_cmd/lateral/steering_tire_angle", ("steer", None)),
        ("p_x [m]", ("x", "m")),
        ("PosLat", ("lat", None)),
        ("xVelocity", ("speed", None)),
        ("kappa_1pm", ("curvature", "1pm")),
        ("speed_cmps", ("speed", "cmps")),
        ("t_h", ("t", "h")),
        ("yaw [mrad]", ("yaw", "mrad")),
        ("refYaw_deg", ("yaw", "deg")),
        ("desired_velocity (km/hr)", ("speed", "km/hr")),
        ("left_x", (None, None)),
        ("PositionX (m)", ("x", "m")),
        ("speedKmh", ("speed", "kmh")),
        ("yawRate", (None, None)),
        ("WheelSpeedFL", (None, None)),
        ("GPS Easting [m]", ("x", "m")),
        ("Direction (°)", ("yaw", "°")),
        ("direction", ("direction", None)),
        ("calc/speed [m/s]", (None, "m/s")),
    ],
)
def test_meaning_of_a_name(name: str, found: tuple[str | None, str | None]) -> None:
    assert meaning(name)[:2] == found
