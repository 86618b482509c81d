"""The signals of a log against each other: repeated samples, units, axes and headings."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from popsteer.identification.arrays import chords, middles, parted, summed
from popsteer.logs import Log, LogError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from popsteer.identification.drive import Array

WINDOW = 1.0
"""Time over which a displacement is taken [s]."""
REPEATED = 0.2
"""A share of the rows of a driving car: above it, poses that repeat are samples that are held."""
NEAR = 0.04
"""How near a ratio must be to that of two units, as a share: a speed is seldom calibrated worse."""
CLEARLY = 0.25
"""The share that a reading of the heading must leave of what the next one does."""
NORTH = math.radians(10.0)
EARLY = 5.0
"""How long before a block commands count [s]: longer than any delay."""
LONGEST, BLOCK = 300.0, 60.0
"""Of longer drives the blocks [s] that steer most are used, up to this time [s] in all."""

_SPEEDS = (
    (1.0 / 3.6, "speed is in km/h (--unit speed=km/h)"),
    (0.44704, "speed is in mph (--unit speed=mph)"),
    (1852.0 / 3600.0, "speed is in knots (--unit speed=kn)"),
    (0.3048, "speed is in feet a second (--unit speed=0.3048)"),
    (1e-2, "speed is in cm/s (--unit speed=cm/s)"),
    (1e-3, "speed is in mm/s (--unit speed=0.001), or t in ms (--unit t=ms)"),
    (3.6, "speed is what km/h were divided by 3.6 once too often (--unit speed=3.6)"),
    (1.0 / 0.3048, "x and y are in feet (--unit x=0.3048 --unit y=0.3048)"),
    (1e2, "x and y are in cm (--unit x=cm --unit y=cm)"),
    (1e3, "x and y are in mm (--unit x=mm --unit y=mm), or t in ks"),
)


class Signals(NamedTuple):
    """A log whose signals agree, and what was seen of them."""

    log: Log
    """A row for each sample of the pose; its commands have their own times."""
    whole: Log
    """All rows."""
    heading_bias: float
    """By how much the measured heading pointed to the right of the car's [rad]: taken out."""
    speed_scale: float
    """How far the positions move over how far the speed said, by which it is multiplied."""
    scale_error: float
    age_error: float
    """Standard error of the times of samples that repeat [s]."""
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class _Windows:
    """Displacements over `WINDOW`: complex, east and north; what the speed says; the rows."""

    moved: Array
    said: Array
    first: Array
    last: Array

    def of(self, values: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Give by how much values of the rows change over each."""
        found: NDArray[np.complex128] = values[self.last] - values[self.first]
        return found


def checked(log: Log, rear_axle: float = 0.0, *, course: bool = False) -> Signals:
    """Bring the samples of a log to their times, and refuse by LogError signals that disagree.

    With `course` yaw is the course of the pose's point, which lies -`rear_axle` ahead of the axle.
    """
    for column, unit in log.shown.items():
        raise LogError(
            f"{log.name}: {column} is in {unit}, as the positions show: --unit {column}={unit} says"
            " so"
        )
    most = float(np.max(np.abs(log.steer)))
    if most > 0.5 * math.pi:
        raise LogError(
            f"{log.name}: steer reaches {most:.4g} rad, more than a quarter turn of the wheels:"
            " is it in degrees (--unit steer=deg), the hand wheel's angle (--unit steer=1/RATIO),"
            " or normalised (--unit steer=MAX_STEER, or MAX_STEER/100)?"
        )
    if abs(most - 1.0) < 1e-9 and np.sum(np.abs(log.steer) == most) > 1:
        raise LogError(
            f"{log.name}: steer reaches 1 and stays there: it is normalised (--unit steer=MAX_STEER"
            " gives the angle of the wheels at 1)"
        )
    thin, age_error = unrepeated(log)
    thin = excited(thin)
    # A gap that was made is no gap of the log's.
    notes = tuple(dict.fromkeys((*log.remarks, *(r for r in thin.remarks if "gap" not in r))))
    windows = _windows(thin)
    moved = float(np.sum(np.abs(windows.moved)))
    if len(windows.moved) < 5 or moved < 1e-4 * float(np.sum(np.abs(windows.said))):
        return Signals(thin, log, 0.0, 1.0, 0.0, age_error, notes)
    _refuse_heading(thin, windows)
    if course:
        thin = looks(thin, -rear_axle)
    else:
        _refuse_course(thin)
    bias, scale, error = _motion(thin, windows)
    for ratio, words in _SPEEDS:
        if abs(scale / ratio - 1.0) < NEAR:
            raise LogError(
                f"{log.name}: the positions move {scale:.4g} times as far as speed says: {words}"
            )
    if not error < 0.02:
        scale, error = 1.0, 0.0
    one, other = (_with(x, yaw=x.yaw + bias, speed=scale * x.speed) for x in (thin, log))
    return Signals(one, other, bias, scale, error, age_error, notes)


def centred(log: Log, antenna_left: float) -> Log:
    """Give the log with the positions of an antenna aside moved onto the car's centre line."""
    if antenna_left == 0.0:
        return log
    x = log.x + antenna_left * np.sin(log.yaw)
    return _with(log, x=x, y=log.y - antenna_left * np.cos(log.yaw))


def _with(log: Log, **columns: Array) -> Log:
    return Log(
        **log.as_dict() | columns,
        name=log.name,
        shown=log.shown,
        remarks=log.remarks,
        commands=log.commands,
        signals=log.signals,
    )


def unrepeated(log: Log) -> tuple[Log, float]:
    """Keep one row of each pose that repeats while the car drives, at the time it was measured.

    Also give the standard error of these times, which they share [s].
    """
    pose = np.stack((log.x, log.y, log.yaw))
    same = np.concatenate(([False], np.all(np.diff(pose) == 0.0, axis=0)))
    moving = np.abs(log.speed) > 0.05 * np.quantile(np.abs(log.speed), 0.9)
    share = float(np.mean(same[moving])) if moving.any() else 0.0
    frozen = np.ptp(log.x) == np.ptp(log.y) == 0.0
    if share < REPEATED or share == 1.0 or frozen:
        return log, 0.0
    rows = np.flatnonzero(~same)
    held = same & moving
    with_pose = np.mean(np.diff(log.speed, prepend=np.nan)[held] != 0.0) < 0.05  # the speed
    commands = (log.t, log.steer) if log.commands is None else log.commands
    times = _sampled(log.t[rows], log.period)

    def sampled(times: Array) -> Log:
        speed = log.speed[rows] if with_pose else np.interp(times, log.t, log.speed)
        columns = (times, log.x[rows], log.y[rows], log.yaw[rows], speed, log.steer[rows])
        return Log(*columns, name=log.name, remarks=remarks, commands=commands)

    rate = 1.0 / float(np.median(np.diff(times)))
    note = f"poses repeat in {100.0 * share:.0f} % of the rows: one sample each, {rate:.3g} Hz"
    remarks = (*log.remarks, note)
    thin = sampled(times)
    age, error = (0.0, math.inf) if with_pose else _age(thin, log)
    if age > 2.0 * error:  # otherwise each is of the row that shows it first
        thin = sampled(times - min(age, log.period))
    return thin, min(error, log.period / math.sqrt(3.0))


def _sampled(seen: Array, period: float) -> Array:
    """Give when samples were measured at the latest that rows show first at `seen` [s].

    At equal intervals, on the latest line that is after no row; or at those rows, if none fits.
    """
    steps = np.diff(seen)
    whole = np.maximum(np.round(steps / float(np.median(steps))), 1.0)
    count = summed(whole)
    for _ in range(3):
        interval, start = np.polyfit(count, seen, 1)
        count = np.round((seen - start) / interval)
    age = (seen - interval * count)[1:]  # the first row may show a sample of long before
    if float(np.ptp(age)) > 1.5 * period or np.any(np.diff(count) <= 0.0):
        return seen
    line: Array = np.minimum(interval * count + float(np.min(age)), seen)
    return line


def _age(thin: Log, log: Log) -> tuple[float, float]:
    """Give by how much the samples are older than their times, and its standard error [s].

    By how far they moved where the speed of all rows changes: the least squares of `_motion`, with
    the age besides (Gauss and Newton).
    """
    windows, age = _windows(thin), 0.0
    if len(windows.moved) < 5:
        return 0.0, math.inf
    way = summed(middles(log.speed) * np.diff(log.t))
    steps = chords(np.unwrap(thin.yaw))
    for _ in range(3):
        driven, faster = (
            summed(np.diff(np.interp(thin.t - age, log.t, each)) * steps)
            for each in (way, log.speed)
        )
        columns = [windows.of(each) for each in (driven, faster, np.exp(1j * thin.yaw))]
        matrix = np.stack([np.append(each.real, each.imag) for each in columns], axis=1)
        moved = np.append(windows.moved.real, windows.moved.imag)
        found = np.linalg.lstsq(matrix, moved, rcond=1e-9)[0]
        age -= float(found[1] / found[0])
    # Windows overlap by half: each residual counts once.
    size = 2.0 * float(np.mean((moved - matrix @ found) ** 2))
    error = math.sqrt(size * float(np.linalg.pinv(matrix.T @ matrix)[1, 1])) / abs(found[0])
    return age, float(error)


def excited(log: Log) -> Log:
    """Give the part of a long log that steers most, a block a minute; a short log as it is."""
    if log.duration <= LONGEST:
        return log
    block = np.floor((log.t - log.t[0]) / BLOCK).astype(int)
    turned = np.abs(np.diff(log.yaw, prepend=log.yaw[0]))
    work = np.bincount(block, np.abs(np.diff(log.steer, prepend=log.steer[0])) * (turned > 0.0))
    best = np.argsort(-work, kind="stable")[: int(LONGEST / BLOCK)]
    rows = np.isin(block, best)
    commands = (log.t, log.steer) if log.commands is None else log.commands
    # The rows of the chosen blocks; means of rows that are closer than the simulation's cells.
    group = max(1, round(0.04 / log.period))
    columns = dict(log.as_dict(), yaw=np.unwrap(log.yaw))
    index = np.arange(0, len(log) - group + 1, group)[:, None] + np.arange(group)
    whole = log.t[index[:, -1]] - log.t[index[:, 0]] < (group + 0.5) * log.period
    index = index[whole & rows[index].all(axis=1)]
    made = {key: values[index].mean(axis=1) for key, values in columns.items()}
    given = [np.floor((commands[0] + early - log.t[0]) / BLOCK) for early in (0.0, EARLY)]
    near = np.isin(given[0], best) | np.isin(given[1], best)
    commands = (commands[0][near], commands[1][near])
    note = f"{LONGEST / 60.0:.0f} minutes that steer most are used of {log.duration / 60.0:.0f}"
    return Log(**made, name=log.name, remarks=(*log.remarks, note), commands=commands)


def _windows(log: Log) -> _Windows:
    """Give displacements over `WINDOW` where the speed says that the car drives one way."""
    place = log.x + 1j * log.y
    found: list[tuple[Array, ...]] = []
    travelled = summed(middles(log.speed) * np.diff(log.t))
    for part in parted(log.gaps, len(log)):
        t = log.t[part]
        # By their number, as times that are off would choose which ends they take.
        rows = max(2, round(WINDOW * (len(t) - 1) / max(float(t[-1] - t[0]), 1e-9)))
        first = np.arange(part.start, part.stop - rows, max(1, rows // 2))
        last = first + rows
        ends = place[last] - place[first], travelled[last] - travelled[first]
        found.append((*ends, first, last))
    moved, said, first, last = (np.concatenate(values) for values in zip(*found, strict=True))
    lively = np.abs(said) > 0.3 * np.quantile(np.abs(said), 0.9) if len(said) else said > 0.0
    return _Windows(moved[lively], said[lively], first[lively], last[lively])


def _aligned(log: Log, windows: _Windows, unit: float, *, twice: bool = False) -> complex:
    """Give by how much the car moves off a heading in `unit`: 1 without spread, by its angle.

    The mean direction of circular statistics (K. Mardia, P. Jupp, 2000); of twice the angles,
    which are the same forwards and backwards.
    """
    total = summed(np.exp(-1j * unit * log.yaw))
    off = windows.moved * np.sign(windows.said) * (total[windows.last + 1] - total[windows.first])
    off /= np.maximum(np.abs(off), 1e-12)
    weight = np.abs(windows.moved)
    return complex(np.sum(weight * (off**2 if twice else off)) / np.sum(weight))


def _refuse_heading(log: Log, windows: _Windows) -> None:
    """Refuse a heading whose unit or sense is wrong, and a speed without its sign."""
    degrees = math.radians(1.0)
    units = {1.0: "1", degrees: "deg", -1.0: "-1", -degrees: "-deg"}
    fits = {unit: _aligned(log, windows, unit) for unit in units}
    spread = {unit: 1.0 - abs(fit) for unit, fit in fits.items()}
    best = min(spread, key=lambda unit: spread[unit])
    if best != 1.0 and spread[best] < CLEARLY * spread[1.0]:
        off = math.atan2(fits[best].imag, fits[best].real)
        raise LogError(f"{log.name}: {_reading(log, best, units[best], off)}")
    both = abs(_aligned(log, windows, 1.0, twice=True))
    if spread[1.0] > 0.2 and 1.0 - both < CLEARLY * spread[1.0]:
        raise LogError(
            f"{log.name}: the car drives backwards where speed is positive: speed must be negative"
            " backwards"
        )


def _reading(log: Log, unit: float, name: str, off: float) -> str:
    """Say what the heading is, and the option that converts it."""
    seen = "yaw against the direction in which the positions move:"
    if unit > 0.0:
        return f"{seen} it turns 57.3 times as far: yaw is in degrees (--unit yaw=deg)"
    if abs(off - 0.5 * math.pi) < NORTH:
        called = "deg-north" if abs(unit) < 1.0 else "rad-north"
        return (
            f"{seen} it is a heading from north, clockwise: --unit yaw={called} converts it, with x"
            " to the east and y to the north"
        )
    turned, steered = np.diff(np.unwrap(log.yaw * abs(unit))), log.speed[:-1] * log.steer[:-1]
    late = int(0.3 / log.period)
    agrees = float(turned[late:] @ steered[: len(steered) - late]) > 0.0
    if agrees:
        axis = "x" if abs(off) > 0.5 * math.pi else "y"
        also = "" if abs(unit) == 1.0 else " --unit yaw=deg"
        return (
            f"{seen} it turns left where they turn right: {axis} is mirrored (--unit"
            f" {axis}=-1{also})"
        )
    return f"{seen} it counts clockwise (--unit yaw={name})"


def _refuse_course(log: Log) -> None:
    """Refuse a heading that was made of the positions: it has their noise."""
    place = log.x + 1j * log.y
    step, wide = np.diff(place), place[2:] - place[:-2]
    drives = np.abs(wide) > np.quantile(np.abs(wide), 0.5)
    turn = np.angle(step[1:] * np.conj(step[:-1]))
    # A bend turns evenly; noise turns to and fro.
    noise = float(np.median(np.abs(np.diff(turn, prepend=turn[:1]))[drives]))
    for course in (step[1:], step[:-1], wide):
        off = np.angle(course * np.exp(-1j * log.yaw[1:-1]))[drives]
        if noise > 1e-3 and float(np.median(np.abs(off))) < 0.02 * noise:
            raise LogError(
                f"{log.name}: yaw is the course over ground, made of x and y (it has their noise,"
                f" {noise:.2g} rad): it does not show where the car looks; --course takes it for"
                " that of the pose's point"
            )


def looks(log: Log, ahead: float) -> Log:
    """Give a log whose yaw is the course of a point `ahead` of the rear axle the car's heading.

    The rear axle is drawn behind the point (a tractrix): yaw' = v sin(course - yaw) / ahead. Of a
    point behind the axle that holds backwards in time, in which errors fade, too.
    """
    if abs(ahead) < 1e-6:
        return log
    rows = slice(None, None, 1 if ahead > 0.0 else -1)
    course, speeds = np.unwrap(log.yaw)[rows], np.abs(log.speed)[rows]
    steps = log.steps if ahead > 0.0 else np.roll(log.steps[rows], 1)
    yaw, headings = float(course[0]), []
    middle = 0.5 * (course + np.concatenate((course[:1], course[:-1])))
    for step, speed, way in zip(steps, speeds, middle, strict=True):
        kept = math.exp(-speed * step / abs(ahead))
        yaw = way + kept * math.remainder(yaw - way, math.tau)
        headings.append(yaw)
    return _with(log, yaw=np.array(headings)[rows])


def _motion(log: Log, windows: _Windows) -> tuple[float, float, float]:
    """Give the heading's turn [rad], the speed's scale and its standard error, by least squares.

    A point p ahead of the no-slip point moves by c ∫ v exp(i yaw) dt + p (exp(i yaw1) - exp(i
    yaw0)), all complex: the scale is |c|, the turn its angle.
    """
    driven = summed(middles(log.speed) * chords(np.unwrap(log.yaw)) * np.diff(log.t))
    columns = np.stack([windows.of(each) for each in (driven, np.exp(1j * log.yaw))], axis=1)
    found = np.linalg.lstsq(columns, windows.moved, rcond=1e-9)[0]
    left = windows.moved - columns @ found
    # Windows overlap by half: each residual counts once.
    error = math.sqrt(2.0 * float(np.mean(np.abs(left) ** 2)) / len(left))
    size = math.sqrt(float(np.mean(np.abs(columns[:, 0]) ** 2)))
    return math.atan2(found[0].imag, found[0].real), abs(found[0]), error / size
