"""Logs from CSV files with named columns."""

from __future__ import annotations

import csv
import io
import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from popsteer.files import read_bytes
from popsteer.logs.log import COLUMNS, SIGNALS, Log, LogError
from popsteer.logs.units import converted, factor

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

_SHOWN = 12
_SHOWN_CHARACTERS = 40


def read_csv(
    file: str | os.PathLike[str],
    *,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
) -> Log:
    r"""Read a log from a CSV file.

    The first line that is no comment (``#``) names the columns; commas, semicolons or tabs separate
    them. Those of `COLUMNS` must be there, those of `SIGNALS` may; others are left alone. An empty
    entry leaves its row out.

    Parameters
    ----------
    file : str or os.PathLike
        The file.
    columns : mapping of str to str, optional
        What a column is called in the file, where that is not its name in `COLUMNS`.
    units : mapping of str to str, optional
        What a column is measured in; see `popsteer.logs.units.factor`.

    Returns
    -------
    Log
        The log.

    Raises
    ------
    LogError
        The file cannot be read, has no such column, or has an entry that is not a number.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "drive.csv"
    ...     _ = file.write_text("t,x,y,yaw,speed,delta\n0,0,0,0,36,1\n0.1,1,0,0,36,1\n")
    ...     log = read_csv(file, columns={"steer": "delta"}, units={"speed": "km/h"})
    >>> log.speed.tolist()
    [10.0, 10.0]
    """
    name = os.fsdecode(file)
    wanted = {key: key for key in COLUMNS} | dict(columns or {})
    for key, unit in (units or {}).items():
        factor(key, unit)
    if unknown := [key for key in wanted if key not in COLUMNS + SIGNALS]:
        raise LogError(f"unknown column {unknown[0]!r}; known: {', '.join(COLUMNS + SIGNALS)}")
    text = _text(name)
    lines = text.splitlines()
    first = next((k for k, line in enumerate(lines) if _content(line)), None)
    if first is None:
        raise LogError(f"{name}: the file is empty")
    separator = next((mark for mark in ",;\t" if mark in lines[first]), ",")
    names = [
        entry.strip() for entry in _entries(f"{name}, line {first + 1}", lines[first], separator)
    ]
    wanted |= {key: key for key in SIGNALS if key not in wanted and key in names}
    places = {}
    for key, called in wanted.items():
        if called not in names:
            there = ", ".join(names[:_SHOWN]) + (", ..." if len(names) > _SHOWN else "")
            raise LogError(
                f"{name}: no column {called!r}; there are: {there} (--column {key}=NAME names"
                " another)"
            )
        if names.count(called) > 1:
            raise LogError(f"{name}: {names.count(called)} columns are called {called!r}")
        places[key] = names.index(called)
    values = _numbers(name, lines[first + 1 :], first + 2, separator, places)
    scaled = dict(zip(places, values.T, strict=True))
    for key, unit in (units or {}).items():
        if key in scaled:
            scaled[key] = converted(key, unit, scaled[key])
    signals = {key: scaled.pop(key) for key in SIGNALS if key in scaled}
    return Log(**scaled, name=Path(name).name, signals=signals)


def _text(name: str) -> str:
    try:
        return read_bytes(name).decode("utf-8-sig")
    except OSError as error:
        raise LogError(f"{name}: cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise LogError(f"{name}: is not text in UTF-8 at byte {error.start}") from error
    except ValueError as error:  # a name that no file can have
        raise LogError(f"{name!r}: cannot be read: {error}") from error


def _content(line: str) -> str:
    return line.partition("#")[0].strip()


def _numbers(
    name: str, lines: list[str], number: int, separator: str, places: dict[str, int]
) -> NDArray[np.float64]:
    """Read the columns at `places`, (N, M): numpy where it can, line by line where not."""
    use = list(places.values())
    if not any(_content(line) for line in lines):
        return np.empty((0, len(use)))
    try:
        values: NDArray[np.float64] = np.loadtxt(
            io.StringIO("\n".join(lines)),
            delimiter=separator,
            comments="#",
            usecols=use,
            ndmin=2,
            quotechar='"',
        )
    except (ValueError, IndexError):
        return _carefully(name, lines, number, separator, use)
    return values


def _carefully(
    name: str, lines: list[str], number: int, separator: str, use: list[int]
) -> NDArray[np.float64]:
    rows = []
    for place, line in enumerate(lines, start=number):
        content = _content(line)
        if not content:
            continue
        entries = _entries(f"{name}, line {place}", content, separator)
        if len(entries) <= max(use):
            raise LogError(f"{name}, line {place}: found {len(entries)} columns, too few")
        rows.append([_number(f"{name}, line {place}, column {k + 1}", entries[k]) for k in use])
    return np.array(rows).reshape(-1, len(use))


def _entries(where: str, line: str, separator: str) -> list[str]:
    try:
        return next(csv.reader([line], delimiter=separator))
    except csv.Error as error:
        raise LogError(f"{where}: {error}") from None


def _number(where: str, entry: str) -> float:
    entry = entry.strip()
    if not entry:
        return float("nan")
    try:
        return float(entry)
    except ValueError:
        shown = entry if len(entry) <= _SHOWN_CHARACTERS else entry[:_SHOWN_CHARACTERS] + "..."
        raise LogError(f"{where}: {shown!r} is not a number") from None
