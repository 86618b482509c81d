"""What drives on the map of a page, and what is drawn below it over time and distance."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from popsteer._core import Path, Vehicle
from popsteer.lab.report.colours import Colour
from popsteer.status import Status

Array = NDArray[Any]

HOLE = -(2**31)
"""What stands for a number that is not finite."""
_MOST = 2.0**30


class Pack:
    """Columns of numbers that a page carries.

    Rounded 32-bit integers, each the difference to the one before; their bytes are sorted by their
    place in the integer, which compresses well, and deflated.

    Examples
    --------
    >>> pack = Pack()
    >>> pack.add([1.0, 1.0004, float("nan")], 1e-3)
    [0, 3, 0.001, 1.0]
    >>> pack.add([1.0, 1.0004, float("nan")], 1e-3)  # the same is stored once
    [0, 3, 0.001, 1.0]
    """

    def __init__(self) -> None:
        self._parts: list[Any] = []
        self._count = 0
        self._known: dict[tuple[bytes, float], list[float]] = {}

    def add(self, values: ArrayLike, resolution: float) -> list[float]:
        """Add a column rounded to `resolution`; give first number, count, resolution, offset."""
        column = np.ascontiguousarray(values, dtype=np.float64)
        key = (column.tobytes(), resolution)
        if key not in self._known:
            whole = np.isfinite(column)
            low, high = (column[whole].min(), column[whole].max()) if whole.any() else (0.0, 0.0)
            scale = max(resolution, float(high - low) / _MOST)
            steps = np.full(len(column), HOLE, dtype=np.int64)
            steps[whole] = np.rint((column[whole] - low) / scale).astype(np.int64)
            # Differences wrap round at 32 bits, as the sums of them do on the page.
            differences = np.diff(steps, prepend=0).astype(np.uint64).astype(np.uint32)
            self._parts.append(differences)
            self._known[key] = [self._count, len(column), scale, float(low)]
            self._count += len(column)
        return list(self._known[key])

    def text(self) -> str:
        """Give all columns as text: Base64 of a zlib stream."""
        whole = np.concatenate([np.empty(0, dtype=np.uint32), *self._parts]).astype("<u4")
        return deflated(whole.view(np.uint8).reshape(-1, 4).T.tobytes())


def deflated(data: bytes) -> str:
    """Compress bytes as a page inflates them: Base64 of a zlib stream."""
    return base64.b64encode(zlib.compress(data, 9)).decode("ascii")


# What each column is rounded to: positions [m], errors [m], angles [deg], speeds [m/s], times [s].
_RESOLUTION = {"time": 1e-4, "distance": 1e-3, "x": 1e-3, "y": 1e-3, "speed": 1e-3, "status": 1.0}
_OTHERS = 1e-4
_FINE = 1e-3
_MOST_OF_PATH = 20_000  # points of a path on the map
_MARGIN = 0.2  # of a car's wheelbase, before and behind the axles


@dataclass(frozen=True)
class Panel:
    """A quantity over time or distance."""

    column: str
    """What it shows, a column of the actors."""
    title: str
    short: str
    """The head of its column beside the map."""
    decimals: int = 2
    """How many decimals its values are read with."""
    limit: float | None = None
    """Where a dashed line is drawn, either way."""


ANGLES = Panel("steer_deg", "Steering angle [deg]", "δ [deg]", 2)
"""The angle that was commanded."""


@dataclass(frozen=True)
class Actor:
    """A car that drives, or a controller that only watched."""

    name: str
    title: str
    colour: Colour
    columns: Mapping[str, Array]
    """`time` [s] and `distance` [m], both ascending; what is drawn besides, as long as they."""
    width: float = 1.4
    """Of its lines, in pixels."""
    body: str = "car"
    """What moves on the map: ``car``; ``dot``, which has no heading; or ``ray``, a direction of the
    front wheels on somebody else's car."""


@dataclass(frozen=True)
class Scene:
    """Actors along one path."""

    title: str
    actors: Sequence[Actor]
    panels: Sequence[Panel]
    vehicle: Vehicle
    """What is drawn of the cars."""
    paths: Sequence[Path] = ()
    marks: Sequence[tuple[float, float, str]] = ()
    """Places to mark on the map: x, y [m] and what is there."""
    distance_title: str = "distance along the path [m]"
    figures: Sequence[dict[str, Any]] = field(default=())
    settled: float = 0.0
    """When its start is over [s]."""

    @property
    def samples(self) -> int:
        """How many samples the longest of its columns has, before any is left out."""
        return max((len(each.columns["time"]) for each in self.actors), default=0)

    @property
    def points(self) -> int:
        """How many points its plots have, before any is left out."""
        drawn = {"time", *(panel.column for panel in self.panels)}
        return sum(
            len(each.columns["time"]) * len(drawn & each.columns.keys()) for each in self.actors
        )

    def document(self, pack: Pack, stride: int = 1) -> dict[str, Any]:
        """Give the scene for JSON, one of `stride` samples; its numbers go into `pack`."""
        statuses: set[int] = set()
        actors = []
        for actor in self.actors:
            keep = self._kept(actor, stride)
            columns = {}
            for name, values in actor.columns.items():
                if name == "status":
                    statuses |= {int(bits) for bits in np.unique(values)}
                fine = _FINE if name.endswith("_deg") else _OTHERS
                kept = np.asarray(values, dtype=np.float64)[keep]
                columns[name] = pack.add(kept, _RESOLUTION.get(name, fine))
            actors.append(vars(actor) | {"columns": columns})
        return {
            "title": self.title,
            "actors": actors,
            "panels": [vars(panel) for panel in self.panels],
            "paths": [_path(path, pack) for path in self.paths],
            "marks": [[float(x), float(y), text] for x, y, text in self.marks],
            "car": _car(self.vehicle),
            "statuses": {bits: [Status(bits).level, str(Status(bits))] for bits in statuses},
            "distanceTitle": self.distance_title,
            "figures": list(self.figures),
            "settled": self.settled,
        }

    def _kept(self, actor: Actor, stride: int) -> NDArray[np.int64]:
        """Choose samples: one in so many, and those that tell most."""
        count = len(actor.columns["time"])
        if stride == 1 or not count:
            return np.arange(count)
        # The last sample shows where the run ended.
        chosen = [np.arange(0, count, stride), np.array([count - 1])]
        if "status" in actor.columns:
            change = np.flatnonzero(np.diff(actor.columns["status"].astype(np.int64)))
            chosen += [change, change + 1]
        for panel in self.panels:
            values = np.abs(np.asarray(actor.columns.get(panel.column, []), dtype=np.float64))
            if np.isfinite(values).any():
                chosen.append(np.array([np.nanargmax(values)]))
        return np.unique(np.concatenate(chosen))


def _path(path: Path, pack: Pack) -> list[list[float]]:
    # A map has fewer pixels; the last point stays.
    keep = np.arange(0, len(path), -(-len(path) // _MOST_OF_PATH))
    if path.closed or keep[-1] != len(path) - 1:
        keep = np.append(keep, 0 if path.closed else len(path) - 1)
    return [pack.add(np.asarray(each)[keep], _RESOLUTION["x"]) for each in (path.x, path.y)]


def _car(vehicle: Vehicle) -> dict[str, float]:
    """Give the shape of a car, in metres ahead of the point whose pose it has."""
    rear, base = vehicle.rear_axle, vehicle.wheelbase
    ends = {"tail": rear - _MARGIN * 1.6 * base, "nose": rear + base + _MARGIN * 1.5 * base}
    return {"rear": rear, "front": rear + base, **ends, "half": 0.32 * base}


def travelled(time: Array, speed: Array) -> NDArray[np.float64]:
    """Tell how far a vehicle has driven from the first sample on [m], by its speed [m/s]."""
    middle = 0.5 * np.abs(np.asarray(speed)[1:] + np.asarray(speed)[:-1])
    return np.concatenate(([0.0], np.cumsum(middle * np.diff(time))))
