from __future__ import annotations

import subprocess
import sys
from typing import TYPE_CHECKING

import numpy as np

import popsteer
from popsteer import tracks
from popsteer.cli.progress import Progress
from tests.cli import command
from tests.helpers import looped

if TYPE_CHECKING:
    from pathlib import Path

    import pytest

_COMMANDS = (
    "compare",
    "matrix",
    "new",
    "plan",
    "stability",
    "identify",
    "replay",
    "tune",
    "sweep",
    "ros2",
    "record",
    "bench",
    "tracks",
)


def test_help_of_the_command_reads_as_a_page() -> None:
    outcome = command.run("--help")
    assert outcome.status == 0
    assert outcome.err == ""
    assert "\x1b" not in outcome.out
    for part in (
        "Examples:",
        "--report FILE",
        "What `compare --out DIR` writes:",
        "metrics.json",
        "status 2",
    ):
        assert part in outcome.out
    for name in _COMMANDS:
        assert f"\n  {name} " in outcome.out


def test_command_without_arguments_shows_the_help(capsys: pytest.CaptureFixture[str]) -> None:
    bare = command.call(capsys)
    assert bare.status == 0
    assert bare.out.strip() == command.call(capsys, "--help").out.strip()


@looped("name", _COMMANDS)
def test_help_of_each_command_has_examples(capsys: pytest.CaptureFixture[str], name: str) -> None:
    outcome = command.call(capsys, name, "--help")
    assert outcome.status == 0
    assert "Examples:" in outcome.out
    assert f"  popsteer {name}" in outcome.out


@looped("options", [("--version",), ("--version", "compare")])
def test_version_is_that_of_the_package(
    capsys: pytest.CaptureFixture[str], options: tuple[str, ...]
) -> None:
    outcome = command.call(capsys, *options)
    assert (outcome.status, outcome.out) == (0, f"popsteer {popsteer.__version__}\n")


def test_tracks_lists_them_all(capsys: pytest.CaptureFixture[str]) -> None:
    outcome = command.call(capsys, "tracks")
    assert outcome.status == 0
    for name in tracks.names():
        assert name in outcome.out
        assert tracks.get(name).title in outcome.out


def test_tracks_export_writes_what_compare_reads(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "new" / "track.csv"
    assert command.call(capsys, "tracks", "export", "slalom", str(file)).status == 0
    path = popsteer.Path.from_csv(file)
    assert np.array_equal(np.column_stack((path.x, path.y)), tracks.get("slalom").xy)
    outcome = command.call(capsys, "compare", "--waypoints", str(file), "--controllers", "pop")
    shipped = command.call(capsys, "compare", "--track", "slalom", "--controllers", "pop")
    assert outcome.out.replace("track.csv", "slalom") == shipped.out


def test_tracks_with_out_writes_each(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert command.call(capsys, "tracks", "--out", str(tmp_path / "all")).status == 0
    files = {file.name for file in (tmp_path / "all").iterdir()}
    assert files == {f"{name}.csv" for name in tracks.names()}


def test_progress_off_a_terminal_or_in_the_first_second_shows_nothing(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    with Progress() as progress:
        progress.update("pop", 0.5)
    monkeypatch.setattr("popsteer.cli.progress._PATIENCE", 0.0)
    with Progress() as progress:
        progress.update("pop", 0.5)
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("", "")


def test_progress_on_a_terminal_shows_what_is_done_and_goes_away(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("popsteer.cli.progress._PATIENCE", 0.0)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setenv("TERM", "xterm")
    with Progress() as progress:
        progress.update("figures", 0.5)
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "figures" in captured.err


def test_help_of_every_command_needs_nothing_that_windows_lacks() -> None:
    code = f"""
import sys
sys.modules.update(fcntl=None, resource=None, termios=None)
from popsteer.cli import main
for name in {_COMMANDS!r}:
    try:
        main([name, "--help"])
    except SystemExit as end:
        assert end.code == 0, name
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.count("Usage: popsteer ") == len(_COMMANDS)


def test_completion_completes_commands_and_is_offered() -> None:
    shown = command.run("--show-completion", "bash")
    assert (shown.status, shown.err) == (0, "")
    assert "_POPSTEER_COMPLETE=complete_bash" in shown.out
    asked = {
        "_POPSTEER_COMPLETE": "complete_bash",
        "COMP_WORDS": "popsteer comp",
        "COMP_CWORD": "1",
    }
    assert command.run(environment=asked).out.split() == ["compare"]
