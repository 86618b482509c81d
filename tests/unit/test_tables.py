from __future__ import annotations

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import popsteer
from popsteer.errors import PathError
from popsteer.tables import read_waypoints
from popsteer.tables.text import Table, table_of
from popsteer.tracks import Track
from tests.helpers import ROOT, looped

if TYPE_CHECKING:
    from numpy.typing import NDArray

CASES = ROOT.parent / "shared" / "cases" / "paths"
FINITE = st.floats(-1e100, 1e100, allow_nan=False)
# Each example writes its file anew, so one folder serves all; and a disk may be slow.
ONE_FOLDER = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
ROWS = st.lists(st.tuples(FINITE, FINITE, FINITE), min_size=2, max_size=20)


def _file(folder: Path, content: str | bytes) -> Path:
    file = folder / "waypoints.csv"
    file.write_bytes(content.encode() if isinstance(content, str) else content)
    return file


def _read(file: str | os.PathLike[str]) -> tuple[NDArray[np.float64], Any]:
    found = read_waypoints(file)
    return found.xy, found.speed


@looped(
    "content",
    [
        "1,2\n3,4\n",
        "1,2\n3,4",
        "1 2\n3 4\n",
        "\t1\t2\n  3    4  \n",
        "1 , 2\n3, 4\n",
        "1,2\r\n3,4\r\n",
        "1,2\r3,4\r",
        b"\xef\xbb\xbf1,2\n3,4\n",
        b"\xef\xbb\xbf# head\n1,2\n3,4\n",
        "x,y\n1,2\n3,4\n",
        "# two\n\n  # comments\nx y # names\n\n1 2 # first\n   \n3 4#last\n",
        "# \u2028 is no line end\n1,2\n3,4\n",
        "1e0,+2.0\n3.,.4e1\n",
        "x;y\n1;2\n3;4\n",
        "1;2\n3;4\n",
        "x\ty\n1,0\t2\n3\t4,0\n",
        '"x","y"\n"1","2"\n"3","4"\n',
    ],
)
def test_read_waypoints_two_columns_gives_xy_alone(tmp_path: Path, content: str | bytes) -> None:
    xy, speed = _read(_file(tmp_path, content))
    assert xy.tolist() == [[1.0, 2.0], [3.0, 4.0]]
    assert speed is None
    assert xy.dtype == np.float64
    assert xy.flags.c_contiguous


@looped(
    ("content", "wanted"),
    [
        ("t,x,y,speed\n9,1,2,5\n9,3,4,6\n", [5.0, 6.0]),  # a log
        ("speed y x\n5 2 1\n6 4 3\n", [5.0, 6.0]),
        ("id,X [m],Y [m],v (m/s)\na,1,2,5\n,3,4,6\n", [5.0, 6.0]),
        ("x_m,y_m,w_tr_right_m,w_tr_left_m\n1,2,7,8\n3,4,7,8\n", None),
        ("x,y,yaw\n1,2,0\n3,4,0\n", None),
        ("x y speed\n1 2 5\n3 4 6\n", [5.0, 6.0]),
        ("# v;y;x\n5;2;1\n6;4;3\n", [5.0, 6.0]),
        ("x,y,speed\n1,2,5,\n3,4,6,\n", [5.0, 6.0]),
    ],
)
def test_read_waypoints_finds_named_columns_wherever_they_stand(
    tmp_path: Path, content: str, wanted: list[float] | None
) -> None:
    xy, speed = _read(_file(tmp_path, content))
    assert xy.tolist() == [[1.0, 2.0], [3.0, 4.0]]
    assert (speed if speed is None else speed.tolist()) == wanted


@pytest.mark.parametrize("as_given", [str, Path, os.fspath])
def test_read_waypoints_takes_str_and_path_like(tmp_path: Path, as_given: type) -> None:
    xy, _ = _read(as_given(_file(tmp_path, "1,2\n3,4\n")))
    assert xy.shape == (2, 2)


@looped(
    ("content", "place", "fault", "index"),
    [
        ("1,2\n# c\nabc,4\n", ", line 3, column 1", "'abc' is not a number", 1),
        ("1,2\n3,abc\n", ", line 2, column 2", "'abc' is not a number", 1),
        ("1,2,5\n3,4,x\n", ", line 2, column 3", "'x' is not a number", 1),
        ("1,2,5\n3,4,\n", ", line 2, column 3", "'' is not a number", 1),
        ("1,x\n3,4\n", ", line 1, column 2", "'x' is not a number", 0),
        ("x,1\n3,4\n", ", line 1, column 1", "'x' is not a number", 0),
        ("x,y\nx,1\n3,4\n", ", line 2, column 1", "'x' is not a number", 0),
        ("1,2\nx,y\n3,4\n", ", line 2, column 1", "'x' is not a number", 1),
        ("1_0,2\n3,4\n", ", line 1, column 1", "'1_0' is not a number", 0),
        ("1,2\n" + "z" * 99 + ",4\n", ", line 2, column 1", f"'{'z' * 40}...' is not a number", 1),
        ("nan,inf\n3,4\n", ", line 1, column 1", "'nan' is not finite", 0),
        ("1,2\n3,-inf\n", ", line 2, column 2", "'-inf' is not finite", 1),
        ("1,2\r\n3,1e999\r\n", ", line 2, column 2", "'1e999' is not finite", 1),
        ("1,2\n3,4,5\n", ", line 2", "found 3 columns, the first row has 2: complete", 1),
        ("x,y,v\n3,4\n", ", line 2", "found 2 columns, the first row has 3", 0),
        ("1,2,3\n3,4\n", ", line 2", "found 2 columns, the first row has 3", 1),
        ("1,2\n3\n", ", line 2", "found 1 column, the first row has 2", 1),
        ("t,lat,y\n1,2,3\n3,4,5\n", ", line 1", "no column is named x; there are: t, lat, y", None),
        ("x,u,v\n1,2,3\n3,4,5\n", ", line 1", "no column is named y; there are: x, u, v", None),
        ("x,y,y\n1,2,3\n3,4,5\n", ", line 1", "two columns are named y", None),
        (
            "a" * 500 + ",b\n1,2\n",
            ", line 1",
            f"no column is named x or y; there are: {'a' * 200}",
            None,
        ),
        ("1|2\n3|4\n", ", line 1", "found 1 column, at least 2 are needed", None),
        ("1,2\n3,1e200\n", ", line 2, column 2", "'1e200' is too large", 1),
        ("", "", "at least 2 waypoints are needed, found 0", None),
        ("# nothing\n\n", "", "at least 2 waypoints are needed, found 0", None),
        ("x,y\n", "", "at least 2 waypoints are needed, found 0", None),
        ("x,y\n1,2\n", "", "at least 2 waypoints are needed, found 1", None),
        (b"1,2\n3,4\n\xff\xfe", ", line 3", "is not text in UTF-8", None),
        (b"\x89PNG\r\n\x1a\n", "", "is a picture, no table", None),
        (b"\x88PNG\r\n\x1a\n", ", line 1", "is not text in UTF-8", None),
        (b"1,2\n3,\x004\n", ", line 2", "holds a null character, is not text", None),
    ],
)
def test_read_waypoints_bad_content_names_file_line_and_column(
    tmp_path: Path, content: str | bytes, place: str, fault: str, index: int | None
) -> None:
    file = _file(tmp_path, content)
    with pytest.raises(PathError, match=f"^{re.escape(f'{file}{place}: {fault}')}") as caught:
        read_waypoints(file)
    assert caught.value.index == index
    assert "\n" not in str(caught.value)


def test_column_that_the_option_takes_away_is_not_said_to_be_missing(tmp_path: Path) -> None:
    file = _file(tmp_path, "x,y\n1,2\n3,4\n")
    with pytest.raises(PathError, match="line 1: --columns makes none y; there are: x, y"):
        read_waypoints(file, columns="x,z")


def test_read_waypoints_missing_file_gives_the_reason(tmp_path: Path) -> None:
    with pytest.raises(PathError, match=r"none\.csv: cannot be read: No such file") as caught:
        read_waypoints(tmp_path / "none.csv")
    assert isinstance(caught.value.__cause__, FileNotFoundError)


def test_read_waypoints_folder_gives_the_reason(tmp_path: Path) -> None:
    with pytest.raises(PathError, match="cannot be read"):
        read_waypoints(tmp_path)


def test_read_waypoints_impossible_name_is_refused() -> None:
    with pytest.raises(PathError, match=r"^'a\\x00b': cannot be read"):
        read_waypoints("a\0b")


@ONE_FOLDER
@given(rows=ROWS, closed=st.booleans())
def test_read_waypoints_of_exported_track_gives_the_same_bits(
    tmp_path: Path, rows: list[tuple[float, float, float]], closed: bool
) -> None:
    table = np.array(rows)
    Track("t", "any", "", table[:, :2], table[:, 2], closed).to_csv(tmp_path / "t.csv")
    xy, speed = _read(tmp_path / "t.csv")
    assert speed is not None
    assert xy.tobytes() == np.ascontiguousarray(table[:, :2]).tobytes()
    assert speed.tobytes() == table[:, 2].tobytes()


@ONE_FOLDER
@given(
    rows=ROWS, separator=st.sampled_from([",", ";", " ", "\t", " , "]), end=st.sampled_from("\r\n")
)
def test_read_waypoints_any_separator_gives_the_same_bits(
    tmp_path: Path, rows: list[tuple[float, float, float]], separator: str, end: str
) -> None:
    lines = [separator.join(map(repr, row)) for row in rows]
    found = read_waypoints(_file(tmp_path, end.join(lines)), columns="x,y,speed")
    assert found.speed is not None
    assert np.column_stack((found.xy, found.speed)).tobytes() == np.array(rows).tobytes()


@ONE_FOLDER
@given(content=st.binary(max_size=60) | st.text(alphabet="0123e.,-# \n\r_;xnaif", max_size=60))
def test_read_waypoints_any_content_gives_finite_waypoints_or_a_path_error(
    tmp_path: Path, content: bytes | str
) -> None:
    try:
        xy, speed = _read(_file(tmp_path, content))
    except PathError:
        return
    assert len(xy) >= 2
    assert np.isfinite(xy).all()
    assert speed is None or np.isfinite(speed).all()


def test_share_driven_backwards_is_of_the_segments_from_their_first_waypoints(
    tmp_path: Path,
) -> None:
    file = _file(tmp_path, "x,y,speed\n0,0,2\n10,0,-2\n8,0,-2\n5,0,2\n9,0,2\n15,0,2\n")
    assert "20 % of the length is driven backwards" in read_waypoints(file).source()


@pytest.mark.parametrize("unit", ["rad", "deg", "rad-north", "deg-north"])
def test_heading_in_a_unit_that_is_named_is_taken_as_named(tmp_path: Path, unit: str) -> None:
    bend = np.linspace(0.3, 1.4, 60)
    named = np.pi / 2.0 - bend if unit.endswith("north") else bend
    named = np.degrees(named) if unit.startswith("deg") else named
    columns = 20.0 * np.sin(bend), -20.0 * np.cos(bend), named
    rows = "".join(f"{x:.9f},{y:.9f},{yaw:.9f}\n" for x, y, yaw in zip(*columns, strict=True))
    found = read_waypoints(_file(tmp_path, f"x,y,yaw [{unit}]\n" + rows))
    assert found.more["yaw"] == pytest.approx(bend, abs=1e-8)
    assert "yaw is in" not in found.source()


@pytest.mark.skipif(not CASES.is_dir(), reason="needs the cases beside the checkout")
def test_cases_are_read_right_or_refused_with_the_remedy() -> None:
    pytest.importorskip("pyproj")
    yaw = 0.1 * np.arange(60)
    x, y = 20.0 * np.sin(yaw), 20.0 * (1.0 - np.cos(yaw))
    special = ("lap_small_open", "closed_first_repeated", "comment_header_reordered")
    for file in sorted(CASES.iterdir()):
        try:
            path = popsteer.Path.from_csv(file)
        except PathError as error:
            said = str(error)
        else:
            said = ""
        if said or file.stem in special:
            assert not said or "--columns " in said, file.name
            continue
        assert np.asarray(path.x)[:60] - path.x[0] == pytest.approx(x, abs=0.2), file.name
        assert np.asarray(path.y)[:60] - path.y[0] == pytest.approx(y, abs=0.2), file.name
        if path.speed is not None:
            assert np.asarray(path.speed) == pytest.approx(5.0, abs=1e-3), file.name
        if path.yaw is not None:
            off = (np.asarray(path.yaw)[:60] - yaw + np.pi) % (2.0 * np.pi) - np.pi
            assert np.abs(off).max() < 0.06, file.name


@pytest.mark.parametrize(
    ("text", "at_once"),
    [
        ("x,y\n1,2\n3,4\n", True),
        ("x y\r\n1 2e3\r\n\r\n3\t-4.5\r\n", True),
        ("# a\n1;2\n3;4\n", True),
        ("x_m,y_m\n 1 , 2 \n3,4", True),
        ("x,y,z\n1,2,3\n4,5,6\n", True),
        ("x,y\n1,2,\n3,4,\n", False),
        ("x,y\n1,2,3\n3,4\n", False),
        ("x,y,z\n1,2,3\n3,4\n", False),
        ("x,y\n1,inf\n3,4\n", False),
        ("x,y\n1,2e100\n3,2e101\n", False),
        ("x,y\n1,2\n1_000,4\n", False),
        ("x,y\n1,2\n0x10,4\n", False),
        ("x,y\n1,2\n3,\n", False),
        ('x,y\n"1",2\n3,4\n', False),
        ("x,y\n1,2 # one\n# two\n3,4\n", False),
        ("x, y\n1, 2 3\n4, 5 6\n", False),
        ("x;y\n1,5;2\n3,5;4\n", False),
        ("x,y\n", False),
    ],
)
def test_numbers_read_at_once_are_those_read_one_by_one(
    text: str, at_once: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def read() -> Any:
        try:
            return table_of("a.csv", text).numbers([0, 1]).tolist()
        except PathError as error:
            return str(error)

    assert (table_of("a.csv", text)._plain is not None) == at_once
    whole = read()
    monkeypatch.setattr(Table, "_plain", None)
    assert read() == whole
