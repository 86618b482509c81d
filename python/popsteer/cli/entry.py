"""From the command line to an exit status: every error is one line."""

from __future__ import annotations

import functools
import os
import re
import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, TextIO

from popsteer.errors import PopsteerError, printable
from popsteer.extras import MODULES, MissingExtra, missing, require
from popsteer.interrupt import handle_as_usual, has_come, leave

if TYPE_CHECKING:
    from collections.abc import Sequence

REFUSED = 2
"""Exit status where the input, the options or a file are at fault."""
INTERRUPTED = 130
"""Exit status after Ctrl-C, as a shell has it."""

_LONGEST = 500  # characters of an error
_TYPED = ("rich", "typer")  # enough for help and for what only prints
_PRINTING = ("new", "tracks")
_OF_ROS2 = ("ros2", "record")
# What else a command line may need, by words in it.
_ALSO = {
    "dask": r"--dask\b",
    "mpc": r"\bmpc\b",
    "parquet": r"\.parquet\b",
    "plants": r"\b(commonroad|mujoco)-",
}
_NOW = {
    "--laws": "--controllers",
    "simulate": "compare --controllers NAME",
    "--replay-run": "sweep --run",
    "--suite": "popsteer suite",
    "bench": "make bench, in a checkout,",
    **dict.fromkeys(("--csv", "--json", "--figure", "--figures"), "--out"),
}


_ALIASES = {"matrix": "compare"}
"""Former names of commands that are taken for a release, with a warning."""


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line with the arguments after the name of the command, and exit.

    Raises SystemExit: 0 where all went well, 2 with one line on stderr where it did not, 130 after
    Ctrl-C, and 1 where whoever read the output has gone.

    Examples
    --------
    >>> main(["tracks", "--tracks", "nowhere"])
    Traceback (most recent call last):
    SystemExit: 2
    """
    handle_as_usual()
    _set_up_streams()
    given = _renamed(list(sys.argv[1:] if arguments is None else arguments))
    try:
        try:
            _check_extras(given)
            status = _run(given)
        except MissingExtra as error:
            raise _with_all_extras(error, given) from None
        sys.stdout.flush()
    except PopsteerError as error:
        print(getattr(error, "traceback", ""), end="", file=sys.stderr)  # of the user's own code
        status = _refuse(str(error))
    except BrokenPipeError:
        status = 1  # whoever read the output has seen enough: `popsteer tracks | head` is no error
    except OSError as error:
        where = error.filename
        # A long write that failed leaves the buffer empty: one more character shows it.
        if where is None and (_drop_what_fails(sys.stdout) or _is_full(sys.stdout)):
            where = "standard output"
        status = _refuse(f"{f'{where}: ' if where else ''}{error.strerror or error}")
    except KeyboardInterrupt:
        status = INTERRUPTED
    except Exception:
        if not has_come():
            raise
        status = INTERRUPTED  # matplotlib's C++ makes a ValueError of it
    _drop_what_fails(sys.stdout)
    if status == INTERRUPTED and arguments is None:
        leave()
    sys.exit(status)


def _set_up_streams() -> None:
    """Make sure that there are streams to write to, or exit."""
    if sys.stderr is None:  # closed by the shell, `2>&-`; print would take stdout for it
        # Never closed: it stands in for a stream that lives as long as the process.
        sys.stderr = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115
    if sys.stdout is None:  # `>&-`; said at once, not after a drive whose table nobody sees
        sys.exit(_refuse("standard output is closed"))
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            # A terminal without ψ shows a question mark instead of an error.
            stream.reconfigure(errors="replace")


def _command(given: Sequence[str]) -> str:
    """Name the command of a command line; empty where there is none."""
    return next((each for each in given if not each.startswith("-")), "")


def _renamed(given: list[str]) -> list[str]:
    """Replace a former name of a command, and warn of it."""
    command = _command(given)
    if (now := _ALIASES.get(command)) is not None:
        print(f"popsteer: warning: {command} will go; it is {now} now", file=sys.stderr)
        given[given.index(command)] = now
    return given


def _check_extras(given: Sequence[str]) -> None:
    """Refuse a command whose extra is missing, before any of its work."""
    command = _command(given)
    extra = "ros2" if command in _OF_ROS2 else "lab"
    printing = command in ("", *_PRINTING) or not {"--help", "-h"}.isdisjoint(given)
    require(command or "the command line", extra, *(_TYPED if printing else ()))


def _with_all_extras(error: MissingExtra, given: Sequence[str]) -> MissingExtra:
    """Name at once all extras that the command line needs and that are missing."""
    command, line = _command(given), " ".join(given)
    needed = {"ros2" if command in _OF_ROS2 else "lab"}
    needed |= {extra for extra, word in _ALSO.items() if re.search(word, line)}
    absent = {extra for extra in needed if missing(*MODULES[extra])}
    return MissingExtra(error.what, *sorted({*error.extras, *absent}))


@functools.cache  # once a process: reading the options of a command takes longer than most runs
def _commands(first: str) -> Any:  # noqa: ANN401 - typer does not export what it makes
    """Give the command with what a command line that begins so needs: one page, all, or none."""
    import typer

    from popsteer.cli.app import PAGES, made

    pages = (first,) if first in PAGES else () if first == "--version" else PAGES
    return typer.main.get_command(made(pages))


def _run(given: list[str]) -> int:
    """Run the command line; errors of its use come back as a status, all others as they are."""
    import typer

    # What typer raises at wrong use; it does not export the class by name.
    wrong_use: Any = next(
        kind for kind in typer.BadParameter.__mro__ if kind.__name__ == "ClickException"
    )
    try:
        # A report tells the command that made it.
        status = _commands(given[0] if given else "").main(
            args=given, prog_name="popsteer", standalone_mode=False, obj=given
        )
    except wrong_use as error:
        return _refuse(_with_new_name(error.format_message()))
    except typer.Abort:  # older versions make this of Ctrl-C
        return INTERRUPTED
    return status if isinstance(status, int) else 0


def _with_new_name(message: str) -> str:
    """Add what an option or a command of 0.1.0 is called now."""
    found = re.match(r"No such (?:option|command):? '?([\w-]+)'?", message)
    if found is None or found[1] not in _NOW:
        return message
    return f"{found[0]}; it is {_NOW[found[1]]} now"


def _refuse(message: str) -> int:
    """Say in one line on stderr what is wrong; of a long one its beginning and its end."""
    line = printable(" ".join(message.split()))
    if len(line) > _LONGEST:
        line = f"{line[: _LONGEST - 200]} ... {line[-190:]}"
    with suppress(OSError):  # where stderr is full or gone, the status alone tells
        print(f"popsteer: {line}", file=sys.stderr)
    _drop_what_fails(sys.stderr)
    return REFUSED


def _is_full(stream: TextIO) -> bool:
    """Whether nothing more can be written; asked where a write has failed already."""
    with suppress(OSError):  # where nothing is buffered, the write itself fails
        stream.write("\n")
        return _drop_what_fails(stream)
    return True


def _drop_what_fails(stream: TextIO) -> bool:
    """Empty the buffer, if need be into nowhere: Python would fail on it again as it exits."""
    try:
        stream.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
        return True
    return False
