"""Waypoints read from text files: columns x, y and, optionally, a reference speed."""

from __future__ import annotations

import io
import math
import os
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from popsteer.errors import PathError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

__all__ = ["read_waypoints"]

_PARSED_COLUMNS = 3  # x, y, reference speed; what stands further right is never looked at
_SHOWN_CHARACTERS = 40  # of an entry that is no number: enough to find it, short of flooding


class _Row(NamedTuple):
    """The entries of one line that holds more than a comment, and where it stands."""

    where: str
    fields: list[str]


def read_waypoints(
    file: str | os.PathLike[str],
) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    r"""Read waypoints from a text file.

    Each row holds x [m], y [m] and, where there is a third column, the reference speed [m/s],
    separated by commas or by white space; further columns are left alone. ``#`` starts a comment,
    blank lines are skipped, and the first row may name the columns: it is taken for names if
    neither of its first two entries is a number. The text is UTF-8, with or without a byte-order
    mark.

    Parameters
    ----------
    file : str or os.PathLike
        The file to read.

    Returns
    -------
    xy : (N, 2) ndarray of float64
        The waypoints [m], N >= 2.
    speed : (N,) ndarray of float64, or None
        The reference speeds [m/s]; None if there are two columns only.

    Raises
    ------
    PathError
        The file cannot be read or is no such text, a row has more or fewer columns than the first,
        an entry is not a finite number, or there are fewer than two rows. The message names file,
        line and column; `index` is the waypoint.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "waypoints.csv"
    ...     _ = file.write_text("x, y, speed  # metres, m/s\n0, 0, 1.5\n1, 0.5, 2\n")
    ...     xy, speed = read_waypoints(file)
    >>> xy.tolist(), speed.tolist()
    ([[0.0, 0.0], [1.0, 0.5]], [1.5, 2.0])
    """
    name = os.fsdecode(file)
    rows = list(_rows(name, _text(name)))
    if rows and _names_columns(rows[0].fields):
        _check_columns(rows[0], len(rows[0].fields))
        columns = len(rows.pop(0).fields)
    else:
        columns = len(rows[0].fields) if rows else 0

    parsed = min(columns, _PARSED_COLUMNS)
    values = np.empty((len(rows), parsed))
    for index, row in enumerate(rows):
        _check_columns(row, columns, index)
        for column in range(parsed):
            values[index, column] = _number(row, column, index)
    if len(rows) < 2:
        message = f"{name}: at least 2 waypoints are needed, found {len(rows)}"
        raise PathError(message)
    xy = np.ascontiguousarray(values[:, :2])
    return xy, (values[:, 2].copy() if parsed == _PARSED_COLUMNS else None)


def _text(name: str) -> str:
    """Read the whole file, or say in one line why it cannot be."""
    try:
        data = Path(name).read_bytes()
    except OSError as error:
        raise PathError(f"{name}: cannot be read: {error.strerror or error}") from error
    except ValueError as error:  # a name that no file can have, with a null character in it
        raise PathError(f"{name!r}: cannot be read: {error}") from error
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise PathError(f"{name}, line {line}: is not text in UTF-8") from error
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        raise PathError(f"{name}, line {line}: holds a null character, is not text")
    return text


def _rows(name: str, text: str) -> Iterator[_Row]:
    """Split the text into rows, without comments and blank lines."""
    # StringIO ends lines where editors do; str.splitlines would also at a form feed or U+2028,
    # and the line numbers in messages would drift from those an editor shows.
    for number, line in enumerate(io.StringIO(text, newline=None), start=1):
        content = line.partition("#")[0].strip()
        if not content:
            continue
        entries = content.split(",") if "," in content else content.split()
        yield _Row(f"{name}, line {number}", [entry.strip() for entry in entries])


def _names_columns(fields: list[str]) -> bool:
    """Whether a first row holds names: neither of the first two entries is a number."""
    return all(_parse(field) is None for field in fields[:2])


def _check_columns(row: _Row, columns: int, index: int | None = None) -> None:
    """Refuse a row that has too few columns, or not as many as the first."""
    found = len(row.fields)
    plural = "column" if found == 1 else "columns"
    if found < 2:
        message = (
            f"{row.where}: found {found} {plural}, at least 2 are needed (x and y, "
            "separated by a comma or white space)"
        )
        raise PathError(message, index)
    if found != columns:
        raise PathError(f"{row.where}: found {found} {plural}, the first row has {columns}", index)


def _number(row: _Row, column: int, index: int) -> float:
    """Convert one entry to a finite number, or say where the entry stands."""
    field = row.fields[column]
    value = _parse(field)
    if value is None or not math.isfinite(value):
        shown = field if len(field) <= _SHOWN_CHARACTERS else field[:_SHOWN_CHARACTERS] + "..."
        fault = "is not a number" if value is None else "is not finite"
        raise PathError(f"{row.where}, column {column + 1}: {shown!r} {fault}", index)
    return value


def _parse(field: str) -> float | None:
    """Read a number as CSV files write it; None if it is not one."""
    if "_" in field:  # float() reads 1_000, which in a table is a slip rather than a number
        return None
    try:
        return float(field)
    except ValueError:
        return None
