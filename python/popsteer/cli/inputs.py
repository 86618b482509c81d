"""The paths, starts, tuning and pedals that options ask for, as the library takes them."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path as FilePath
from typing import Any, Literal, NamedTuple, TypeAlias, cast, get_args

from popsteer import controllers as own_controllers
from popsteer import logs, own, plants, sim, toml_file, tracks, vehicle_file, vehicles
from popsteer._core import AdaptParams, MonitorParams, Path, Vehicle
from popsteer.cli.assignments import assigned, assigned_each, pairs
from popsteer.cli.outputs import Progress
from popsteer.errors import ConfigError, PopsteerError, printable
from popsteer.files import alike
from popsteer.lab.common.longitudinal import LongitudinalParams, name_of, params_of
from popsteer.lab.common.longitudinal import usual as usual_pedals
from popsteer.lab.common.names import controller_names
from popsteer.lab.common.varied import Distribution, distribution, usual, varying
from popsteer.lab.compare import parameters
from popsteer.lab.compare.runs import tunings
from popsteer.params_file import load_all
from popsteer.plants.protocol import PythonPlant
from popsteer.ranges import check_known
from popsteer.sim import CarlaIdentified, KinematicBicycle, Plant
from popsteer.sim.geometry import CORE_PLANTS, Pose, StartAt, object_of

Mover: TypeAlias = CarlaIdentified | KinematicBicycle | PythonPlant
OWN_CONTROLLERS = own_controllers.names()
"""The controllers of popsteer; the baselines are from elsewhere."""
DEFAULT_TRACK = "racetrack"
"""The track that is driven by default."""
DEFAULT_CONTROLLER = "preview-pop"
"""The controller by default."""
# What no vehicle has that this is for: of a number beyond that the unit is another, as a rule.
_PLAUSIBLE = {
    "wheelbase": (0.05, 20.0, "m"),
    "rear_axle": (-20.0, 20.0, "m"),
    "max_steer_rate": (0.01, 20.0, "rad/s"),
    **dict.fromkeys(("steer_lag", "dead_time"), (0.0, 3.0, "s")),
    "drive_delay": (0.0, 5.0, "s"),
    "max_lateral_acceleration": (0.1, 60.0, "m/s²"),
    **dict.fromkeys(("max_acceleration", "max_deceleration"), (0.05, 60.0, "m/s²")),
    "max_speed": (0.05, 150.0, "m/s"),
}
_OF_FILE = "given with --waypoints"
_CLOSED = "given with --waypoints; a shipped track is open or closed by itself"


class Course(NamedTuple):
    """A path, and what to call it."""

    path: Path
    name: str


class Tuning(NamedTuple):
    """What the controllers of a run are tuned by."""

    params: dict[str, Any]
    """Parameters by name of the controller, in the order given."""
    adapt: AdaptParams | Literal["auto"] | None
    """How they adapt; None: not at all."""
    monitor: MonitorParams | Literal["auto"]
    """How they watch for faults."""
    preset: str
    called: dict[str, str]
    """What the tuning of each is called."""


def course(
    waypoints: FilePath | None,
    track: str | None,
    *,
    closed: bool,
    columns: str | None = None,
    origin: str | None = None,
) -> Course:
    """Give the path of a file of waypoints or of a track; ConfigError where both are given."""
    if waypoints is not None:
        if track is not None:
            raise ConfigError("--track", track, "left out where --waypoints is given")
        path = Path.from_csv(waypoints, closed=closed, columns=columns, origin=place(origin))
        return Course(path, printable(waypoints.name))
    _check_of_file(closed=closed, columns=columns, origin=origin)
    if track is not None and own.is_reference(track):
        return Course(_own_path(track), own.title(track))
    shipped = tracks.get(DEFAULT_TRACK if track is None else track)
    return Course(_of_track(shipped), shipped.name)


def place(origin: str | None) -> tuple[float, float] | None:
    """Give the latitude and longitude of ``--origin``; ConfigError where it is not two numbers."""
    if origin is None:
        return None
    try:
        latitude, longitude = (float(part) for part in origin.split(","))
    except ValueError:
        latitude = longitude = math.nan
    if not (abs(latitude) <= 90.0 and abs(longitude) <= 180.0):
        raise ConfigError("--origin", origin, "LAT,LON in degrees")
    return latitude, longitude


def log(
    files: list[FilePath],
    columns: str | None,
    topics: list[str] | None,
    units: list[str] | None,
    origin: str | None,
    progress: Progress,
) -> logs.Log:
    """Read the log that the options name; LogError where it cannot be."""
    return logs.read(
        files,
        columns=columns,
        topics=dict(pairs("--topic", topics, whole=True)),
        units=dict(pairs("--unit", units, whole=True)),
        origin=place(origin),
        progress=partial(progress.update, "read"),
    )


def _check_of_file(**given: object) -> None:
    """Refuse options that are about a file of waypoints where there is none."""
    for name, value in given.items():
        if value:
            raise ConfigError(f"--{name}", value, _CLOSED if name == "closed" else _OF_FILE)


def _of_track(track: tracks.Track) -> Path:
    return Path(track.xy, speed=track.speed, closed=track.closed)


def _own_path(name: str) -> Path:
    """Give the path that a function of your own makes, or that stands there: of (x, y) rows too."""
    made = own.load("track", name)
    try:
        found = made() if callable(made) else made
    except Exception as error:
        raise own.OwnCodeError(name, error) from error
    if isinstance(found, tracks.Track):
        return _of_track(found)
    try:
        return found if isinstance(found, Path) else Path(found)
    except PopsteerError as error:
        raise PopsteerError(f"{name}: {error}") from None


def courses(
    waypoints: Sequence[FilePath] | None,
    tracks: str | None,
    *,
    closed: bool,
    columns: str | None,
    origin: str | None,
) -> list[Course]:
    """Give the paths of the tracks that are named, then those of files of waypoints."""
    if not waypoints:
        _check_of_file(closed=closed, columns=columns, origin=origin)
    shipped = [] if tracks is None else names("--tracks", tracks)
    if not waypoints and not shipped:
        shipped = [DEFAULT_TRACK]
    how: Any = {"closed": closed, "columns": columns, "origin": origin}
    found = [course(None, name, closed=False) for name in shipped]
    found += [course(file, None, **how) for file in waypoints or []]
    for place, each in enumerate(found):
        if each.name in (other.name for other in found[:place]):
            raise ConfigError("--waypoints", each.name, "files and tracks of different names")
    return found


def names(option: str, text: str) -> list[str]:
    """Split a list of names at its commas: each once, in the order given; ConfigError if none."""
    found = list(dict.fromkeys(name for name in map(str.strip, text.split(",")) if name))
    if not found:
        raise ConfigError(option, text, "names, separated by commas")
    return found


def tuned(
    controllers: Sequence[str],
    preset: str,
    assignments: Sequence[str] | None,
    *,
    no_adapt: bool = False,
    params: FilePath | None = None,
    known: Sequence[str] | None = None,
    own_too: bool = True,
    in_loop: bool = True,
) -> Tuning:
    """Give what the controllers are tuned by.

    A file of tuning, `params`, takes the place of the preset for the controllers that it has; the
    assignments count for every controller that has the parameter, for how they adapt and for how
    they watch for faults; the last two not where no loop is closed, `in_loop`. `known` are the
    controllers that the command takes, all by default, beside those of your own, `own_too`.
    """
    for name in controllers:
        if not (own_too and own.is_named("controller", name)):
            check_known("controller", name, controller_names() if known is None else known)
    begun: dict[str, Any] = parameters(controllers, preset)
    called = dict(tunings(controllers, preset))
    if params is not None:
        found = load_all(params, controllers)
        for name in found:
            if name not in begun:
                driven = ", ".join(begun)
                raise ConfigError("--params", f"{params} with {name}", f"a file of {driven} alone")
        begun |= found
        preset = params.name
        called |= dict.fromkeys(found, preset)
    owner = " or ".join(controllers)
    usual: dict[str, Any] = {}
    # The baselines neither adapt nor watch, so alone they have no such parameters.
    if in_loop and set(controllers) & set(OWN_CONTROLLERS):
        usual = {"adapt": AdaptParams(), "monitor": MonitorParams()}
    if no_adapt and usual:
        del usual["adapt"]
        owner += " with --no-adapt"
    changed = assigned_each([*begun.values(), *usual.values()], assignments, owner)
    made = dict(zip(begun, changed, strict=False))
    others = dict(zip(usual, changed[len(begun) :], strict=True))
    loop: dict[str, Any] = {k: "auto" if v is usual[k] else v for k, v in others.items()}
    called = {k: v if made[k] is begun[k] else f"{v} with changes" for k, v in called.items()}
    said = f"{preset} with changes" if assignments else preset
    adapt = None if no_adapt else loop.get("adapt", "auto")
    return Tuning(made, adapt, loop.get("monitor", "auto"), said, called)


def start(
    text: str | None, at: str, offset: float | None, courses: Sequence[Course]
) -> tuple[Pose | None, StartAt]:
    """Give the pose at the start, and whose it is; the pose is None where no option gives it.

    `text` is ``X,Y,YAW`` [m, m, rad], for one path; `at` "pose", "rear" or "front".
    """
    check_known("--start-at", at, get_args(StartAt))
    place = cast("StartAt", at)
    if text is None:
        if place != "pose":
            raise ConfigError("--start-at", at, "given with --start")
        return None, place
    if offset is not None:
        raise ConfigError("--start-offset", offset, "left out where --start is given")
    if len(courses) > 1:
        raise ConfigError("--start", text, "given with one track")
    try:
        x, y, yaw = (float(part) for part in text.split(","))
    except ValueError:
        raise ConfigError("--start", text, "three numbers X,Y,YAW [m, m, rad]") from None
    return (x, y, yaw), place


def longitudinal(
    name: str | None,
    assignments: Sequence[str] | None,
    constant_speed: float | None,
    plants: Iterable[Plant],
) -> LongitudinalParams | None:
    """Give the parameters of the controller of the pedals; None where a constant speed is kept.

    Where no option names one, it is what `popsteer.lab.common.longitudinal.usual` gives.
    """
    if constant_speed is not None:
        if name or assignments:
            raise ConfigError("--constant-speed", constant_speed, "given without --longitudinal")
        return None
    if name is not None:
        return assigned(params_of(name), assignments, name)
    found = usual_pedals(plants)
    return assigned(found, assignments, name_of(found))


def plant(text: str, assignments: Sequence[str] | None = None) -> Mover:
    """Give the plant that an option names; of a file ``*.toml`` it is a kinematic bicycle."""
    if not _is_file(text):
        if text not in CORE_PLANTS and not plants.is_known(text) and ":" not in text:
            raise _unknown("plant", text, (*CORE_PLANTS, *plants.names()))
        return _changed(object_of(text), text, assignments)
    found = _changed(KinematicBicycle(Vehicle.load(text)), plant_label(text), assignments)
    _doubt(found.vehicle)
    return found


def movers(text: str, assignments: Sequence[str] | None = None) -> dict[str, Mover]:
    """Give the plants that an option names by what tables call them, each changed alike."""
    given = names("--plants", text)
    labels = list(map(plant_label, given))
    called = given if len(set(labels)) < len(labels) else labels
    return {name: plant(each, assignments) for name, each in zip(called, given, strict=True)}


def _changed(plant: Mover, name: str, assignments: Sequence[str] | None) -> Mover:
    """Give a copy of a plant, changed as assignments say; messages call it `name`."""
    if not assignments:
        return plant
    if isinstance(plant, CarlaIdentified | KinematicBicycle):
        changed, vehicle = assigned_each([plant, plant.vehicle], assignments, name)
        _doubt(vehicle)
        return changed.replace(vehicle=vehicle)  # type: ignore[no-any-return]
    configurable: Any = plant
    params = assigned(configurable.params, assignments, name)
    return configurable.with_params(params)  # type: ignore[no-any-return]


def plant_label(text: str) -> str:
    """Say what tables call a plant: its name, or that of its file."""
    return printable(FilePath(text).name) if _is_file(text) else text


def named_vehicle(text: str) -> Vehicle:
    """Give the vehicle of a file ``*.toml``, one of `popsteer.vehicles.names`, or a plant's."""
    if _is_file(text):
        return Vehicle.load(text)
    if text in vehicles.names():
        return vehicles.get(text)
    if plants.is_known(text):
        return sim.vehicle_of(text)
    raise _unknown("vehicle", text, (*vehicles.names(), *plants.names()))


def _unknown(what: str, text: str, names: Iterable[str]) -> ConfigError:
    """Make the error for a name of no file either; one that it may mean is among the known."""
    meant = alike(text, ".toml")
    return ConfigError.unknown(what, text, (*names, *filter(None, [meant]), "a file *.toml"))


def believed(
    text: str | None, changes: Sequence[str] | None, itself: Vehicle | None = None
) -> Vehicle:
    """Give the vehicle that the controllers are given: by default that of the plant, `itself`."""
    found = itself or Vehicle() if text is None else named_vehicle(text)
    found = assigned(found, changes, "the vehicle")
    if text is not None or changes:
        _doubt(found)
    return found


def _doubt(vehicle: Vehicle) -> None:
    """Warn on stderr of a vehicle's numbers that are allowed, and hardly in the unit meant."""
    for name, (low, high, unit) in _PLAUSIBLE.items():
        value = getattr(vehicle, name)
        if value is not None and not low <= value <= high:
            said = f"{name} = {value:g} {unit} is beyond what vehicles have, {low:g} to {high:g}"
            print(f"popsteer: warning: {said}: is it in {unit}?", file=sys.stderr)


def told(text: str | None, changes: Sequence[str] | None) -> set[str]:
    """Name the fields of a vehicle that are told, in a file or one by one."""
    there = toml_file.read(text, "vehicle file") if text is not None and _is_file(text) else {}
    names = {*there, *(name for name, _ in pairs("--set-vehicle", changes))}
    return names & Vehicle().as_dict().keys()


def defaults_note(
    text: str | None,
    changes: Sequence[str] | None,
    drives: Iterable[tuple[Any, Any, Any]],
    *,
    stops: bool,
) -> list[str]:
    """Say what a vehicle file leaves at its default and drives hang on: times, speeds, angles."""
    if text is None or not _is_file(text):
        return []
    import numpy as np

    speed = turning = 0.0
    for t, speeds, steer in drives:
        if len(t) > 1:
            speed = max(speed, float(np.max(np.abs(speeds))))
            rates = np.abs(np.diff(steer)) / np.maximum(np.diff(t), 1e-3)
            turning = max(turning, float(np.quantile(rates, 0.98)))
    left = vehicle_file.defaults(text, speed, turning, stops=stops)
    car = Vehicle().as_dict()
    values = {name: "none" if car[name] is None else f"{car[name]:g}" for name in left}
    left = [name for name in left if name not in told(text, changes)]
    said = ", ".join(f"{name} = {values[name]}" for name in left)
    return [f"this drive depends on defaults that {text} does not set: {said}"] if left else []


def varied(
    plant_text: str | None,
    set_plant: Sequence[str] | None,
    vehicle: str | None,
    set_vehicle: Sequence[str] | None,
) -> tuple[Any, Vehicle, str]:
    """Give a plant before it varies, the vehicle that the controller is given, and a label.

    Without a plant it is a kinematic bicycle of the vehicle, and without both the identified one.
    """
    if plant_text is None and vehicle is not None:
        label = plant_label(vehicle)
        made = _changed(KinematicBicycle(named_vehicle(vehicle)), label, set_plant)
    else:
        named = "carla-identified" if plant_text is None else plant_text
        made, label = plant(named, set_plant), plant_label(named)
    return made, believed(vehicle, set_vehicle, sim.vehicle_of(made)), label


def _is_file(text: str) -> bool:
    return text.lower().endswith(".toml")


def tuning(
    controller: str | None,
    params: FilePath | None,
    preset: str,
    assignments: Sequence[str] | None,
    *,
    no_adapt: bool,
) -> tuple[str, Tuning]:
    """Give the name of the controller, by default the one that the file is of, and its tuning."""
    if controller is None:
        controller = DEFAULT_CONTROLLER if params is None else next(iter(load_all(params)))
    return controller, tuned([controller], preset, assignments, no_adapt=no_adapt, params=params)


def distributions(
    vary: Sequence[str] | None, file: FilePath | None, plant: Plant
) -> dict[str, Distribution]:
    """Give what varies, by name: that of a file, or else what usually does, changed by `vary`.

    ``NAME=none`` takes one out; anything else leaves what usually varies with the plant out.
    """
    texts: dict[str, Any] = {}
    if file is not None:
        texts = toml_file.read(file, "--distributions")
        try:
            for name, text in texts.items():
                check_known("quantity that varies", name, varying(plant))
                distribution(name, text)
        except ConfigError as error:
            raise toml_file.in_file(file, error) from None
    elif not vary or all(each.partition("=")[2].strip() == "none" for each in vary):
        texts = dict(usual(sim.vehicle_of(plant), plant))
    for name, text in pairs("--vary", vary, "NAME=DISTRIBUTION"):
        if text == "none":
            texts.pop(name, None)
        else:
            texts[name] = text
    return {name: distribution(name, text) for name, text in texts.items()}
