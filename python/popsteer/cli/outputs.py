"""What the commands print and write."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from rich.console import Console
from rich.text import Text

from popsteer import lab
from popsteer.cli.progress import Progress
from popsteer.files import write_files_atomic
from popsteer.lab.common.layout import WIDE
from popsteer.lab.compare.table import caption, notes

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from rich.table import Table

    from popsteer.lab.compare import Comparison

__all__ = ["deliver", "deliver_table", "show"]


def show(comparison: Comparison) -> None:
    """Print the table, with what has to be known to read it.

    Parameters
    ----------
    comparison : Comparison
        The runs.
    """
    console = Console()
    if not console.is_terminal:
        console = Console(width=WIDE)  # a file or a pipe has room for all columns
    console.print(Text(caption(comparison), style="bold"), soft_wrap=True)
    for table in lab.compare.table.tables(comparison, console.width):
        console.print()
        console.print(table)
    console.print()
    for note in notes(comparison):
        console.print(Text(note, style="dim"), soft_wrap=not console.is_terminal)


def deliver(comparison: Comparison, out: Path | None, progress: Progress) -> None:
    """Write the files, if a folder is given, then print the table.

    In this order, so that the files are there also for one who reads only the head of the output.

    Parameters
    ----------
    comparison : Comparison
        The runs, with their records.
    out : pathlib.Path or None
        The folder to write to.
    progress : Progress
        Told how far it is.

    Raises
    ------
    OSError
        A file cannot be written; nothing was printed then.
    """
    if out is None:
        said = "--out DIR writes figures, records and metrics.json."
    else:
        content = lab.compare.files.files(comparison, progress.update)
        lab.common.files.write(content, out)
        records = [name for name in content if name.startswith("runs/")]
        others = ", ".join(sorted(content.keys() - records))
        said = f"Written to {out}{os.sep}: {others} and {len(records)} file(s) in runs{os.sep}"
    progress.stop()
    show(comparison)
    print(said)


def deliver_table(said: str, table: Table, **files: tuple[Path | None, Callable[[], str]]) -> None:
    """Write the files that are asked for, then print a table under a line that says what it is.

    Parameters
    ----------
    said : str
        What the table shows.
    table : rich.table.Table
        The table.
    **files : tuple
        Where to write, if anywhere, and what gives the text.

    Raises
    ------
    OSError
        A file cannot be written; nothing was printed then.
    """
    content = {file: text().encode() for file, text in files.values() if file is not None}
    write_files_atomic(content)
    console = Console()
    if not console.is_terminal:
        console = Console(width=WIDE)  # a file or a pipe has room for all columns
    console.print(Text(said, style="bold"), soft_wrap=True)
    console.print()
    console.print(table)
    for file in content:
        print(f"Written to {file}")
