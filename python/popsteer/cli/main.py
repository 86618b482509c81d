"""From the command line to an exit status: every error is one line."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING, Any, NoReturn

from popsteer.errors import PopsteerError

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["INTERRUPTED", "REFUSED", "main"]

REFUSED = 2
"""Exit status where the input, the options or a file are at fault."""
INTERRUPTED = 130
"""Exit status after Ctrl-C, as a shell has it."""

_LAB = ("matplotlib", "rich", "typer")


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line and exit.

    Parameters
    ----------
    arguments : sequence of str, optional
        The arguments after the name of the command; those of the process by default.

    Raises
    ------
    SystemExit
        Always: 0 where all went well, 2 with one line on stderr where it did not, 130 after Ctrl-C.

    Examples
    --------
    >>> main(["tracks", "export", "nowhere", "track.csv"])
    Traceback (most recent call last):
    SystemExit: 2
    """
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            # A terminal that has no ψ shows a question mark rather than an error.
            stream.reconfigure(errors="replace")
    try:
        status = _run(arguments)
        sys.stdout.flush()
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in _LAB:
            raise
        status = _refuse('the command line needs the extra "lab": pip install "popsteer[lab]"')
    except PopsteerError as error:
        status = _refuse(str(error))
    except BrokenPipeError:
        # Whoever read the output has seen enough. What is left in the buffer has nowhere to go.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        status = 1
    except OSError as error:
        where = f"{error.filename}: " if error.filename is not None else ""
        status = _refuse(f"{where}{error.strerror or error}")
    except KeyboardInterrupt:
        status = INTERRUPTED
    sys.exit(status)


def _run(arguments: Sequence[str] | None) -> int:
    """Run the command line; errors of its use come back as a status, all others as they are."""
    import typer

    from popsteer.cli.app import app

    # What typer raises at wrong use; it does not export the class by name.
    wrong_use: Any = next(
        kind for kind in typer.BadParameter.__mro__ if kind.__name__ == "ClickException"
    )
    command = typer.main.get_command(app)
    given = None if arguments is None else list(arguments)
    try:
        status = command.main(args=given, prog_name="popsteer", standalone_mode=False)
    except wrong_use as error:
        return _refuse(error.format_message())
    except typer.Abort:  # older versions make this of Ctrl-C
        return INTERRUPTED
    return status if isinstance(status, int) else 0


def _refuse(message: str) -> int:
    """Say in one line on stderr what is wrong."""
    print(f"popsteer: {' '.join(message.split())}", file=sys.stderr)
    return REFUSED
