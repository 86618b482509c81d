"""Tables as text: what separates the columns, what they are called, and the numbers in them.

A table is read as `csv` reads a line: entries between commas, semicolons, tabs or white space, in
quotes or not. What stands above the numbers is found by what it is: the names are the last row
without a number whose columns are known, units may stand below them (MoTeC), and titles or sections
above (VBOX). Without such a row the comment directly above the numbers is it, where it has as many
entries and one is known.
"""

from __future__ import annotations

import csv
import io
import math
import os
import re
import shlex
from array import array
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from popsteer.errors import PathError
from popsteer.files import read_bytes
from popsteer.tables import kinds
from popsteer.tables.quantities import UNITS, meaning

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

_SAMPLE = 200  # rows from which separator, names and preamble are found
_SHOWN = 12  # names of columns in a message
_SHOWN_CHARACTERS = 40  # of an entry that is no number: enough to find it, short of flooding
_LARGEST = 1e100
_BOTH = ", "  # a comma or white space
_LONGEST = 1_000_000  # characters of a line
_UNITS = {unit for units in UNITS.values() for unit in units} - {"", "1"}
_UNITS |= {"N", "Nm", "rad/s", "deg/s", "1/min", "rpm", "G", "V", "A", "W", "bar", "°C", "C"}
_COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?$")
# Thousands as spreadsheets write them: 5.334.567,5 in German, with narrow spaces in French,
# 5,334,567.5 in English.
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(?:([.\u00a0\u202f])\d{3})(?:\1\d{3})*,\d+$")
_ENGLISH = re.compile(r"[+-]?\d{1,3}(?:,\d{3})+\.\d+$")
_PRINTED = re.compile(r"-?\d+[.,]\d{6}$")
_HASH = re.compile(r"(?<![,;])#")  # a name may begin with one
_WESTERN = re.compile(r"[\t-\r -~°²³µÀ-ü]*")  # text as older Windows programs write it
_COMMENT = re.compile(r"\s*(?:[#%:]|//)")  # a colon as CarMaker's roads have it
_EXCEL = re.compile(r'"?sep=.?"?\s*$')  # in the first line, which separator it takes
_ROW_OF = re.compile(r"(?i:names?|columns?|fields?|channels?|units?|dataset|nstates)$")
_SECTION = re.compile(r"\[([A-Za-z ]+)\]$")


def read_text(file: str | os.PathLike[str]) -> tuple[str, str]:
    """Read a file's name and text; PathError says in one line why it is none."""
    name = os.fsdecode(file)
    try:
        data = read_bytes(name)
    except OSError as error:
        raise PathError(f"{name}: cannot be read: {error.strerror or error}") from error
    except ValueError as error:  # a name that no file can have, with a null character in it
        raise PathError(f"{name!r}: cannot be read: {error}") from error
    if refused := kinds.refusal(data):
        raise PathError(f"{name}: {refused}")
    wide = data.startswith((b"\xff\xfe", b"\xfe\xff"))
    try:
        text = data.decode("utf-16" if wide else "utf-8-sig")
    except UnicodeDecodeError as error:
        text = data.decode("latin-1")
        if wide or not _WESTERN.fullmatch(text):
            line = data.count(b"\n", 0, error.start) + 1
            raise PathError(f"{name}, line {line}: is not text in UTF-8") from error
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        raise PathError(f"{name}, line {line}: holds a null character, is not text")
    return name, text


@dataclass(frozen=True)
class Table:
    """The rows of a text, and what is known of them before their numbers are read."""

    name: str
    text: str
    separator: str | None
    """None: white space."""
    decimal_comma: bool
    columns: int
    head: list[str] = field(default_factory=list)
    head_line: int = 0
    start: int = 0
    """The line after which the numbers begin."""
    comments: list[str] = field(default_factory=list)
    vbox: bool = False
    has_index: bool = False
    """Whether the first column is the index of an array, as pandas writes it."""

    def where(self, line: int) -> str:
        """Name a line, as messages do."""
        return f"{self.name}, line {line}"

    @property
    def _parse(self) -> Callable[[str], float | None]:
        return _parse_comma if self.decimal_comma else _parse

    def at(self, line: int, column: int) -> str:
        """Name an entry by its line and column, as messages do."""
        return f"{self.where(line)}, column {column + 1}"

    def rows(self) -> Iterator[tuple[int, list[str]]]:
        """Give the rows of numbers: each line's number and its entries."""
        for line, content in _contents(self.name, self.text):
            if line > self.start and not (self.vbox and _SECTION.match(content)):
                yield line, split(content, self.separator)

    def entries(self, columns: Sequence[int]) -> Iterator[tuple[int, int, list[str]]]:
        """Give what stands in some columns: index of the row, line, entries."""
        for index, (line, row) in enumerate(self.rows()):
            if len(row) != self.columns:
                self._check_count(line, row, index)
            yield index, line, [row[k] for k in columns]

    def _check_count(self, line: int, row: list[str], index: int) -> None:
        """Refuse a row of another number of columns; one empty entry more ends in a separator."""
        while len(row) > self.columns and not row[-1]:
            row.pop()
        if len(row) != self.columns:
            raise PathError(
                f"{self.where(line)}: found {_counted(len(row))}, the first row has {self.columns}:"
                " complete the one that is wrong, or leave it out",
                index,
            )

    def numbers(self, columns: Sequence[int], *, blank: bool = False) -> NDArray[np.float64]:
        """Read columns, shape (N, len(columns)); with `blank` an empty entry is NaN.

        Raises PathError, which names line and column, where an entry is not a finite number.
        """
        if self._plain is not None:
            return self._plain[:, columns]
        values = array("d")
        parse = self._parse
        for index, line, row in self.entries(columns):
            for column, entry in zip(columns, row, strict=True):
                value = parse(entry)
                if value is not None and abs(value) <= _LARGEST:
                    values.append(value)
                elif blank and (value is not None or not entry):
                    values.append(math.nan)
                else:
                    self._refuse(line, column, index, entry, value)
        return np.array(values).reshape(-1, len(columns))

    @cached_property
    def _plain(self) -> NDArray[np.float64] | None:
        """All columns as numpy reads them; None where any line is more than plain numbers."""
        stream = io.StringIO(self.text, newline=None)
        for _ in range(self.start):
            stream.readline()
        rest = stream.read()
        odd = self.decimal_comma or self.vbox or self.separator == _BOTH or not rest.strip()
        if odd or any(mark in rest for mark in ("#", "%", "//", '"', "_")):
            return None
        try:
            lines = io.StringIO(rest)
            found = np.loadtxt(lines, delimiter=self.separator, comments=None, ndmin=2)
        except ValueError:
            return None
        sound = found.shape[1] == self.columns and bool(np.all(np.abs(found) <= _LARGEST))
        return found if sound else None

    def _refuse(self, line: int, column: int, index: int, entry: str, value: float | None) -> None:
        shown = entry if len(entry) <= _SHOWN_CHARACTERS else entry[:_SHOWN_CHARACTERS] + "..."
        fault = "is not a number" if value is None else "is not finite"
        fault = "is too large" if value is not None and math.isfinite(value) else fault
        if entry and self.head and self.head[column].startswith(entry):
            fault += ": the names come again, so keep one table a file"
        raise PathError(f"{self.at(line, column)}: {shown!r} {fault}", index)

    @cached_property
    def _first(self) -> list[list[str]]:
        return [row for _, row in islice(self.rows(), 3)]

    def is_text(self, column: int) -> bool:
        """Whether a column's first entries are no numbers."""
        shown = [row[column] for row in self._first if len(row) > column]
        return bool(shown) and all(self._parse(entry) is None for entry in shown)

    @property
    def is_logged(self) -> bool:
        """Whether rows are four numbers in C's %f, as F1TENTH's logger writes them."""
        return all(len(row) == 4 and all(map(_PRINTED.match, row)) for row in self._first)

    def option(self, places: Mapping[str, int], unit: Mapping[str, str] = {}) -> str:
        """Word the option that says what columns are: by name, or by number where none tells."""
        parts, head = [], self.head or [""] * self.columns
        for quantity, place in places.items():
            name = head[place]
            tells = head.count(name) == 1 and 0 < len(name) <= 90 and "," not in name
            after = f" [{unit[quantity]}]" if quantity in unit else ""
            parts.append(f"{quantity}={name if tells and name.isprintable() else place + 1}{after}")
        return f"--columns {shlex.quote(','.join(parts))}"

    def listed(self) -> str:
        """List the names of the columns, for a message."""
        names = [each or '""' for each in self.head]
        return (", ".join(names[:_SHOWN]) + (", ..." if len(names) > _SHOWN else ""))[:200]


def read_table(file: str | os.PathLike[str]) -> Table:
    """Find separator, names and first row of a table; PathError where a text is none."""
    return table_of(*read_text(file))


def table_of(name: str, text: str) -> Table:
    """Do the same for a text that was read."""
    if refused := kinds.text_refusal(text):
        raise PathError(f"{name}: {refused}")
    sample = list(islice(_contents(name, text), _SAMPLE))
    separator = _separator([content for _, content in sample[-20:]])
    if separator in (",", _BOTH) and _is_comma_spaced([content for _, content in sample[1:]]):
        separator = None
    marks = {match[1] for _, content in sample if (match := _SECTION.match(content))}
    rows = [
        (line, split(content, separator)) for line, content in sample if not _SECTION.match(content)
    ]
    every = [entry for _, row in rows for entry in row]
    comma = any(_COMMA.match(entry) or _THOUSANDS.match(entry) for entry in every)
    found = Table(name, text, separator, comma, 0)
    begun = rows[0][1] if rows else []
    has_index = begun == ["", *map(str, range(len(begun) - 1))]
    # pandas' head of an array: 0, 1, 2, ... above decimals, and nothing above the index.
    counted = len(rows) > 1 and len(begun) > 2 and begun == list(map(str, range(len(begun))))
    mark = "," if comma else "."
    decimals = counted and all(mark in entry for _, row in rows[1:5] for entry in row)
    rows = rows[has_index or decimals :]
    if not rows:
        return found
    parse = _parse_comma if comma else _parse
    place, units = _head(rows, parse)
    comments = _comments(text, rows[0 if place is None else place][0])
    if place is None:
        alike = [row for _, row in rows if len(row) == len(rows[0][1])]
        columns = max(map(len, map(_filled, alike)))
        head = _head_of_comment(comments, columns, separator) or kinds.echoed(rows[0][1])
        start = rows[0][0] - 1
        found = replace(found, columns=columns, head=head, start=start, has_index=has_index)
    else:
        line, head = rows[place][0], _head_of([row for _, row in rows[place:]], units)
        first = rows[place + units + 1][1] if place + units + 1 < len(rows) else []
        if len({*head}) < len(head) == len(first):
            head = _nested(head, [row for _, row in rows[place + 1 :] if len(row) == len(head)])
        columns = max(len(head), *(k + 1 for k, entry in enumerate(first) if entry), 0)
        start = rows[place + units][0]
        found = replace(found, columns=columns, head=head, head_line=line, start=start)
    if found.columns < 2:
        message = (
            f"{found.where(rows[0][0])}: found {_counted(found.columns)}, at least 2 are needed (x"
            " and y, separated by a comma, a semicolon or white space)"
        )
        raise PathError(message)
    names = [each.lower() for each in found.head]
    is_vbox = marks >= {"column names", "data"}
    renamed = _VBOX if is_vbox else _NGSIM if {"local_x", "v_vel"} <= {*names} else {}
    if renamed:
        pairs = zip(names, found.head, strict=True)
        found = replace(found, head=[renamed.get(name, each) for name, each in pairs])
    return replace(found, comments=comments, vbox=is_vbox)


# Racelogic's VBOX writes minutes, positive to the north and to the west.
_VBOX = {"lat": "lat [min]", "long": "lon [-min]", "velocity": "velocity [km/h]"}
_VBOX |= {"heading": "heading [deg]", "time": "time [hhmmss]"}
# NGSIM's recordings are in feet; beside the road's plane they have that of the state.
_NGSIM = {"local_x": "Local_X [ft]", "local_y": "Local_Y [ft]", "v_vel": "v_Vel [ft/s]"}
_NGSIM |= {"global_time": "Global_Time [ms]"}
_NGSIM |= {f"global_{axis}": f"Global_{axis.upper()} of the state" for axis in "xy"}


def _head_of(rows: list[list[str]], units: int) -> list[str]:
    """Give the names that begin some rows, with their units; none to columns behind them."""
    widest = max(len(_filled(row)) for row in rows[1:] or rows)
    head = rows[0] if len(_filled(rows[0])) < widest <= len(rows[0]) else _filled(rows[0])
    told = next((k for k, row in enumerate(rows[1 : 1 + units], 1) if _are_units(row)), len(rows))
    return _explained(head[: max(widest, len(_filled(head)))], *rows[told : 1 + units])


def _filled(row: list[str]) -> list[str]:
    """Leave out empty entries at the end of a row, which ends in separators."""
    return row[: max((k for k, entry in enumerate(row) if entry), default=0) + 1]


def _explained(
    head: list[str], told: Sequence[str] = (), sources: Sequence[str] = (), *_: Sequence[str]
) -> list[str]:
    """Put the units that a row below tells behind names, and before those that repeat a source.

    RaceChrono writes of several speeds which is the GPS's.
    """
    if sources:
        of = zip(head, sources, strict=False)
        head = [f"{b.split()[-1]}/{a}" if b and head.count(a) > 1 else a for a, b in of]
    pairs = zip(head, told, strict=False) if told else ((name, "") for name in head)
    return [f"{name} [{unit}]" if unit else name for name, unit in pairs]


def _nested(head: list[str], rows: list[list[str]]) -> list[str]:
    """Put names that repeat behind the title of an empty column: position,x,y is ,position/x."""
    found, above = [], ""
    for name, entries in zip(head, zip(*rows, strict=True), strict=True):
        is_title = not any(entries)
        is_part = above and (head.count(name) > 1 or len(name) == 1)
        found.append("" if is_title else f"{above}/{name}" if is_part else name)
        above = name if is_title else above
    return found


def split(content: str, separator: str | None) -> list[str]:
    """Split a line into its entries, without quotes and surrounding white space."""
    if separator is None:
        return [entry.strip('",') for entry in content.split()]
    if separator != ";":
        content = content.rstrip("; ")  # which may end every line
    if '"' in content:
        reader = csv.reader((content,), delimiter=separator, skipinitialspace=True)
        return [entry.strip() for entry in next(reader)]
    if separator == _BOTH:
        return content.replace(",", " ").split()
    return [entry.strip() for entry in content.split(separator)]


def _contents(name: str, text: str) -> Iterator[tuple[int, str]]:
    """Give the lines that hold more than a comment, with their numbers.

    They end where editors end them; str.splitlines would also at a form feed or U+2028, and the
    numbers in messages would drift from those an editor shows.
    """
    for number, line in enumerate(io.StringIO(text, newline=None), start=1):
        if len(line) > _LONGEST:
            raise PathError(f"{name}, line {number}: is longer than {_LONGEST:,} characters")
        content = _HASH.split(line, 1)[0] if "#" in line and '"' not in line else line
        if content.strip(" \t\r\n,;") and not (
            _COMMENT.match(content) or (number == 1 and _EXCEL.match(line))
        ):
            yield number, content.strip(" \n")  # a tab may stand before a column without a name


def _comments(text: str, before: int) -> list[str]:
    lines = islice(io.StringIO(text, newline=None), before - 1)
    stripped = (line.strip() for line in lines)
    return [line.lstrip("#%/: ") for line in stripped if _COMMENT.match(line)]


def _separator(lines: list[str]) -> str | None:
    for mark in (";", "\t", ","):
        counts = [line.rstrip("; ").count(mark) for line in lines]
        most = 2 * sum(map(bool, counts)) + bool(counts[:1] and counts[0]) > len(counts)
        if most and (mark != "\t" or min(counts) > 0):
            return _BOTH if mark == "," and all(map(_is_spaced, lines)) else mark
    return None


def _is_comma_spaced(lines: list[str]) -> bool:
    """Whether commas are decimal ones between white space: some number is else none, as 0,05 is."""
    rows = [[entry.rstrip(",") for entry in line.split()] for line in lines]
    every = [entry for row in rows for entry in row]
    return (
        len({len(row) for row in rows}) == 1 < len(rows[0])
        and all(_COMMA.match(entry) or entry.lstrip("+-").isdecimal() for entry in every)
        and any(re.search(r",0\d", entry) for entry in every)
    )


def _is_spaced(line: str) -> bool:
    """Whether entries between commas are several numbers, or a number and a flag."""
    entries = [entry.split() for entry in line.split(",")]
    flags = ("True", "False")
    return any(len(each) > 1 for each in entries) and all(
        _parse(part) is not None or part in flags for each in entries for part in each
    )


def _are_units(row: list[str]) -> bool:
    """Whether a row says mostly units."""
    told = [each in _UNITS for each in row if each]
    return 2 * sum(told) > len(told)


def _head(
    rows: list[tuple[int, list[str]]], parse: Callable[[str], float | None]
) -> tuple[int | None, int]:
    """Find the row of names, None if there is none; and how many rows below it say units."""

    def is_names(place: int) -> bool:
        row = rows[place][1]
        return any(row) and all(parse(entry) is None for entry in row)

    def is_numbers(row: list[str]) -> bool:
        told = [parse(entry) is not None for entry in row if entry]
        return 2 * sum(told) > len(told)

    def has_data(place: int, columns: int) -> bool:
        there = rows[place : place + 2]
        return bool(there) and all(
            len(row) in (columns, columns + 1) and not is_names(place + k)
            for k, (_, row) in enumerate(there)
        )

    for place, (_, row) in enumerate(rows):
        known = sum(meaning(entry).quantity is not None for entry in row)
        is_mixed = place == 0 and known > 1 and not is_numbers(row)  # pandas' 0, 1 among names
        if known == 0 or not (is_mixed or is_names(place)):
            continue
        if any(len(above) == len(row) and is_numbers(above) for _, above in rows[:place]):
            break
        units = 0  # and where the values come from
        while place + 1 + units < len(rows) and is_names(place + 1 + units):
            units += 1
        below = [each for _, each in rows[place + 1 : place + 1 + units]]
        if not any(_are_units(each) or each == row for each in below):  # or the names again
            units = 0
        if (known > 1 and place == 0) or has_data(place + 1 + units, len(row)):
            return place, units
    return (0, 0) if is_names(0) else (None, 0)


def _head_of_comment(comments: list[str], columns: int, separator: str | None) -> list[str]:
    """Take the comment above the numbers for names, where it has as many and one is known.

    Units may stand below it, and before each what the row is (CarMaker).
    """
    below: list[list[str]] = []
    for text in reversed(comments):
        rows = list(_entries_of_comment(text, columns, separator))
        for names in rows:
            if not _are_units(names) and any(meaning(each).quantity for each in names):
                return _explained(names, *filter(_are_units, below))
        if not rows:
            break
        below.append(rows[0])
    return []


def _entries_of_comment(text: str, columns: int, separator: str | None) -> Iterator[list[str]]:
    """Split a comment into as many entries as there are columns, in all ways that there are."""
    for mark in dict.fromkeys((separator, ";", ",", "\t", None)):
        line = re.sub(r"\s+([\[(])", r"\1", text) if mark is None else text
        entries = split(line.rstrip(mark), mark)
        if len(entries) == columns + 1 and _ROW_OF.match(entries[0]):
            del entries[0]
        if len(entries) == columns:
            yield entries


def _counted(number: int) -> str:
    return f"{number} column" if number == 1 else f"{number} columns"


def _parse(entry: str) -> float | None:
    """Read a number as CSV files write it; None if it is not one."""
    if "_" in entry:  # float() reads 1_000, which in a table is a slip rather than a number
        return None
    try:
        return float(entry.replace(",", "") if _ENGLISH.match(entry) else entry)
    except ValueError:
        return None


def _parse_comma(entry: str) -> float | None:
    """Read a number with a decimal comma, beside which a dot is one of thousands."""
    if grouped := _THOUSANDS.match(entry):
        entry = entry.replace(grouped[1], "")
    return None if "." in entry else _parse(entry.replace(",", "."))
