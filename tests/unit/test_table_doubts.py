"""Files that would be misread without a doubt: each is refused with what settles it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from popsteer import Path, PathError
from tests.helpers import looped
from tests.unit.test_table_kinds import NONE, ONE, SPEED, YAW, X, Y, _agrees, _rows, _write


def _camera(turn: Any) -> tuple[Any, ...]:
    """Give quaternions (x, y, z, w) of turns about a camera's y, which points down."""
    return NONE, np.sin(turn / 2.0), NONE, np.cos(turn / 2.0)


def test_poses_of_a_camera_are_read_in_the_ground_s_plane(tmp_path: Any) -> None:
    # A camera's x points to the right and its z ahead, so that a turn to the left is negative.
    position = -Y, 0.01 * np.sin(YAW), X
    path = Path.from_csv(_write(tmp_path, _rows((0.3 * YAW, *position, *_camera(-YAW)), " ")))
    _agrees(path, "y")
    assert "a quaternion of a camera: x is its z, y its -x" in str(path.source)
    # Where it looks elsewhere, the plane is not known.
    file = _write(tmp_path, _rows((0.3 * YAW, *position, *_camera(np.sin(9.0 * YAW))), " "))
    with pytest.raises(PathError, match="whose z moves as much as x and y do") as refused:
        Path.from_csv(file)
    for columns in ("-,x,y,-,-,-,-,-", "-,x,-,y,-,-,-,-"):
        assert columns in str(refused.value)
    path = Path.from_csv(file, columns="-,x,-,y,-,-,-,-")
    assert np.column_stack((path.x, path.y)) == pytest.approx(np.column_stack((-Y, X)), abs=1e-6)


def test_speed_that_no_vehicle_has_in_metres_asks_for_its_unit(tmp_path: Any) -> None:
    file = _write(tmp_path, "x,y,speed\n" + _rows((X, Y, 40.0 * SPEED)))
    with pytest.raises(PathError, match="speed without a unit would be up to 140 m/s") as told:
        Path.from_csv(file)
    for unit, size in (("km/h", 3.6), ("m/s", 1.0)):
        assert f"--columns 'speed=speed [{unit}]'" in str(told.value)
        path = Path.from_csv(file, columns=f"speed=speed [{unit}]")
        assert np.asarray(path.speed) == pytest.approx(40.0 * SPEED / size)


def test_degrees_that_are_asked_for_as_x_and_y_are_refused_by_their_places(tmp_path: Any) -> None:
    file = _write(tmp_path, _rows((9.0 + 1e-5 * X, 47.0 + 1e-5 * Y)))
    with pytest.raises(PathError, match="degrees rather than metres: --columns lon=1,lat=2 reads"):
        Path.from_csv(file, columns="x,y")
    assert Path.from_csv(file, columns="x [m],y [m]").x[0] == pytest.approx(9.0, abs=0.01)


def test_inches_are_a_unit_where_a_name_does_not_end_so(tmp_path: Any) -> None:
    inches = X / 0.0254, Y / 0.0254, np.degrees(YAW), SPEED / 0.0254, X
    text = "x(in),y(in),theta(deg),v [ips],x_in\n" + _rows(inches)
    _agrees(Path.from_csv(_write(tmp_path, text)), "vy")
    with pytest.raises(PathError, match="no column is named x or y; there are: x_in, y_in"):
        Path.from_csv(_write(tmp_path, "x_in,y_in\n" + _rows((X, Y))))


def test_slope_without_a_unit_is_no_grade(tmp_path: Any) -> None:
    for name, values in {"slope": 0.02 * ONE, "Grade": 2.0 * ONE}.items():
        path = Path.from_csv(_write(tmp_path, f"x,y,{name}\n" + _rows((X, Y, values))))
        assert path.grade is None
        assert f"{name} ignored: a slope needs a unit, as slope [%]" in str(path.source)
    for name, values in {"slope [%]": 2.0 * ONE, "grade": 0.02 * ONE}.items():
        path = Path.from_csv(_write(tmp_path, f"x,y,{name}\n" + _rows((X, Y, values))))
        assert np.asarray(path.grade) == pytest.approx(0.02)


def test_two_rows_of_many_columns_are_x_and_y(tmp_path: Any) -> None:
    path = Path.from_csv(_write(tmp_path, _rows(tuple(np.column_stack((X, Y))))))
    _agrees(path, "")
    assert "x, y (rows 1, 2)" in str(path.source)


@looped(
    ("text", "said"),
    [
        ("x,y\n" + _rows((X, Y)) + "x,y\n" + _rows((X, Y)), "line 52, column 1: 'x' is not a"),
        (_rows(tuple(np.column_stack((X, Y, X)))), "3 rows of 50 columns: a waypoint is a row"),
        (
            _rows(tuple(np.column_stack((np.arange(50.0), Y)))),
            "2 rows of 50 columns: a waypoint is a row",
        ),
        (_rows(tuple(X[:, None])), "1 row of 50 columns: a waypoint is a row"),
        (
            "Format,A,,\nRate,50,Hz,\n,,,\nDistance,Speed,Height,Grip\nm,km/h,m,\n"
            + _rows((YAW, SPEED, NONE, NONE)),
            r"line 4: no column is named x or y; there are: Distance \[m\], Speed",
        ),
        (
            '#Name,"Car.Distance","Car.vx"\n#Unit,"m","m/s"\n' + _rows((YAW, SPEED)),
            r"no column is named x or y; there are: Car.Distance \[m\], Car.vx",
        ),
    ],
)
def test_tables_of_something_else_are_refused_by_what_they_are(
    tmp_path: Any, text: str, said: str
) -> None:
    with pytest.raises(PathError, match=said) as refused:
        Path.from_csv(_write(tmp_path, text))
    assert "\n" not in str(refused.value)
