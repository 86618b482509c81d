"""What the commands are given, as the library takes it."""

from __future__ import annotations

import os
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, get_args

from popsteer import controllers as own_controllers
from popsteer import plants, sim, tracks, vehicles
from popsteer._core import AdaptParams, Path, Vehicle
from popsteer.cli.assignments import assigned, assigned_each
from popsteer.errors import ConfigError
from popsteer.lab import baselines
from popsteer.lab.common.names import controller_names
from popsteer.lab.compare import parameters
from popsteer.params_file import load_all
from popsteer.sim import CarlaIdentified, KinematicBicycle, default_start
from popsteer.sim.geometry import StartAt, made

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from popsteer.plants.protocol import PythonPlant
    from popsteer.sim.closed_loop import Pose

__all__ = [
    "DEFAULT_TRACK",
    "OWN_CONTROLLERS",
    "PLANTS",
    "Course",
    "Start",
    "Tuning",
    "believed",
    "changed_plant",
    "course",
    "courses",
    "named_vehicle",
    "names",
    "plant",
    "plant_label",
    "start",
    "tuned",
]

PLANTS: dict[str, type[CarlaIdentified | KinematicBicycle]] = {
    "carla-identified": CarlaIdentified,
    "kinematic-bicycle": KinematicBicycle,
}
"""The plants of the core by name."""
OWN_CONTROLLERS = own_controllers.names()
"""The controllers of popsteer; the baselines are from elsewhere."""
DEFAULT_TRACK = "racetrack"
"""The track that is driven by default."""


_CLOSED = "given with --waypoints; a shipped track is open or closed by itself"


class Course(NamedTuple):
    """A path, and what to call it."""

    path: Path
    name: str


class Start(NamedTuple):
    """A pose at the start, and whose it is."""

    pose: Pose | None
    at: StartAt


class Tuning(NamedTuple):
    """What the controllers of a run are tuned by."""

    params: dict[str, Any]
    """Parameters by name of the controller, in the order given."""
    adapt: AdaptParams | Literal["auto"] | None
    """How they adapt; None: not at all."""
    preset: str
    """Where the tuning comes from, for captions."""


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
        raise ConfigError("--closed", closed, _CLOSED)
    shipped = tracks.get(DEFAULT_TRACK if track is None else track)
    return Course(Path(shipped.xy, speed=shipped.speed, closed=shipped.closed), shipped.name)


def courses(
    waypoints: Sequence[FilePath] | None, tracks: str | None, *, closed: bool
) -> list[Course]:
    """Give the paths that the options of a command of many ask for.

    Parameters
    ----------
    waypoints : sequence of pathlib.Path or None
        Files of waypoints.
    tracks : str or None
        Names of shipped tracks; `DEFAULT_TRACK` where neither is given.
    closed : bool
        Whether the last waypoint of each file joins its first.

    Returns
    -------
    list of Course
        The shipped tracks, then the files.

    Raises
    ------
    ConfigError
        As `course`.
    PathError
        A file makes no path.

    Examples
    --------
    >>> [each.name for each in courses(None, "circle,slalom", closed=False)]
    ['circle', 'slalom']
    """
    if closed and not waypoints:
        raise ConfigError("--closed", closed, _CLOSED)
    shipped = [] if tracks is None else names("--tracks", tracks)
    if not waypoints and not shipped:
        shipped = [DEFAULT_TRACK]
    found = [course(None, name, closed=False) for name in shipped]
    return found + [course(file, None, closed=closed) for file in waypoints or []]


def names(option: str, text: str) -> list[str]:
    """Split a list of names at its commas.

    Parameters
    ----------
    option : str
        The option that holds the list, for messages.
    text : str
        The list. Empty names are left out.

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
    >>> names("--controllers", "pid, pop,,pid")
    ['pid', 'pop']
    """
    found = list(dict.fromkeys(name for name in map(str.strip, text.split(",")) if name))
    if not found:
        raise ConfigError(option, text, "names, separated by commas")
    return found


def tuned(
    controllers: Sequence[str],
    preset: str,
    assignments: Sequence[str] | None,
    *,
    no_adapt: bool,
    params: FilePath | None = None,
    known: Sequence[str] | None = None,
    given: Callable[[str], Any] | None = None,
) -> Tuning:
    """Give what the controllers are tuned by, as the options ask for it.

    Parameters
    ----------
    controllers : sequence of str
        Names of the controllers.
    preset : str
        Name of a preset.
    assignments : sequence of str or None
        ``NAME=VALUE`` each: for every controller that has the parameter, and for how they adapt.
    no_adapt : bool
        Whether they estimate nothing.
    params : pathlib.Path, optional
        A file of tuning, which takes the place of the preset for the controllers that it has.
    known : sequence of str, optional
        The controllers that the command can take; all by default.
    given : callable, optional
        Gives the parameters of a controller by its name, where they are not the preset's.

    Returns
    -------
    Tuning
        Parameters, how they adapt, and what the tuning is called.

    Raises
    ------
    ConfigError
        A controller, the preset or a parameter is not known, or a value is refused; or the file
        has a controller that is not among them.

    Examples
    --------
    >>> tuning = tuned(["pid", "pop"], "default", ["min_lookahead=3"], no_adapt=False)
    >>> tuning.params["pop"].min_lookahead, tuning.adapt, tuning.preset
    (3.0, 'auto', 'default with changes')
    """
    known = controller_names() if known is None else known
    for name in controllers:
        if name not in known:
            raise ConfigError.unknown("controller", name, known)
    if given is None:
        begun: dict[str, Any] = parameters(controllers, preset)
    else:
        begun = {name: given(name) for name in controllers}
    if params is not None:
        found = load_all(params)
        for name in found:
            if name not in begun:
                driven = ", ".join(begun)
                raise ConfigError("--params", f"{params} with {name}", f"a file of {driven} alone")
        begun |= found
        preset = params.name
    usual = AdaptParams()
    # The baselines do not adapt, so alone they have no such parameters.
    adapting = [] if set(controllers) <= set(baselines.names()) else [usual]
    owner = " or ".join(controllers)
    changed = assigned_each([*begun.values(), *adapting], assignments or [], owner)
    adapt: AdaptParams | Literal["auto"] | None = "auto"
    if no_adapt:
        adapt = None
    elif adapting and changed[-1] is not usual:
        adapt = changed[-1]
    said = f"{preset} with changes" if assignments else preset
    return Tuning(dict(zip(begun, changed, strict=False)), adapt, said)


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


def plant(
    text: str, assignments: Sequence[str] | None = None
) -> CarlaIdentified | KinematicBicycle | PythonPlant:
    """Give the plant that an option names.

    Parameters
    ----------
    text : str
        The name of a plant, or a file ``*.toml`` of a vehicle: a kinematic bicycle is made of it.
    assignments : sequence of str, optional
        ``NAME=VALUE`` each: parameters of the plant and fields of its vehicle.

    Returns
    -------
    CarlaIdentified or KinematicBicycle or PythonPlant
        What moves.

    Raises
    ------
    ConfigError
        No plant has this name, the file holds no vehicle, or a parameter is refused.
    PopsteerError
        The plant needs an extra that is not installed.

    Examples
    --------
    >>> plant("carla-identified").vehicle.rear_axle
    -1.94
    >>> plant("kinematic-bicycle", ["wheelbase=2.5"]).vehicle.wheelbase
    2.5
    """
    if _is_file(text):
        found: str | CarlaIdentified | KinematicBicycle | PythonPlant
        found = KinematicBicycle(Vehicle.load(text))
    else:
        found = made(text)  # refuses an unknown one
    whole = PLANTS[text]() if isinstance(found, str) else found
    return changed_plant(whole, plant_label(text), assignments)


def changed_plant(
    plant: CarlaIdentified | KinematicBicycle | PythonPlant,
    name: str,
    assignments: Sequence[str] | None,
) -> CarlaIdentified | KinematicBicycle | PythonPlant:
    """Change a plant as assignments say.

    Parameters
    ----------
    plant : CarlaIdentified or KinematicBicycle or PythonPlant
        What is to be changed; it stays as it is.
    name : str
        What it is called, for messages.
    assignments : sequence of str or None
        ``NAME=VALUE`` each: parameters of the plant and fields of its vehicle.

    Returns
    -------
    CarlaIdentified or KinematicBicycle or PythonPlant
        A changed copy.

    Raises
    ------
    ConfigError
        A name is not known, or a value is refused.

    Examples
    --------
    >>> changed_plant(KinematicBicycle(), "mine", ["steer_lag=0.3"]).vehicle.steer_lag
    0.3
    """
    if not assignments:
        return plant
    if isinstance(plant, CarlaIdentified | KinematicBicycle):
        changed, vehicle = assigned_each([plant, plant.vehicle], assignments, name)
        return changed.replace(vehicle=vehicle)  # type: ignore[no-any-return]
    configurable: Any = plant
    params = assigned(configurable.params, assignments, name)
    return configurable.with_params(params)  # type: ignore[no-any-return]


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
    """Give what the controllers know of the vehicle.

    Parameters
    ----------
    text : str or None
        As `named_vehicle` takes it; None for the plant's own.
    changes : sequence of str or None
        What is changed, ``NAME=VALUE`` each.
    itself : Vehicle
        What the plant is.

    Returns
    -------
    Vehicle
        What they are given.

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
