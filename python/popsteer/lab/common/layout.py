"""How all reports look alike: their tables on a terminal, their JSON documents."""

from __future__ import annotations

import csv
import io
import json
import math
import os
import platform
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from popsteer.status import Status

if TYPE_CHECKING:
    from rich.table import Table
    from rich.text import Text

WIDE = 160
"""Characters of a line where no terminal says how many it has."""
SIGN = "✗"
"""What stands before a fault, and before a run that did not finish."""
BAD = "bold red"
"""The style of these."""
FIGURE_KINDS = ("png", "svg")
"""What each figure is written as."""
_LONG = 20  # characters of a name that every table has room for


def blank_table(gap: int = 2) -> Table:
    """Begin a table with a rule under its heads alone, and so many characters between columns.

    A number that its digits round to 0 has no sign there, as by the ``z`` of PEP 682.
    """
    from rich import box
    from rich.table import Table
    from rich.text import Text

    class PlainZeros(Table):
        def add_row(self, *cells: Any, **how: Any) -> None:
            for cell in cells:
                if isinstance(cell, Text):
                    cell.plain = _plain_zeros(cell.plain)
            super().add_row(*(_plain_zeros(c) if isinstance(c, str) else c for c in cells), **how)

    look: Any = {"box": box.SIMPLE_HEAD, "pad_edge": False, "show_edge": False}
    return PlainZeros(**look, padding=(0, gap, 0, 0), header_style="")


def _plain_zeros(cell: str) -> str:
    """Take the sign of each 0 away."""
    return re.sub(r"(?<![\w.])-(?=0(\.0*)?(?![\w.]))", "", cell)


def add_names(table: Table, head: str, names: Iterable[str]) -> None:
    """Add a column for whole names: a long one is folded, never cut."""
    fits = all(len(name) <= _LONG for name in names)
    table.add_column(head, no_wrap=fits, overflow="fold")


def add_numbers(table: Table, *heads: str) -> None:
    """Add columns of numbers; what stands in brackets in a head is no markup."""
    from rich.text import Text

    for head in heads:
        table.add_column(Text(head), justify="right", no_wrap=True)


def number(value: float | None, form: str) -> str:
    """Word a number; a dash where there is none."""
    return "–" if value is None or not math.isfinite(value) else _plain_zeros(format(value, form))


def outcome(faults: Status, *, finished: bool) -> Text:
    """Word how a run came out; what is wrong with a sign and in red."""
    from rich.text import Text

    wrong = [*([] if finished else ["unfinished"]), *faults.names]
    return Text(f"{SIGN} {', '.join(wrong)}", BAD) if wrong else Text("finished")


def fits(table: Table, width: int) -> bool:
    """Whether a table needs no more than so many characters."""
    from rich.console import Console

    # With a height, as it would take a dumb terminal for one of 80 characters.
    return Console(width=10_000, height=25).measure(table).maximum <= width


def csv_text(comments: Sequence[str], names: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Write a table as CSV: comments such as the units, the names of the columns, and the rows."""
    text = io.StringIO(newline="")
    text.writelines(f"# {' '.join(comment.split())}\n" for comment in comments)
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    writer.writerows(rows)
    return text.getvalue()


def csv_columns(comments: Sequence[str], columns: Mapping[str, Any]) -> str:
    """Write columns of numbers, arrays by name, as CSV: a row for each place, to the last bit."""
    rows = zip(*(np.asarray(each).tolist() for each in columns.values()), strict=True)
    return csv_text(comments, columns, (map(repr, row) for row in rows))


def figure_name(stem: str, theme: str, kind: str) -> str:
    """Name a file of a figure, by the name of its theme."""
    return f"{stem}{'' if theme == 'light' else f'-{theme}'}.{kind}"


def figure_names(stem: str) -> list[str]:
    """Name the files of a figure, for a light and a dark background."""
    return [figure_name(stem, theme, kind) for theme in ("light", "dark") for kind in FIGURE_KINDS]


def finite(value: object) -> object:
    """Give None for what JSON has no number for, in a table of them too."""
    if isinstance(value, dict):
        return {name: finite(entry) for name, entry in value.items()}
    if isinstance(value, tuple):
        return [finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def json_text(document: dict[str, Any]) -> str:
    """Write a document as JSON that people can read as well; its numbers have to be finite."""
    return json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def this_machine() -> dict[str, str]:
    """Name what a benchmark ran on: ``cpu``, ``cores``, ``python`` and ``platform``."""
    return {
        "cpu": _cpu(),
        "cores": str(os.cpu_count() or "unknown"),
        "python": f"{platform.python_implementation()} {platform.python_version()}",
        "platform": platform.platform(),
    }


def _cpu() -> str:
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:  # not on Linux
        text = ""
    named = re.search(r"^model name\s*:[ \t]*(\S.*?)\s*$", text, re.MULTILINE)
    return named[1] if named else platform.processor() or platform.machine() or "unknown"
