"""What the commands print and write."""

from __future__ import annotations

import os
import shlex
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import typer
from rich.console import Console
from rich.progress import BarColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bar
from rich.table import Table
from rich.text import Text

from popsteer import files, lab
from popsteer._core import build_profile
from popsteer.errors import ConfigError, printable
from popsteer.lab.common.layout import BAD, SIGN, WIDE, figure_names
from popsteer.lab.common.theme import Theme
from popsteer.lab.compare import Comparison
from popsteer.lab.compare.table import heading, notes
from popsteer.sim import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from typing_extensions import Self

    from popsteer.lab.report import Origin

_PATIENCE = 1.0  # seconds without a bar


class Progress:
    """A bar on stderr with the time that remains, from the first second on, on a terminal alone."""

    def __init__(self) -> None:
        columns = TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn()
        self._bar = Bar(*columns, console=Console(stderr=True), transient=True)
        self._task = self._bar.add_task("", total=1.0, visible=False)
        # A timer, as what takes longest may say nothing while it lasts.
        self._timer = threading.Timer(_PATIENCE, self._bar.start)
        self._timer.daemon = True

    def __enter__(self) -> Self:
        if self._bar.console.is_terminal:
            self._timer.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def update(self, what: str, share: float) -> None:
        """Take note of what is being done, and of the share of it that is done, 0 to 1."""
        if share < self._bar.tasks[0].completed:
            self._bar.reset(self._task)  # another work, whose speed is its own
        self._bar.update(self._task, description=what, completed=share, visible=True)

    def stop(self) -> None:
        """Take the bar away; it does not come back."""
        self._timer.cancel()
        if self._timer.ident is not None:
            self._timer.join()
        if self._bar.live.is_started:
            self._bar.stop()


@contextmanager
def kept_in(where: object) -> Iterator[None]:
    """Say, where Ctrl-C stops a command, that what is done is kept in `where`, unless None."""
    try:
        yield
    except KeyboardInterrupt:
        if where is not None:
            said = f"popsteer: stopped; the same command goes on with what is in {where}"
            with suppress(OSError):
                print(said, file=sys.stderr)
        raise


def figure_paths(out: Path) -> list[Path]:
    """Name the figures beside a file; none if its name has no suffix, as ``/dev/stdout``."""
    return [out.with_name(name) for name in figure_names(out.stem)] if out.suffix else []


def draw_figures(
    out: Path, draw: Callable[[Theme], Figure], progress: Progress
) -> dict[Path, bytes]:
    """Draw a figure into the files that `figure_paths` names; nothing where it names none."""
    from popsteer.lab.common.draw import files_of

    if not figure_paths(out):
        return {}
    drawn = files_of({out.stem: draw}, progress.update)
    return {out.with_name(name): data for name, data in drawn.items()}


def console() -> Console:
    """Give the standard output, as wide as the terminal; a file has room for all columns."""
    found = Console()
    return found if found.is_terminal else Console(width=WIDE)


def say(text: str, style: str = "") -> None:
    """Print a sentence: wrapped on a terminal, in one line elsewhere."""
    at = console()
    at.print(Text(printable(text), style=style), soft_wrap=not at.is_terminal)


def show(
    head: str,
    tables: Iterable[Table],
    below: Iterable[str] = (),
    said: str = "",
    page: Path | None = None,
    read: Iterable[str | None] = (),
    draw: Callable[[Progress], bytes] = lambda _: b"",
) -> None:
    """Print tables with a heading above, notes below, and what was written: `said`, a page.

    `read` are the sources of the files that were read; each is said in a line first. The page is
    made last, by `draw`: if it fails, or nobody reads the table, nothing else is lost.
    """
    at = console()
    try:
        for source in filter(None, read):
            say(f"Read {source}.", "dim")
        say(head, "bold")
        for table in tables:
            at.print()
            at.print(table)
        for index, note in enumerate(below):
            if index == 0:
                at.print()
            say(note, BAD if note.startswith(SIGN) else "dim")
        for line in said.splitlines():
            print(printable(line))
    finally:
        if page is not None and not isinstance(sys.exc_info()[1], KeyboardInterrupt):
            with Progress() as progress:
                progress.update("report", 0.0)
                files.write_bytes_atomic(page, draw(progress))
    if page is not None:
        print(f"Written to {printable(str(page))}")


def deliver(
    comparisons: Sequence[Comparison],
    out: Path | None,
    progress: Progress,
    report: Path | None,
    origin: Origin,
    read: Iterable[str | None] = (),
    more: Iterable[str] = (),
) -> None:
    """Write the files of comparisons, then print their table: they are there if a pipe closes.

    `more` are notes below the usual ones.
    """
    if out is None:
        said = "--out DIR writes figures, tables and records."
    else:
        content = lab.compare.files.files(*comparisons, progress=progress.update)
        said = write(content, out)
        if records := [name for name in content if name.startswith("runs/")]:
            others = ", ".join(sorted(content.keys() - records))
            said = f"Written to {out}{os.sep}: {others} and {len(records)} file(s) in runs{os.sep}"
    progress.stop()
    tables = lab.compare.table.tables(*comparisons, width=console().width)
    below = (*notes(*comparisons), *more)
    draw = partial(_page, comparisons, origin)
    show(heading(*comparisons), tables, below, said, report, read, draw)
    say_raised(run for each in comparisons for run in each.runs.values())


def say_raised(runs: Iterable[Run]) -> None:
    """Show the tracebacks of the runs that code of your own ended, on stderr."""
    for run in runs:
        if run.traceback:
            print(f"\n{run.law} on {run.plant}:\n{run.traceback}", end="", file=sys.stderr)


def _page(comparisons: Sequence[Comparison], origin: Origin, progress: Progress) -> bytes:
    """Make the page of comparisons; steps are timed for one where that means something."""
    first = comparisons[0]
    untimed = not first.step_times and build_profile != "debug"
    if len(comparisons) == 1 and untimed and first.first.settings.keep_records:
        timed = lab.compare.time_steps(
            first, origin.params, progress.update, adapt=origin.adapt, monitor=origin.monitor
        )
        comparisons = [timed]
    return lab.report.of_comparison(*comparisons, origin=origin)


def write(content: Mapping[str, bytes], out: Path | None, otherwise: str = "") -> str:
    """Write files by their names into a folder, all or none, and say so; else say `otherwise`."""
    if out is None:
        return otherwise
    files.write_files_atomic({out / name: data for name, data in content.items()})
    return f"Written to {out}{os.sep}: {', '.join(sorted(content))}"


def written(out: Path | None, others: Iterable[Path], otherwise: str) -> str:
    """Say which file was written, and which beside it; `otherwise` where none was."""
    if out is None:
        return otherwise
    return printable(f"Written to {', '.join([str(out), *(each.name for each in others)])}")


def check_folder(out: Path | None, names: Iterable[str], report: Path | None = None) -> None:
    """Refuse a folder of files and a page that cannot be written, before the work for them."""
    if out is not None:
        files.check_folder(out, names)
    _check_page(report)


def check_file(out: Path | None, report: Path | None, kind: str = "") -> list[Path]:
    """Refuse a file that is not of its `kind`, or cannot be written; give its figures' files."""
    pictures = []
    if out is not None:
        if not out.suffix.lower().endswith(kind):
            raise ConfigError("--out", str(out), f"a file *{kind}")
        pictures = figure_paths(out)
        files.check_files([out, *pictures])
    _check_page(report)
    return pictures


def _check_page(file: Path | None) -> None:
    if file is not None:
        if file.suffix.lower() not in (".html", ".htm"):
            raise ConfigError("--report", str(file), "a file *.html")
        files.check_files([file])


def command_line(context: typer.Context) -> str:
    """Give the command as it was typed, quoted for a shell; empty where it is not known."""
    arguments = context.obj
    return shlex.join(["popsteer", *arguments]) if isinstance(arguments, list) else ""
