"""Controllers on pathological paths: crossings, near misses, cusps, odd spacings, starts.

Also the angle on the last metres of a path, and past its end. These are tables of docs/edges.md.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from popsteer import (
    Path,
    SpeedPid,
    SpeedPidParams,
    Status,
    Vehicle,
    controllers,
    presets,
    sim,
    vehicles,
)
from popsteer.lab.common.experiment import controller as made
from popsteer.sim import KinematicBicycle, Plant, Pose, Run, Settings, vehicle_of
from popsteer.tracks import edges as shapes
from studies.layout import course, line

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from numpy.typing import NDArray

    from popsteer.tracks.geometry import Waypoints

NAMES = ("pop", "pure-pursuit", "stanley", "pid", "preview-pop")
PLANT = KinematicBicycle(vehicles.get("kinematic-bicycle").replace(max_steer=0.6))
"""What moves: it drives backwards as well, and turns on a radius of 4.4 m, as a car does."""
CHANGES: Mapping[str, Mapping[str, float]] = {
    "pop": {"min_lookahead": 3.0},
    "pure-pursuit": {"min_lookahead": 3.0, "lookahead_gain": 0.5},
    "stanley": {"softening": 1.0},
    "preview-pop": {"min_speed": 1.0},
}
"""The parameters of each controller that are not its defaults, the same on all tracks.

Bends of 6 m radius and speeds of 0.3 m/s are no racetrack: lookaheads shorter than the bends, a
Stanley that is soft at walking pace, a preview that is not blind there.
"""
TOP_SPEED = 10.0
"""Speed that no reference speed exceeds [m/s]."""
TURNING_SPEED = 2.0
"""... where the path turns more sharply than the vehicle can [m/s]."""
START_SPEED = 5.0
"""... and on the straight that is joined from beside and askew [m/s]."""
PEDALS = SpeedPidParams(kp=1.0, ki=0.5)
SETTINGS = Settings(dt=0.05, time_limit=300.0)


class EdgeTrack(NamedTuple):
    """A path that is hard to follow, and where its run starts."""

    name: str
    path: Path
    start: Pose
    """Pose of the rear axle at the start [m, m, rad]."""


@dataclass(frozen=True, eq=False)
class EdgeRun:
    """What a controller did on an edge, and how long it took [s]."""

    track: str
    law: str
    finished: bool
    ending: str
    """How the run ended; `Simulation.ending` lists the ways."""
    time: float
    max_error: float
    """Largest distance of the rear axle from the path [m]."""
    max_jump: float
    """Largest change of the commanded angle from one step to the next [rad]."""
    steps: int
    statuses: Mapping[Status, int]
    """In how many steps each condition held, `Status.OK` where none did; only what came up, the
    most frequent first. Several conditions may hold in one step."""


def edge_tracks() -> tuple[EdgeTrack, ...]:
    """Crossings and near misses, odd spacings, cusps, and starts beside and askew."""
    straight = shapes.dense_straight(100.0, 1.0)
    touching = shapes.touching()
    xy, speed = (np.repeat(part, 3, axis=0) for part in touching[:2])
    duplicates = Path(xy, speed=np.clip(speed, 0.0, TOP_SPEED))
    joined = _path(straight, START_SPEED)
    return (
        _track("figure-eight", _path(shapes.figure8())),
        _track("out-and-back", _path(shapes.out_and_back(0.5), TURNING_SPEED)),
        _track("spiral", _path(shapes.spiral())),
        _track("touching", _path(touching)),
        _track("duplicates", duplicates),
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
    names: Iterable[str] = NAMES,
    tracks: Iterable[EdgeTrack] | None = None,
    *,
    plant: Plant = PLANT,
    vehicle: Vehicle | None = None,
) -> list[EdgeRun]:
    """Let controllers drive the edges, track by track, at the paths' reference speeds.

    `vehicle` is what the controllers are given; the plant's own by default.
    """
    believed = vehicle_of(plant) if vehicle is None else vehicle
    return [
        _row(
            track.name,
            sim.run(
                edge_controller(name, track.path, believed),
                plant,
                start=track.start,
                start_at="rear",
                longitudinal=SpeedPid(PEDALS),
                settings=SETTINGS,
            ),
        )
        for track in (edge_tracks() if tracks is None else tracks)
        for name in names
    ]


def edge_controller(name: str, path: Path, vehicle: Vehicle) -> controllers.Controller:
    """Make a controller as it drives the edges: its default, with `CHANGES`."""
    # The registry pairs each controller with its parameters; the type checker cannot see that.
    usual: Any = presets.get(name, "default")
    return controllers.get(name).controller(path, vehicle, usual.replace(**CHANGES.get(name, {})))


def _row(track: str, done: Run) -> EdgeRun:
    """Sum up a run."""
    statuses = done.records["status"]
    # `saturated` says enough here: it is the angle that limits.
    shown = [each for each in Status if each and each < Status.STEER_LIMIT]
    counts = Counter({each: int(np.count_nonzero(statuses & each)) for each in shown})
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


def edge_lines(runs: Iterable[EdgeRun]) -> list[str]:
    """A row for each run."""
    return [
        line(
            run.track,
            controllers.get(run.law).title,
            run.ending,
            f"{run.time:.1f}",
            f"{run.max_error:.2f}",
            f"{math.degrees(run.max_jump):.1f}",
            _shares(run),
        )
        for run in runs
    ]


def _shares(run: EdgeRun) -> str:
    """Say in which shares of the steps each condition held."""
    shares = {status: 100.0 * count / run.steps for status, count in run.statuses.items()}
    return ", ".join(
        f"{status} {f'{share:.0f}' if share >= 0.5 else '<1'} %" for status, share in shares.items()
    )


END_PLANT = "carla-identified"
END_CAR = vehicles.get(END_PLANT)
TO_THE_END = Settings(stop_distance=0.0, time_limit=300.0)
CUT = 15.0
"""How much shorter the controller's path is where it is driven past its end [m]."""


def controller(name: str, path: Path, preset: str) -> Any:
    """Make a controller of the plant's vehicle."""
    return made(name, path, END_CAR, presets.get(name, preset))


def shortened(name: str, path: Path, preset: str) -> Any:
    """Make a controller whose path ends `CUT` earlier, to drive along the whole of it."""
    kept = path.s <= path.length - CUT
    speed = None if path.speed is None else path.speed[kept]
    shorter = Path(np.column_stack((path.x, path.y))[kept], speed=speed)
    law = controller(name, shorter, preset)
    return SimpleNamespace(step=law.step, tracked_point=law.tracked_point)


def angles_by_arc(
    law: controllers.Controller, path: Path, start: Pose | None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where on the path the front axle was at each step [m], and the angle commanded [rad]."""
    done = sim.run(law, END_PLANT, path=path, start=start, settings=TO_THE_END)
    records = done.records
    x = records["x"] + END_CAR.front_axle * np.cos(records["yaw"])
    y = records["y"] + END_CAR.front_axle * np.sin(records["yaw"])
    arc = np.array([path.project(*point).arc_length for point in zip(x, y, strict=True)])
    return arc, records["steer"]


def end_lines() -> list[str]:
    """A row for each preset of the controllers that look ahead."""
    path, start = course("racetrack")
    lines = []
    for name in ("pop", "pure-pursuit"):
        for preset in ("default", "paper", "published-code"):
            arc, steer = angles_by_arc(controller(name, path, preset), path, start)
            whole = np.degrees(np.abs(steer[arc > path.length - 10.0]).max())
            arc, steer = angles_by_arc(shortened(name, path, preset), path, start)
            past = f"{np.degrees(np.abs(steer[arc > path.length - CUT]).max()):.1f}"
            if arc[-1] < path.length - 2.0:
                past = f"{past}, circles"
            lines.append(line(controllers.get(name).title, preset, f"{whole:.1f}", past))
    return lines
