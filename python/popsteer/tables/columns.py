"""Which column is what: by what is asked for, by its name, or by what it shows itself to be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from popsteer.errors import ConfigError, PathError, PopsteerError
from popsteer.tables import shown
from popsteer.tables.quantities import UNITS, factor, meaning, spelled

if TYPE_CHECKING:
    from popsteer.tables.shown import Floats
    from popsteer.tables.text import Table

Columns: TypeAlias = str | Sequence[str] | Mapping[str, str]
"""What columns are asked for: ``"x,y,-,speed [km/h]"`` in their order, ``"speed=V [km/h]"`` or a
mapping by their names."""
LEFT_OUT = "-"
_BEFORE = {"count", "t", "s", "nothing"}  # what stands before x in a file without names
_TIMED = "speed speed, as time and distances are"
_MANY = 40  # columns without names: what has more is no path


@dataclass(frozen=True)
class Column:
    """A column that is read: where it stands, its name, and its unit if one is known."""

    place: int
    name: str
    unit: str | None = None

    def factor(self, quantity: str, file: str) -> float:
        """Give what its numbers are multiplied by; PathError where its unit is not known."""
        try:
            return 1.0 if self.unit is None else factor(quantity, self.unit)
        except PopsteerError:
            known = ", ".join(spelled(quantity))
            raise PathError(
                f"{file}: {self}: the unit {self.unit!r} of {quantity} is not known; known:"
                f" {known} (--columns {quantity}='NAME [{spelled(quantity)[0]}]' says another)"
            ) from None

    def __str__(self) -> str:
        name = "".join(each if each.isprintable() else "?" for each in self.name)
        return name if len(name) <= 40 else name[:40] + "..."


def asked_for(columns: Columns | None) -> list[str] | dict[str, str]:
    """Give the names of columns in their order, or by quantity; empty for None.

    Raises ConfigError, which names what is not known.
    """
    if columns is None:
        return []
    if isinstance(columns, str):
        parts = [part.strip() for part in columns.split(",")]
        if all("=" in part for part in parts):
            pairs = (part.partition("=") for part in parts)
            columns = {quantity.strip(): name.strip() for quantity, _, name in pairs}
        else:
            columns = parts
    if isinstance(columns, Mapping):
        for quantity in columns:
            if quantity not in UNITS:
                raise ConfigError("columns", quantity, f"one of {', '.join(UNITS)}")
        return dict(columns)
    found = list(columns)
    for name in found:
        if name != LEFT_OUT and meaning(name).quantity is None:
            known = f"{', '.join(UNITS)}, or {LEFT_OUT} for a column that is left out"
            raise ConfigError("columns", name, f"made of {known}")
    return found


def named(table: Table, wanted: list[str] | dict[str, str]) -> dict[str, Column]:
    """Find columns by the names that are asked for, and else by their own.

    Raises PathError, which lists the names there are, where one is missing or given twice.
    """
    where = table.where(table.head_line) if table.head_line else table.name
    if isinstance(wanted, list) and wanted:
        if len(wanted) > table.columns:
            raise PathError(
                f"{table.name}: {len(wanted)} columns are asked for, there are {table.columns}"
            )
        head: Sequence[str] = wanted
    else:
        head = table.head or []
    found: dict[str, Column] = {}
    if isinstance(wanted, dict):
        found = {key: _by_name(table, where, key, name) for key, name in wanted.items()}
    given, taken = set(found), {column.place for column in found.values()}
    ranks: dict[str, tuple[bool, int]] = {}
    for place, name in enumerate(head):
        quantity, unit, rank = meaning(name)
        if quantity is None or quantity in given or place in taken:
            continue
        if quantity in found and rank == ranks[quantity]:
            first = found[quantity].name
            if first == name:
                raise PathError(f"{where}: two columns are named {name[:200]}")
            raise PathError(
                f"{where}: two columns could be {quantity}: {first[:90]}, {name[:90]} (--columns"
                f" {quantity}=NAME chooses one)"
            )
        if quantity not in found or rank < ranks[quantity]:
            found[quantity], ranks[quantity] = Column(place, name, unit), rank
    return found


def _by_name(table: Table, where: str, quantity: str, name: str) -> Column:
    head = table.head or []
    plain = name.rpartition("[")[0].strip() if name.endswith("]") else ""
    for wanted in filter(None, (name, plain)):
        if head.count(wanted) > 1:
            raise PathError(f"{where}: {head.count(wanted)} columns are called {wanted!r}")
        if wanted in head:
            unit = meaning(f"x {name[len(wanted) :]}" if wanted == plain else wanted).unit
            return Column(head.index(wanted), wanted, unit)
    raise PathError(
        f"{where}: no column {name!r}; there are: {table.listed() or 'no names'}"
        f" (--columns {quantity}=NAME names another)"
    )


def check_units(name: str, columns: Mapping[str, Column]) -> dict[str, float]:
    """Give each column's factor; PathError names the column whose unit is not known."""
    return {quantity: column.factor(quantity, name) for quantity, column in columns.items()}


@np.errstate(all="ignore")  # what is out of all proportion agrees with nothing
def explained(
    name: str, values: Floats, texts: Mapping[int, str] | None = None
) -> tuple[dict[str, Column], list[str]]:
    """Find which columns without names are what, and say what the others are.

    Every column has to be explained by the waypoints that two of them make; else PathError says
    what is not, and which option settles it. `texts` says what columns are that are no numbers.
    """
    texts = texts or {}
    count = values.shape[1]
    if count > _MANY:
        raise PathError(f"{name}: {count} columns without names (--columns x,y,... names them)")
    if shown.is_degrees(values[:, 0], values[:, 1]):
        both = ["lon", "lat"] if np.abs(values[:, 0]).max() > 90.0 else ["lat", "lon"]
        raise PathError(
            f"{name}: columns 1 and 2 are degrees rather than metres: say which is which, as"
            f" --columns {','.join(both + ['-'] * (count - 2))}"
        )
    tried = [_explain(values, x, y, texts) for x, y in _pairs(values) if not {x, y} & set(texts)]
    possible = [known for known in tried if _is_possible(values, known, texts)]
    if not possible:
        raise PathError(f"{name}: no two columns are waypoints (--columns x,y,... names them)")
    known = max(possible, key=len)  # of several the first
    if len(known) < count:
        raise PathError(f"{name}: {_unexplained(values, known)}")
    found, notes = {}, []
    for place, what in sorted(known.items()):
        quantity, _, words = what.partition(" ")
        if quantity in ("x", "y", "yaw", "speed", "curvature"):
            found[quantity] = Column(place, f"column {place + 1}")
        if quantity not in ("x", "y", "yaw", "curvature"):
            notes.append(f"column {place + 1} is {words}")
    return found, notes


def _is_possible(values: Floats, known: Mapping[int, str], texts: Mapping[int, str]) -> bool:
    """Whether x and y may stand behind other columns: those are a count, a time or an arc length.

    Where x and y are the first two, 0, 1, 2, ... may be x itself, so that another column has to
    prove the waypoints, or a stamp is none of a map's coordinates.
    """
    x = next(iter(known))
    found = {known.get(k, "?").split()[0] for k in range(values.shape[1])}
    before = {known.get(k, "?").split()[0] for k in range(x)}
    is_proved = (
        set(range(x)) <= set(texts)
        or _TIMED in known.values()
        or found & {"yaw", "curvature", "s", "normal"}
    )
    return before <= _BEFORE and bool(x == 0 or is_proved or values[0, :x].max() > 1e9)


def _pairs(values: Floats) -> list[tuple[int, int]]:
    """Give the columns that may be x and y, the likeliest first."""
    still = [bool(np.ptp(column) == 0.0) for column in values.T]
    # A height of 0 between x and y, as Unity's coordinates have it.
    there = [k for k in range(values.shape[1]) if not (still[k] and values[0, k] == 0.0)]
    pairs = list(pairwise(range(values.shape[1])))
    if values.shape[1] == 3 and there == [0, 2] and np.any(np.diff(np.sign(np.diff(values[:, 0])))):
        pairs.insert(0, (0, 2))
    return [(a, b) for a, b in pairs if not (still[a] and still[b])] or pairs[:1]


def _explain(values: Floats, x: int, y: int, texts: Mapping[int, str]) -> dict[int, str]:
    """Say of each column what the waypoints of two make of it: a quantity, and words."""
    known = {x: "x", y: "y", **texts}
    way = shown.along(values[:, [x, y]])
    others = [k for k in range(values.shape[1]) if k not in known]
    turned = None
    for k in others:
        column = values[:, k]
        if np.all(column == 0.0):
            known[k] = "nothing always 0"
        elif shown.is_count(column):
            known[k] = "count the number of the row"
        elif shown.is_arc(way, column):
            known[k] = "s the arc length"
        elif turned is None and (turned := shown.heading(values[:, [x, y]], column)) is not None:
            known[k] = f"yaw yaw ({turned})"
        elif shown.is_curvature(way, column):
            known[k] = "curvature curvature"
        elif (k < min(x, y) or column[0] > 1e8) and shown.is_time(column):
            known[k] = "t time"
        elif turned is None and shown.is_near_heading(values[:, [x, y]], column):
            known[k] = "heading a heading, which is left out: the waypoints turn otherwise"
    _find_pairs(values, way, known, others)
    _find_speed(values, way, known)
    return known


def _find_pairs(values: Floats, way: shown.Along, known: dict[int, str], others: list[int]) -> None:
    """Find columns that are something together."""
    for a, b in pairwise(others):
        if {a, b} & known.keys():
            continue
        if shown.is_direction(way, values[:, a], values[:, b]):
            known |= dict.fromkeys((a, b), "normal a unit vector along or beside the path")
        elif shown.are_widths(way, values[:, a], values[:, b], alone=values.shape[1] == 4):
            known |= dict.fromkeys((a, b), "nothing half of the width, as its neighbour is")


def _find_speed(values: Floats, way: shown.Along, known: dict[int, str]) -> None:
    """Find the speed among the columns that are not known yet, by one of five proofs."""
    rest = [k for k in range(values.shape[1]) if k not in known]
    place_of_y = next(k for k, what in known.items() if what == "y")
    time = next((k for k, what in known.items() if what == "t time"), None)
    for k in rest:
        column = values[:, k]
        if k < place_of_y:
            continue
        paired = [j for j in rest if j != k and shown.is_acceleration(way, values[:, j], column)]
        clock = [j for j in rest if j != k and shown.is_time(values[:, j])] if time is None else []
        clock = clock if time is None else [time]
        timed = [j for j in clock if shown.is_rate(way, column, values[:, j])]
        if timed:
            known[k], known[timed[0]] = _TIMED, "t time"
        elif (column < 0.0).any():
            continue
        elif paired:
            known[k], known[paired[0]] = "speed speed", "acceleration the acceleration"
        elif shown.is_recorded_speed(way, column):
            known[k] = "speed speed, as the waypoints are apart"
        elif len(rest) == 1 and shown.is_planned_speed(way, column):
            known[k] = "speed speed, lower in bends"
        elif (
            # What F1TENTH's waypoint logger writes: x, y, a heading that proves to be one, speed.
            values.shape[1] == 4 and rest == [3] and known.get(2, "").startswith(("yaw", "heading"))
        ):
            known[k] = "speed speed, as F1TENTH's logger writes x, y, yaw, speed"
        else:
            continue
        return


def _unexplained(values: Floats, known: Mapping[int, str]) -> str:
    count = values.shape[1]
    names = {k: what.partition(" ")[0] for k, what in known.items()}
    rest = [k for k in range(count) if k not in known]
    ranges = [
        f"column {k + 1} ({values[:, k].min():.5g} to {values[:, k].max():.5g})" for k in rest
    ]
    read = [
        n if n in ("x", "y", "yaw", "curvature", "speed") else "-"
        for k in range(count)
        for n in [names.get(k, "?")]
    ]
    likely = next((k for k in rest if values[:, k].min() >= 0.0 < np.ptp(values[:, k])), rest[-1])
    first = ",".join("speed" if k == likely else each for k, each in enumerate(read))
    plain = ",".join(read)
    listed = ", ".join(ranges[:4]) + (", ..." if len(ranges) > 4 else "")
    return (
        f"{count} columns without names, and the waypoints do not say what {listed} "
        f"{'is' if len(rest) == 1 else 'are'}: a speed would be --columns {first}, "
        f"nothing that is needed --columns {plain}"
    )
