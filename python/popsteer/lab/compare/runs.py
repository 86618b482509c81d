"""Several controllers on one plant and one path, or on each of several."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from popsteer import controllers, presets, sim
from popsteer._core import Path, Settings, Vehicle
from popsteer.controllers import Params
from popsteer.errors import ConfigError
from popsteer.lab.common.experiment import Adapt, Experiment, Monitor, controller
from popsteer.lab.common.longitudinal import LongitudinalParams, beginning, made, usual
from popsteer.lab.common.names import law_of
from popsteer.lab.compare.comparison import Comparison, nothing, time_steps
from popsteer.parameters import Parameters
from popsteer.sim import Plant, Run, plant_name, vehicle_of
from popsteer.sim.geometry import Pose, StartAt, object_of
from popsteer.sim.pedals import Longitudinal

DEFAULT_CONTROLLERS = ("pid", "pure-pursuit", "stanley", "pop")
"""The controllers of the paper, in the order of its table."""


def parameters(
    names: Sequence[str], preset: str | Mapping[str, str]
) -> dict[str, Params | Parameters]:
    """Give the tuning of several controllers from a preset.

    Parameters
    ----------
    names : sequence of str
        Names of controllers or baselines; those have no presets.
    preset : str
        Name of a preset.

    Returns
    -------
    dict
        Parameters by name of the controller, in the order given.

    Raises
    ------
    ConfigError
        A controller or the preset is not known, or a preset is given to baselines alone.

    Examples
    --------
    >>> parameters(["pid"], "published-code")["pid"].kp
    0.12
    """
    if not isinstance(preset, str):
        raise ConfigError("preset", preset, "the name of one where no parameters are given")
    known = controllers.names()
    chosen = {
        name: presets.get(name, preset) if name in known else law_of(name).params()
        for name in names
    }
    if preset != "default" and names and not set(names) & set(known):
        requirement = f"left out, as it changes nothing about {', '.join(names)}"
        raise ConfigError("preset", preset, requirement)
    return chosen


def run(  # noqa: PLR0913 - as `popsteer.sim.run`
    path: Path,
    names: Sequence[str] | Mapping[str, Params | Parameters] = DEFAULT_CONTROLLERS,
    plant: Plant = "carla-identified",
    *,
    vehicle: Vehicle | None = None,
    adapt: Adapt = "auto",
    monitor: Monitor = "auto",
    preset: str | Mapping[str, str] = "default",
    start: Pose | None = None,
    start_at: StartAt = "pose",
    speed: float | None = None,
    constant_speed: float | None = None,
    longitudinal: Longitudinal | None = None,
    settings: Settings | None = None,
    progress: Callable[[str, float], object] | None = None,
) -> Comparison:
    """Let several controllers drive the same plant along the same path, one after the other.

    Parameters
    ----------
    path : Path
        What they follow.
    names : sequence of str, or mapping of str to parameters
        The controllers, of `popsteer.lab.common.names.controller_names` or of your own as
        `popsteer.own` has them; by default the paper's four. What one of your own raises ends its
        run alone; `Run.traceback` has it. A mapping gives each its tuning, and `preset` then only
        says what that is called.
    plant : str or CarlaIdentified or KinematicBicycle or PythonPlant, default "carla-identified"
        What moves.
    vehicle : Vehicle, optional
        The vehicle that the controllers are given; the plant's own by default.
    adapt, monitor : AdaptParams or None, MonitorParams or None, optional
        How the controllers of popsteer adapt, and how they watch for faults; None: not at all. Left
        out: as each does by default.
    preset : str or mapping of str to str, default "default"
        Where the tuning comes from; see `popsteer.presets`. A mapping says what each controller's
        is called.
    start : tuple of float, optional
        Pose at the start, (x, y, yaw) [m, m, rad]; by default the front axle is at the first
        waypoint.
    start_at : {"pose", "rear", "front"}, default "pose"
        Whose pose `start` is: the vehicle's point's, or that of an axle.
    speed, constant_speed : float, optional
        Speed at the start, and speed to be kept throughout [m/s]; as `popsteer.sim.run` has them.
    longitudinal : CoupledLongitudinal or SpeedPid or SpeedTracker, optional
        What works the pedals; by default what `popsteer.lab.common.longitudinal.usual` gives.
    settings : Settings, optional
        Control period, limits and the like.
    progress : callable, optional
        Called now and then with the name of the controller and the share of its path done, 0 to 1.

    Returns
    -------
    Comparison
        The runs.

    Raises
    ------
    ConfigError
        A controller, the preset or the plant is not known, or `vehicle` puts the pose's point
        elsewhere than the plant does; nothing was driven then.
    InputError
        The start is not finite or beyond its bound.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer import tracks
    >>> comparison = run(popsteer.Path(tracks.get("slalom").xy))
    >>> {name: run.metrics.finished for name, run in comparison.runs.items()}
    {'pid': True, 'pure-pursuit': True, 'stanley': True, 'pop': True}
    """
    if start is None:
        start, start_at = sim.default_start(path, vehicle=vehicle_of(plant)), "pose"
    chosen = dict(names) if isinstance(names, Mapping) else parameters(names, preset)
    believed = vehicle_of(plant) if vehicle is None else vehicle
    if longitudinal is None and constant_speed is None:
        longitudinal = made(usual([plant]), path, believed)
    drivers = {
        name: controller(name, path, believed, params, adapt, monitor)
        for name, params in chosen.items()
    }
    progress = progress or nothing
    runs: dict[str, Run] = {}
    for name, driver in drivers.items():
        progress(name, 0.0)
        run = sim.run(
            driver,
            plant,
            path=path,
            start=start,
            start_at=start_at,
            speed=speed,
            constant_speed=constant_speed,
            longitudinal=longitudinal,
            settings=settings,
            progress=partial(progress, name),
            keep_going=True,
        )
        runs[name] = replace(run, law=name, params=run.params or chosen[name].as_dict())
        progress(name, 1.0)
    found = Comparison(
        runs, tunings(runs, preset), plant_name(plant), constant_speed=constant_speed
    )
    how = plant, speed, constant_speed, longitudinal
    return replace(found, begins=beginning(found.first.start, path, *how)) if runs else found


@dataclass(frozen=True, eq=False)
class _Joining(Experiment):
    """What finds out when a plant has joined a path."""

    plant: Any


def run_each(  # noqa: PLR0913 - as `run`
    paths: Mapping[str, Path],
    names: Sequence[str] | Mapping[str, Params | Parameters],
    plants: Sequence[Plant] | Mapping[str, Plant],
    *,
    vehicle: Vehicle | Mapping[str, Vehicle] | None = None,
    start_offset: float | None = None,
    longitudinal: LongitudinalParams | None = None,
    joined: bool = False,
    step_time: bool = False,
    progress: Callable[[str, float], object] | None = None,
    **how: Any,
) -> list[Comparison]:
    """Let several controllers drive each of several plants along each of several paths.

    Parameters
    ----------
    paths : mapping of str to Path
        What they follow, by name.
    names : sequence of str, or mapping of str to parameters
        The controllers, as `run` has them.
    plants : sequence of str or plants, or mapping of str to these
        What moves; a mapping says what each is called.
    vehicle : Vehicle or mapping of str to Vehicle, optional
        The vehicle that the controllers are given, on all plants or by what the plant is called;
        each plant's own by default.
    start_offset : float, optional
        How far to the left of the first waypoint the front axle starts [m]; by default at it, or
        where `start` says.
    longitudinal : parameters, optional
        Those of the controller of the pedals, `popsteer.lab.common.longitudinal.KINDS`; by default
        what `usual` there gives. A `SpeedTracker` plans for the vehicle that the controllers are
        given.
    joined : bool, default False
        Whether errors count as settled when each plant has driven `JOINED` wheelbases of each path,
        in place of the settling time of the settings.
    step_time : bool, default False
        Whether the steps are timed, as `time_steps` does.
    progress : callable, optional
        Called now and then with what is being done and the share of all that is done, 0 to 1.
    **how
        What `run` takes besides.

    Returns
    -------
    list of Comparison
        One for each plant and path.

    Raises
    ------
    ConfigError
        There is no path, controller or plant, or one is not known; nothing was driven then.
    PopsteerError
        A controller or a plant needs an extra that is not installed; nothing was driven then.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> found = run_each({"straight": path}, ["pop"], ["kinematic-bicycle"])
    >>> [(each.plant, each.track, list(each.runs)) for each in found]
    [('kinematic-bicycle', 'straight', ['pop'])]
    """
    for what, given in {"tracks": paths, "controllers": names, "plants": plants}.items():
        if not given:
            raise ConfigError(what, list(given), "at least one")
    if not isinstance(plants, Mapping):
        plants = {plant_name(plant): plant for plant in plants}
    movers = {name: object_of(plant) for name, plant in plants.items()}
    preset = how.get("preset", "default")
    params = dict(names) if isinstance(names, Mapping) else parameters(names, preset)
    believed = {
        name: (vehicle.get(name) if isinstance(vehicle, Mapping) else vehicle) or plant.vehicle
        for name, plant in movers.items()
    }
    if longitudinal is None and how.get("constant_speed") is None:
        longitudinal = usual(movers.values())
    found, tell = [], progress or nothing
    if joined:
        tell("start", 0.0)  # which is driven, too
        keys = ("speed", "constant_speed", "settings")
        alike: dict[str, Any] = {key: how[key] for key in keys if how.get(key) is not None}
        experiments = (
            _Joining(each, longitudinal=longitudinal, **alike) for each in movers.values()
        )
        settings = [each.joining(paths.values()) for each in experiments]
        how["settings"] = max(settings, key=lambda each: each.settling_time)
    cells = [(name, track) for name in movers for track in paths]
    total, done = len(cells) * len(params) * (2 if step_time else 1), 0
    for name, track in cells:
        where = f"{name}, {track}: " if len(cells) > 1 else ""

        def advance(what: str, share: float, where: str = where) -> None:
            nonlocal done
            tell(f"{where}{what}", min((done + share) / total, 1.0))
            done += share >= 1.0

        plant, path = movers[name], paths[track]
        if start_offset is not None:
            how["start"] = sim.default_start(path, start_offset, plant.vehicle)
        how["longitudinal"] = made(longitudinal, path, believed[name])
        comparison = run(path, params, plant, vehicle=believed[name], progress=advance, **how)
        comparison = replace(comparison, track=track, plant=name, joined=joined)
        if step_time:
            watching = {key: how[key] for key in ("adapt", "monitor") if key in how}
            comparison = time_steps(comparison, params, advance, **watching)
        found.append(comparison)
    return found


def tunings(names: Iterable[str], preset: str | Mapping[str, str]) -> Mapping[str, str]:
    """Say what the tuning of each controller is called: those from elsewhere have defaults."""
    if isinstance(preset, Mapping):
        return preset
    return {name: preset if name in controllers.names() else "default" for name in names}
