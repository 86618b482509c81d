"""What ``--report`` shares among the commands: the file is checked before, and written after."""

from __future__ import annotations

import shlex
from pathlib import Path

import typer

from popsteer.errors import ConfigError
from popsteer.files import check_files, write_bytes_atomic

_KINDS = (".html", ".htm")


def check(file: Path | None) -> None:
    """Refuse a page that cannot be written, before the work that it is to show.

    Raises ConfigError where it is no HTML file by its name, and OSError where the file cannot be
    written.
    """
    if file is None:
        return
    if file.suffix.lower() not in _KINDS:
        raise ConfigError("--report", str(file), "a file *.html")
    check_files([file])


def command_line(context: typer.Context) -> str:
    """Give the command as it was typed, quoted for a shell; empty where it is not known."""
    arguments = context.obj
    return shlex.join(["popsteer", *arguments]) if isinstance(arguments, list) else ""


def write(file: Path, page: bytes) -> str:
    """Write a page, whole or not at all, and say so; raises OSError where it cannot be written."""
    write_bytes_atomic(file, page)
    return f"Written to {file}"
