"""The tables and the files of a suite."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, fields
from functools import partial
from statistics import fmean
from typing import TYPE_CHECKING, Any

from popsteer._core import __version__
from popsteer.lab.common.layout import (
    BAD,
    SIGN,
    add_names,
    add_numbers,
    blank_table,
    csv_text,
    figure_names,
    finite,
    json_text,
    number,
    this_machine,
)
from popsteer.lab.common.names import counted, title_of
from popsteer.lab.suite.runs import Cell, Suite, grouped, leaders, mean_error, rows

if TYPE_CHECKING:
    from rich.table import Table


FILES = ("suite.csv", "suite.md", "suite.json", *figure_names("suite"))
"""The names of the files that `suite_files` gives."""
SCHEMA = "popsteer-suite/1"
"""What the document says it is."""


def worded(cells: Sequence[Cell]) -> str:
    """Word the error of some cells, and how many of them failed."""
    failed = sum(not each.success for each in cells)
    return f"{mean_error(cells):.4f}" + (f" ({failed})" if failed else "")


def _marked(cells: dict[str, list[Cell]], bold: str = "") -> dict[str, str]:
    """Word a row: who leads alone between two `bold`, those that tie behind a ``=``."""
    words, first = {name: worded(own) for name, own in cells.items()}, leaders(cells)
    for name in first:
        words[name] = f"{bold}{words[name]}{bold}" if len(first) == 1 else f"= {words[name]}"
    return words


_OTHERS: tuple[tuple[str, Callable[[Cell], float], str], ...] = (
    ("rate of the command, rms [rad/s]", lambda cell: cell.steer_rate, ".2f"),
    ("lateral jerk, rms [m/s³]", lambda cell: cell.lateral_jerk, ".1f"),
    ("steps with a fault [%]", lambda cell: 100.0 * cell.faults, ".2f"),
)


def _others(found: Suite) -> list[tuple[str, dict[str, str]]]:
    """Word what is not an error: means over all cells, and the time of a step."""
    cells = grouped(found.cells, "controller")
    success = {
        name: f"{sum(each.success for each in own)} of {len(own)}" for name, own in cells.items()
    }
    means = (
        (title, {name: number(fmean(map(of, own)), spec) for name, own in cells.items()})
        for title, of, spec in _OTHERS
    )
    return [("runs that succeed", success), *means]


def suite_tables(found: Suite) -> list[Table]:
    """Set out the errors by scenario and by condition, and what is not an error."""
    from rich.text import Text

    table = blank_table(1)
    names = list(found.step_times)
    lines = [*((title, _marked(cells)) for title, cells in rows(found)), *_others(found)]
    lines.append(("step [µs]", {k: number(1e6 * v, ".1f") for k, v in found.step_times.items()}))
    add_names(table, "", (title for title, _ in lines))
    add_numbers(table, *(_head(name, names) for name in names))
    for title, cells in lines:
        said = (cells[name] for name in names)
        shown = (Text(each.replace("(", f"({SIGN} "), BAD if "(" in each else "") for each in said)
        table.add_row(Text(title), *shown)
    return [table]


def suite_caption(found: Suite) -> str:
    """Say in one line what was driven and what the figures are."""
    plants = ", ".join(dict.fromkeys(each.plant for each in found.cells))
    return (
        f"{found.name}, {counted(len(found.cells), 'run')} on {plants}; geometric mean of the mean"
        " |cross-track error| of the rear axle [m], in brackets how many runs failed; = tie for the"
        " least (bootstrap over the cells of the row, 95 %)"
    )


def sentences(found: Suite) -> list[str]:
    """Say what the rows of the table show: who has the least error where."""
    return spoken(
        {
            title: {title_of(name, cells): word for name, word in _marked(cells, "**").items()}
            for title, cells in rows(found)
        }
    )


def spoken(shown: Mapping[str, Mapping[str, str]]) -> list[str]:
    """Say what rows of `suite_lines` show, given by their titles and the controllers'."""
    parts, whole = {k: v for k, v in shown.items() if k != "All"}, shown["All"]
    if len(whole) < 2:
        return []
    error = {name: word.strip("*= ").partition(" ")[0].strip("*") for name, word in whole.items()}
    first, second = sorted(whole, key=lambda name: float(error[name]))[:2]
    tie = ": a tie" if whole[second].startswith("=") else ""
    best = f"The least error over all runs is that of {first}, {error[first]} m"
    said = [f"{best}, the next that of {second}, {error[second]} m{tie}."]
    alone = {name: [k for k, row in parts.items() if row[name][0] == "*"] for name in whole}
    said += [f"{k} alone has the least: {'; '.join(where)}." for k, where in alone.items() if where]
    tied = {k: [name for name, word in row.items() if word[0] == "="] for k, row in parts.items()}
    if ties := [f"{title} ({', '.join(names)})" for title, names in tied.items() if names]:
        said.append(f"Ties for the least: {'; '.join(ties)}.")
    behind = [name for name in whole if all(row[name][0] not in "*=" for row in parts.values())]
    if behind:
        said.append(f"Behind the least in every row: {', '.join(behind)}.")
    return said


def suite_files(found: Suite) -> dict[str, bytes]:
    """Compute the CSV, the JSON, the Markdown, and the figures in PNG and SVG, by name."""
    from popsteer.lab.common.draw import files_of
    from popsteer.lab.suite.figure import suite_figure

    content = files_of({"suite": partial(suite_figure, found)})
    names = [field.name for field in fields(Cell)]
    cells = [list(map(str, asdict(each).values())) for each in found.cells]
    units = "errors of the rear axle in m, steer_rate in rad/s, lateral_jerk in m/s³"
    content["suite.csv"] = csv_text([f"{found.name}: {units}"], names, cells).encode()
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "version": __version__,
        "suite": found.name,
        "machine": this_machine(),
        "step_times": finite(dict(found.step_times)),
        "cells": [finite(asdict(each)) for each in found.cells],
    }
    content["suite.json"] = json_text(document).encode()
    content["suite.md"] = ("\n".join(suite_lines(found)) + "\n").encode()
    return content


def suite_lines(found: Suite) -> list[str]:
    """Set out the tables in Markdown: what is the same on every machine."""
    names = list(found.step_times)
    lines = [
        ("", {name: title_of(name, names) for name in names}),
        ("---", dict.fromkeys(names, "--:")),
        *((title, _marked(cells, "**")) for title, cells in rows(found)),
        *_others(found),
    ]
    return [
        f"| {' | '.join((title, *(cells[name] for name in names)))} |" for title, cells in lines
    ]


def _head(name: str, among: Iterable[str]) -> str:
    """Fold a title for the head of a column."""
    title = title_of(name, among)
    folded = re.sub(r"(?<=[a-z])(?=[A-Z])", "\n", title, count=2)
    if len(title) > 10 and folded != title:
        return folded
    return title.replace(" ", "\n").replace("-", "-\n")
