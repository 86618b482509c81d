"""The command, as a process of its own and in this one."""

from __future__ import annotations

import os
import subprocess
import sysconfig
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import pytest

from popsteer.cli import main

if TYPE_CHECKING:
    from collections.abc import Mapping


class Outcome(NamedTuple):
    status: int
    out: str
    err: str


def script() -> str:
    """The installed command."""
    return str(Path(sysconfig.get_path("scripts")) / "popsteer")


def run(*arguments: str, environment: Mapping[str, str] | None = None) -> Outcome:
    """Run the installed command."""
    done = subprocess.run(
        [script(), *arguments],
        capture_output=True,
        encoding="utf-8",
        env={**os.environ, **(environment or {})},
        check=False,
    )
    return Outcome(done.returncode, done.stdout, done.stderr)


def call(capsys: pytest.CaptureFixture[str], *arguments: str) -> Outcome:
    """Run the command in this process, which is faster."""
    with pytest.raises(SystemExit) as exit_:
        main(arguments)
    captured = capsys.readouterr()
    assert isinstance(exit_.value.code, int)
    return Outcome(exit_.value.code, captured.out, captured.err)


def read_terminal(reading: int) -> bytes:
    """Read all that is sent to a terminal, until its other end is closed."""
    sent = b""
    while True:
        try:
            part = os.read(reading, 65536)
        except OSError:  # Linux says so where the other end is closed
            return sent
        if not part:
            return sent
        sent += part
