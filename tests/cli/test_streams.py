"""Output that goes nowhere: closed, full, or a pipe that nobody reads. Never a traceback."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from tests.cli import command
from tests.helpers import looped

pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs a POSIX shell")

COMMANDS: dict[str, tuple[str, ...]] = {
    "help": ("--help",),
    "version": ("--version",),
    "compare": ("compare", "--track", "straight", "--controllers", "pop", "--out", "out"),
    "stability": ("stability", "--controllers", "stanley", "--speeds", "5", "--out", "out"),
    "several": ("compare", "--tracks", "straight,circle", "--controllers", "pop", "--out", "out"),
    "tracks": ("tracks",),
    "export": ("tracks", "--tracks", "circle", "--out", "out"),
    "tracks-out": ("tracks", "--out", "out"),
}
# Figures alone take seconds, and the others write files enough.
QUICK = COMMANDS | {name: COMMANDS[name][:-2] for name in ("compare", "stability", "several")}
# Buffered, as outside of tests: it fails late, on leaving.
BUFFERED = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}


def _shell(
    redirection: str,
    arguments: tuple[str, ...],
    folder: Path,
    environment: dict[str, str] = BUFFERED,
) -> tuple[int, str, str]:
    """Run the command with its output redirected by a shell."""
    line = ["sh", "-c", f'exec "$@" {redirection}', "sh", command.script(), *arguments]
    done = subprocess.run(
        line, capture_output=True, encoding="utf-8", cwd=folder, env=environment, check=False
    )
    return done.returncode, done.stdout, done.stderr


@looped("arguments", COMMANDS.values())
def test_closed_stdout_is_one_line_before_anything_is_done(
    tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    outcome = _shell(">&-", arguments, tmp_path)
    assert outcome == (2, "", "popsteer: standard output is closed\n")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full here")
@looped("name", ["help", "compare", "tracks", "export"])
def test_full_stdout_is_one_line(tmp_path: Path, name: str) -> None:
    for environment in (BUFFERED, {**BUFFERED, "PYTHONUNBUFFERED": "1"}):
        outcome = _shell(">/dev/full", QUICK[name], tmp_path, environment)
        assert outcome == (2, "", "popsteer: standard output: No space left on device\n")


@pytest.mark.parametrize(
    "arguments", [*QUICK.values(), ("compare", "--help")], ids=[*QUICK, "long-help"]
)
def test_output_that_nobody_reads_is_no_traceback(
    tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    try:
        done = subprocess.run(
            [command.script(), *arguments],
            stdout=writing,
            stderr=subprocess.PIPE,
            cwd=tmp_path,
            env=BUFFERED,
            check=False,
        )
    finally:
        os.close(writing)
    # Silent, as `popsteer tracks | head` is no fault of anybody's; the files are there.
    assert (done.returncode, done.stderr) == (1, b"")
    if "--out" in arguments:
        assert any((tmp_path / "out").iterdir())


@looped("redirection", ["2>&-", "2>/dev/full", "2>&- <&-"])
def test_stderr_that_takes_nothing_leaves_the_status(tmp_path: Path, redirection: str) -> None:
    outcome = _shell(redirection, ("compare", "--controllers", "foo"), tmp_path)
    assert outcome == (2, "", "")


def test_closed_stdout_and_stderr_leave_the_status(tmp_path: Path) -> None:
    assert _shell(">&- 2>&-", ("tracks",), tmp_path) == (2, "", "")


def test_closed_stderr_and_stdin_leave_the_output_alone(tmp_path: Path) -> None:
    status, out, _ = _shell("2>&- <&-", ("tracks", "--tracks", "circle", "--out", "."), tmp_path)
    assert (status, out[:7]) == (0, "circle:")
    assert (tmp_path / "circle.csv").read_text(encoding="utf-8").startswith("#")
