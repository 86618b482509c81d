"""What was written is read back with care: damage, bombs, pipes and changed code are refused."""

from __future__ import annotations

import base64
import contextlib
import io
import json
import os
import sys
import threading
import zlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import files, own
from popsteer.errors import ConfigError, PopsteerError, printable
from popsteer.lab import sweep, tune
from popsteer.lab.common.varied import distribution
from popsteer.lab.sweep import rows
from popsteer.lab.sweep.job import from_text
from popsteer.parameters import Parameters
from tests.cli.command import call
from tests.fuzz import read_back

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

pytest.importorskip("scipy")

TURN = 0.05 * np.arange(60)
BEND = np.column_stack((20.0 * np.sin(TURN), 20.0 * (1.0 - np.cos(TURN))))
MINE = """
import popsteer
from helper import GAIN

class Own:
    def __init__(self, path, vehicle):
        self.path = path

    def step(self, x, y, yaw, speed, dt):
        from package.late import SIGN
        return SIGN * GAIN * (y - self.path.y[0])

class Car:
    name, reverses = "own", True

    def __init__(self, params):
        self.vehicle = popsteer.Vehicle(wheelbase=2.0)
"""


@dataclass(frozen=True)
class Gain(Parameters):
    gain: float = 0.5


def _job(**changes: Any) -> sweep.Job:
    vary = {"start_offset": distribution("start_offset", "uniform(-0.3,0.3)")}
    given: dict[str, Any] = {"vary": vary, "runs": 4, "seed": 2, "constant_speed": 5.0, **changes}
    path = given.pop("path", popsteer.Path(BEND))
    controller, plant = given.pop("controller", "pop"), given.pop("plant", "kinematic-bicycle")
    params = given.pop("params", popsteer.PopParams())
    return sweep.Job(path, controller, params, plant, **given)


@pytest.mark.usefixtures("_blank_figures")
def test_damaged_files_are_read_or_refused_in_one_line() -> None:
    counts, faults = read_back.run(72, 7)
    assert not faults
    read = sum(count for name, count in counts.items() if name.endswith(" read"))
    assert 0.1 * counts.total() < read < 0.9 * counts.total(), counts


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda t: t[:-1], "1 of 4 runs are missing at its end"),
        (lambda t: t[:3] + t[4:], "line 4: run must be 1, got 2"),
        (lambda t: [*t[:4], t[3], *t[4:]], "line 5: run must be 2, got 1"),
        (lambda t: [*t[:3], "", *t[3:]], "line 4 has 0 entries for "),
        (
            lambda t: [*t[:2], t[2].replace("True", "yes", 1), *t[3:]],
            "line 3: finished must be True",
        ),
        (lambda t: [*t[:2], t[2].replace(",0.", ",O.", 1), *t[3:]], "line 3: start_offset must be"),
        (lambda t: [*t[:2], t[2].replace(",", ",9", 1), *t[3:]], "line 3: seed must be "),
        (lambda t: [t[0], t[1].replace("seed", "seeds"), *t[2:]], "the columns are not those"),
        (lambda t: [t[0].replace('"runs":4', '"runs":4.0'), *t[1:]], "runs must be a whole number"),
        (lambda t: [t[0].replace('"course":""', '"course":5'), *t[1:]], "course must be text"),
    ],
)
def test_file_of_a_sweep_with_a_damaged_line_names_it(
    tmp_path: Path, change: Any, said: str
) -> None:
    file = tmp_path / "s.csv"
    sweep.run(_job(), file)
    lines = file.read_text().splitlines()
    file.write_text("\n".join(change(lines)) + "\n")
    for read in (lambda: rows.read(file), lambda: sweep.run(_job(), file)):
        with pytest.raises(PopsteerError) as refused:
            read()
        assert str(refused.value).startswith(f"{file}: ")
        assert said in str(refused.value) or "holds another sweep" in str(refused.value)


def test_journal_with_a_blank_or_broken_line_names_it(tmp_path: Path) -> None:
    found = sweep.run(_job())
    file = rows.journal_of(tmp_path / "s.csv")
    lines = [_job().text, *map(json.dumps, found[:3])]
    for number, broken in enumerate(("", lines[2][:50], "[1]", lines[1]), start=1):
        there = [*lines[:number], broken, *lines[number:]]
        file.write_text("\n".join(there) + "\n")
        before = file.read_bytes()
        with pytest.raises(PopsteerError, match=f"line {number + 1}"):
            sweep.run(_job(), tmp_path / "s.csv")
        assert file.read_bytes() == before


def test_run_of_a_file_that_cannot_be_driven_names_the_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = sweep.run(_job())
    document = json.loads(_job().text)
    document["plant"]["vehicle"]["rear_axle"] = 9.5
    file = rows.journal_of(tmp_path / "s.csv")
    lines = (json.dumps(each, separators=(",", ":")) for each in (document, found[1]))
    file.write_text("\n".join(lines) + "\n")
    done = call(capsys, "sweep", "--run", f"{file}:1")
    assert done.status == 2
    assert done.err.startswith(f"popsteer: {file}: rear_axle must be that of the plant, 9.5, got ")


def test_bombs_are_refused_unopened(tmp_path: Path) -> None:
    document = json.loads(_job().text)
    packed = zlib.compress(bytes(800_000_000 + 8), 9)
    document["path"]["x"] = base64.b64encode(packed).decode()
    with pytest.raises(PopsteerError, match="more than 10,000,000 numbers"):
        from_text(json.dumps(document, separators=(",", ":")))
    arrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    table = arrow.table({"run": np.zeros(5_000_000, dtype=np.int64)})
    stream = io.BytesIO()
    parquet.write_table(table, stream, compression="zstd")
    assert len(stream.getvalue()) < 100_000
    (tmp_path / "s.parquet").write_bytes(stream.getvalue())
    with pytest.raises(PopsteerError, match="no Parquet file of a sweep: 5000000 rows"):
        rows.read(tmp_path / "s.parquet")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes with a name")
def test_pipe_is_read_to_its_end_and_not_waited_for_without_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    text = "x,y\n" + "".join(f"{x},0\n" for x in range(20_000))
    threading.Thread(target=lambda: pipe.write_text(text)).start()
    assert len(popsteer.Path.from_csv(pipe)) == 20_000
    monkeypatch.setattr(files, "_PATIENCE", 0.1)
    done = call(capsys, "plan", str(pipe))
    assert done.status == 2
    assert done.err == f"popsteer: {pipe}: cannot be read: nothing is written into it for 0.1 s\n"
    for kind, words in (("mcap", ["replay", "FILE"]), ("journal", ["tune", "--storage", "FILE"])):
        other = tmp_path / f"pipe.{kind}"
        os.mkfifo(other)
        done = call(capsys, *(word.replace("FILE", str(other)) for word in words))
        assert done.status == 2
        assert done.err.startswith(f"popsteer: {other}: ")
    # Nor for one that nobody reads.
    (tmp_path / "path.csv").write_text("x,y\n0,0\n10,0\n20,0\n")
    done = call(capsys, "plan", str(tmp_path / "path.csv"), "--out", str(pipe))
    assert done.status == 2
    assert done.err == f"popsteer: {pipe}: nobody reads it for 0.1 s\n"
    monkeypatch.setattr(files, "_PATIENCE", 30.0)
    read: list[str] = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_text()))
    reader.start()
    files.write_text_atomic(pipe, text)
    reader.join()
    assert read == [text]
    monkeypatch.setattr(files, "_MOST_PIPED", 50_000)
    threading.Thread(target=lambda: _try(lambda: pipe.write_text(text))).start()
    with pytest.raises(OSError, match=r"writes more than 50,000 bytes"):
        files.read_bytes(pipe)


def _try(write: Any) -> None:
    with contextlib.suppress(BrokenPipeError):
        write()


def test_message_is_short_and_has_no_control_characters(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done = call(capsys, "plan", "a\x1b[31m\x07b\u202e.csv")
    assert done.status == 2
    assert done.err == (
        "popsteer: a\\x1b[31m\\x07b\\u202e.csv: cannot be read: No such file or directory\n"
    )
    done = call(capsys, "compare", "--waypoints", f"{'x' * 9_000}.csv", "--track", "y" * 9_000)
    assert len(done.err) < 800
    file = tmp_path / "a\x1b[31mb.csv"
    file.write_text("x,y\n" + "".join(f"{x},{y}\n" for x, y in BEND.tolist()))
    assert "\x1b" not in call(capsys, "plan", str(file), "--out", f"{file}.csv").out
    assert printable("ψ, 3 m") == "ψ, 3 m"


# Of each kind of path: what is told of it, beside the waypoints.
KINDS: dict[str, dict[str, Any]] = {
    "plain": {},
    "as it stands": {"mend": False},
    "spline": {"yaw": "spline"},
    "heading": {"yaw": TURN + 0.02 * np.sin(3.0 * TURN)},
    "curvature": {"yaw": TURN, "curvature": np.full(60, 0.05)},
    "slope": {"grade": 0.1 * np.sin(TURN), "speed": np.full(60, 6.0)},
    "backwards": {"reverse": np.ones(60, dtype=bool), "speed": np.full(60, 3.0)},
}


@pytest.mark.parametrize("kind", KINDS)
def test_document_repeats_a_row_to_the_bit_for_each_kind_of_path(kind: str) -> None:
    path = popsteer.Path(BEND, **KINDS[kind])
    speed: dict[str, Any] = {"constant_speed": None} if path.speed is not None else {}
    job = _job(path=path, **speed)
    again = from_text(job.text)
    assert again.text == job.text
    assert sweep.drive(again, range(4)) == sweep.drive(job, range(4))
    assert (kind == "plain") == (job.text == _job().text)


def test_lap_and_mended_path_repeat_to_the_bit() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 41)[:-1]
    lap = np.column_stack((20.0 * np.cos(turn), 20.0 * np.sin(turn)))
    swapped = np.insert(BEND, 30, BEND[29], axis=0)
    for path in (popsteer.Path(lap, closed=True, yaw="spline"), popsteer.Path(swapped)):
        job = _job(path=path)
        again = from_text(job.text)
        assert again.path.mended == path.mended
        assert sweep.drive(again, range(4)) == sweep.drive(job, range(4))


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    (tmp_path / "package").mkdir()
    (tmp_path / "package" / "late.py").write_text("SIGN = -1.0\n")
    (tmp_path / "helper.py").write_text("GAIN = 0.1\n")
    (tmp_path / "mine.py").write_text(MINE)
    (tmp_path / "other.py").write_text("raise SystemExit\n")
    yield tmp_path
    for name in ("helper", "package", "package.late"):
        sys.modules.pop(name, None)


def test_code_of_a_name_is_all_that_it_imports_below_its_folder(here: Path) -> None:
    found = own.code("controller", "mine.py:Own")
    assert list(found) == ["helper.py", "mine.py", "package/late.py"]
    assert own.changed("controller", "mine.py:Own", found) is None
    (here / "package" / "late.py").write_text("SIGN = 1.0\n")
    assert own.changed("controller", "mine.py:Own", found) == "package/late.py"
    assert own.code("controller", "pop") == {}


def test_sweep_and_study_of_changed_code_are_refused(here: Path) -> None:
    def job() -> sweep.Job:
        return _job(controller="mine.py:Own", params=own.params_of(object)())

    def problem() -> tune.Problem:
        known = distribution("gain", "uniform(0,1)")
        base: Any = Gain()
        search, car = {"gain": known}, popsteer.sim.KinematicBicycle()
        paths = {"bend": popsteer.Path(BEND)}
        return tune.Problem(paths, "mine.py:Own", base, search, car, {}, 0, constant_speed=2.0)

    tune.run(problem(), here / "t.journal", trials=1)
    sweep.run(job(), here / "s.csv", workers=1)
    assert rows.read(here / "s.csv", ["mine.py:Own"])[0].text == job().text
    (here / "helper.py").write_text("GAIN = 0.2\n")
    with pytest.raises(PopsteerError, match=r"holds another sweep, which differs in files"):
        sweep.run(job(), here / "s.csv")
    with pytest.raises(PopsteerError, match=r"differs in files"):
        tune.run(problem(), here / "t.journal", trials=1)
    with pytest.raises(PopsteerError, match=r"mine.py:Own is not there .*: helper.py is another"):
        rows.read(here / "s.csv", ["mine.py:Own"])


def test_file_runs_no_code_that_is_not_named(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = _job(controller="mine.py:Own", params=own.params_of(object)())
    text = job.text.replace("mine.py:Own", "ran:Own")
    (here / "ran.py").write_text("open('it-ran', 'w').close()\nOwn = None\n")
    (here / "s.csv.part").write_text(text + "\n")
    with pytest.raises(PopsteerError, match="code of your own: name it by --controller ran:Own"):
        rows.read(here / "s.csv.part")
    with pytest.raises(PopsteerError, match="differs in controller"):
        sweep.run(_job(), here / "s.csv")
    (here / "tuned.toml").write_text('["ran:Own"]\n')
    for options in ([], ["--controllers", "pop"]):
        done = call(capsys, "compare", *options, "--params", "tuned.toml")
        assert done.status == 2
        assert "table must be code of your own that the command line names" in done.err
    assert not (here / "it-ran").exists()


def test_draws_out_of_range_of_a_plant_in_python_are_refused_before_the_first_run(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from tests.cli.test_own import BROKEN

    (here / "car.py").write_text(BROKEN)
    vary = {"dead_time": distribution("dead_time", "normal(0.1,0.1)")}
    job = _job(plant="car.py:Car", vary=vary, runs=30)
    monkeypatch.setattr(sweep.runs, "on_processes", lambda *_: pytest.fail("a run was driven"))
    with pytest.raises(ConfigError, match=r"run \d+: dead_time must be in \[0, "):
        sweep.run(job, here / "s.csv")


def test_study_with_a_damaged_journal_names_the_line(tmp_path: Path) -> None:
    pytest.importorskip("optuna")
    search = {"min_lookahead": distribution("min_lookahead", "uniform(2,12)")}
    params = popsteer.PopParams()
    problem = tune.Problem(
        {"bend": popsteer.Path(BEND)},
        "pop",
        params,
        search,
        popsteer.sim.KinematicBicycle(),
        {},
        0,
        constant_speed=2.0,
    )
    file = tmp_path / "t.journal"
    tune.run(problem, file, trials=2)
    lines = file.read_text().splitlines()
    create = [k for k, line in enumerate(lines) if line.startswith('{"op_code":4')]
    worst = next(k for k, line in enumerate(lines) if '"worst"' in line)
    done = next(k for k, line in enumerate(lines) if line.startswith('{"op_code":6'))
    for changed, number in (
        ([*lines[:4], "", *lines[4:]], 5),
        ([*lines[:4], lines[4][:30], *lines[5:]], 5),
        (lines[: create[1]] + lines[create[1] + 1 :], create[1] + 1),
        (lines[:worst] + lines[worst + 1 :], done),
        (
            [*lines[:worst], lines[worst].replace('"worst":', '"worst":-'), *lines[worst + 1 :]],
            done + 1,
        ),
    ):
        file.write_text("\n".join(changed) + "\n")
        before = file.read_bytes()
        with pytest.raises(PopsteerError, match=rf"t\.journal, line {number}: "):
            tune.run(problem, file, trials=2)
        assert file.read_bytes() == before


def test_packed_bag_is_read_and_unpacks_to_no_more_than_it_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    storage = pytest.importorskip("rosbags.rosbag2.storage_mcap")
    lz4 = pytest.importorskip("lz4.frame")
    from popsteer import logs
    from popsteer.logs import bag
    from tests.bags import write_bag

    t = 0.05 * np.arange(40)
    columns = {"t": t, "x": 5.0 * t, "y": 0.0 * t, "yaw": 0.0 * t, "v": 5.0 + 0.0 * t}
    columns["steer"] = 0.1 * np.sin(t)
    plain = logs.read(write_bag(tmp_path / "plain", columns))
    file = write_bag(tmp_path / "packed", columns, packed="STORAGE")
    assert (logs.read(file).steer == plain.steer).all()
    for kind, pack in (("zstd", storage.zstd.compress), ("lz4", lz4.compress)):
        found = storage.DECOMPRESSORS[kind](pack(bytes(50_000_000)), 1000)
        assert len(found) == 1001  # one more than was said, which rosbags refuses
    monkeypatch.setattr(bag, "_MOST_OF_CHUNK", 1000)
    with pytest.raises(logs.LogError, match=r"a chunk of [0-9,]+ bytes, more than 1,000"):
        logs.read(file)


@pytest.mark.parametrize("how", ["FILE", "MESSAGE"])
def test_packed_file_or_message_of_a_bag_unpacks_within_a_bound(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, how: str
) -> None:
    pytest.importorskip("rosbags.rosbag2")
    from popsteer import logs
    from popsteer.logs import bag
    from tests.bags import write_bag

    t = 0.05 * np.arange(40)
    columns = {"t": t, "x": 5.0 * t, "y": 0.0 * t, "yaw": 0.0 * t, "v": 5.0 + 0.0 * t}
    columns["steer"] = 0.1 * np.sin(t)
    file = write_bag(tmp_path / "packed", columns, mcap=False, packed=how)
    assert bool([*file.glob("*.zstd")]) == (how == "FILE")
    assert len(logs.read(file).steer) == 40
    monkeypatch.setattr(bag, "_MOST_OF_CHUNK", 100)
    monkeypatch.setattr(bag, "_MOST_PACKED", 1)
    with pytest.raises(logs.LogError, match=r"unpacks to more than [0-9,]+ bytes"):
        logs.read(file)
