from __future__ import annotations

import math
import struct
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from popsteer import logs
from popsteer.logs import Log, LogError
from popsteer.logs.units import factor
from tests.bags import START, write_bag
from tests.helpers import looped

if TYPE_CHECKING:
    from pathlib import Path


def _columns(count: int = 50) -> dict[str, Any]:
    t = 0.1 * np.arange(count)
    return {
        "t": t,
        "x": 8.0 * t,
        "y": 0.1 * t,
        "yaw": 0.5 * np.sin(t),
        "speed": 8.0 + 0.0 * t,
        "steer": 0.01 * t,
    }


def _csv(folder: Path, text: str) -> Path:
    file = folder / "drive.csv"
    file.write_text(text)
    return file


def test_log_rows_that_cannot_be_right_are_skipped_and_said() -> None:
    columns = _columns(10)
    columns["t"][4] = columns["t"][3]
    columns["t"][6] = 0.05
    columns["yaw"][8] = math.nan
    log = Log(**columns)
    assert len(log) == 7
    assert np.all(np.diff(log.t) > 0.0)
    assert log.remarks == (
        "1 row with a number that is not finite: skipped",
        "1 row repeats the time of an earlier one: skipped",
        "time runs backwards in 1 row: skipped",
    )


def test_log_with_one_stray_stamp_loses_that_row_alone() -> None:
    columns = _columns(600)
    columns["t"][3] = 1e9
    log = Log(**columns)
    assert len(log) == 599
    assert log.remarks == ("time runs backwards in 1 row: skipped",)


def test_log_gap_is_found_and_its_step_is_the_usual_one() -> None:
    columns = _columns(30)
    columns["t"][20:] += 3.0
    log = Log(**columns)
    assert log.gaps == (20,)
    assert log.remarks == ("1 gap, the longest 3.10 s: left out",)
    assert log.steps[20] == pytest.approx(0.1)


def test_log_of_unequal_columns_is_refused() -> None:
    columns = _columns(10) | {"yaw": np.zeros(9)}
    with pytest.raises(LogError, match=r"log: yaw must have shape \(10,\), got \(9,\)"):
        Log(**columns)


@looped(
    ("column", "unit", "expected"),
    [
        ("t", "ms", 1e-3),
        ("speed", "km/h", 1 / 3.6),
        ("steer", "deg", math.pi / 180),
        ("steer", "-deg/15.5", -math.pi / 180 / 15.5),
        ("steer", "1/16", 0.0625),
        ("y", "-1", -1.0),
    ],
)
def test_factor_of_a_unit_is_its_size(column: str, unit: str, expected: float) -> None:
    assert factor(column, unit) == pytest.approx(expected, rel=1e-15)


@looped("unit", ["furlong", "", "deg/0", "nan", "0", "deg/x"])
def test_factor_of_an_unknown_unit_is_refused(unit: str) -> None:
    with pytest.raises(LogError, match="unit of steer must be rad, deg, mrad, a number"):
        factor("steer", unit)


def test_read_csv_takes_columns_by_name_and_units(tmp_path: Path) -> None:
    text = "# made by hand\ntime;delta;y;x;yaw;speed;note\n0;9;0;1;90;36;a\n100;-9;0;2;90;36;b\n"
    log = logs.read(
        _csv(tmp_path, text),
        columns={"t": "time", "steer": "delta"},
        units={"t": "ms", "steer": "deg", "yaw": "deg", "speed": "km/h"},
    )
    assert log.t.tolist() == [0.0, 0.1]
    assert log.x.tolist() == [1.0, 2.0]
    assert log.speed == pytest.approx([10.0, 10.0])
    assert np.degrees(log.steer) == pytest.approx([9.0, -9.0])
    assert np.degrees(log.yaw) == pytest.approx([90.0, 90.0])


def test_read_csv_keeps_a_quoted_comma_in_its_column(tmp_path: Path) -> None:
    rows = "".join(f'0.{k},"a, b",{k},0,0,1,0\n' for k in range(3))
    log = logs.read(_csv(tmp_path, "t,note,x,y,yaw,speed,steer\n" + rows))
    assert log.x.tolist() == [0.0, 1.0, 2.0]


def test_read_csv_leaves_out_rows_with_an_empty_entry(tmp_path: Path) -> None:
    text = "t,x,y,yaw,speed,steer\n0,0,0,0,1,0\n0.1,,0,0,1,0\n0.2,1,0,0,1,0\n"
    log = logs.read(_csv(tmp_path, text))
    assert len(log) == 2
    assert log.remarks == ("1 row with a number that is not finite: skipped",)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the file is empty"),
        ("t,x,y,yaw,w,steer\n", "no column is named speed; there are: t, x, y, yaw, w, steer"),
        ("t,x,y,yaw,speed,steer\n0,0,0,0,fast,0\n", "line 2, column 5: 'fast' is not a number"),
        ("t,x,y,yaw,speed,steer\n0,0,0\n", "line 2: found 3 columns, the first row has 6"),
        ("t,x,y,yaw,speed,steer\n0,0,0,0,1,0\n", "at least 2 rows are needed, found 1"),
        ("t,x,y,yaw,speed,steer,x\n0,0,0,0,1,0,9\n", "two columns are named x"),
        ("t,x,y,yaw,speed,steer\n", "at least 2 rows are needed, found 0"),
    ],
)
def test_read_csv_of_what_is_no_log_says_what_is_wrong(
    tmp_path: Path, text: str, message: str
) -> None:
    with pytest.raises(LogError, match=message):
        logs.read(_csv(tmp_path, text))


def test_read_of_a_missing_file_names_it(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"none\.csv: cannot be read: No such file"):
        logs.read(tmp_path / "none.csv")


@pytest.fixture
def columns() -> dict[str, Any]:
    pytest.importorskip("rosbags")
    return _columns()


@pytest.mark.parametrize("mcap", [True, False])
def test_read_bag_gives_back_what_was_driven(
    tmp_path: Path, columns: dict[str, Any], mcap: bool
) -> None:
    log = logs.read(write_bag(tmp_path / "bag", columns, mcap=mcap))
    for name, values in columns.items():
        # The clock is that of the car, the message's angle a float32.
        tolerance = {"t": 1e-6, "steer": 1e-7}.get(name, 1e-12)
        assert log.as_dict()[name] == pytest.approx(values, abs=tolerance), name
    assert log.remarks == ()


def test_read_bag_of_measured_angles_without_stamps_says_so(
    tmp_path: Path, columns: dict[str, Any]
) -> None:
    kind = "autoware_vehicle_msgs/msg/SteeringReport"
    log = logs.read(write_bag(tmp_path / "bag", columns, steering=kind, stamped=False))
    assert log.steer == pytest.approx(columns["steer"], abs=1e-7)
    first, second = log.remarks
    assert first == "messages without stamps: their times of recording are taken"
    assert "has measured angles" in second


def test_read_bag_without_the_topic_names_those_there_are(
    tmp_path: Path, columns: dict[str, Any]
) -> None:
    file = write_bag(tmp_path / "bag", columns)
    with pytest.raises(LogError, match=r"no topic '/steer'; there are: /control/drive \(ackermann"):
        logs.read(file, topics={"steer": "/steer"})
    with pytest.raises(LogError, match="/control/drive is of type ackermann_msgs"):
        logs.read(file, topics={"odometry": "/control/drive"})
    with pytest.raises(LogError, match="columns and an origin are of tables"):
        logs.read(file, columns={"t": "time"})


def test_read_bag_whose_clocks_share_no_time_is_refused(
    tmp_path: Path, columns: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    file = write_bag(tmp_path / "bag", columns)
    from popsteer.logs import bag

    whole = bag._read

    def later(*arguments: Any) -> Any:
        rows = whole(*arguments)
        if rows.shape[1] == 3:  # the angles
            rows[:, :2] += 1e4
        return rows

    monkeypatch.setattr(bag, "_read", later)
    with pytest.raises(LogError, match="have no time in common"):
        logs.read(file)
    assert START > 0.0


def test_read_bag_whose_index_has_another_time_than_its_messages_is_one_line(
    tmp_path: Path,
) -> None:
    pytest.importorskip("rosbags")
    t = 0.1 * np.arange(50)
    columns = {"t": t, "x": t, "y": 0 * t, "yaw": 0 * t, "speed": 0 * t + 1, "steer": 0 * t}
    file = write_bag(tmp_path / "bag", columns)
    raw, begin = file.read_bytes(), struct.pack("<Q", round(START * 1e9))
    # The last but one is of the index of chunks, the last of the statistics.
    at = raw.rindex(begin, 0, raw.rindex(begin))
    file.write_bytes(raw[:at] + struct.pack("<Q", 2**63) + raw[at + 8 :])
    with pytest.raises(LogError, match="promises messages that are not there"):
        logs.read(file)


@pytest.mark.parametrize("name", ["broken.mcap", "broken.db3"])
def test_read_bag_of_a_broken_file_is_one_line(tmp_path: Path, name: str) -> None:
    pytest.importorskip("rosbags")
    file = tmp_path / name
    file.write_bytes(b"no bag")
    with pytest.raises(LogError, match="read") as refused:
        logs.read(file)
    assert "\n" not in str(refused.value)
