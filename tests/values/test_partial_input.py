"""Input that is partial or mixed: units, stamps, half lines, gaps, columns, interruptions."""

from __future__ import annotations

import json
import math
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from popsteer import PopsteerError, logs
from popsteer.lab.sweep import rows as files
from popsteer.lab.sweep import run
from popsteer.logs import Log, LogError
from popsteer.logs.log import COLUMNS, _rising
from popsteer.logs.units import UNITS, factor
from tests.bags import START, write_bag
from tests.values.tables import job

if TYPE_CHECKING:
    from pathlib import Path

PEDALS = ("throttle", "brake")
# One of each, in the unit of popsteer: by the definitions, not by the table.
SIZES = {
    ("t", "s"): 1.0,
    ("t", "ms"): 1e-3,
    ("t", "us"): 1e-6,
    ("t", "ns"): 1e-9,
    ("t", "min"): 60.0,
    ("t", "h"): 3600.0,
    ("t", "day"): 86400.0,
    **{
        (name, unit): size
        for name in "xyz"
        for unit, size in (
            ("m", 1.0),
            ("cm", 0.01),
            ("mm", 0.001),
            ("km", 1e3),
            ("in", 0.0254),
            ("ft", 0.3048),
        )
    },
    **{(name, "rad"): 1.0 for name in ("yaw", "steer")},
    **{(name, "mrad"): 1e-3 for name in ("yaw", "steer")},
    **{(name, "deg"): math.pi / 180.0 for name in ("yaw", "steer")},
    **{
        (name, unit): size
        for name in ("speed", "speed_command")
        for unit, size in (
            *(("m/s", 1.0), ("cm/s", 0.01), ("mm/s", 0.001)),
            *(("in/s", 0.0254), ("ft/s", 0.3048)),
            *(("km/h", 1000.0 / 3600.0), ("mph", 1609.344 / 3600.0), ("kn", 1852.0 / 3600.0)),
        )
    },
    ("yaw", "rad-north"): -1.0,
    ("yaw", "deg-north"): -math.pi / 180.0,
    **{(name, unit): size for name in PEDALS for unit, size in (("1", 1.0), ("%", 0.01))},
    ("acceleration_command", "m/s²"): 1.0,
    ("acceleration_command", "g"): 9.80665,
}
T = 0.1 * np.arange(20)


def _columns() -> dict[str, Any]:
    return {
        "t": T,
        "x": 8.0 * T,
        "y": 0.3 * T,
        "yaw": 0.5 * np.sin(T),
        "speed": 8.0 + 0.1 * T,
        "steer": 0.01 * T + 0.02,
    }


def _write(file: Path, columns: dict[str, Any]) -> Path:
    lines = [",".join(columns)]
    lines += [
        ",".join(repr(float(v)) for v in each) for each in zip(*columns.values(), strict=True)
    ]
    file.write_text("\n".join(lines) + "\n")
    return file


def test_every_unit_of_every_column_is_its_definition(tmp_path: Path) -> None:
    assert {(name, unit) for name in UNITS for unit in UNITS[name]} == set(SIZES)
    for (name, unit), size in SIZES.items():
        assert factor(name, unit) == pytest.approx(size, rel=1e-12), (name, unit)
        whole = _columns() | {name: _columns().get(name, 0.02 * T)}
        east = 0.5 * math.pi if unit.endswith("north") else 0.0
        columns = whole | {name: (whole[name] - east) / size}
        log = logs.read(_write(tmp_path / "log.csv", columns), units={name: unit})
        for key, values in whole.items():
            found = log.as_dict() | dict(log.signals)
            assert found[key] == pytest.approx(values, rel=1e-9, abs=1e-9), (name, unit)


def test_every_unit_of_a_bag_is_its_definition(tmp_path: Path) -> None:
    pytest.importorskip("rosbags")
    bag = write_bag(tmp_path / "bag", _columns())
    plain = logs.read(bag).as_dict()
    units = {
        name: unit
        for name, unit in SIZES
        if name in plain and name != "t" and SIZES[name, unit] != 1.0 and "north" not in unit
    }
    log = logs.read(bag, units=units)
    for name, unit in units.items():
        expected = plain[name] * SIZES[name, unit]
        assert log.as_dict()[name] == pytest.approx(expected, rel=1e-12), name
    assert log.commands is not None
    held = log.commands[1]
    assert held == pytest.approx(plain["steer"] * math.pi / 180.0, rel=1e-6)
    turned = logs.read(bag, units={"steer": "-1"})
    assert turned.steer == pytest.approx(-plain["steer"])


def test_bag_whose_stamps_begin_late_is_read_by_the_recording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("rosbags")
    from popsteer.logs import bag

    file = write_bag(tmp_path / "bag", _columns())
    whole = bag._read
    for width in (6, 3):  # the poses, then the angles

        def part(*arguments: Any, width: int = width) -> Any:
            found = whole(*arguments)
            found[:, 0] += 500.0  # the car's clock is not the recorder's
            if found.shape[1] == width:
                found[:7, 0] = np.nan
            return found

        monkeypatch.setattr(bag, "_read", part)
        log = logs.read(file)
        assert log.remarks[0].startswith("messages without stamps")
        assert log.t == pytest.approx(T, abs=1e-6)
        assert log.steer == pytest.approx(_columns()["steer"], abs=1e-7)
    assert START > 0.0


def test_stamps_within_the_first_second_of_a_clock_are_stamps() -> None:
    from types import SimpleNamespace

    from popsteer.logs import bag

    times = [(0, 0), (0, 40_000_000), (1, 0), (2, 5)]
    stamps = [SimpleNamespace(stamp=SimpleNamespace(sec=a, nanosec=b)) for a, b in times]
    connection = SimpleNamespace(msgcount=4, msgtype="kind")
    reader = SimpleNamespace(
        messages=lambda _: [(connection, 10**9 * (50 + k), k) for k in range(4)],
        deserialize=lambda k, _: stamps[k],
    )
    told: list[float] = []
    for stamp, own in ((("stamp",), [math.nan, 0.04, 1.0, 2.000000005]), (None, [math.nan] * 4)):
        found = bag._read(reader, [connection], stamp, lambda _: (7.0,), told.append, 0.5)
        assert found[:, 0] == pytest.approx(own, nan_ok=True)
        assert found[:, 1] == pytest.approx([50.0, 51.0, 52.0, 53.0])
        assert found[:, 2].tolist() == [7.0] * 4
    assert told == [0.5, 0.5]


def test_topic_without_messages_is_none_unless_it_is_asked_for() -> None:
    from types import SimpleNamespace

    from popsteer.logs import bag

    there: list[Any] = [
        SimpleNamespace(topic="/first", msgtype="better", msgcount=0),
        SimpleNamespace(topic="/second", msgtype="good", msgcount=3),
        SimpleNamespace(topic="/third", msgtype="good", msgcount=0),
    ]
    path: Any = "bag"
    types = ("better", "good")
    assert bag._choose(path, there, "steer", types, {}) == [there[1]]
    assert bag._choose(path, there, "steer", types, {"steer": "/first"}) == [there[0]]
    there[0].msgcount = 1
    assert bag._choose(path, there, "steer", types, {}) == [there[0]]
    for each in there:
        each.msgcount = 0
    with pytest.raises(LogError, match="no topic of better or good for steer"):
        bag._choose(path, there, "steer", types, {})


def test_angles_hold_from_their_own_times_and_come_in_any_order() -> None:
    times, angles = [0.35, 0.05, 0.05, math.nan, 0.9], [3.0, 1.0, 2.0, 9.0, math.nan]
    log = Log(**_columns(), commands=(times, angles))
    assert log.commands is not None
    # Of two at one time the last counts; what is not finite is left out.
    assert log.commands[0].tolist() == [0.05, 0.35]
    assert log.commands[1].tolist() == [2.0, 3.0]
    for bad in (([0.0, 1.0], [0.0]), ([], [])):
        with pytest.raises(LogError, match="as many angles as times"):
            Log(**_columns(), commands=bad)


def test_row_of_a_bag_has_the_command_that_holds_then(tmp_path: Path) -> None:
    pytest.importorskip("rosbags")
    from popsteer.logs import bag
    from popsteer.logs.messages import STEERING

    poses = np.array([[10.0 + 0.1 * k, math.nan, 0.0, 0.0, 0.0, 5.0] for k in range(5)])
    angles = np.array([[10.31, 0.0, 0.3], [10.11, 0.0, 0.1], [10.2, 0.0, 0.2]])
    kind = next(iter(STEERING.values()))
    log = bag._log(tmp_path, poses, angles, kind, {}, "/drive", ["pose (/odom)"])
    assert log.t == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert log.steer == pytest.approx([0.1, 0.1, 0.2, 0.2, 0.3])


def test_rows_out_of_order_and_gaps_are_found_where_they_are() -> None:
    columns = _columns()
    columns["t"] = np.concatenate((T[:10], T[10:] + 0.25, [0.5]))
    others = {name: np.append(each, 1.0) for name, each in _columns().items() if name != "t"}
    log = Log(**{**others, "t": columns["t"]})
    assert len(log) == 20
    assert log.gaps == ()
    assert log.steps[10] == pytest.approx(0.35)
    columns["t"][10:20] += 0.2
    log = Log(**{**others, "t": columns["t"]})
    assert log.gaps == (10,)
    assert log.steps[10] == pytest.approx(0.1)
    assert log.steps[0] == pytest.approx(0.1)
    assert log.period == pytest.approx(0.1)
    assert log.duration == pytest.approx(1.9 + 0.45)


def test_short_periods_have_gaps_of_three_tenths_of_a_second_at_least() -> None:
    for period, step, gaps in ((0.01, 0.29, 0), (0.01, 0.31, 1), (0.1, 0.49, 0), (0.1, 0.51, 1)):
        t = np.concatenate((period * np.arange(50), 49 * period + step + period * np.arange(50)))
        log = Log(t, *np.zeros((5, 100)))
        assert len(log.gaps) == gaps, (period, step)


def test_columns_in_any_order_with_others_between_are_read_by_name(tmp_path: Path) -> None:
    columns = _columns()
    mixed = {"note": 7.0 + 0.0 * T, **{name: columns[name] for name in reversed(COLUMNS)}}
    log = logs.read(_write(tmp_path / "log.csv", mixed))
    for name, values in columns.items():
        assert log.as_dict()[name] == pytest.approx(values), name


def test_journal_is_whole_after_each_of_two_interruptions(tmp_path: Path) -> None:
    sweep = job(runs=9)
    rows = run(sweep)
    part = tmp_path / "sweep.csv.part"
    lines = [json.dumps(row, separators=(",", ":")) for row in rows]
    for cut in (1, 20, len(lines[4]) - 1, len(lines[4])):
        part.write_text("\n".join([sweep.text, *lines[:4], lines[4][:cut]]))
        for count in (4, 6):  # another row comes, and half of one after it
            with files.Journal(part, sweep) as journal:
                assert sorted(journal.rows) == list(range(count)), cut
                journal.add(rows[: count + 1])
                journal.add([rows[count + 1]])
            with part.open("a") as stream:
                stream.write(lines[8][:cut])
        again, found = files.read(part)
        assert again.text == sweep.text
        assert found == rows[:8]
    # Killed within its first line, or before it: there is nothing to lose.
    for begun in ("", sweep.text[:30], sweep.text):
        part.write_text(begun)
        with files.Journal(part, sweep) as journal:
            assert journal.rows == {}
            journal.add(rows[:1])
        assert files.read(part)[1] == rows[:1]
    part.write_text("another file")
    with pytest.raises(PopsteerError, match="no sweep"), files.Journal(part, sweep):
        pass
    assert part.read_text() == "another file"


def test_rows_that_are_kept_are_the_most_whose_times_rise() -> None:
    random = np.random.default_rng(0)
    for count in (1, 2, 3, 5, 7, 9):
        for _ in range(12):
            times = random.integers(0, 7, count).astype(float)
            kept = _rising(times).tolist()
            assert kept == sorted(set(kept))
            assert (np.diff(times[kept]) > 0.0).all()
            most = max(
                len(rows)
                for size in range(1, count + 1)
                for rows in combinations(range(count), size)
                if (np.diff(times[list(rows)]) > 0.0).all()
            )
            assert len(kept) == most, times
    assert _rising(np.zeros(0)).tolist() == []
    # Of rows of one time the first counts.
    assert _rising(np.array([0.0, 1.0, 1.0, 2.0])).tolist() == [0, 1, 3]
