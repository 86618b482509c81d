"""The identified vehicle, driven by the log's commands, beside the car that was measured."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from popsteer.identification.drive import SETTLING

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from popsteer.identification.drive import Array, PreparedLog
    from popsteer.logs import Log

AFRESH = 10.0
"""After this time the simulation restarts at the measured pose [s]."""


def compared(
    log: Log, drive: PreparedLog, yaw: Array, theta: float, point: tuple[float, float, float]
) -> dict[str, NDArray[Any]]:
    """Set the simulated motion beside the measured one: the records of an `Identification`.

    `yaw` is the simulated heading [rad], `theta` as `fit` gives it; `point` is rear axle [m], slip
    [s²/m] and heading bias [rad], as `fit_point` gives them.
    """
    from popsteer.identification.point import smooth

    heading = smooth(drive.yaw - yaw, theta, drive)  # what the measured heading is ahead
    rear, slip, bias = point
    starts = _starts(drive)
    x, y, off = np.empty_like(yaw), np.empty_like(yaw), np.zeros_like(yaw)
    for start, end in zip(starts, [*starts[1:], len(yaw)], strict=True):
        part = slice(start, end)
        course = yaw[part] + heading[start]
        step, turn = np.diff(drive.t[part]), np.diff(course)
        middle = course[:-1] + 0.5 * turn
        speed = 0.5 * (drive.sample_speed[part][1:] + drive.sample_speed[part][:-1])
        way, aside = speed * step, speed * step * bias - (rear + slip * speed**2) * turn
        east = way * np.cos(middle) - aside * np.sin(middle)
        north = way * np.sin(middle) + aside * np.cos(middle)
        near = slice(start, min(start + 5, end))
        # The mean of the first few, so that one sample's noise does not stay for 10 s.
        path = [np.concatenate(([0.0], np.cumsum(moved))) for moved in (east, north)]
        count = near.stop - near.start
        x[part] = path[0] + np.mean(drive.x[near] - path[0][:count])
        y[part] = path[1] + np.mean(drive.y[near] - path[1][:count])
        left = (drive.x[part] - x[part], drive.y[part] - y[part])
        off[part] = left[1] * np.cos(course) - left[0] * np.sin(course)
    counts = np.zeros(len(yaw), dtype=np.bool_)
    for part in drive.parts():
        counts[part.start + 1 : part.stop] = True
    step = np.diff(drive.t, prepend=drive.t[0] - drive.usual_step)
    return {
        "t": np.array(log.t),
        "x": np.array(log.x),
        "y": np.array(log.y),
        "simulated_x": x,
        "simulated_y": y,
        "position_error": off,
        "yaw_rate": np.diff(drive.yaw, prepend=drive.yaw[0]) / step,
        "simulated_yaw_rate": np.diff(yaw, prepend=yaw[0]) / step,
        "counts": counts,
    }


def _starts(drive: PreparedLog) -> list[int]:
    """Give the samples at which the simulation restarts."""
    found: list[int] = []
    ends = [*drive.starts[1:], len(drive.t)]
    for start, end in zip(drive.starts, ends, strict=True):
        first = drive.t[start]
        # What does not count, as nobody knows what was commanded before, is no beginning either.
        marks = np.arange(first + SETTLING, drive.t[end - 1] - 1e-9, AFRESH)
        marks = np.concatenate(([first], marks))
        places = start + np.searchsorted(drive.t[start:end], marks)
        found += [int(place) for place in places]
    return found
