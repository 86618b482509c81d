"""What the commands print and write."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from rich.console import Console
from rich.text import Text

from popsteer import lab
from popsteer._core import build_profile
from popsteer.cli.report import write as write_report
from popsteer.files import write_files_atomic
from popsteer.lab.compare.table import caption, notes

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from pathlib import Path

    from rich.table import Table

    from popsteer.cli.progress import Progress
    from popsteer.lab.compare import Comparison
    from popsteer.lab.report import Origin

__all__ = ["beside", "console", "deliver", "say", "show", "write"]

_PIPED = 160


def beside(out: Path) -> list[Path]:
    """Name the figures that are drawn beside a file.

    Parameters
    ----------
    out : pathlib.Path
        The file.

    Returns
    -------
    list of pathlib.Path
        For a light and a dark background; none where the name has no suffix, as ``/dev/stdout``.

    Examples
    --------
    >>> from pathlib import Path
    >>> [file.name for file in beside(Path("car.toml"))]
    ['car.png', 'car.svg', 'car-dark.png', 'car-dark.svg']
    """
    if not out.suffix:
        return []
    kinds = [(dark, kind) for dark in ("", "-dark") for kind in ("png", "svg")]
    return [out.with_name(f"{out.stem}{dark}.{kind}") for dark, kind in kinds]


def console() -> Console:
    """Give the standard output as the tables are laid out for it.

    Returns
    -------
    rich.console.Console
        As wide as the terminal. A file or a pipe has room for all columns.

    Examples
    --------
    >>> console().width
    160
    """
    found = Console()
    return found if found.is_terminal else Console(width=_PIPED)


def say(text: str, style: str = "") -> None:
    """Print a sentence: wrapped on a terminal, in one line elsewhere.

    Parameters
    ----------
    text : str
        The sentence.
    style : str, optional
        How rich shows it.

    Examples
    --------
    >>> say("5 waypoints", "bold")
    5 waypoints
    """
    at = console()
    at.print(Text(text, style=style), soft_wrap=not at.is_terminal)


def show(head: str, tables: Iterable[Table], below: Iterable[str] = ()) -> None:
    """Print tables, with what has to be known to read them.

    Parameters
    ----------
    head : str
        What the tables show.
    tables : iterable of rich.table.Table
        The tables, made for the width of `console`.
    below : iterable of str, optional
        Notes to print below them.
    """
    at = console()
    say(head, "bold")
    for table in tables:
        at.print()
        at.print(table)
    for index, note in enumerate(below):
        if index == 0:
            at.print()
        say(note, "dim")


def deliver(
    comparison: Comparison,
    out: Path | None,
    progress: Progress,
    report: Path | None = None,
    origin: Origin | None = None,
) -> None:
    """Write the files of a comparison that are wanted, then print its table.

    In this order, so that the files are there also for one who reads only the head of the output.

    Parameters
    ----------
    comparison : Comparison
        The runs, with their records.
    out : pathlib.Path or None
        The folder to write to.
    progress : Progress
        Shows what is being done.
    report : pathlib.Path, optional
        The page to write.
    origin : Origin, optional
        What that says of how it was made.

    Raises
    ------
    OSError
        A file cannot be written; nothing was printed then.
    """
    if out is None:
        said = "--out DIR writes figures, records and metrics.json."
    else:
        content = lab.compare.files.files(comparison, progress.update)
        write(content, out)
        records = [name for name in content if name.startswith("runs/")]
        others = ", ".join(sorted(content.keys() - records))
        said = f"Written to {out}{os.sep}: {others} and {len(records)} file(s) in runs{os.sep}"
    if report is not None:
        said += "\n" + write_report(report, _page(comparison, origin, progress))
    progress.stop()
    tables = lab.compare.table.tables(comparison, console().width)
    show(caption(comparison), tables, notes(comparison))
    print(said)


def _page(comparison: Comparison, origin: Origin | None, progress: Progress) -> bytes:
    """Make the page of a comparison; steps are timed for it where that means something."""
    progress.update("report", 0.0)
    untimed = not comparison.step_times and build_profile != "debug"
    if untimed and origin is not None and comparison.first.settings.keep_records:
        comparison = lab.compare.time_steps(
            comparison, origin.params, progress.update, adapt=origin.adapt
        )
    return lab.report.of_comparison(comparison, origin)


def write(content: Mapping[str, bytes], out: Path | None, otherwise: str = "") -> str:
    """Write files into a folder, all or none.

    Parameters
    ----------
    content : mapping of str to bytes
        The content of each file by its name in the folder.
    out : pathlib.Path or None
        The folder, if one is given.
    otherwise : str, optional
        What to say where none is.

    Returns
    -------
    str
        What was done, for a line at the end of the output.

    Raises
    ------
    OSError
        A file cannot be written; then none is.

    Examples
    --------
    >>> write({}, None, "--out DIR writes the table.")
    '--out DIR writes the table.'
    """
    if out is None:
        return otherwise
    write_files_atomic({out / name: data for name, data in content.items()})
    return f"Written to {out}{os.sep}: {', '.join(sorted(content))}"
