"""Waypoints read from text files: columns x, y and, optionally, speed, yaw and curvature."""

from __future__ import annotations

import io
import math
import os
import re
from array import array
from itertools import chain
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from popsteer.errors import PathError
from popsteer.files import read_bytes

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from numpy.typing import NDArray

# Names of columns, without units; x and y are needed.
_KNOWN_AS = {
    "x": ("x", "x_m", "pos_x", "position_x", "x_pos"),
    "y": ("y", "y_m", "pos_y", "position_y", "y_pos"),
    "speed": ("speed", "v", "vx", "velocity", "speed_mps", "v_mps", "vx_mps", "speed_m_s", "v_ref"),
    "yaw": ("yaw", "yaw_rad"),
    "curvature": ("curvature", "curvature_1_m", "kappa", "kappa_radpm", "kappa_1_m"),
}
_MANY = 100  # columns: numpy is not asked to read more
_SHOWN = 12  # names of columns in a message
_SHOWN_CHARACTERS = 40  # of an entry that is no number: enough to find it, short of flooding


class _Row(NamedTuple):
    """The entries of one line that holds more than a comment, and where it stands."""

    where: str
    fields: list[str]


def read_waypoints(
    file: str | os.PathLike[str],
) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """Read waypoints [m], shape (N, 2), and their speeds [m/s], if any, from a text file.

    Each row holds x [m], y [m] and, where there is a third column, the reference speed [m/s],
    separated by commas or by white space; further columns are left alone. ``#`` starts a comment,
    and blank lines are skipped. The first row may name the columns: it is taken for names if
    neither of its first two entries is a number, and x, y and the speed are then found by their
    names, wherever they stand. The text is UTF-8, with or without a byte-order mark.

    Raises PathError, which names file, line and column, where the file cannot be read or is no such
    text, the names lack x or y or have one twice, a row has more or fewer columns than the first,
    an entry is not a finite number, or there are fewer than two rows; its `index` is the waypoint.
    """
    xy, more = read_columns(file)
    return xy, more.get("speed")


def read_columns(
    file: str | os.PathLike[str],
) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
    """Read waypoints as `read_waypoints`, and ``speed``, ``yaw``, ``curvature`` where named."""
    values, names = _read(os.fsdecode(file))
    xy = np.ascontiguousarray(values[:, :2])
    return xy, {name: values[:, k].copy() for k, name in enumerate(names) if k > 1}


def _read(name: str) -> tuple[NDArray[np.float64], Sequence[str]]:
    """Read the columns that are parsed, and what they are."""
    try:
        data = read_bytes(name)
    except OSError as error:
        raise PathError(f"{name}: cannot be read: {error.strerror or error}") from error
    except ValueError as error:  # a name that no file can have, with a null character in it
        raise PathError(f"{name!r}: cannot be read: {error}") from error
    values = _read_fast(data)
    return _read_carefully(name, data) if values is None else values


def _read_fast(data: bytes) -> tuple[NDArray[np.float64], Sequence[str]] | None:
    """Let numpy read plain text as `_read_carefully` would to the bit; None where it is not."""
    if b"\0" in data:
        return None
    lines = _lines(data)
    try:
        names = line = None
        for line in lines:
            fields = _fields(line)
            if fields and names is None and _names_columns(fields):
                names = fields
            elif fields:
                break
        else:
            return None
        columns = len(fields)
        if not 2 <= columns <= _MANY or (names is not None and len(names) != columns):
            return None
        used = _used("", columns, names)
        # Other columns may hold anything. They are counted, and the least of them is kept.
        kinds = np.dtype(
            [(str(k), np.float64 if k in used.values() else "U1") for k in range(columns)]
        )
        delimiter = "," if "," in line.partition("#")[0] else None
        if delimiter is None and columns > len(used) and b"," in data:
            return None  # numpy would take a row with commas for one that has none
        rows = np.loadtxt(chain([line], lines), kinds, delimiter=delimiter, comments="#", ndmin=1)
    except ValueError:  # also of text that is not UTF-8, and of names that do not do
        return None
    values: NDArray[np.float64] = np.column_stack([rows[str(k)] for k in used.values()])
    return (values, list(used)) if len(values) >= 2 and np.isfinite(values).all() else None


def _read_carefully(name: str, data: bytes) -> tuple[NDArray[np.float64], Sequence[str]]:
    """Read line by line: what this takes, and says about the rest, is how files are defined."""
    _check_text(name, data)
    rows = _rows(name, _lines(data))
    first = next(rows, None)
    columns = 0 if first is None else len(first.fields)
    used = _used("", columns, None)
    if first is not None and _names_columns(first.fields):
        _check_columns(first, columns)
        used = _used(first.where, columns, first.fields)
    elif first is not None:
        rows = chain([first], rows)

    numbers = array("d")  # a list of 5 million rows would take gigabytes
    count = 0
    for index, row in enumerate(rows):
        _check_columns(row, columns, index)
        numbers.extend([_number(row, column, index) for column in used.values()])
        count += 1
    if count < 2:
        message = f"{name}: at least 2 waypoints are needed, found {count}"
        raise PathError(message)
    return np.array(numbers).reshape(count, len(used)), list(used)


def _check_text(name: str, data: bytes) -> None:
    """Refuse what is no text, in one line."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise PathError(f"{name}, line {line}: is not text in UTF-8") from error
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        raise PathError(f"{name}, line {line}: holds a null character, is not text")


def _lines(data: bytes) -> Iterator[str]:
    # This ends lines where editors do; str.splitlines would also at a form feed or U+2028, and the
    # line numbers in messages would drift from those an editor shows.
    return io.TextIOWrapper(io.BytesIO(data), "utf-8-sig")


def _rows(name: str, lines: Iterable[str]) -> Iterator[_Row]:
    """Split lines into rows, without comments and blank lines."""
    for number, line in enumerate(lines, start=1):
        fields = _fields(line)
        if fields:
            yield _Row(f"{name}, line {number}", fields)


def _fields(line: str) -> list[str]:
    """Split a line into its entries; no entries if it is blank or only a comment."""
    content = line.partition("#")[0].strip()
    entries = content.split(",") if "," in content else content.split()
    return [entry.strip() for entry in entries]


def _names_columns(fields: list[str]) -> bool:
    """Whether a first row holds names: neither of the first two entries is a number."""
    return all(_parse(field) is None for field in fields[:2])


def _used(where: str, columns: int, names: list[str] | None) -> dict[str, int]:
    """Find the columns of x, y and, if any, the others: by their names, where they have names."""
    if names is None:
        return {name: k for k, name in enumerate(("x", "y", "speed")) if k < columns}
    plain = ["_".join(re.split(r"[\[(]", name)[0].lower().split()) for name in names]
    found: dict[str, int] = {}
    for what, wanted in _KNOWN_AS.items():
        there = [plain.index(name) for name in wanted if name in plain]
        shown = ", ".join(names[:_SHOWN]) + (", ..." if len(names) > _SHOWN else "")
        if not there and what in ("x", "y"):
            raise PathError(f"{where}: no column is named {wanted[0]}; there are: {shown[:200]}")
        if there and plain.count(plain[there[0]]) > 1:
            raise PathError(f"{where}: two columns are named {names[there[0]][:200]}")
        if there:
            found[what] = there[0]
    return found


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
