"""Where a command is to write: refused before anything is driven, written whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path
from typing import NoReturn

import numpy as np
import pytest

from popsteer import lab
from popsteer.cli import outputs
from popsteer.errors import PopsteerError
from popsteer.lab.stability import figures
from tests.cli import command
from tests.helpers import looped

# Each command that writes, up to the place to write to.
FOLDERS = {
    "compare": ("compare", "--controllers", "pop", "--track", "straight", "--out"),
    "several": ("compare", "--controllers", "pop", "--tracks", "straight,circle", "--out"),
    "stability": ("stability", "--speeds", "5", "--out"),
    "tracks": ("tracks", "--out"),
}
FILES = {
    "plan": ("plan", "read-later.csv", "--out"),
}
each_folder = looped("arguments", FOLDERS.values())
each_file = looped("arguments", FILES.values())
each = looped("arguments", [*FOLDERS.values(), *FILES.values()])


@pytest.fixture
def _parked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fails the test where something is driven, computed or measured."""

    def refuse(*_: object, **__: object) -> NoReturn:
        pytest.fail("the work was done before the output was refused")

    for experiment, work in ((lab.compare, "run_each"), (lab.stability, "run")):
        monkeypatch.setattr(experiment, work, refuse)


def _refused(
    capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], place: Path, reason: str
) -> None:
    outcome = command.call(capsys, *arguments, str(place))
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err.startswith(f"popsteer: {place}")
    assert outcome.err.endswith(f": {reason}\n")
    assert outcome.err.count("\n") == 1


@pytest.mark.usefixtures("_parked")
@each_folder
def test_folder_that_is_a_file_is_refused_before_the_work(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    taken = tmp_path / "taken"
    taken.write_text("mine", encoding="utf-8")
    _refused(capsys, arguments, taken, "Not a directory")
    assert list(tmp_path.iterdir()) == [taken]
    assert taken.read_text(encoding="utf-8") == "mine"


@pytest.mark.usefixtures("_parked")
@each
def test_output_below_a_file_is_refused_before_the_work(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    taken = tmp_path / "taken"
    taken.write_text("mine", encoding="utf-8")
    _refused(capsys, arguments, taken / "deeper", "Not a directory")
    assert list(tmp_path.iterdir()) == [taken]
    assert taken.read_text(encoding="utf-8") == "mine"


@pytest.mark.usefixtures("_parked")
@each_file
def test_file_that_is_a_folder_is_refused_before_the_work(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    _refused(capsys, arguments, tmp_path, "Is a directory")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("_parked")
@looped("below", ["", "deeper"])
@each
def test_output_to_a_loop_of_links_is_refused_before_the_work(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, arguments: tuple[str, ...], below: str
) -> None:
    loop = tmp_path / "loop"
    loop.unlink(missing_ok=True)
    loop.symlink_to(loop)
    _refused(capsys, arguments, loop / below, "Too many levels of symbolic links")
    assert list(tmp_path.iterdir()) == [loop]


@pytest.mark.usefixtures("_parked")
@each
def test_output_with_an_impossible_name_is_refused_before_the_work(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    _refused(capsys, arguments, tmp_path / ("a" * 300), "File name too long")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("_parked")
@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="there is no /proc here")
@each
def test_output_where_even_root_cannot_write_is_refused_before_the_work(
    capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...]
) -> None:
    outcome = command.call(capsys, *arguments, "/proc/popsteer")
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err.startswith("popsteer: /proc/popsteer: ")
    assert outcome.err.count("\n") == 1


@pytest.mark.usefixtures("_parked")
@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
@each
def test_output_without_permission_is_refused_before_the_work(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    tmp_path.chmod(0o500)
    try:
        _refused(capsys, arguments, tmp_path / "out", "Permission denied")
    finally:
        tmp_path.chmod(0o700)


@pytest.mark.usefixtures("_parked")
@looped(
    ("name", "taken"),
    [
        ("compare", "runs/pop.csv"),
        ("compare", "overview-dark.svg"),
        ("several", "matrix.json"),
        ("stability", "stability-map-dark.png"),
        ("several", "matrix.md"),
        ("tracks", "straight.csv"),
    ],
)
def test_folder_with_a_name_taken_by_a_folder_is_refused_before_the_work(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, name: str, taken: str
) -> None:
    folder = tmp_path / taken.replace("/", "-")
    (folder / taken).mkdir(parents=True)
    before = sorted(folder.rglob("*"))
    _refused(capsys, FOLDERS[name], folder, "Is a directory")
    assert sorted(folder.rglob("*")) == before


@pytest.mark.usefixtures("_parked")
def test_folder_whose_runs_are_a_file_is_refused_before_the_work(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "runs").write_text("mine", encoding="utf-8")
    _refused(capsys, FOLDERS["compare"], tmp_path, "Not a directory")
    assert [file.name for file in tmp_path.iterdir()] == ["runs"]


@pytest.mark.usefixtures("_coarse", "_blank_figures")
@pytest.mark.parametrize("name", ["compare", "several", "stability", "tracks"])
def test_each_name_that_is_written_was_checked(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    name: str,
) -> None:
    checked: list[str] = []
    monkeypatch.setattr("popsteer.files.check_folder", lambda folder, names: checked.extend(names))
    # Coarse figures of stability have the same names.
    monkeypatch.setattr(figures, "_SPEEDS", np.linspace(1.0, 30.0, 4))
    monkeypatch.setattr(figures, "_DISTANCES", np.geomspace(1.0, 25.0, 4))
    out = tmp_path / "out"
    outcome = command.call(capsys, *FOLDERS[name], str(out))
    assert outcome.status == 0
    written = {file.relative_to(out).as_posix() for file in out.rglob("*") if file.is_file()}
    # Which figures of stability there are depends on the controllers; this time all.
    assert written == set(checked)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


REPORTED = {
    "compare": ("of_comparison", "results.png", ["--controllers", "pop", "--out", "out"]),
    "several": (
        "of_comparison",
        "matrix.csv",
        ["--controllers", "pop", "--plants", "kinematic-bicycle,carla-identified"],
    ),
    "sweep": ("of_sweep", "", ["--controller", "pop", "--runs", "2", "--out", "s.csv"]),
}


@pytest.mark.usefixtures("_blank_figures")
@pytest.mark.parametrize("name", REPORTED)
def test_report_that_fails_loses_neither_files_nor_table(
    capsys: pytest.CaptureFixture[str], here: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    def fail(*_: object, **__: object) -> NoReturn:
        raise PopsteerError("a report of 9 bytes")

    report, file, options = REPORTED[name]
    monkeypatch.setattr(lab.report, report, fail)
    options += ["--out", "out"] if "--out" not in options else []
    options += ["--track", "circle", "--constant-speed", "6"]
    name = name.replace("several", "compare")
    done = command.call(capsys, name, *options, "--report", "page.html")
    assert (done.status, done.err) == (2, "popsteer: a report of 9 bytes\n")
    assert "circle" in done.out
    assert "Written to" in done.out
    assert "page.html" not in done.out
    assert (here / "out" / file if file else here / "s.csv").exists()
    assert not (here / "page.html").exists()


def test_page_is_written_where_nobody_reads_the_table(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def gone(*_: object) -> NoReturn:
        raise BrokenPipeError

    monkeypatch.setattr(outputs, "say", gone)
    with pytest.raises(BrokenPipeError):
        outputs.show("head", [], page=here / "page.html", draw=lambda _: b"page")
    assert (here / "page.html").read_bytes() == b"page"


def test_records_of_two_controllers_never_share_a_file() -> None:
    names = ["a.py:B", "a.py-B", "A.py:B", "pop", "a.py-B-2"]
    found = lab.compare.files.file_names(names)[: len(names)]
    assert found[0] == "runs/a.py-B.csv"
    assert len({each.lower() for each in found}) == len(names)


def test_record_is_whole_or_what_was_there(
    capsys: pytest.CaptureFixture[str], here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = pytest.importorskip("popsteer.adapters.ros2.recording")
    pytest.importorskip("rosbags")
    (here / "drive.mcap").write_text("mine")
    add, count = recording.Recording.add, iter(range(100))

    def full(*given: object) -> None:
        if next(count) > 50:
            raise OSError(28, "No space left on device")
        add(*given)

    line = ["compare", "--controllers", "pop", "--track", "circle", "--constant-speed", "6"]
    with monkeypatch.context() as patch:
        patch.setattr(recording.Recording, "add", full)
        done = command.call(capsys, *line, "--record", "drive.mcap")
    assert done.status == 2
    assert [file.name for file in here.iterdir()] == ["drive.mcap"]
    assert (here / "drive.mcap").read_text() == "mine"
    assert command.call(capsys, *line, "--record", "drive.mcap").status == 0
    assert (here / "drive.mcap").read_bytes().startswith(b"\x89MCAP")
