"""What was measured and commanded during a drive."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from popsteer.errors import PopsteerError, unknown

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

COLUMNS = ("t", "x", "y", "yaw", "speed", "steer")
"""The columns of a log."""
SIGNALS = ("throttle", "brake", "acceleration_command", "speed_command", "z")
"""Further columns that a log may have: what the drive was commanded, and the height."""
_GAP_PERIODS = 5.0
_SHORTEST_GAP = 0.3
_LONGEST_PERIOD = 1.0
_LONGEST_DRIVE = 86400.0


class LogError(PopsteerError, ValueError):
    """A log that cannot be read, or that does not show what is asked of it.

    Examples
    --------
    >>> issubclass(LogError, PopsteerError)
    True
    """


@dataclass(frozen=True, eq=False)
class Log:
    """Poses, speeds and commanded angles over time.

    Rows that cannot be right are left out, and listed in `remarks`: times that do not rise, and
    numbers that are not finite. Where more than five periods are missing, and 0.3 s at least, the
    log has a gap.

    Parameters
    ----------
    t : (N,) array_like of float
        Time [s].
    x, y : (N,) array_like of float
        Position of the vehicle's point [m].
    yaw : (N,) array_like of float
        Heading [rad], counter-clockwise from x.
    speed : (N,) array_like of float
        Speed along the heading [m/s], negative backwards.
    steer : (N,) array_like of float
        Angle of the front wheels that was commanded at `t` and held until the next row [rad],
        positive to the left; or the measured one.
    name : str, default "log"
        What it is called in errors and pictures.
    remarks : tuple of str, optional
        Remarks that there are already.
    commands : tuple of array_like, optional
        Times [s] and angles [rad] of the commands where they have times of their own; `steer` at
        `t` by default.
    source : str, optional
        Where the log came from and how it was read.
    shown : mapping of str to str, optional
        Units from which columns were converted that nobody told: the motion showed them.

    Attributes
    ----------
    gaps : tuple of int
        The rows that follow a gap.
    remarks : tuple of str
        What was left out, in words.

    Raises
    ------
    LogError
        The columns differ in length, fewer than two rows are left, or the times are of another
        unit: a row takes more than 1 s, or the drive more than a day.

    Examples
    --------
    >>> log = Log([0.0, 0.1, 0.1, 0.2], [0, 1, 1, 2], [0] * 4, [0] * 4, [10] * 4, [0] * 4)
    >>> len(log), log.remarks
    (3, ('1 row repeats the time of an earlier one: skipped',))
    """

    t: NDArray[np.float64]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    yaw: NDArray[np.float64]
    speed: NDArray[np.float64]
    steer: NDArray[np.float64]
    name: str = "log"
    gaps: tuple[int, ...] = field(init=False, default=())
    remarks: tuple[str, ...] = ()
    commands: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None
    signals: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    source: str = ""
    shown: Mapping[str, str] = field(default_factory=dict)

    def __init__(  # noqa: PLR0913 - a column each
        self,
        t: ArrayLike,
        x: ArrayLike,
        y: ArrayLike,
        yaw: ArrayLike,
        speed: ArrayLike,
        steer: ArrayLike,
        *,
        name: str = "log",
        remarks: tuple[str, ...] = (),
        commands: tuple[ArrayLike, ArrayLike] | None = None,
        signals: Mapping[str, ArrayLike] | None = None,
        source: str = "",
        shown: Mapping[str, str] | None = None,
    ) -> None:
        given = dict(zip(COLUMNS, (t, x, y, yaw, speed, steer), strict=True)) | dict(signals or {})
        columns = {key: np.array(values, dtype=np.float64) for key, values in given.items()}
        if strange := [key for key in columns if key not in COLUMNS + SIGNALS]:
            raise LogError(f"{name}: {unknown('signal', strange[0], SIGNALS)}")
        for key, values in columns.items():
            if values.shape != columns["t"].shape or values.ndim != 1:
                raise LogError(
                    f"{name}: {key} must have shape {columns['t'].shape}, got {values.shape}"
                )
        keep, found = _usable(columns)
        if keep.sum() < 2:
            raise LogError(f"{name}: at least 2 rows are needed, found {int(keep.sum())}")
        columns = {key: values[keep] for key, values in columns.items()}
        _check_time(columns["t"], name)
        gaps = _gaps(columns["t"])
        if gaps:
            longest = max(columns["t"][k] - columns["t"][k - 1] for k in gaps)
            found.append(f"{_count(len(gaps), 'gap')}, the longest {longest:.2f} s: left out")
        for values in columns.values():
            values.flags.writeable = False
        own = None if commands is None else _own(commands, name)
        others = {
            "name": name,
            "gaps": gaps,
            "remarks": (*remarks, *found),
            "commands": own,
            "source": source,
            "shown": dict(shown or {}),
            "signals": {key: columns.pop(key) for key in SIGNALS if key in columns},
        }
        for key, value in {**columns, **others}.items():
            object.__setattr__(self, key, value)

    def __len__(self) -> int:
        return len(self.t)

    @property
    def duration(self) -> float:
        """Time from the first row to the last [s]."""
        return float(self.t[-1] - self.t[0])

    @property
    def period(self) -> float:
        """The usual time between two rows [s]."""
        return float(np.median(np.diff(self.t)))

    @property
    def steps(self) -> NDArray[np.float64]:
        """Time since the row before [s]; the usual one for the first row and after a gap."""
        steps = np.diff(self.t, prepend=self.t[0] - self.period)
        steps[list(self.gaps)] = self.period
        return steps

    def as_dict(self) -> dict[str, Any]:
        """Give the columns by name.

        Examples
        --------
        >>> log = Log([0, 1], [0, 1], [0, 0], [0, 0], [1, 1], [0, 0])
        >>> list(log.as_dict())
        ['t', 'x', 'y', 'yaw', 'speed', 'steer']
        """
        return {key: getattr(self, key) for key in COLUMNS}


def _own(
    commands: tuple[ArrayLike, ArrayLike], name: str
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Check commands with times of their own; of several at one time the last counts."""
    times, angles = (np.array(values, dtype=np.float64) for values in commands)
    if times.shape != angles.shape or times.ndim != 1 or not len(times):
        raise LogError(f"{name}: commands must have as many angles as times, and one at least")
    keep = np.isfinite(times) & np.isfinite(angles)
    times, angles = times[keep], angles[keep]
    order = np.argsort(times, kind="stable")
    times, angles = times[order], angles[order]
    last = np.append(np.diff(times) > 0.0, True)
    return times[last], angles[last]


def _usable(columns: dict[str, NDArray[np.float64]]) -> tuple[NDArray[np.bool_], list[str]]:
    """Say which rows can be right, and in words which cannot."""
    finite = np.all([np.isfinite(values) for values in columns.values()], axis=0)
    keep, found = finite.copy(), []
    if count := int((~finite).sum()):
        found.append(f"{_count(count, 'row')} with a number that is not finite: skipped")
    rows = np.flatnonzero(finite)
    times = columns["t"][rows]
    rising = _rising(times)
    keep[np.delete(rows, rising)] = False
    others = np.delete(times, rising)
    count = int(np.isin(others, times[rising]).sum())
    if count:
        verb = "repeats" if count == 1 else "repeat"
        found.append(f"{_count(count, 'row')} {verb} the time of an earlier one: skipped")
    if count := len(others) - count:
        found.append(f"time runs backwards in {_count(count, 'row')}: skipped")
    return keep, found


def _rising(times: NDArray[np.float64]) -> NDArray[np.int64]:
    """Give the most rows whose times rise: one stray stamp costs its own row alone."""
    if np.all(np.diff(times) > 0.0):
        return np.arange(len(times))
    ends: list[float] = []  # the least last time of a rising row of rows of each length
    last: list[int] = []
    before = np.full(len(times), -1, dtype=np.int64)
    for k, time in enumerate(times.tolist()):
        place = bisect_left(ends, time)
        before[k] = last[place - 1] if place else -1
        if place == len(ends):
            ends.append(time)
            last.append(k)
        elif time < ends[place]:  # of rows of one time the first counts
            ends[place], last[place] = time, k
    found = []
    row = last[-1] if last else -1
    while row >= 0:
        found.append(row)
        row = int(before[row])
    return np.array(found[::-1], dtype=np.int64)


def _check_time(t: NDArray[np.float64], name: str) -> None:
    """Refuse times that are hardly seconds."""
    period, duration = float(np.median(np.diff(t))), float(t[-1] - t[0])
    if period > _LONGEST_PERIOD or duration > _LONGEST_DRIVE:
        raise LogError(
            f"{name}: a row every {period:.4g} s, {duration:.4g} s in all, is hardly a drive: in"
            " what unit is t? (--unit t=ms, --unit t=us or --unit t=ns) If it is in seconds:"
            f" nothing is read from rows more than {_LONGEST_PERIOD:g} s apart, or from more than a"
            " day"
        )


def _gaps(t: NDArray[np.float64]) -> tuple[int, ...]:
    steps = np.diff(t)
    longest = max(_GAP_PERIODS * float(np.median(steps)), _SHORTEST_GAP)
    return tuple(int(k) + 1 for k in np.flatnonzero(steps > longest))


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
