"""What the commands are given, as the library takes it."""

from __future__ import annotations

import os
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, NamedTuple, get_args

from popsteer import plants, sim, tracks, vehicles
from popsteer._core import Path, Vehicle
from popsteer.cli.assignments import assigned
from popsteer.errors import ConfigError
from popsteer.sim import CarlaIdentified, KinematicBicycle, default_start
from popsteer.sim.geometry import StartAt, made

if TYPE_CHECKING:
    from collections.abc import Sequence

    from popsteer.plants.protocol import PythonPlant
    from popsteer.sim.closed_loop import Pose

__all__ = [
    "DEFAULT_TRACK",
    "PLANTS",
    "Course",
    "Start",
    "believed",
    "course",
    "named_vehicle",
    "names",
    "plant",
    "plant_label",
    "start",
]

PLANTS: dict[str, type[CarlaIdentified | KinematicBicycle]] = {
    "carla-identified": CarlaIdentified,
    "kinematic-bicycle": KinematicBicycle,
}
"""The plants of the core by name."""
DEFAULT_TRACK = "racetrack"
"""The track that is driven unless told otherwise."""


class Course(NamedTuple):
    """A path, and what to call it."""

    path: Path
    name: str


class Start(NamedTuple):
    """A pose at the start, and whose it is."""

    pose: Pose | None
    at: StartAt


def course(waypoints: FilePath | None, track: str | None, *, closed: bool) -> Course:
    """Give the path that the options ask for.

    Parameters
    ----------
    waypoints : pathlib.Path, optional
        A file of waypoints.
    track : str, optional
        Name of a shipped track; `DEFAULT_TRACK` where neither is given.
    closed : bool
        Whether the last waypoint of the file joins its first.

    Returns
    -------
    Course
        The path and its name.

    Raises
    ------
    ConfigError
        No track has this name, or the options exclude each other.
    PathError
        The file makes no path.

    Examples
    --------
    >>> course(None, "circle", closed=False).name
    'circle'
    """
    if waypoints is not None:
        if track is not None:
            raise ConfigError("--track", track, "left out where --waypoints is given")
        return Course(Path.from_csv(os.fspath(waypoints), closed=closed), waypoints.name)
    if closed:
        raise ConfigError("--closed", closed, "given with --waypoints; a track knows by itself")
    shipped = tracks.get(DEFAULT_TRACK if track is None else track)
    return Course(Path(shipped.xy, speed=shipped.speed, closed=shipped.closed), shipped.name)


def names(text: str) -> list[str]:
    """Split a list of names at its commas.

    Parameters
    ----------
    text : str
        The list; it may be empty here and there.

    Returns
    -------
    list of str
        The names, each once, in the order given.

    Raises
    ------
    ConfigError
        There is none.

    Examples
    --------
    >>> names("pid, pop,,pid")
    ['pid', 'pop']
    """
    found = list(dict.fromkeys(name for name in map(str.strip, text.split(",")) if name))
    if not found:
        raise ConfigError("--controllers", text, "names of controllers, separated by commas")
    return found


def start(path: Path, text: str | None, at: str, offset: float | None, vehicle: Vehicle) -> Start:
    """Give the pose that the options ask for.

    Parameters
    ----------
    path : Path
        What is followed.
    text : str or None
        ``X,Y,YAW`` [m, m, rad].
    at : {"pose", "rear", "front"}
        Whose pose that is: the vehicle's point's, or that of an axle.
    offset : float or None
        How far to the left of the first waypoint [m], as `popsteer.sim.default_start` has it.
    vehicle : Vehicle
        What starts.

    Returns
    -------
    Start
        The pose, None where neither is given; and whose it is.

    Raises
    ------
    ConfigError
        They are not three numbers, the offset is out of its range, or both are given.

    Examples
    --------
    >>> path = Path([(0.0, 0.0), (9.0, 0.0)])
    >>> start(path, "-183.8,78.7,-1.574", "front", None, Vehicle())
    Start(pose=(-183.8, 78.7, -1.574), at='front')
    >>> start(path, None, "pose", 1.0, Vehicle(rear_axle=-1.5))
    Start(pose=(-1.5, 1.0, 0.0), at='pose')
    """
    place = next((known for known in get_args(StartAt) if known == at), None)
    if place is None:
        raise ConfigError.unknown("--start-at", at, get_args(StartAt))
    if text is None:
        if place != "pose":
            raise ConfigError("--start-at", at, "given with --start")
        return Start(None if offset is None else default_start(path, offset, vehicle), place)
    if offset is not None:
        raise ConfigError("--start-offset", offset, "left out where --start is given")
    try:
        x, y, yaw = (float(part) for part in text.split(","))
    except ValueError:
        raise ConfigError("--start", text, "three numbers X,Y,YAW [m, m, rad]") from None
    return Start((x, y, yaw), place)


def plant(text: str) -> CarlaIdentified | KinematicBicycle | PythonPlant:
    """Give the plant that an option names.

    Parameters
    ----------
    text : str
        The name of a plant, or a file ``*.toml`` of a vehicle: a kinematic bicycle is made of it.

    Returns
    -------
    CarlaIdentified or KinematicBicycle or PythonPlant
        What moves.

    Raises
    ------
    ConfigError
        No plant has this name, or the file holds no vehicle.
    PopsteerError
        The plant needs an extra that is not installed.

    Examples
    --------
    >>> plant("carla-identified").vehicle.rear_axle
    -1.94
    """
    if _is_file(text):
        return KinematicBicycle(Vehicle.load(text))
    found = made(text)  # refuses an unknown one
    return PLANTS[text]() if isinstance(found, str) else found


def plant_label(text: str) -> str:
    """Say what to call a plant in tables.

    Parameters
    ----------
    text : str
        As `plant` takes it.

    Returns
    -------
    str
        Its name; of a file the file's.

    Examples
    --------
    >>> plant_label("cars/golf.toml")
    'golf.toml'
    """
    return FilePath(text).name if _is_file(text) else text


def named_vehicle(text: str) -> Vehicle:
    """Give the vehicle that an option names.

    Parameters
    ----------
    text : str
        A file ``*.toml`` of a vehicle, a name of `popsteer.vehicles.names`, or that of a plant.

    Returns
    -------
    Vehicle
        The vehicle.

    Raises
    ------
    ConfigError
        No vehicle has this name, or the file holds none.

    Examples
    --------
    >>> named_vehicle("carla-identified").rear_axle
    -1.94
    """
    if _is_file(text):
        return Vehicle.load(text)
    if text in vehicles.names():
        return vehicles.get(text)
    if text in plants.names():
        return sim.vehicle_of(text)
    known = (*vehicles.names(), *plants.names(), "a file *.toml")
    raise ConfigError.unknown("vehicle", text, known)


def believed(text: str | None, changes: Sequence[str] | None, itself: Vehicle) -> Vehicle:
    """Give what the controllers are told of the vehicle.

    Parameters
    ----------
    text : str or None
        As `named_vehicle` takes it; None for the plant's own.
    changes : sequence of str or None
        What is told otherwise, ``NAME=VALUE`` each.
    itself : Vehicle
        What the plant is.

    Returns
    -------
    Vehicle
        What they are told.

    Raises
    ------
    ConfigError
        As `named_vehicle`, or a name is not known, or a value is not of its kind or out of its
        range.

    Examples
    --------
    >>> believed(None, ["dead_time=0.1", "max_steer_rate=0.4"], Vehicle()).max_steer_rate
    0.4
    """
    vehicle = itself if text is None else named_vehicle(text)
    return assigned(vehicle, changes or [], "the vehicle")


def _is_file(text: str) -> bool:
    return text.lower().endswith(".toml")
