"""The situations that the benchmark puts the controllers in: a drive, state by state."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import TYPE_CHECKING

import numpy as np

from benches.latency.timing import Drive
from popsteer import Path, Pop, tracks, vehicles
from popsteer.errors import PathError
from popsteer.sim import default_start, run
from popsteer.tables.text import read_table

if TYPE_CHECKING:
    import os

    from numpy.typing import NDArray

DT = 0.05
"""The control period of both drives [s]: 20 Hz, the paper's."""

# Both drives are of one vehicle, the one that the plant was identified from.
_PLANT = "carla-identified"
# Beside the working directory, if that is the checkout.
_RECORDING = FilePath("..", "shared", "data", "carla_racetrack")


def at_hand() -> Drive:
    """Give the authors' recorded drive where its folder is, else the embedded track's."""
    return recorded(_RECORDING) if _RECORDING.is_dir() else embedded()


def embedded() -> Drive:
    """Drive the embedded race track with POP, from rest 2.44 m beside the path."""
    track = tracks.get("racetrack")
    path = Path(track.xy, speed=track.speed, closed=track.closed)
    vehicle = vehicles.get(_PLANT)
    start = default_start(path, 2.44, vehicle)
    driven = run(Pop(path, vehicle), _PLANT, start=start)
    table = np.column_stack([driven.records[name] for name in ("x", "y", "yaw", "speed")])
    return Drive("the embedded race track, closed loop", path, _tuples(table), vehicle)


def recorded(folder: str | os.PathLike[str]) -> Drive:
    """Read the drive that the paper's authors recorded in CARLA.

    The folder holds ``waypoints.csv``, ``trajectory.csv`` (t, x, y, speed of the front axle) and
    ``tracking_error.csv`` (cross-track error, heading error). The states begin with the second row
    of the trajectory; the first row is the vehicle's origin. Raises PathError where a file cannot
    be read or is not of this shape.

    Notes
    -----
    The recording holds no yaw. It does hold the heading error, direction of the path less yaw,
    against the segment that leads to the nearest waypoint; that gives the yaw back.
    """
    folder = FilePath(folder)
    path = Path.from_csv(folder / "waypoints.csv", columns="x,y,speed")
    trajectory = _table(folder / "trajectory.csv", 4)[1:]
    errors = _table(folder / "tracking_error.csv", 2)
    if len(errors) != len(trajectory):
        raise PathError(
            f"{folder / 'tracking_error.csv'}: has {len(errors)} rows for {len(trajectory)} states"
        )
    vehicle = vehicles.get(_PLANT)
    front = vehicle.front_axle
    table = np.empty((len(trajectory), 4))
    nearest = path.nearest_waypoint(*trajectory[0, 1:3])
    for row, (_, x, y, speed), heading_error in zip(table, trajectory, errors[:, 1], strict=True):
        # The vehicle is known by its point alone: look along the path, 6 m to both sides.
        place = path.locate(x, y, path.path_yaw_behind(nearest), nearest, 6.0)
        nearest = path.nearest_waypoint(*place.point)
        yaw = path.path_yaw_behind(nearest) - heading_error
        row[:] = x - front * np.cos(yaw), y - front * np.sin(yaw), yaw, speed
    return Drive("the authors' recorded run", path, _tuples(table), vehicle)


def _table(file: FilePath, columns: int) -> NDArray[np.float64]:
    """Read a file of numbers between commas: at least two rows, so many columns."""
    table = read_table(file)
    rows = sum(1 for _ in table.rows())
    if table.columns != columns or rows < 2:
        raise PathError(
            f"{file}: must hold at least 2 rows of {columns} finite numbers, has {rows} of"
            f" {table.columns}"
        )
    return table.numbers(range(columns))


def _tuples(table: NDArray[np.float64]) -> list[tuple[float, float, float, float]]:
    """Turn rows into Python's own numbers, as a controller written in Python would hold them."""
    return [(x, y, yaw, speed) for x, y, yaw, speed in table.tolist()]
