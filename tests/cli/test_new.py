"""`popsteer new`: a project that runs, written completely or not at all."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

import popsteer
from tests.cli import command

if TYPE_CHECKING:
    from pathlib import Path

FILES = {"README.md", "car.py", "drive.py", "test_drive.py", "vehicle.toml", "waypoints.csv"}


def _python(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    program = [sys.executable, "-W", "error", *arguments]
    return subprocess.run(program, cwd=folder, check=False, capture_output=True, text=True)


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("new") / "deep" / "my-car"
    outcome = command.run("new", str(folder))
    assert (outcome.status, outcome.err) == (0, "")
    assert f"Next: cd {folder} && python drive.py\n" in outcome.out
    assert {file.name for file in folder.iterdir()} == FILES
    assert {each.name for each in folder.parent.iterdir()} == {"my-car"}
    return folder


def test_project_drives_to_its_end(project: Path) -> None:
    ran = _python(project, "drive.py")
    assert (ran.returncode, ran.stderr) == (0, "")
    assert ran.stdout.startswith("arrived after ")
    settled = re.search(r"at most ([\d.]+) m off", ran.stdout)
    assert settled is not None
    assert float(settled[1]) < 0.1


CARS = """
import math, car, drive

class Wrong(car.Car):
    def actuate(self, steer, acceleration, seconds):
        super().actuate(-steer, acceleration, seconds)

class Degrees(car.Car):
    def actuate(self, steer, acceleration, seconds):
        super().actuate(math.degrees(steer), acceleration, seconds)

class Far(car.Car):
    def localise(self):
        x, y, *others = super().localise()
        return x, y + 500.0, *others

class Blind(car.Car):
    def localise(self):
        return (math.nan,) * 4

for kind in Wrong, Degrees, Far, Blind:
    drive.Car = kind
    drive.main()
"""


def test_project_with_a_car_that_is_connected_wrongly_says_what_is_wrong(project: Path) -> None:
    ran = _python(project, "-c", CARS)
    assert (ran.returncode, ran.stderr) == (0, "")
    # At once, before there is anything to say of errors.
    said = [line.split(" after ")[0] for line in ran.stdout.splitlines()]
    assert said == ["fault: steering", "fault: steering", "fault: deviation", "no localisation"]


def test_names_of_folders_are_quoted_and_escaped(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done = command.call(capsys, "new", str(tmp_path / "my \x1b[31mcar"))
    assert f"Next: cd '{tmp_path}/my \\x1b[31mcar' && python drive.py\n" in done.out
    assert "\x1b" not in done.out


def test_tests_of_the_project_pass(project: Path) -> None:
    ran = _python(project, "test_drive.py")
    assert (ran.returncode, ran.stderr) == (0, "")
    assert len(set(re.findall(r"^(test_\w+): passed$", ran.stdout, re.MULTILINE))) == 3


def test_commands_of_the_readme_run(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(project)
    readme = (project / "README.md").read_text(encoding="utf-8")
    found = re.findall(r"popsteer (plan [^`\n]+|stability [^`\n]+)", readme)
    assert len(found) == 2
    for line in found:
        outcome = command.run(*line.split())
        assert (outcome.status, outcome.err) == (0, ""), line
    assert popsteer.Path.from_csv("course.csv").speed is not None


def test_test_of_the_project_fails_where_its_loop_is_broken(project: Path, tmp_path: Path) -> None:
    for file in FILES:
        text = (project / file).read_text(encoding="utf-8")
        text = text.replace("car.actuate(answer.steer, answer", "car.actuate(0.0, answer")
        (tmp_path / file).write_text(text, encoding="utf-8")
    assert _python(tmp_path, "test_drive.py").returncode == 1


def test_files_of_the_project_are_what_popsteer_reads(project: Path) -> None:
    vehicle = popsteer.Vehicle.load(project / "vehicle.toml")
    path = popsteer.Path.from_csv(project / "waypoints.csv")
    assert (vehicle.wheelbase, vehicle.rear_axle) == (2.7, -1.35)
    assert path.length > 200.0
    readme = (project / "README.md").read_text(encoding="utf-8")
    assert readme.startswith("# my-car\n")
    assert {name for name in FILES if name in readme} >= FILES - {"README.md"}
    for file in project.glob("*.py"):
        ast.parse(file.read_text(encoding="utf-8"), feature_version=(3, 10))


def test_empty_folder_is_filled(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert command.call(capsys, "new", str(tmp_path)).status == 0
    assert {file.name for file in tmp_path.iterdir()} == FILES
    path = popsteer.Path.from_csv(tmp_path / "waypoints.csv")
    assert path.x.tolist() == list(range(201))
    bends = [0.0, 0.0, 1.757, 6.0, 12.0, 0.0, 12.0, 0.0, 0.0]
    assert path.y[[0, 20, 30, 40, 60, 100, 140, 180, 200]].tolist() == bends
    assert path.speed is not None
    assert set(path.speed.tolist()) == {8.0}


@pytest.mark.parametrize("kind", ["folder", "file", "link"])
def test_what_is_there_is_refused_and_kept(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, kind: str
) -> None:
    target = tmp_path / "mine"
    if kind == "folder":
        target.mkdir()
        (target / "note.txt").write_text("mine")
    elif kind == "file":
        target.write_text("mine")
    else:
        target.symlink_to(tmp_path / "nowhere")
    outcome = command.call(capsys, "new", str(target))
    assert outcome.status == 2
    assert outcome.out == ""
    assert outcome.err.startswith("popsteer: DIR must be a new or an empty folder")
    assert [each.name for each in tmp_path.iterdir()] == ["mine"]
    if kind == "folder":
        assert [each.name for each in target.iterdir()] == ["note.txt"]


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="no folder that nobody writes")
def test_folder_that_cannot_be_written_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    outcome = command.call(capsys, "new", "/proc/mine")
    assert (outcome.status, outcome.err) == (2, "popsteer: /proc: No such file or directory\n")


def test_failure_leaves_nothing(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device", "vehicle.toml")

    monkeypatch.setattr("popsteer.cli.new._write", full)
    outcome = command.call(capsys, "new", str(tmp_path / "mine"))
    assert outcome.status == 2
    assert "No space left" in outcome.err
    assert not list(tmp_path.iterdir())
