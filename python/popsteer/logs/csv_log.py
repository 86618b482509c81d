"""Logs from tables: CSV, and the exports of PlotJuggler, rostopic, MoTeC and VBOX."""

from __future__ import annotations

import math
import os
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from popsteer.errors import ConfigError, PathError, unknown
from popsteer.logs.log import COLUMNS, SIGNALS, Log, LogError
from popsteer.logs.units import factor
from popsteer.tables import clock, geo, shown
from popsteer.tables.columns import (
    Columns,
    asked_for,
    check_one,
    check_there,
    ignored,
    measured,
    named,
)
from popsteer.tables.poses import yaw_of
from popsteer.tables.quantities import converted
from popsteer.tables.text import Table, read_table
from popsteer.tables.waypoints import backwards

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from popsteer.tables.shown import Floats

_MERGED = 0.2  # share of empty entries from which a column is a topic with times of its own
_FITS = 0.04  # how near a ratio of speeds has to be to one of those
_TIMES = {"ms": 1e3, "us": 1e6, "ns": 1e9, "min": 1 / 60, "h": 1 / 3600, "days": 1 / 86400}
_APART = 1.5  # times speed and positions may differ: more is another unit, or no speed
_COMPASS = ("", "from north, clockwise")
_ENOUGH = 20_000  # rows that show what a heading is
_LONGEST_WHEELBASE = 20.0  # m; a hand wheel's angle makes a car look longer


class _Series(NamedTuple):
    """A quantity over the times of its own, on the clock of the first file."""

    t: Floats
    values: Floats
    said: str
    """Its column, where that is not called as the quantity is."""
    unit: str | None
    """Its unit, where that is told."""


def read_csv(
    file: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    *,
    columns: Columns | None = None,
    units: Mapping[str, str] | None = None,
    origin: tuple[float, float] | None = None,
) -> Log:
    r"""Read a log from a table, or from several that have one clock, as `popsteer.logs.read` does.

    An empty entry leaves its row out; a column that is mostly empty, as an export of several topics
    has them, and one of another file are put on the position's clock: the angle is held, all else
    is interpolated. LogError where the file cannot be read, has no such column, or an entry that is
    no number; or its numbers show that a unit is another one, and the message says how to tell it.

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
    files = paths(file)
    given = dict(units or {})
    for key, unit in given.items():
        factor(key, unit)  # refused before the file is read
    try:
        wanted = asked_for(columns)
        if isinstance(wanted, dict) and (strange := [k for k in wanted if k not in _KNOWN]):
            raise LogError(unknown("column", strange[0], _KNOWN))
        series: dict[str, _Series] = {}
        begun: int | None = None
        notes: list[str] = []
        for each in files:
            table, alone = read_table(each), len(files) == 1
            found, begun, left = _read(table, wanted, given, begun, alone=alone)
            series = {**found, **series}
            notes += left
        return _log(files, series, given, origin, notes)
    except (PathError, ConfigError) as error:
        raise LogError(str(error)) from error


def paths(
    file: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
) -> list[str | os.PathLike[str]]:
    """Give the files of an argument that may be one or several."""
    return [file] if isinstance(file, (str, os.PathLike)) else list(file)


_KNOWN = (*COLUMNS, *SIGNALS, *clock.PARTS, "speed_y", "direction", "lat", "lon")
_KNOWN += ("qx", "qy", "qz", "qw", "v_east", "v_north")


def _read(
    table: Table,
    wanted: list[str] | dict[str, str],
    units: Mapping[str, str],
    begun: int | None,
    *,
    alone: bool,
) -> tuple[dict[str, _Series], int, list[str]]:
    """Read the quantities of a table over its own times, the clock's origin, and what is left."""
    if not table.columns:
        raise LogError(f"{table.name}: the file is empty")
    if not alone and isinstance(wanted, dict):
        wanted = {key: name for key, name in wanted.items() if name in table.head}
    places = named(table, wanted, _KNOWN)
    if not wanted:
        check_one(table)
    clock.find(table, places)
    needed = COLUMNS if alone else ("t",)
    check_there(table, places, needed)
    times = clock.read(table, places, units.get("t"))
    begun = times.origin if begun is None else begun
    t = times.values + 1e-9 * (times.origin - begun)
    rest = {key: column for key, column in places.items() if key not in ("t", *clock.PARTS)}
    gear = rest.pop("direction", None)
    columns, used = measured(table, rest, given=units, blank=True)
    geo.check(table, rest, columns, wanted)
    found = {"t": _Series(t, t, times.said, "s" if times.is_sure else None)}
    for key, column in rest.items():
        found[key] = _Series(t, columns[key], column.said(key), units.get(key, column.unit))
    if gear is not None:
        with suppress(PathError):  # words of a gearbox that are not known say nothing
            found["direction"] = _Series(
                t, np.where(backwards(table, gear), -1.0, 1.0), f"{gear}", None
            )
    others = (each for key, each in places.items() if key in ("t", *clock.PARTS, "direction"))
    return found, begun, ignored(table, [*rest.values(), *used, *others])


def _log(
    files: Sequence[str | os.PathLike[str]],
    series: dict[str, _Series],
    units: Mapping[str, str],
    origin: tuple[float, float] | None,
    notes: list[str],
) -> Log:
    """Put all on the clock of the position, and find the units that are not told."""
    name = str(files[0])
    if "x" not in series and {"lat", "lon"} <= series.keys():
        notes.append(_localise(name, series, origin))
    elif origin is not None:
        raise LogError(f"{name}: has no latitudes and longitudes for an origin")
    if "yaw" not in series and {"qz", "qw"} <= series.keys():
        parts = {key: each.values for key, each in series.items() if key.startswith("q")}
        said = f"yaw (of the quaternion {series['qz'].said})"
        series["yaw"] = _Series(series["qz"].t, yaw_of(parts), said, "rad")
    for key in COLUMNS:
        if key not in series:
            raise LogError(f"{name}: none of {len(files)} files has a column {key!r}")
    base = series["x"]
    here = np.isfinite(base.values) & np.isfinite(series["y"].values)
    merged, columns = [], {}
    there = [*COLUMNS[1:], *(key for key in SIGNALS if key in series)]
    for key in there:
        each = series[key]
        empty = (
            len(each.t) != len(base.t) or np.isnan(each.values[here]).sum() > _MERGED * here.sum()
        )
        if empty and key not in ("x", "y"):
            merged.append(key)
        columns[key] = _on_clock(key, each, base.t) if empty else each.values
    notes += _of_the_plane(columns, series, base.t)
    notes += _backwards(columns, series, base.t)
    rows = here if merged else np.ones(len(base.t), dtype=np.bool_)
    columns = {
        key: converted(key, units[key], values[rows]) if key in units else values[rows]
        for key, values in columns.items()
    }
    columns["t"] = base.t[rows]
    if series["t"].said:
        notes.append(series["t"].said)
    if merged:
        notes.append(f"{', '.join(merged)} put on the position's clock")
    told = {key: each.unit for key, each in series.items() if each.unit is not None}
    shown_units, settled = _settle(name, columns, told, units)
    notes += settled
    notes += [f"{key} is in {unit}, as asked for" for key, unit in units.items()]
    label = Path(files[0]).name
    read = ", ".join(["t", *(series[key].said for key in there)])
    source = "; ".join([f"{label}: {len(columns['t'])} rows of {read}", *notes])
    return Log(
        *(columns[key] for key in COLUMNS),
        name=label,
        remarks=_still(columns),
        source=source,
        signals={key: columns[key] for key in SIGNALS if key in columns},
        shown=shown_units,
    )


def _of_the_plane(
    columns: dict[str, Floats], series: Mapping[str, _Series], t: Floats
) -> list[str]:
    """Make a speed of a velocity in the plane, and say it."""
    if "speed_y" not in series:
        return []
    other = _on_clock("speed_y", series["speed_y"], t)
    parts = np.column_stack([columns[key] for key in ("x", "y", "speed", "yaw")] + [other])
    known = np.flatnonzero(np.isfinite(parts).all(axis=1))
    x, y, vx, yaw, vy = parts[known[:: max(1, len(known) // _ENOUGH)]].T
    if len(x) < 2 or not vy.any() or not shown.is_velocity(np.column_stack((x, y)), vx, vy, yaw):
        return []
    columns["speed"] = np.hypot(columns["speed"], other)
    return [f"{series['speed'].said} and {series['speed_y'].said} are one velocity over ground"]


def _backwards(columns: dict[str, Floats], series: Mapping[str, _Series], t: Floats) -> list[str]:
    """Give a speed without signs that of the gear, and say it."""
    gear = series.get("direction")
    if gear is None or (columns["speed"] < 0.0).any():
        return []
    back = _on_clock("direction", gear, t) < 0.0
    columns["speed"] = np.where(back, -columns["speed"], columns["speed"])
    return [f"speed is negative where {gear.said} says backwards"] if back.any() else []


def _localise(name: str, series: dict[str, _Series], origin: tuple[float, float] | None) -> str:
    degrees = np.column_stack((series["lat"].values, series["lon"].values))
    degrees[geo.before_fix(*degrees.T)] = math.nan
    known = np.isfinite(degrees).all(axis=1)
    if not known.any():
        raise LogError(f"{name}: has no positions")
    xy = np.full(degrees.shape, math.nan)
    xy[known], _, said = geo.local(name, degrees[known], origin)
    t = series["lat"].t
    series["x"] = _Series(t, xy[:, 0], "x (longitude)", "m")
    series["y"] = _Series(t, xy[:, 1], "y (latitude)", "m")
    return said


def _on_clock(key: str, each: _Series, t: Floats) -> Floats:
    """Hold or interpolate a quantity at the times of another; NaN before and after its own."""
    known = np.isfinite(each.values) & np.isfinite(each.t)
    own, values = each.t[known], each.values[known]
    if not len(own):
        return np.full(len(t), math.nan)
    if key in ("steer", "direction"):  # a command holds until the next one, and so does a gear
        return values[np.clip(np.searchsorted(own, t, side="right") - 1, 0, None)]
    values = np.unwrap(values) if key == "yaw" else values
    return np.interp(t, own, values, left=math.nan, right=math.nan)


@np.errstate(all="ignore")
def _settle(
    name: str, columns: dict[str, Floats], told: Mapping[str, str], units: Mapping[str, str]
) -> tuple[dict[str, str], list[str]]:
    """Convert what the motion shows to be in another unit, and say it; refuse what stays open."""
    whole = np.isfinite(np.column_stack([columns[key] for key in COLUMNS])).all(axis=1)
    if whole.sum() < 20:
        return {}, []
    t, x, y, yaw, speed, steer = (columns[key][whole] for key in COLUMNS)
    found, notes = _settle_motion(name, columns, told, units, shown.ratio(t, x, y, speed))
    units_of_yaw = ("rad",) if "yaw" in told else ("rad", "deg")
    some = slice(None, None, max(1, len(t) // _ENOUGH))
    here = np.column_stack((x[some], y[some]))
    turned = shown.heading(shown.ways(here), yaw[some], units_of_yaw, both_ways=True)
    # Identification tells a sensor that is turned and an axis that is mirrored from each other.
    if "yaw" not in units and turned is not None and turned.frame in _COMPASS:
        scale, offset = shown.to_yaw(turned)
        if scale != 1.0:
            columns["yaw"] = scale * columns["yaw"] + offset
            found["yaw"] = turned.unit + ("-north" if turned.frame else "")
            said = turned._replace(unit=told.get("yaw", turned.unit))
            notes.append(f"yaw is in {said}, as the positions show")
    xy = np.column_stack((x, y))
    return found, notes + _check_steer(name, xy, columns["yaw"][whole], steer, told.get("steer"))


def _settle_motion(
    name: str,
    columns: dict[str, Floats],
    told: Mapping[str, str],
    units: Mapping[str, str],
    ratio: float | None,
) -> tuple[dict[str, str], list[str]]:
    """Do so for time and speed, by how many times as far one says as the positions move."""
    found: dict[str, str] = {}
    notes: list[str] = []
    if ratio is None:
        return found, notes
    for unit, size in _TIMES.items():
        if "t" not in told and abs(ratio / size - 1.0) < 3.0 * _FITS:
            columns["t"], ratio = columns["t"] / size, ratio / size
            notes.append(f"t is in {unit}, as speed and positions show")
    fast = shown.unit_of_speed(ratio)
    if fast and "speed" not in told:
        columns["speed"] = columns["speed"] * factor("speed", fast)
        found["speed"], ratio = fast, 1.0
        notes.append(f"speed is in {fast}, as the positions show")
    for unit, size in (("cm", 0.01), ("mm", 0.001)):
        if "x" not in told and abs(ratio / size - 1.0) < _FITS:
            raise LogError(
                f"{name}: the positions move {1.0 / size:.0f} times as far as speed says: x"
                f" and y are in {unit} (--unit x={unit} --unit y={unit})"
            )
    # Where a row takes more than 1 s, the unit of time is asked for.
    is_second = float(np.nanmedian(np.diff(columns["t"]))) <= 1.0
    if is_second and not {"t", "speed"} & units.keys() and not 1.0 / _APART < ratio < _APART:
        raise LogError(
            f"{name}: speed says {ratio:.4g} times as far as the positions move, which is no unit"
            f" of it: --unit speed={1.0 / ratio:.6g} scales it"
        )
    return found, notes


def _check_steer(name: str, xy: Floats, yaw: Floats, steer: Floats, unit: str | None) -> list[str]:
    """Refuse angles that are not the front wheels', by the wheelbase that they would mean.

    Says that they are taken for radians where neither the file nor the drive tells.
    """
    most = float(np.max(np.abs(steer)))
    percent = "--unit steer=ANGLE/100, the front wheels' ANGLE at 100 % in rad"
    if unit is None and most in (1.0, 100.0):
        full = percent if most > 1.0 else "--unit steer=ANGLE, the front wheels' ANGLE at 1 in rad"
        raise LogError(
            f"{name}: steer reaches {most:g}, as a share of the largest angle does: {full}; or if"
            f" it is one, --unit steer={'rad' if most == 1.0 else 'deg'}"
        )
    length = _wheelbase(xy, yaw, steer)
    if length is None or abs(length) <= _LONGEST_WHEELBASE:
        is_open = length is None and unit is None and np.ptp(steer) > 0.0
        return ["steer is taken for rad: the drive does not tell"] if is_open else []
    why = "" if math.isinf(length) else f", a wheelbase of {abs(length):.0f} m"
    known = (unit or ("deg" if most > 4.0 * math.pi else "rad")).partition("/")[0]
    by = [f"--unit steer={known}/RATIO where it is the hand wheel's"]
    if unit is None and abs(_wheelbase(xy, yaw, np.radians(steer)) or 0.0) <= _LONGEST_WHEELBASE:
        by.insert(0, "--unit steer=deg")
    by += [f"{percent}, where it is in percent"] if unit is None and 1.0 < most <= 100.0 else []
    raise LogError(
        f"{name}: steer of up to {most:.3g} would be no front wheels'{why}: {', or '.join(by)}"
    )


def _wheelbase(xy: Floats, yaw: Floats, steer: Floats) -> float | None:
    """Give the wheelbase of a bicycle with such angles, inf beyond 90 degrees; None if not shown.

    It turns by ds tan(steer) / wheelbase; of the stretches, least squares gives it where they
    correlate. On a straight an offset of the angle turns as much, and is left out.
    """
    if float(np.max(np.abs(steer))) >= math.pi / 2.0:
        return math.inf
    gone = np.hypot(*np.diff(xy, axis=0).T)
    ends = np.arange(0, len(gone), max(1, len(gone) // 20))
    series = gone, gone * np.tan(steer[:-1]), np.diff(np.unwrap(yaw))
    way, bent, turned = (np.add.reduceat(each, ends) for each in series)
    if float(np.sum(np.abs(turned))) < 0.2:
        bent, turned = (each - (each @ way) / (way @ way) * way for each in (bent, turned))
    both = float(bent @ turned)
    alike = abs(both) > 0.8 * float(np.linalg.norm(bent) * np.linalg.norm(turned))
    return float(bent @ bent) / both if alike else None


def _still(columns: Mapping[str, Floats]) -> tuple[str, ...]:
    """Say which column never changes although the positions turn, or that those never do.

    So it is with a speed of 0, but no other: that may be driven.
    """
    x, y = columns["x"], columns["y"]
    if len(x) > 5 and np.ptp(x) == 0.0 and np.ptp(y) == 0.0:
        return ("the position never changes",)
    known = np.isfinite(x) & np.isfinite(y)
    some = np.flatnonzero(known)[:: max(1, len(x) // _ENOUGH)]
    still: list[str] = []
    if len(some) >= 20 and shown.along(np.column_stack((x[some], y[some]))).turn >= 1.0:
        still = [key for key in ("yaw", "steer") if np.ptp(columns[key]) == 0.0]
        still += [] if columns["speed"].any() else ["speed"]
    return (*(f"{key} never changes" for key in still), *_stands(columns))


def _stands(columns: Mapping[str, Floats]) -> list[str]:
    """Say where the position stands for more than a second in which speed says a metre and more."""
    t, x, y, speed = (columns[key] for key in ("t", "x", "y", "speed"))
    if not len(t):
        return []
    moves = np.flatnonzero(np.append(np.hypot(np.diff(x), np.diff(y)) != 0.0, True))
    said = np.concatenate(([0.0], np.cumsum(np.nan_to_num(np.abs(speed[:-1]) * np.diff(t)))))
    ends, begins = moves, np.concatenate(([0], moves[:-1] + 1))
    lost = np.where(t[ends] - t[begins] > 1.0, said[ends] - said[begins], 0.0)
    worst = int(np.argmax(lost))
    if not lost[worst] > 1.0:
        return []
    begun, ended = t[begins[worst]], t[ends[worst]]
    said_of = f"from t = {begun:.2f} s on, in which speed says {lost[worst]:.3g} m"
    return [f"the position stands for {ended - begun:.1f} s {said_of}"]
