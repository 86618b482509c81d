"""Controllers along a log: each computes its command, and the driver's stays applied."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from popsteer import controllers, own
from popsteer._core import Path, Vehicle
from popsteer.errors import ConfigError
from popsteer.lab import baselines
from popsteer.lab.common.experiment import Adapt, Monitor
from popsteer.logs import Log, LogError
from popsteer.own import OwnCodeError
from popsteer.sim.steering import step_of, tracked_point
from popsteer.state import State
from popsteer.status import Status

Array = NDArray[np.float64]


class Watched(NamedTuple):
    """What it answered, and where its tracked point was."""

    steer: float
    status: Status
    cross_track_error: float
    heading_error: float


class Watching:
    """A controller of your own, which is not told what the driver applied."""

    def __init__(self, name: str, path: Path, vehicle: Vehicle, params: Any, **_: object) -> None:
        # What is left out says how to adapt and to watch: one of your own does both as it likes.
        found = baselines.get(name)
        params = found.params() if params is None else params
        self._name, self._path = name, path
        self._own: Any = found.controller(path, vehicle, params)
        self._step = step_of(self._own)
        tracked = tracked_point(self._own)
        self.tracked_point = vehicle.front_axle if tracked is None else tracked
        self.segment: int | None = None
        # As the controllers of popsteer search, of two wheelbases and the distance travelled.
        self._reach = 2.0 * vehicle.wheelbase
        self._opposite = vehicle.wheelbase * 10.0 / 3.0

    def step_or_hold(
        self, x: float, y: float, yaw: float, speed: float, dt: float, **_: float
    ) -> Watched:
        """Answer a row of the log; OwnCodeError, with its traceback, if the controller raises."""
        try:
            command = self._step(x, y, yaw, speed, dt)
            steer = float(getattr(command, "steer", command))
        except Exception as error:
            raise OwnCodeError(self._name, error) from error
        if not math.isfinite(steer):
            raise ConfigError(f"the angle of {self._name}", steer, "finite")
        x, y = x + self.tracked_point * math.cos(yaw), y + self.tracked_point * math.sin(yaw)
        if self.segment is None:
            self.segment = self._path.relocalise(x, y, yaw, opposite_distance=self._opposite)
        reach = self._reach + abs(speed) * dt
        at = self._path.locate(x, y, yaw, self.segment, reach, opposite_distance=self._opposite)
        self.segment = at.segment
        heading = math.remainder(yaw - at.path_yaw, math.tau)
        status = Status(int(getattr(command, "status", 0)))
        return Watched(steer, status, at.cross_track_error, heading)


SPACING = 1.0 / 6.0
"""Distance of the waypoints that are made of a log's trajectory, in wheelbases."""
NOISE = 0.03
"""How much of the noise of the positions may remain in the path's curvature, standard deviation
times the wheelbase: the wheels' angle that it asks for [rad]."""
LEAST, MOST = 0.1, 1.0
"""Bounds of the length that such a path is smoothed over, in wheelbases."""
_SHORTEST = 2.0
"""Least distance that makes a path, in wheelbases."""
_LONGEST = 1e6
"""What no drive is longer than [m]."""


@dataclass(frozen=True, eq=False)
class Shadow:
    """What one controller would have done: arrays with a number for each row of the log."""

    name: str
    path: Path
    """What it would have followed."""
    steer: Array
    """The angles that it would have commanded [rad]."""
    cross_track_error: Array
    heading_error: Array
    """The errors of its tracked point as the car was driven [m, rad]."""
    status: NDArray[np.uint32]
    """The bits of `popsteer.Status`."""

    def share(self, level: str) -> float:
        """Give the share of the rows whose status is of this level, "degraded" or "fault"."""
        known, counts = np.unique(self.status, return_counts=True)
        hit = [n for bits, n in zip(known, counts, strict=True) if Status(int(bits)).level == level]
        return float(sum(hit)) / max(len(self.status), 1)

    def conditions(self) -> dict[str, float]:
        """Give the share of the rows in which each condition held, those that did."""
        held = ((str(each), (self.status & int(each)) != 0) for each in Status if each)
        return {name: float(np.mean(rows)) for name, rows in held if rows.any()}


@dataclass(frozen=True, eq=False)
class Replay:
    """Controllers along a log."""

    log: Log
    vehicle: Vehicle
    shadows: dict[str, Shadow]
    course: str
    """What was to be followed, in words."""
    called: str = ""
    """What the vehicle is called, in words; nothing is said of it without."""


def run(
    log: Log,
    tuning: Mapping[str, controllers.Params | None],
    vehicle: Vehicle,
    *,
    path: Path | None = None,
    course: str = "the log's own trajectory",
    adapt: Adapt = "auto",
    monitor: Monitor = "auto",
    progress: Callable[[str, float], object] | None = None,
) -> Replay:
    """Let controllers watch a drive.

    Each is given the poses and speeds of the log, and the driver's angle as the one that was
    applied: it answers what it would command now, whatever it answered before. After a gap it
    begins anew. `tuning` has the parameters of each controller by its name, None for the defaults.
    Without a `path` each follows the trajectory that its own tracked point was driven along;
    `course` is what to call it. Raises ConfigError where no controller has such a name,
    OwnCodeError where one of your own raises, and LogError where the log's trajectory makes no
    path.
    """
    shadows = {}
    for name, params in tuning.items():
        own_code = name not in controllers.names() and own.is_named("controller", name)
        kind: Any = partial(Watching, name) if own_code else controllers.get(name).controller
        make = partial(kind, vehicle=vehicle, params=params, adapt=adapt, monitor=monitor)
        followed, places = path, None
        if followed is None:
            # Where the tracked point lies is known to the controller alone.
            somewhere = make(Path([(0.0, 0.0), (1.0, 0.0)]))
            followed, places = _own(log, float(somewhere.tracked_point), vehicle.wheelbase)
        shadows[name] = _shadow(log, name, make, followed, places, progress)
    return Replay(log=log, vehicle=vehicle, shadows=shadows, course=course)


def _shadow(
    log: Log,
    name: str,
    make: Callable[[Path], Any],
    path: Path,
    places: NDArray[np.int64] | None,
    progress: Callable[[str, float], object] | None,
) -> Shadow:
    """Let a controller watch; `places` are the waypoints to find where laps could overlap."""
    count = len(log)
    steer, cross, heading = np.empty(count), np.empty(count), np.empty(count)
    status = np.empty(count, dtype=np.uint32)
    states = np.column_stack((log.x, log.y, log.yaw, log.speed, log.steps)).tolist()
    # The angle applied since the row before; at the first row, the angle of that row.
    applied = [log.steer[0], *log.steer[:-1].tolist()]
    begins = {0, *log.gaps}
    controller: Any = None
    for k, (state, angle) in enumerate(zip(states, applied, strict=True)):
        if k in begins:
            controller = make(path)
            if places is not None:
                _place(controller, int(places[k]))
        command = controller.step_or_hold(*state, applied_steer=angle)
        steer[k], status[k] = command.steer, int(command.status)
        cross[k], heading[k] = command.cross_track_error, command.heading_error
        if progress is not None and k % 512 == 0:
            progress(name, k / count)
    return Shadow(name, path, steer, cross, heading, status)


def own_path(log: Log, ahead: float = 0.0, wheelbase: float = 3.0) -> Path:
    """Make a path of a log's trajectory, smoothed as little as its noise allows, with its speeds.

    It is that of the point `ahead` of the pose's [m], with a waypoint every `SPACING` wheelbases,
    backwards where the log drives backwards. The smoothing is Whittaker's, as that of
    `popsteer.planning.curvature`: a bend keeps its radius. Raises LogError where the car was driven
    for less than two wheelbases.
    """
    return _own(log, ahead, wheelbase)[0]


def _place(controller: Any, waypoint: int) -> None:
    """Give a controller its place: where laps overlap, it could find the wrong one."""
    if isinstance(controller, Watching):
        controller.segment = waypoint
        return
    path = controller.path
    point = float(path.x[waypoint]), float(path.y[waypoint])
    place = State(segment=waypoint, point=point, lost=False)
    controller.state = controller.state.replace(place=place)


def _own(log: Log, ahead: float, wheelbase: float) -> tuple[Path, NDArray[np.int64]]:
    """Make the path, and say near which of its waypoints each row is."""
    # The distance by the speed: noisy positions of a standing car would add up to one.
    middle = 0.5 * np.abs(log.speed[1:] + log.speed[:-1])
    step = np.diff(log.t)
    gaps = np.array(log.gaps, dtype=np.int64) - 1
    chord = np.hypot(np.diff(log.x), np.diff(log.y))
    rolled = middle * step
    rolled[gaps] = chord[gaps]
    way = np.concatenate(([0.0], np.cumsum(rolled)))
    if way[-1] < _SHORTEST * wheelbase:
        raise LogError(
            f"{log.name}: {way[-1]:.1f} m of driving make no path: at least"
            f" {_SHORTEST * wheelbase:.3g} m are needed, or --waypoints"
        )
    if way[-1] > _LONGEST:
        worst = int(np.argmax(rolled))
        raise LogError(
            f"{log.name}: {rolled[worst]:.3g} m between rows {worst} and {worst + 1}: a position"
            " or a speed there is none of a drive"
        )
    backwards = log.speed < 0.0
    turns = _turns(way, backwards, wheelbase / 3.0)
    x = log.x + ahead * np.cos(log.yaw)
    y = log.y + ahead * np.sin(log.yaw)
    pieces = []
    for start, end in pairwise(turns):
        at = np.linspace(start, end, max(2, round((end - start) / (SPACING * wheelbase)) + 1))
        inside = (way >= start) & (way <= end)
        if inside.sum() < 2:
            continue
        line = _smoothed(way[inside], np.stack((x[inside], y[inside])), at, wheelbase)
        back = np.full(len(at), np.interp(0.5 * (start + end), way, backwards) > 0.5)
        pieces.append((*line, np.interp(at, way, log.speed), at, back))
    columns = [np.concatenate(parts) for parts in zip(*pieces, strict=True)]
    keep = np.concatenate(([True], np.hypot(np.diff(columns[0]), np.diff(columns[1])) > 1e-3))
    xy = np.column_stack((columns[0], columns[1]))[keep]
    speed, at, reverse = (column[keep] for column in columns[2:])
    speed = np.where(reverse, np.minimum(speed, 0.0), np.maximum(speed, 0.0))
    path = Path(xy, speed=speed, reverse=reverse if reverse.any() else None)
    near = np.clip(np.searchsorted(at, way, side="right") - 1, 0, len(xy) - 2)
    return path, near.astype(np.int64)


def _turns(way: Array, backwards: NDArray[np.bool_], least: float) -> list[float]:
    """Give the ends of the stretches that are driven one way, those longer than `least` [m]."""
    marks = way[1:][np.diff(backwards.astype(int)) != 0]
    found = [0.0]
    for mark in [*marks, way[-1]]:
        if mark - found[-1] > least:
            found.append(float(mark))
    found[-1] = float(way[-1])
    return found


def _smoothed(way: Array, points: Array, at: Array, wheelbase: float) -> Array:
    """Smooth points (2, N) over the distance by Whittaker's graduation; give them `at` (2, M).

    The q are taken that minimise Σ |q - p|² + (length / h)⁶ Σ |Δ³q|², at a distance h: a wave of
    length 2π L is kept up to 1 / (1 + (length / L)⁶). Of noise n every h it leaves a curvature of
    n sqrt(0.0556 h / length⁵).
    """
    from scipy.linalg import solveh_banded

    rows = 1 + int(np.count_nonzero(np.diff(way) > 0.0))
    count = max(rows, 2)
    even = np.linspace(way[0], way[-1], count)
    line = np.stack([np.interp(even, way, each) for each in points])
    step = float(even[1] - even[0])
    if count > 6:
        noise = 1.4826 * float(np.median(np.abs(np.diff(line, 3)))) / np.sqrt(20.0)
        wanted = (0.0556 * step * (noise * wheelbase / NOISE) ** 2) ** 0.2
        weight = (np.clip(wanted, LEAST * wheelbase, MOST * wheelbase) / step) ** 6
        bands = np.zeros((4, count))
        bands[3] = 1.0
        third = np.array([-1.0, 3.0, -3.0, 1.0])
        for one in range(4):
            for other in range(one, 4):
                last = count - 3
                bands[3 - (other - one), other : other + last] += weight * third[one] * third[other]
        line = solveh_banded(bands, line.T).T
    found: Array = np.stack([np.interp(at, even, each) for each in line])
    return found
