"""Waypoints from a file: x and y, what else a path takes, and a line that says what was read."""

from __future__ import annotations

import re
import shlex
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

import numpy as np

from popsteer.errors import ConfigError, PathError
from popsteer.tables import clock, geo, shown
from popsteer.tables.columns import (
    LEFT_OUT,
    MANY,
    Column,
    Columns,
    asked_for,
    check_one,
    check_there,
    explained,
    ignored,
    likeliest,
    measured,
    named,
)
from popsteer.tables.poses import poses, yaw_of
from popsteer.tables.quantities import UNITS, converted, seconds
from popsteer.tables.text import Table, read_text, table_of

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from popsteer.tables.shown import Floats

_AT_REST = 0.1  # m/s: a negative speed nearer to 0 may be noise
_SIDES = {"left", "right", "inner", "outer", "blue", "yellow", "orange", "big", "small", "cone"}
_FASTEST = 120.0  # m/s of any car
_LAP = ": a lap with --closed"
_WAYS = {"d": 1.0, "drive": 1.0, "f": 1.0, "forward": 1.0, "forwards": 1.0, "true": 1.0}
_WAYS |= {"n": 0.0, "p": 0.0, "false": 0.0, "r": -1.0, "b": -1.0, "reverse": -1.0}
_WAYS |= {"backward": -1.0, "backwards": -1.0}
_FEW = 20  # waypoints that no one recorded
_OF_A_LOG = {"t", "steer", "throttle", "brake", "acceleration_command", "speed_command", "z"}
_OF_A_PATH = UNITS.keys() - _OF_A_LOG - clock.PARTS.keys()
_NEEDED = ("x", "y", "lat", "lon", "speed", "direction")


@dataclass
class Waypoints:
    """What a file has of a path."""

    name: str
    xy: Floats
    more: dict[str, Any] = field(default_factory=dict)
    """``speed``, ``yaw``, ``curvature``, ``grade``, ``reverse``, as `Path` takes them."""
    read: list[str] = field(default_factory=list)
    """The columns that were read, and as what."""
    notes: list[str] = field(default_factory=list)
    """What was ignored, converted or found, in words."""
    table: Table | None = None
    origin: tuple[float, float] | None = None
    """Latitude and longitude of x = y = 0 [deg], where the file has these."""

    @property
    def speed(self) -> Floats | None:
        """The speeds [m/s], if there are any."""
        return self.more.get("speed")

    def source(self) -> str:
        """Say in one line what was read."""
        read = f"{len(self.xy)} waypoints of {', '.join(self.read)}"
        return "; ".join([f"{FilePath(self.name).name}: {read}", *self.notes])

    def origin_line(self) -> str:
        """Word the origin as the comment that a file of this path begins with; empty without."""
        if self.origin is None:
            return ""
        return f"# origin, latitude and longitude [deg]: {self.origin[0]!r}, {self.origin[1]!r}\n"


def read_waypoints(
    file: str | os.PathLike[str],
    *,
    columns: Columns | None = None,
    origin: tuple[float, float] | None = None,
) -> Waypoints:
    """Read waypoints from a table, GPX or GeoJSON, as `popsteer.Path.from_csv` describes.

    PathError names file, place and the option that settles it, and its `index` is the waypoint;
    ConfigError an option that is not known or not of this file, MissingExtra the extra ``geo``.
    """
    wanted = asked_for(columns)
    name, text = read_text(file)
    found = _read(name, text, wanted, origin)
    if origin is not None and found.origin is None:
        raise ConfigError("origin", origin, f"left out, as {name} has no latitudes and longitudes")
    return _judged(found)


def _read(
    name: str, text: str, wanted: list[str] | dict[str, str], origin: tuple[float, float] | None
) -> Waypoints:
    if (recorded := geo.positions(name, text)) is not None:
        if wanted:
            raise ConfigError("columns", wanted, f"left out, as {name} is no table")
        degrees, notes = recorded
        found = Waypoints(name, np.empty((0, 2)), read=["latitude", "longitude"], notes=notes)
        _check_count(name, len(degrees))
        found.xy = _local(found, degrees, origin)
        return found
    table = table_of(name, text)
    if not table.columns:
        _check_count(name, 0)
    return _read_table(table, wanted, origin)


def make_path(make: Callable[..., Any], found: Waypoints, *, closed: bool) -> Any:  # noqa: ANN401
    """Make a `Path` of waypoints that were read; PathError names file and line.

    A yaw or a curvature that contradicts the waypoints is left out, and said; so it is where coarse
    waypoints show themselves to lie on a curve, whose directions are then a spline's.
    """
    if np.ptp(found.xy, axis=0).max() == 0.0:
        raise PathError(f"{found.name}: its {len(found.xy)} waypoints are all at one place")
    given = {**found.more, "closed": closed}
    if closed:
        found.notes = [each.removesuffix(_LAP) for each in found.notes]
    backwards = "reverse" in given or (found.speed is not None and (found.speed < 0.0).any())
    if not (backwards or {"yaw", "curvature"} & given.keys()) and shown.is_curve(
        found.xy, closed=closed
    ):
        given["yaw"] = "spline"
        found.notes.append("coarse bends, which lie on a curve: yaw and curvature are a spline's")
    while True:
        try:
            return make(found.xy, **given, source=found.source())
        except PathError as error:  # noqa: PERF203 - twice at most
            # A curvature alone is summed to a yaw, which then contradicts the waypoints.
            said = "yaw" if "yaw of" in str(error) and "yaw" in given else "curvature"
            wrong = said if said in given and re.match("yaw|curvature", str(error)) else None
            if wrong is None:
                raise PathError(f"{_place(found, error.index)}: {error}", error.index) from error
            given.pop(wrong)
            found.read = [each for each in found.read if not each.startswith(wrong)]
            found.notes = [each for each in found.notes if not each.startswith(f"{wrong} is in ")]
            found.notes.append(f"{wrong} ignored: {error}"[:200])


def _place(found: Waypoints, index: int | None) -> str:
    if found.table is None or index is None:
        return found.name
    lines = (line for k, (line, _) in enumerate(found.table.rows()) if k == index)
    line = next(lines, None)
    return found.name if line is None else found.table.where(line)


def _check_count(name: str, count: int, columns: int = 2) -> None:
    if count < min(_FEW, columns) and columns > MANY:
        raise PathError(
            f"{name}: {count} {'row' if count == 1 else 'rows'} of {columns} columns: a waypoint is"
            " a row, so write it the other way round"
        )
    if count < 2:
        raise PathError(f"{name}: at least 2 waypoints are needed, found {count}")


def _read_table(
    table: Table, wanted: list[str] | dict[str, str], origin: tuple[float, float] | None
) -> Waypoints:
    if not (wanted or table.head):
        texts = _texts(table)
        values = table.numbers([k for k in range(table.columns) if k not in texts])
        # Two rows, rather than two columns; but the first may count the columns.
        across = len(values) == 2 and table.columns > MANY and not shown.is_count(values[0])
        values = values.T if across else values
        _check_count(table.name, len(values), values.shape[1])
        for k in sorted(texts):
            values = np.insert(values, k, 0.0, axis=1)
        if (posed := poses(table.name, values)) is not None:
            found = Waypoints(
                table.name, posed.xy, read=[posed.read], notes=[posed.note], table=table
            )
            _add_yaw(found, {"yaw": posed.yaw}, "yaw (of the orientation)", both_ways=True)
            return found
        found = Waypoints(table.name, np.empty((0, 2)), table=table)
        said = "x, y"
        if shown.is_degrees(values[:, 0], values[:, 1]) and np.abs(values[:, :2]).max() > 90.0:
            # No latitude is beyond 90 degrees, so that one of the two is the longitude.
            east = int(np.argmax(np.abs(values[:, :2]).max(axis=0)))
            said = "longitude, latitude" if east == 0 else "latitude, longitude"
            values[:, :2] = _local(found, values[:, [1 - east, east]], origin)
        try:
            places, notes = explained(table.name, values, texts, logged=table.is_logged)
        except PathError as error:
            degrees = ",".join(each[:3] for each in said.split(", "))
            both = "x,y" if found.origin is None else degrees
            raise PathError(str(error).replace("--columns x,y", f"--columns {both}")) from None
        columns = {
            key: converted(key, each.unit, values[:, each.place]) for key, each in places.items()
        }
        found.xy = np.column_stack((columns["x"], columns["y"]))
        both = f"{places['x'].place + 1}, {places['y'].place + 1}"
        found.read.append(f"{said} ({'rows' if across else 'columns'} {both})")
        found.notes += notes
    else:
        places = {
            key: each
            for key, each in named(table, wanted, _OF_A_PATH).items()
            # A course may be the name of one; but a gear in letters is not left out.
            if key in _NEEDED or not table.is_text(each.place)
        }
        check_there(table, places, ("x", "y"))
        if not wanted:
            check_one(table)
            _refuse_sides(table, places)
        columns, used = measured(table, places)
        geo.check(table, places, columns, wanted)
        _check_count(table.name, min(map(len, columns.values())))
        found = Waypoints(table.name, np.empty((0, 2)), table=table)
        found.xy = _position(found, columns, places, origin)
        if not wanted:
            _refuse_steep(found, table, places)
        found.notes += ignored(table, [*places.values(), *used])
    _add(found, columns, places)
    return found


def _texts(table: Table) -> dict[int, str]:
    """Find columns that are no numbers, and what is said of those that never change.

    So is pandas' index. Raises PathError where one changes, or is a unit, or a side of a road.
    """
    index = {0: "nothing the index"} if table.has_index else {}
    texts = [k for k in range(table.columns) if table.is_text(k)]
    if not texts or len(texts) >= table.columns - 1:
        return index
    entries = [row for _, _, row in table.entries(texts)]
    first = dict(zip(texts, entries[0], strict=True))
    told = zip(texts, zip(*entries, strict=True), strict=True)
    varied = [k for k, each in told if len(set(each)) > 1]
    told_more = UNITS["speed"].keys() | _SIDES
    for k in varied or [k for k in texts if told_more & {first[k], *first[k].lower().split("_")}]:
        rest = [each for each in range(table.columns) if each not in texts]
        x, y = likeliest(np.nan_to_num(table.numbers(rest, blank=True)))
        shown_as = [LEFT_OUT] * table.columns
        shown_as[rest[x]], shown_as[rest[y]] = "x", "y"
        if first[k] in UNITS["speed"] and k - 1 not in texts and shown_as[k - 1] == LEFT_OUT:
            shown_as[k - 1] = f"speed [{first[k]}]"
        raise PathError(
            f"{table.name}: column {k + 1} is text ({first[k][:40]!r}) without a name (--columns"
            f" {shlex.quote(','.join(shown_as))} reads the others, in the order of the rows)"
        )
    return index | {k: f"nothing always {entry[:40]!r}" for k, entry in first.items()}


def _refuse_sides(table: Table, places: Mapping[str, Column]) -> None:
    """Refuse lists of both sides of a road: boundaries, or cones by their colours."""
    for k in filter(table.is_text, range(table.columns)):
        said = sorted({row[k].lower() for _, row in table.rows() if len(row) > k})
        if len(said) > 1 and {word for each in said for word in each.split("_")} <= _SIDES:
            both = {key: places[key].place for key in ("x", "y", "lat", "lon") if key in places}
            raise PathError(
                f"{table.name}: {table.head[k]} says {' and '.join(said)[:60]}: lists of"
                f" two sides, and no path ({table.option(both)} reads them in the rows' order)"
            )


def _refuse_steep(found: Waypoints, table: Table, places: Mapping[str, Column]) -> None:
    """Refuse a z that no vehicle climbs, where y may be the height, as Unity has it."""
    head = table.head
    names = [places[key].name if key in places else "" for key in ("x", "y")]
    upward = re.sub("y([^y]*)$", r"z\1", names[1].replace("Y", "y"))
    z = next((k for k, name in enumerate(head) if name.replace("Z", "z") == upward), None)
    if z is None or "" in names or table.is_text(z):
        return
    move = np.abs(np.diff((*found.xy.T, table.numbers([z], blank=True)[:, 0])))
    steep = move[2] > 0.7 * np.hypot(move[0], move[1])
    flat = move[1] <= 0.35 * np.hypot(move[0], move[2])
    if steep.mean() > 0.1 and flat.mean() > 0.9:
        by = table.option({"x": places["x"].place, "y": z})
        raise PathError(
            f"{found.name}: {names[1]} may be the height, as {head[z]} climbs steeper than any"
            f" vehicle: {by} reads it so, y={names[1]} as it is named"
        )


def backwards(table: Table, column: Column) -> NDArray[np.bool_]:
    """Read where a gear, a direction or a flag, in numbers or in words, says backwards."""
    place = column.place
    if table.is_text(place):
        found = []
        for index, line, (entry,) in table.entries([place]):
            if (value := _WAYS.get(entry.lower())) is None:
                known = ", ".join(_WAYS)
                raise PathError(
                    f"{table.at(line, place)}: {entry[:40]!r} is none of {known}", index
                )
            found.append(value)
        values = np.array(found)
    else:
        values = np.nan_to_num(table.numbers([place], blank=True)[:, 0])
    return values != 0.0 if "reverse" in column.name.lower() else values < 0.0


def _position(
    found: Waypoints,
    columns: dict[str, Floats],
    places: Mapping[str, Column],
    origin: tuple[float, float] | None,
) -> Floats:
    """Give x and y: as they are, from latitude and longitude, or beside a reference line."""
    if "x" not in columns or "y" not in columns:
        if (none := np.flatnonzero(geo.before_fix(columns["lat"], columns["lon"]))).size:
            raise PathError(
                f"{_place(found, int(none[0]))}: latitude and longitude are 0, as before a receiver"
                " has a position: leave such rows out",
                int(none[0]),
            )
        degrees = np.column_stack((columns["lat"], columns["lon"]))
        found.read += [f"latitude ({places['lat']})", f"longitude ({places['lon']})"]
        return _local(found, degrees, origin)
    x, y = columns["x"], columns["y"]
    if found.table and places["x"].unit is None and shown.is_degrees(x, y):
        both = {"lon": places["x"].place, "lat": places["y"].place}
        by = found.table.option(both)
        raise PathError(
            f"{found.name}: {places['x']} and {places['y']} are degrees rather than metres: {by}"
            " reads them as longitude and latitude"
        )
    found.read += [places["x"].said("x"), places["y"].said("y")]
    if {"x_normal", "y_normal", "alpha"} <= columns.keys() and "ref" in places["x"].name.lower():
        found.notes.append("x and y are the raceline's: the reference line + alpha * normal vector")
        x = x + columns["alpha"] * columns["x_normal"]
        y = y + columns["alpha"] * columns["y_normal"]
    return np.column_stack((x, y))


def _local(found: Waypoints, degrees: Floats, origin: tuple[float, float] | None) -> Floats:
    xy, found.origin, said = geo.local(found.name, degrees, origin)
    found.notes.append(said)
    return xy


@np.errstate(all="ignore")  # what is out of all proportion agrees with nothing
def _add(found: Waypoints, columns: dict[str, Floats], places: Mapping[str, Column]) -> None:
    """Add what a path takes beside its positions."""
    both_ways, ahead = bool(found.table and found.table.head), False
    if "yaw" in columns:
        unit, said = places["yaw"].unit, places["yaw"].said("yaw")
        ahead = _add_yaw(found, columns, said, unit, both_ways=both_ways)
    elif "qz" in columns and "qw" in columns:
        columns["yaw"] = yaw_of(columns)
        ahead = _add_yaw(found, columns, "yaw (of the quaternion)", both_ways=both_ways)
    if "speed" in columns:
        _add_speed(found, columns, places, ahead=ahead)
    slope = places["grade"] if "grade" in columns else None
    called_so = slope and "grade" in slope.name.lower() and np.abs(columns["grade"]).max() < 0.5
    if slope and slope.unit is None and not called_so:
        found.notes.append(f"{slope} ignored: a slope needs a unit, as slope [%]")
        columns.pop("grade")
    for key in ("curvature", "grade"):
        if key in columns:
            found.more[key] = columns[key]
            found.read.append(places[key].said(key))
    if "direction" in places and found.table:
        back = backwards(found.table, places["direction"])
        found.read.append(f"direction ({places['direction']})")
        if back.any() and not (columns.get("speed", 0.0 * back) < 0.0).any():
            found.more["reverse"] = back.tolist()


def _add_yaw(
    found: Waypoints,
    columns: Mapping[str, Floats],
    said: str,
    unit: str | None = "rad",
    *,
    both_ways: bool,
) -> bool:
    """Add a yaw if it is the waypoints' direction; whether it says that nothing is reversed.

    The file says its `unit`, from which it has been converted; else it is found.
    """
    yaw, units = columns["yaw"], ("rad",) if unit else ("rad", "deg")
    turned = shown.heading(shown.ways(found.xy), yaw, units, both_ways=both_ways)
    if turned is None:
        found.notes.append(f"{said} ignored: it is not the waypoints' direction")
        return False
    found.read.append(said)
    exact = turned.unit == "rad" and not turned.frame
    found.more["yaw"] = yaw if exact else turned.yaw
    if not exact:
        found.notes.append(f"yaw is in {turned._replace(unit=unit or turned.unit)}")
    if turned.backwards.any() and not (columns.get("speed", yaw * 0.0) < 0.0).any():
        found.more["reverse"] = turned.backwards.tolist()
    return not turned.backwards.any()


def _add_speed(
    found: Waypoints, columns: dict[str, Floats], places: Mapping[str, Column], *, ahead: bool
) -> None:
    speed, said = columns["speed"], places["speed"].said("speed")
    if "speed_y" in columns and np.any(columns["speed_y"] != 0.0):
        other = columns["speed_y"]
        if shown.is_velocity(found.xy, speed, other, found.more.get("yaw")):
            said = f"speed (of {places['speed']} and {places['speed_y']})"
            speed = np.hypot(speed, other)
    unit = _unit_by_times(found, speed) if places["speed"].unit is None else "m/s"
    if unit is None:
        _refuse_fast(found, places["speed"], speed)
    elif unit != "m/s":
        speed = converted("speed", unit, speed)
        found.notes.append(f"speed is in {unit}, as the times show")
    if (speed < 0.0).any():
        speed = np.where(_at_rest(found.xy, speed, ahead=ahead), 0.0, speed)
    found.more["speed"] = speed
    found.read.append(said)


def _unit_by_times(found: Waypoints, speed: Floats) -> str | None:
    """Find the unit of a speed beside a clock; None if nothing shows it."""
    table = found.table
    if table is None:
        return None
    with suppress(PathError):  # a time that cannot be read shows nothing
        places = named(table, [], ("t", *clock.PARTS))
        clock.find(table, places)
        if "t" in places:
            t = seconds(clock.read(table, places, None).values)
            ratio = shown.ratio(t, found.xy[:, 0], found.xy[:, 1], speed) or 0.0
            return "m/s" if abs(ratio - 1.0) < 0.02 else shown.unit_of_speed(ratio, 0.02)
    return None


def _refuse_fast(found: Waypoints, column: Column, speed: Floats) -> None:
    """Refuse a speed without a unit that would be no vehicle's in m/s, or is Autoware.AI's.

    Its waypoint saver writes km/h, its other files m/s.
    """
    table = found.table
    head = table.head if table else []
    most = float(np.max(np.abs(speed), initial=0.0))
    saved = "change_flag" in head and "steering_flag" not in head
    if table and head and (most > _FASTEST or saved):
        by = [table.option({"speed": column.place}, {"speed": unit}) for unit in ("km/h", "m/s")]
        why = f"without a unit would be up to {most:.4g} m/s"
        why = "beside change_flag is km/h as Autoware writes it" if saved else why
        raise PathError(f"{found.name}: {column} {why}: {by[0]}, or {by[1]}")


def _at_rest(xy: Floats, speed: Floats, *, ahead: bool) -> NDArray[np.bool_]:
    """Find slow negative speeds that are noise: the yaw says so, or they lead nowhere."""
    slow = (speed < 0.0) & (speed > -_AT_REST)
    rest = slow & ahead
    if len(xy) <= _FEW:
        return rest
    steps = np.sort(np.hypot(*np.diff(xy, axis=0).T))
    spacing = steps[np.searchsorted(np.cumsum(steps), 0.5 * steps.sum()).clip(0, len(steps) - 1)]
    # A segment from a speed of 0 is driven as its end says.
    ends = np.flatnonzero(np.diff(speed <= 0.0, prepend=False, append=False))
    for first, last in zip(ends[::2], ends[1::2], strict=True):
        away = np.hypot(*(xy[first : last + 1] - xy[first]).T).max()
        if away < 0.5 * spacing and speed[first:last].min() > -_AT_REST:
            rest[first:last] = slow[first:last]
    return rest


@np.errstate(all="ignore")
def _judged(found: Waypoints) -> Waypoints:
    """Say how much is driven backwards, and whether the ends meet."""
    xy, speed = found.xy, found.more.get("speed")
    steps = np.hypot(*np.diff(xy, axis=0).T)
    total = float(steps.sum())
    back = np.array(found.more.get("reverse", np.zeros(len(xy))), dtype=bool)
    if speed is not None:
        back = back | (speed < 0.0)
    share = float(steps[back[:-1]].sum()) / total if total > 0.0 else 0.0
    if share > 0.0:
        found.notes.append(f"{100.0 * share:.3g} % of the length is driven backwards")
    gap = float(np.hypot(*(xy[-1] - xy[0])))
    usual = float(np.median(steps[steps > 0.0])) if total > 0.0 else 0.0
    if total > 4.0 * gap and gap <= 3.0 * usual:
        found.notes.append(f"the last waypoint is {gap:.2f} m from the first{_LAP}")
    return found
