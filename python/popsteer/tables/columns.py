"""Which column is what: by what is asked for, by its name, or by what it shows itself to be."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from popsteer.errors import ConfigError, PathError, PopsteerError
from popsteer.tables import shown
from popsteer.tables.quantities import (
    UNITS,
    converted,
    factor,
    meaning,
    seconds,
    share,
    spelled,
)

if TYPE_CHECKING:
    from popsteer.tables.shown import Floats
    from popsteer.tables.text import Table

Columns: TypeAlias = str | Sequence[str] | Mapping[str, str]
"""What columns are asked for: ``"x,y,-,speed [km/h]"`` in their order, ``"speed=V [km/h]"`` or a
mapping by their names."""
LEFT_OUT = "-"
_BEFORE = {"count", "t", "s", "nothing"}  # what stands before x in a file without names
_READ = {each: each for each in ("x", "y", "yaw", "speed", "curvature")}
_CLOCK = "t time"
_SECONDS = 1e8  # a clock that counts seconds from 1970 is beyond it
# Of each unit, what is said of a speed in it that time and distances prove.
_TIMED: dict[str, str | None] = {"speed speed, as time and distances are": None}
_TIMED |= {f"speed speed in {unit}, as time and distances are": unit for unit in shown.SPEEDS}
_FARTHEST = 6.1e7  # m, of the coordinates of any map: eastings with the zone before them
MANY = 40  # columns without names: what has more is no path's
_PARTS = ("v_east", "v_north")
# What tells a quantity that has no column of its own.
_TOLD_BY = {"x": {"lat", "lon"}, "y": {"lat", "lon"}, "yaw": {"qz", "qw"}, "speed": {*_PARTS}}
_WHOSE = {f"{each}id" for each in ("track", "agent", "vehicle", "object", "actor", "car", "")}


@dataclass(frozen=True)
class Column:
    """A column that is read: where it stands, its name, and its unit if one is known."""

    place: int
    name: str
    unit: str | None = None

    def __str__(self) -> str:
        name = "".join(each if each.isprintable() else "?" for each in self.name)
        return name if len(name) <= 40 else name[:40] + "..."

    def said(self, quantity: str) -> str:
        """Word it as a quantity, by its name where that is another."""
        return quantity if str(self) == quantity else f"{quantity} ({self})"


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


def named(
    table: Table, wanted: list[str] | dict[str, str], known: Collection[str]
) -> dict[str, Column]:
    """Find columns of `known` quantities by the names that are asked for, and else by their own.

    Raises PathError, which lists the names there are, where one is missing or given twice.
    """
    where = table.where(table.head_line) if table.head_line else table.name
    head: Sequence[str] = table.head
    found: dict[str, Column] = {}
    if isinstance(wanted, dict):
        found = {key: _by_name(table, where, key, name) for key, name in wanted.items()}
    elif wanted:
        if len(wanted) > table.columns:
            raise PathError(
                f"{table.name}: {len(wanted)} columns are asked for, there are {table.columns}"
            )
        head = wanted
    if head is not wanted and (more := table.columns - len(head)) > 0 < len(head):
        read = [meaning(name).quantity or LEFT_OUT for name in head]
        ways = (",".join(each) for each in ([*read, *"-" * more], [*"-" * more, *read]))
        known_ones = f" (--columns {' or --columns '.join(ways)} says which is which)"
        is_told = {"x", "y"} <= {*read} or {"lat", "lon"} <= {*read}
        raise PathError(
            f"{where}: {len(head)} name{'s' * (len(head) > 1)} above {table.columns} columns"
            + (known_ones if is_told and table.columns <= MANY else ": is it a table?")
        )
    taken = {column.place for column in found.values()}
    alike: dict[str, list[tuple[tuple[bool, int], Column]]] = {}
    plain = [name.lower() for name in head]
    together = {"e": "east", "n": "north"} if {"e", "n"} <= {*plain} else {}
    for place, name in enumerate(head):
        quantity, unit, rank = meaning(together.get(plain[place], name))
        rank = (True, len(UNITS) ** 3) if share(quantity, unit) else rank  # before an angle: none
        if quantity in known and quantity not in found and place not in taken:
            alike.setdefault(str(quantity), []).append((rank, Column(place, name, unit)))
    several = {}
    for quantity, each in alike.items():
        plainest = min(rank for rank, _ in each)
        found[quantity], *others = [column for rank, column in each if rank == plainest]
        if others:
            several[quantity] = found[quantity], others[0]
    for quantity, (first, second) in several.items():
        said = f"could be {quantity}: {first.name[:90]}, {second.name[:90]}"
        said = f"are named {first.name[:200]}" if first.name == second.name else said
        firsts = {key: each.place for key, (each, _) in several.items()}
        remedy = "" if head is wanted else f" ({table.option(firsts)} chooses the first)"
        raise PathError(f"{where}: two columns {said}{remedy}")
    return found


def _by_name(table: Table, where: str, quantity: str, name: str) -> Column:
    head = table.head
    plain = name.rpartition("[")[0].strip() if name.endswith("]") else ""
    for wanted in filter(None, (name, plain)):
        unit = meaning(f"x {name[len(wanted) :]}" if wanted == plain else wanted).unit
        if head.count(wanted) > 1:
            raise PathError(f"{where}: {head.count(wanted)} columns are called {wanted!r}")
        if wanted in head:
            return Column(head.index(wanted), wanted, unit)
        if wanted.isdecimal() and 1 <= int(wanted) <= table.columns:
            return Column(int(wanted) - 1, f"column {wanted}", unit if wanted == plain else None)
    raise PathError(
        f"{where}: no column {name!r}; there are: {table.listed() or 'no names'}"
        f" (--columns {quantity}=NAME names another)"
    )


def ignored(table: Table, used: Collection[Column]) -> list[str]:
    """Say which columns with a name are not read; nothing where all are."""
    places = {column.place for column in used}
    left = [f"{Column(k, name)}" for k, name in enumerate(table.head) if name and k not in places]
    return [f"ignored: {', '.join(left[:6])}{', ...' * (len(left) > 6)}"] if left else []


def check_there(table: Table, places: Collection[str], needed: Sequence[str]) -> None:
    """Refuse a table in which columns are missing, PathError: it lists the names there are."""
    missing = [k for k in needed if k not in places and not _TOLD_BY.get(k, {k}) <= {*places}]
    where = table.where(table.head_line) if table.head_line else table.name
    if missing and not table.head:
        raise PathError(
            f"{where}: {table.columns} columns without names (--columns {','.join(needed)} names"
            " them in their order, - is for one that is left out)"
        )
    if missing:
        no = "--columns makes none" if {*missing} & {*table.head} else "no column is named"
        raise PathError(
            f"{where}: {no} {' or '.join(missing)}; there are: {table.listed()}"
            f" (--columns {','.join(f'{key}=NAME' for key in missing)} says which)"
        )


def check_one(table: Table) -> None:
    """Refuse by PathError a table of several vehicles, as recordings of traffic are."""
    for k, name in enumerate(table.head):
        whose = re.sub("[^a-z]", "", name.lower())
        # What is but called id may be that of a row, or of a lane: in recordings it is at times.
        is_timed = any("frame" in each.lower() or meaning(each)[0] == "t" for each in table.head)
        if whose not in _WHOSE or (whose == "id" and not is_timed):
            continue
        rows = [row[k] for _, row in table.rows() if len(row) > k]
        said = list(dict.fromkeys(rows))
        if len(said) > 1 and (whose != "id" or 2 * len(said) <= len(rows)):
            raise PathError(
                f"{table.name}: {Column(k, name)} says {', '.join(said[:3])[:60]}"
                f"{', ...' * (len(said) > 3)}: rows of {len(said)} vehicles: keep those of one"
            )


def check_units(table: Table, columns: Mapping[str, Column]) -> None:
    """Refuse by PathError, which names it, a column whose unit is not known."""
    usual = {}
    for quantity, column in columns.items():
        try:
            factor(quantity, column.unit or "1")
        except PopsteerError:  # noqa: PERF203 - all are named at once
            usual[quantity] = spelled(quantity)[0]
    for quantity, unit in usual.items():
        column = columns[quantity]
        if (full := share(quantity, column.unit)) is not None:
            raise PathError(
                f"{table.name}: {column} is a share of the largest angle: --unit steer={full} with"
                f" the front wheels' ANGLE at {'100 %' if '/' in full else '1'} in rad"
            )
        places = {key: columns[key].place for key in usual}
        remedy = f" ({table.option(places, usual)} takes it for {unit})" if table.head else ""
        raise PathError(
            f"{table.name}: {column}: the unit {column.unit!r} of {quantity} is not known; known:"
            f" {', '.join(spelled(quantity))}{remedy}"
        )


def measured(
    table: Table, places: dict[str, Column], *, given: Collection[str] = (), blank: bool = False
) -> tuple[dict[str, Floats], list[Column]]:
    """Read columns in popsteer's units, but those whose units are `given`, as they are.

    A velocity's parts to the east and north are one speed, unless there is another; the columns
    that it is of are told, too, and what is not read is left out of `places`.
    """
    check_units(table, {key: each for key, each in places.items() if key not in given})
    read = [(key, each) for key, each in places.items() if key != "direction"]
    values = table.numbers([each.place for _, each in read], blank=blank)
    columns = {
        key: raw if key in given else converted(key, each.unit, raw)
        for (key, each), raw in zip(read, values.T, strict=True)
    }
    parts = [each for key in _PARTS if (each := places.pop(key, None)) is not None]
    over_ground = [columns.pop(key) for key in _PARTS if key in columns]
    if len(parts) < len(_PARTS) or "speed" in places:
        return columns, []
    columns["speed"] = np.hypot(*over_ground)
    places["speed"] = Column(parts[0].place, " and ".join(each.name for each in parts), "m/s")
    return columns, parts


@np.errstate(all="ignore")  # what is out of all proportion agrees with nothing
def explained(
    name: str, values: Floats, texts: Mapping[int, str] | None = None, *, logged: bool = False
) -> tuple[dict[str, Column], list[str]]:
    """Find which columns without names are what, and say what the others are.

    Every column has to be explained by the waypoints that two of them make; else PathError says
    what is not, and which option settles it. `texts` says what columns are that are no numbers,
    and `logged` that the rows are written as F1TENTH's logger does.
    """
    texts = texts or {}
    count = values.shape[1]
    if shown.is_degrees(values[:, 0], values[:, 1]):
        rest = ",-" * (count - 2)
        raise PathError(
            f"{name}: columns 1 and 2 are degrees rather than metres: say which is which, by"
            f" --columns lat,lon{rest} or --columns lon,lat{rest}"
        )
    tried, possible = _explanations(values, texts)
    if not possible:
        known = next(iter(tried), {0: "x", 1: "y"})
        both = ",".join(
            _READ.get(known.get(k, "-"), LEFT_OUT) for k in range(max(list(known)[:2]) + 1)
        )
        raise PathError(
            f"{name}: no two of {count} columns without names are waypoints (--columns {both} takes"
            " those two, - is for one that is left out)"
        )
    known = _best(values, possible)
    if logged and known.get(2, "").startswith(("yaw", "heading")) and values[:, 3].min() >= 0.0:
        known.setdefault(3, "speed speed, as F1TENTH's logger writes x, y, yaw, speed")
    if len(known) < count:
        # A count or a time before x and y, which do not prove it; one more column may be a speed.
        behind = [each for each in tried if next(iter(each)) and _before(each) <= _BEFORE]
        others = [
            ",".join(_READ.get(each.get(k, "speed").split()[0], LEFT_OUT) for k in range(count))
            for each in behind
            if len(each) >= count - 1
        ]
        raise PathError(f"{name}: {_unexplained(values, known, others)}")
    found, notes = {}, []
    for place, what in sorted(known.items()):
        quantity, _, words = what.partition(" ")
        if quantity in _READ:
            found[quantity] = Column(place, f"column {place + 1}", _TIMED.get(what))
        if quantity not in ("x", "y", "yaw", "curvature"):
            notes.append(f"column {place + 1} is {words}")
    return found, notes


def _explanations(
    values: Floats, texts: Mapping[int, str]
) -> tuple[list[dict[int, str]], list[dict[int, str]]]:
    """Say what all columns are for each two that may be x and y; and what of it is possible."""
    count = values.shape[1]
    far = np.flatnonzero(np.abs(values).max(axis=0) > _FARTHEST) if count > 2 else ()
    left = {*texts, *far}
    pairs = _pairs(values) if count <= MANY else []
    tried = [_explain(values, x, y, texts) for x, y in pairs if not {x, y} & left]
    return tried, [known for known in tried if _is_possible(values, known, texts)]


@np.errstate(all="ignore")
def likeliest(values: Floats) -> tuple[int, int]:
    """Give the two columns that are x and y, if any are; the first two where none show it."""
    tried, possible = _explanations(values, {})
    x, y, *_ = _best(values, possible or tried) or {0: "x", 1: "y"}
    return x, y


def _before(known: Mapping[int, str]) -> set[str]:
    """Give what stands before x."""
    return {known.get(k, "?").split()[0] for k in range(next(iter(known)))}


def _is_possible(values: Floats, known: Mapping[int, str], texts: Mapping[int, str]) -> bool:
    """Whether x and y may stand behind other columns: those are a count, a time or an arc length.

    Where x and y are the first two, 0, 1, 2, ... may be x itself, so that another column has to
    prove the waypoints, or a stamp is none of a map's coordinates. Along a straight line any
    coordinate is like an arc length, which proves none there.
    """
    x, y, *_ = known
    is_bent = shown.along(values[:, [x, y]]).turn >= shown.TURN
    found = {known.get(k, "?").split()[0] for k in range(values.shape[1])}
    is_proved = (
        set(range(x)) <= set(texts)
        or _TIMED.keys() & known.values()
        or found & {"curvature", "normal"}
        or ("s" in found and is_bent)
        or any(
            shown.is_followed(values[:, [x, y]], values[:, k], degrees="(deg" in said)
            for k, said in known.items()
            if said.startswith("yaw ")
        )
    )
    clocks = [k for k in range(x) if known.get(k) == _CLOCK]  # a second one is a coordinate
    return (
        _before(known) <= _BEFORE
        and len(clocks) < 2
        and bool(x == 0 or is_proved or values[0, :x].max() > 1e9)
    )


def _best(values: Floats, each: Iterable[dict[int, str]]) -> dict[int, str]:
    """Give what columns most likely are, of several the first: empty for none.

    Where all columns are something goes before all else, then waypoints in front, which a direction
    proves; a clock and an arc length stand in front rather than behind, what counts is hardly x,
    and an arc length fits its own waypoints best.
    """

    def proof(known: dict[int, str]) -> tuple[bool, bool, int, bool, bool, float]:
        x, y, *_ = known
        proved = x == 0 and any(said.startswith("yaw ") for said in known.values())
        arcs = [values[:, k] for k, said in known.items() if said.startswith("s ")]
        gone = shown.along(values[:, [x, y]]).s[-1]
        off = max((abs(abs(each[-1] - each[0]) / gone - 1.0) for each in arcs), default=0.0)
        whole = len(known) == values.shape[1]
        behind = bool(_before(known) & {"t", "s"})
        return whole, proved, len(known), behind, not shown.is_count(values[:, x]), -off

    return max(each, key=proof, default={})


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
    measured = tuple(shown.ways(values[:, [x, y]]))
    way = measured[0]
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
        elif turned is None and (turned := shown.heading(measured, column)) is not None:
            known[k] = f"yaw yaw ({turned})"
        elif shown.is_curvature(way, column):
            known[k] = "curvature curvature"
        elif (k < min(x, y) or column[0] > _SECONDS) and shown.is_time(column):
            known[k] = _CLOCK
        elif turned is None and shown.is_near_heading(measured, column):
            known[k] = "heading a heading, which is left out: the waypoints turn otherwise"
        elif turned is not None and shown.heading(measured, column) is not None:
            known[k] = "heading a heading, too"
    _find_pairs(values, way, known, others)
    _find_speed(values, way, known)
    _find_acceleration(values, way, known)
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
    """Find the speed among the columns that are not known yet, by what proves its size, too."""
    rest = [k for k in range(values.shape[1]) if k not in known]
    place_of_y = next(k for k, what in known.items() if what == "y")
    time = next((k for k, what in known.items() if what == _CLOCK), None)
    for k in (k for k in rest if k > place_of_y):
        column = values[:, k]
        clock = [j for j in rest if j != k and shown.is_time(values[:, j])]
        timed = (
            (j, said)
            for j in (clock if time is None else [time])
            for said, unit in _TIMED.items()
            # Of many units one fits any constant.
            if (unit is None or np.ptp(np.quantile(column, (0.1, 0.9))) > 0.1 * np.max(column))
            and shown.is_rate(way, factor("speed", unit or "m/s") * column, seconds(values[:, j]))
        )
        if found := next(timed, None):
            known[found[0]], known[k] = _CLOCK, found[1]
        elif (column < 0.0).any():
            continue
        elif any(j != k and shown.is_acceleration(way, values[:, j], column) for j in rest):
            known[k] = "speed speed"
        elif shown.is_recorded_speed(way, column):
            known[k] = "speed speed, as the waypoints are apart"
        elif len(rest) == 1 and shown.is_planned_speed(way, column):
            known[k] = "speed speed, lower in bends"
        else:
            continue
        return


def _find_acceleration(values: Floats, way: shown.Along, known: dict[int, str]) -> None:
    """Find that of the speed among the columns that are not known yet."""
    speed = next((k for k, what in known.items() if what.startswith("speed")), None)
    for k in range(values.shape[1]) if speed is not None else ():
        if k not in known and shown.is_acceleration(way, values[:, k], values[:, speed]):
            known[k] = "acceleration the acceleration"


def _unexplained(values: Floats, known: Mapping[int, str], others: Sequence[str]) -> str:
    count = values.shape[1]
    names = {k: what.partition(" ")[0] for k, what in known.items()}
    rest = [k for k in range(count) if k not in known]
    ranges = [
        f"column {k + 1} ({values[:, k].min():.5g} to {values[:, k].max():.5g})" for k in rest
    ]
    read = [_READ.get(names.get(k, "?"), "-") for k in range(count)]
    likely = next((k for k in rest if values[:, k].min() >= 0.0 < np.ptp(values[:, k])), rest[-1])
    tried = [] if "speed" in read else sorted(rest, key=lambda k: k != likely)[:3]
    speeds = [[*read[:place], "speed", *read[place + 1 :]] for place in tried]
    fast = " or ".join(f"--columns {','.join(each)}" for each in speeds)
    fast = f"a speed would be {fast}, " if speeds else ""
    listed = ", ".join(ranges[:4]) + (", ..." if len(ranges) > 4 else "")
    return (
        f"{count} columns without names, and the waypoints do not say what {listed} "
        f"{'is' if len(rest) == 1 else 'are'}: {fast}"
        f"nothing that is needed --columns {','.join(read)}"
        + "".join(f"; behind a count or a time --columns {each}" for each in others[:1])
    )
