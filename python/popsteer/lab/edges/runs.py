"""Controllers on pathological paths: crossings, near misses, cusps, odd spacings, starts."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from popsteer import controllers, presets, sim, vehicles
from popsteer._core import AdaptParams, Path, Settings, SpeedPid, SpeedPidParams
from popsteer.errors import ConfigError
from popsteer.sim import KinematicBicycle, vehicle_of
from popsteer.status import Status
from popsteer.tracks import edges as shapes

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from typing import Any

    from popsteer._core import Vehicle
    from popsteer.controllers import Controller, Params
    from popsteer.sim import Plant, Run
    from popsteer.sim.closed_loop import Pose
    from popsteer.tracks.waypoints import Waypoints

__all__ = [
    "EDGE_CHANGES",
    "EDGE_CONTROLLERS",
    "EDGE_PLANT",
    "EdgeRun",
    "EdgeTrack",
    "edge_controller",
    "edge_params",
    "edge_tracks",
    "run",
]

EDGE_CONTROLLERS = ("pop", "pure-pursuit", "stanley", "pid", "preview-pop")
"""The controllers that drive the edges."""
MAX_STEER = 0.6
"""Largest angle of the wheels [rad]: a car's, which turns on a radius of 4.4 m."""
EDGE_PLANT = KinematicBicycle(vehicles.get("kinematic-bicycle").replace(max_steer=MAX_STEER))
"""What moves: it drives backwards as well."""
EDGE_CHANGES: Mapping[str, Mapping[str, float]] = {
    "pop": {"min_lookahead": 3.0},
    "pure-pursuit": {"min_lookahead": 3.0, "lookahead_gain": 0.5},
    "stanley": {"softening": 1.0},
    "pid": {"kd": 0.0},
    "preview-pop": {"min_speed": 1.0},
}
"""The parameters of each controller that are not its defaults, the same on all tracks.

Bends of 6 m radius and speeds of 0.3 m/s are no racetrack: lookaheads shorter than the bends, a
Stanley that is soft at walking pace, a preview that is not blind there and estimates the slip there
too. The wheels of this plant turn at once, so that the PID's derivative would answer to its own
last command.
"""
TOP_SPEED = 10.0
"""Speed that no reference speed exceeds [m/s]."""
TURNING_SPEED = 2.0
"""... where the path turns more sharply than the vehicle can [m/s]."""
START_SPEED = 5.0
"""... and on the straight that is joined from beside and askew [m/s]."""

_PEDALS = SpeedPidParams(kp=1.0, ki=0.5)
_TIME_LIMIT = 300.0  # [s]


class EdgeTrack(NamedTuple):
    """A path that is hard to follow, and where its run starts."""

    name: str
    """What it is called in the table."""
    path: Path
    """The path, with reference speeds."""
    start: Pose
    """Pose of the rear axle at the start [m, m, rad]."""


@dataclass(frozen=True, eq=False)
class EdgeRun:
    """What a controller did on an edge."""

    track: str
    """Name of the track."""
    law: str
    """Name of the controller."""
    finished: bool
    """Whether the end was reached."""
    ending: str
    """How the run ended; `Simulation.ending` lists the ways."""
    time: float
    """How long it took [s]."""
    max_error: float
    """Largest distance of the rear axle from the path [m]."""
    max_jump: float
    """Largest change of the commanded angle from one step to the next [rad]."""
    steps: int
    """How many steps it took."""
    statuses: Mapping[Status, int]
    """In how many steps each condition held, `Status.OK` where none did; only what came up, the
    most frequent first. Several conditions may hold in one step."""


def edge_tracks() -> tuple[EdgeTrack, ...]:
    """Give the tracks of the table.

    Returns
    -------
    tuple of EdgeTrack
        Crossings and near misses, odd spacings, cusps, and starts beside and askew.

    Examples
    --------
    >>> [track.name for track in edge_tracks()][:3]
    ['figure-eight', 'out-and-back', 'spiral']
    >>> edge_tracks()[0].path.closed
    True
    """
    straight = shapes.dense_straight(100.0, 1.0)
    touching = shapes.touching()
    shown_thrice = [np.repeat(part, 3, axis=0) for part in touching[:2]]
    joined = _path(straight, START_SPEED)
    return (
        _track("figure-eight", _path(shapes.figure8())),
        _track("out-and-back", _path(shapes.out_and_back(0.5), TURNING_SPEED)),
        _track("spiral", _path(shapes.spiral())),
        _track("touching", _path(touching)),
        _track(
            "duplicates",
            Path(
                shown_thrice[0],
                speed=np.clip(shown_thrice[1], 0.0, TOP_SPEED),
                drop_duplicates=True,
            ),
        ),
        _track("near-duplicates", _path(shapes.near_duplicates())),
        _track("spacing-0.01", _path(shapes.figure8(spacing=0.01))),
        _track("spacing-100", _path(shapes.polygon(12, 100.0))),
        _track("three-point-turn", _path(shapes.three_point_turn())),
        _track("parallel-parking", _path(shapes.parallel_parking())),
        EdgeTrack("start-3-m-beside", joined, (0.0, 3.0, 0.0)),
        EdgeTrack("start-90-deg-off", joined, (0.0, 0.0, 0.5 * math.pi)),
        EdgeTrack("start-180-deg-off", joined, (0.0, 0.0, math.pi)),
    )


def _path(waypoints: Waypoints, top_speed: float = TOP_SPEED) -> Path:
    """Make a path on which no speed, forwards or backwards, exceeds `top_speed` [m/s]."""
    xy, speed, closed = waypoints
    return Path(xy, speed=np.clip(speed, -top_speed, top_speed), closed=closed)


def _track(name: str, path: Path) -> EdgeTrack:
    """Start with the rear axle on the first waypoint, along the first segment."""
    x, y = float(path.x[0]), float(path.y[0])
    return EdgeTrack(name, path, (x, y, math.atan2(float(path.y[1]) - y, float(path.x[1]) - x)))


def run(
    names: Iterable[str] | Mapping[str, Params] = EDGE_CONTROLLERS,
    tracks: Iterable[EdgeTrack] | None = None,
    *,
    plant: Plant = EDGE_PLANT,
    vehicle: Vehicle | None = None,
    adapt: AdaptParams | Literal["auto"] | None = "auto",
    dt: float = 0.05,
    progress: Callable[[str, float], object] | None = None,
) -> list[EdgeRun]:
    """Let controllers drive the edges, at the paths' reference speeds.

    Parameters
    ----------
    names : iterable of str, or mapping of str to parameters
        The controllers, of `popsteer.controllers.names`. A mapping gives each its tuning instead
        of that of `edge_params`.
    tracks : iterable of EdgeTrack, optional
        The tracks; all of `edge_tracks` by default.
    plant : str or CarlaIdentified or KinematicBicycle or PythonPlant, default EDGE_PLANT
        What moves; only one that reverses drives the tracks with cusps.
    vehicle : Vehicle, optional
        The vehicle that the controllers are given; the plant's own by default.
    adapt : AdaptParams or None, optional
        How the controllers adapt; None: not at all. Left out: as `EDGE_CHANGES` has it.
    dt : float, default 0.05
        Control period [s].
    progress : callable, optional
        Called now and then with what is being done and the share of all that is done, 0 to 1.

    Returns
    -------
    list of EdgeRun
        Track by track, a run of each controller.

    Raises
    ------
    ConfigError
        There is no controller or track, or a controller is not known; nothing was driven then.
    PathError
        The plant does not reverse, and a track is driven backwards in places.

    Examples
    --------
    >>> row = run(["stanley"], edge_tracks()[:1])[0]
    >>> row.track, row.finished, row.max_error < 0.5
    ('figure-eight', True, True)
    """
    params = dict(names) if isinstance(names, Mapping) else dict.fromkeys(names)
    chosen, courses = list(params), list(edge_tracks() if tracks is None else tracks)
    for field, given in (("controllers", chosen), ("tracks", courses)):
        if not given:
            raise ConfigError(field, given, "at least one")
    for name in chosen:
        controllers.get(name)  # refuses an unknown one
    believed = vehicle_of(plant) if vehicle is None else vehicle
    total = len(chosen) * len(courses)
    rows: list[EdgeRun] = []
    for track in courses:
        for name in chosen:
            if progress is not None:
                progress(f"{track.name}: {name}", len(rows) / total)
            done = sim.run(
                edge_controller(name, track.path, believed, params[name], adapt),
                plant,
                start=track.start,
                start_at="rear",
                longitudinal=SpeedPid(_PEDALS),
                settings=Settings(dt=dt, time_limit=_TIME_LIMIT),
            )
            rows.append(_row(track.name, done))
    if progress is not None:
        progress("done", 1.0)
    return rows


def edge_params(name: str) -> Params:
    """Give the tuning that a controller drives the edges with: `EDGE_CHANGES` of its default.

    Parameters
    ----------
    name : str
        One of `popsteer.controllers.names`.

    Returns
    -------
    parameters of that controller
        The tuning.

    Raises
    ------
    ConfigError
        The controller is not known.

    Examples
    --------
    >>> edge_params("stanley").softening
    1.0
    """
    # The registry pairs each controller with its parameters; the type checker cannot see that.
    usual: Any = presets.get(name, "default")
    changed: Params = usual.replace(**EDGE_CHANGES.get(name, {}))
    return changed


def edge_controller(
    name: str,
    path: Path,
    vehicle: Vehicle,
    params: Params | None = None,
    adapt: AdaptParams | Literal["auto"] | None = "auto",
) -> Controller:
    """Make a controller as it drives the edges.

    Parameters
    ----------
    name : str
        One of `popsteer.controllers.names`.
    path : Path
        What it follows.
    vehicle : Vehicle
        The vehicle that it is given.
    params : parameters of that controller, optional
        Its tuning; by default that of `edge_params`.
    adapt : AdaptParams or None, optional
        How it adapts; None: not at all. Left out: as `EDGE_CHANGES` has it.

    Returns
    -------
    Controller
        In a fresh state.

    Raises
    ------
    ConfigError
        The controller is not known.

    Examples
    --------
    >>> from popsteer import Path, Vehicle
    >>> edge_controller("pop", Path([(0.0, 0.0), (9.0, 0.0)]), Vehicle()).params.min_lookahead
    3.0
    """
    # The registry pairs each controller with its parameters; the type checker cannot see that.
    tuning: Any = edge_params(name) if params is None else params
    changes = EDGE_CHANGES.get(name, {})
    if adapt == "auto" and "min_speed" in changes:
        adapt = AdaptParams(min_speed=changes["min_speed"])
    return controllers.get(name).controller(path, vehicle, tuning, adapt=adapt)


def _row(track: str, done: Run) -> EdgeRun:
    """Sum up a run."""
    statuses = done.records["status"]
    counts = Counter({each: int(np.count_nonzero(statuses & each)) for each in Status if each})
    counts[Status.OK] = int(np.count_nonzero(statuses == Status.OK))
    return EdgeRun(
        track=track,
        law=done.law,
        finished=done.metrics.finished,
        ending=done.ending,
        time=done.metrics.time,
        max_error=done.metrics.rear_axle_max_abs_cross_track_error,
        max_jump=float(np.abs(np.diff(done.records["steer"])).max(initial=0.0)),
        steps=len(statuses),
        statuses={each: count for each, count in counts.most_common() if count},
    )
