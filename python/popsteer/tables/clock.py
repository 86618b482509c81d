"""Times of logs: numbers in any unit, seconds and nanoseconds apart, clocks and dates."""

from __future__ import annotations

import re
from contextlib import suppress
from datetime import date
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from popsteer.errors import PathError
from popsteer.tables.columns import Column, check_units
from popsteer.tables.quantities import EPOCH, UNITS, factor

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from numpy.typing import NDArray

    from popsteer.tables.text import Table

    Rows = Iterable[tuple[int, list[str]]]

_CLOCK = re.compile(
    # A day may come first, in words and in any order, by which a drive is not told from another.
    r"(?:(\d{4})[-/_.](\d\d)[-/_.](\d\d)[T /_]\s*|(?:[\w./,-]+\s+){1,5})?"
    # Spreadsheets leave the hours out.
    r"(?:(\d\d?):(\d\d):(\d\d(?:[.,]\d+|:\d{3,6})?)|(\d\d?):(\d\d[.,]\d+))"
    r"\s*(Z|UTC|GMT|[+-]\d\d:?\d\d|[APap]\.?[Mm]\.?)?(?: [A-Z]{3,4})?(?: \d{4})?$"
)
_DURATION = re.compile(r"([+-]?[\d.,]+(?:[eE][+-]?\d+)?)\s*([A-Za-zµ]+)$")  # MATLAB's 0.1 sec
PARTS = {"t_ms": ("ms", 10**6), "t_us": ("us", 10**3), "t_ns": ("ns", 1)}
"""What may stand beside whole seconds, each with its unit and that in ns."""


class Times(NamedTuple):
    """Times of rows [s] since an origin, which keeps the digits that a float has no room for."""

    values: NDArray[np.float64]
    origin: int
    """What the times count from [ns]; 0 where they are as in the file."""
    said: str
    """In what unit they were, where that is not seconds by itself."""
    is_sure: bool
    """Whether the unit was given, or shown by the size."""


def find(table: Table, places: dict[str, Column]) -> None:
    """Find the columns of time: `s` and `ns` beside each other are one."""
    part = next((key for key in PARTS if key in places), None)
    if part and "t" not in places and "s" in table.head:
        places["t"] = Column(table.head.index("s"), "s")
    if part and "t" not in places:
        alone = places.pop(part)
        places["t"] = Column(alone.place, alone.name, alone.unit or PARTS[part][0])


def read(table: Table, places: Mapping[str, Column], unit: str | None) -> Times:
    """Read the times of all rows; NaN where there is none.

    Raises PathError, which names line and column, where an entry is neither number nor clock.
    """
    column, part = places["t"], next((key for key in PARTS if key in places), None)
    unit = unit or column.unit
    use = [column.place] + ([] if part is None else [places[part].place])
    entries = ((line, row) for _, line, row in table.entries(use))
    first, *after = next((row for _, _, row in table.entries(use) if row[0]), [""])
    if part and _is_whole(first) and _is_whole(after[0]):
        name, size = PARTS[part]
        if int(after[0]) * size < 10**9:  # else it is a clock of its own
            return _stamps(table, entries, column, (10**9, size), f"t is s + {name}")
    if unit == "hhmmss":
        values = table.numbers([column.place], blank=True)[:, 0]
        hours, minutes = np.floor(values / 1e4), np.floor(values / 1e2) % 100.0
        since = 3600.0 * hours + 60.0 * minutes + values % 100.0
        return Times(_of_one_day(since), 0, "t is a clock", is_sure=True)
    if (as_clock := _CLOCK.match(first)) or re.search(r"\d[:\sA-DF-Za-df-zµ_]", first):
        return _clocks(table, entries, column, dated=bool(as_clock and as_clock[1]))
    if _is_whole(first) and len(first) > 11 and unit in (None, "ns", "us", "ms"):
        unit = unit or next(name for least, name in (*EPOCH, (0, "ms")) if int(first) >= least)
        return _stamps(table, entries, column, (dict(PARTS.values())[unit],), f"t is in {unit}")
    if unit == column.unit:
        check_units(table, {"t": column})
    scale = factor("t", unit or "s")
    found = scale * table.numbers([column.place], blank=True)[:, 0]
    return Times(found, 0, f"t is in {unit}" if scale != 1.0 else "", unit is not None)


def _is_whole(entry: str) -> bool:
    """Whether an entry is a whole number that some stamp may be."""
    return entry.isdecimal() and len(entry) < 30


def _stamps(
    table: Table, entries: Rows, column: Column, sizes: tuple[int, ...], said: str
) -> Times:
    """Read whole numbers that together are a time, each of so many ns."""
    stamps = []
    for line, row in entries:
        for entry in row[: len(sizes)]:
            if not _is_whole(entry):
                place = table.at(line, column.place)
                raise PathError(f"{place}: {entry[:40]!r} is no whole number")
        stamps.append(sum(int(each) * size for each, size in zip(row, sizes, strict=False)))
    since = np.array([1e-9 * (stamp - stamps[0]) for stamp in stamps])
    return Times(since, stamps[0], f"{said}, and counted from the first row", is_sure=True)


def _clocks(table: Table, entries: Rows, column: Column, *, dated: bool) -> Times:
    values, colons = [], 0
    for line, row in entries:
        value, colons = _clock(row[0]), max(colons, row[0].count(":"))
        value = _duration(row[0]) if value is None else value
        if value is None:
            raise PathError(
                f"{table.at(line, column.place)}: {row[0][:40]!r} is no time: seconds, a clock, or"
                " a date and a clock as 2024-05-01T23:59:58.5"
            )
        values.append(value)
    since = np.array(values)
    if not colons:
        return Times(since, 0, "t is a duration", is_sure=True)
    if not dated:
        span = 86400.0 if colons > 1 else 3600.0
        return Times(_of_one_day(since, span), 0, "t is a clock", is_sure=True)
    origin = int(since[0])
    return Times(since - origin, origin * 10**9, "t is a date and a clock", is_sure=True)


def _duration(entry: str) -> float | None:
    """Give the seconds of a number with a unit behind it; None if it is none."""
    found = _DURATION.match(entry)
    size = UNITS["t"].get(found[2].lower()) if found else None
    with suppress(ValueError):
        return size * float(found[1].replace(",", ".")) if found and size else None
    return None


def _clock(entry: str) -> float | None:
    """Give the seconds of a clock, since 1970 where it has a date; None if it is none."""
    found = _CLOCK.match(entry)
    if found is None:
        return None
    year, month, day, hour, *minutes, zone = found.groups()
    minute, second = filter(None, minutes)
    since = 3600.0 * int(hour or 0) + 60.0 * int(minute) + float(re.sub("[,:]", ".", second))
    if zone and zone[0] in "APap":
        since += 43200.0 * ((zone[0] in "Pp") - (int(hour or 0) == 12))
    elif zone and zone[0] in "+-":
        away = 60 * int(zone[1:3]) + int(zone[-2:])
        since -= 60.0 * (away if zone[0] == "+" else -away)
    try:
        days = date(int(year), int(month), int(day)).toordinal() - 719163 if year else 0
    except ValueError:
        return None
    return since + 86400.0 * days


def _of_one_day(since: NDArray[np.float64], span: float = 86400.0) -> NDArray[np.float64]:
    """Go on past midnight, or past the hour."""
    return since + span * np.cumsum(np.diff(since, prepend=since[:1]) < -0.5 * span)
