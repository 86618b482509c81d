"""Several controllers on one plant and one path."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np

from popsteer import controllers, presets, sim
from popsteer._core import AdaptParams, MonitorParams, Path, Settings, Vehicle, build_profile
from popsteer.errors import ConfigError, PopsteerError
from popsteer.lab import baselines
from popsteer.lab.common.experiment import controller
from popsteer.lab.common.longitudinal import beginning, made, usual
from popsteer.lab.common.names import controller_names
from popsteer.lab.common.timing import Drive, Driver, time_calls
from popsteer.sim import Plant, Run, plant_name, vehicle_of
from popsteer.sim.steering import step_of

if TYPE_CHECKING:
    from popsteer.controllers import Params
    from popsteer.lab.baselines import MpcParams
    from popsteer.sim.geometry import Pose, StartAt
    from popsteer.sim.pedals import Longitudinal


DEFAULT_CONTROLLERS = ("pid", "pure-pursuit", "stanley", "pop")
"""The controllers of the paper, in the order of its table."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """Runs of several controllers on one plant and one path.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> comparison = run(path, ["stanley", "pop"])
    >>> comparison.plant, list(comparison.runs)
    ('carla-identified', ['stanley', 'pop'])
    """

    runs: Mapping[str, Run]
    """The runs by name of the controller, in the order to show them; at least one."""
    tuning: Mapping[str, str]
    """Where the tuning of each controller comes from, by its name: a preset, a file, changes."""
    plant: str
    """What the plant is called."""
    track: str = ""
    """What the path is called; ``dataclasses.replace`` gives it a name."""
    begins: str = ""
    """Where the runs start and how fast they drive, in one line."""
    step_times: Mapping[str, float] = field(default_factory=dict)
    """What a step of each controller takes [s], where that was measured: see `time_steps`."""
    latencies: Mapping[str, Sequence[int]] = field(default_factory=dict)
    """What each of the timed steps took, as the clock read it [ns]; by controller."""

    @property
    def first(self) -> Run:
        """Any of the runs, for what they have in common: the first."""
        return next(iter(self.runs.values()))

    @property
    def points(self) -> dict[str, str]:
        """The point at which the errors of each controller are measured, by its name."""
        return {name: _point(run.tracked_point, self.believed) for name, run in self.runs.items()}

    @property
    def vehicle(self) -> Vehicle:
        """What the plant is: the same for all runs."""
        return self.first.plant_vehicle

    @property
    def believed(self) -> Vehicle:
        """What the controllers were given of the vehicle: the same for all."""
        return self.first.vehicle or self.vehicle

    @property
    def path(self) -> Path:
        """What was followed: the same for all runs."""
        return self.first.path

    @property
    def dt(self) -> float:
        """Control period [s]."""
        return self.first.dt


def parameters(
    names: Sequence[str], preset: str | Mapping[str, str]
) -> dict[str, Params | MpcParams]:
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
    if preset != "default" and names and all(map(baselines.is_known, names)):
        requirement = f"left out, as it changes nothing about {', '.join(names)}"
        raise ConfigError("preset", preset, requirement)
    chosen: dict[str, Params | MpcParams] = {}
    for name in names:
        if name in controllers.names():
            chosen[name] = presets.get(name, preset)
        elif baselines.is_known(name):
            chosen[name] = baselines.get(name).params()
        else:
            raise ConfigError.unknown("controller", name, controller_names())
    return chosen


def run(  # noqa: PLR0913 - as `popsteer.sim.run`
    path: Path,
    names: Sequence[str] | Mapping[str, Params | MpcParams] = DEFAULT_CONTROLLERS,
    plant: Plant = "carla-identified",
    *,
    vehicle: Vehicle | None = None,
    adapt: AdaptParams | Literal["auto"] | None = "auto",
    monitor: MonitorParams | Literal["auto"] | None = "auto",
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
    adapt : AdaptParams or None, optional
        How the controllers of popsteer adapt; None: not at all. Left out: as each does by default.
    monitor : MonitorParams or None, optional
        How they watch for faults; None: not at all. Left out: as each does by default.
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
        start, start_at = sim.default_start(path, 0.0, vehicle_of(plant)), "pose"
    chosen = dict(names) if isinstance(names, Mapping) else parameters(names, preset)
    believed = vehicle_of(plant) if vehicle is None else vehicle
    if longitudinal is None and constant_speed is None:
        longitudinal = made(usual([path], [plant]), path, believed)
    drivers = {
        name: controller(name, path, believed, params, adapt, monitor)
        for name, params in chosen.items()
    }
    progress = progress or _nothing
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
    begins = ""
    if runs:
        first = next(iter(runs.values()))
        begins = beginning(first.start, path, plant, speed, constant_speed, longitudinal)
    return Comparison(
        runs=runs,
        tuning=tunings(runs, preset),
        plant=plant_name(plant),
        begins=begins,
    )


def tunings(names: Iterable[str], preset: str | Mapping[str, str]) -> Mapping[str, str]:
    """Say what the tuning of each controller is called: those from elsewhere have defaults."""
    if isinstance(preset, Mapping):
        return preset
    return {name: preset if name in controllers.names() else "default" for name in names}


def _point(at: float | None, vehicle: Vehicle) -> str:
    """Name a point `at` [m] ahead of the pose's, None for the front axle."""
    at = vehicle.front_axle if at is None else at
    no_slip = vehicle.rear_axle if vehicle.no_slip_point is None else vehicle.no_slip_point
    known = ((vehicle.front_axle, "front"), (vehicle.rear_axle, "rear"), (no_slip, "no-slip"))
    return next((name for ahead, name in known if at == ahead), f"{at:.3g} m ahead")


# Of a slow controller as many as take a second or so, of a fast one as many as steady its median.
_CALLS = 1000


def time_steps(
    comparison: Comparison,
    params: Mapping[str, Any],
    progress: Callable[[str, float], object] | None = None,
    *,
    adapt: AdaptParams | Literal["auto"] | None = "auto",
    monitor: MonitorParams | Literal["auto"] | None = "auto",
) -> Comparison:
    """Measure the step of each controller on the states of its own run.

    Each controller, fresh, is shown the recorded states from the start, again and again, and asked
    for the angle alone, as `popsteer.lab.common.timing` does: warm caches, no garbage collection,
    net of the clock where a step is so short that reading it counts.

    Parameters
    ----------
    comparison : Comparison
        The runs, with their records.
    params : mapping
        The tuning by name of the controller, as `popsteer.lab.compare.runs.parameters` gives it.
    progress : callable, optional
        Called with the name of the controller and the share of its timing done, 0 to 1.
    adapt : AdaptParams or None, optional
        How the controllers adapt; None: not at all. Left out: as each does by default.
    monitor : MonitorParams or None, optional
        How they watch for faults; None: not at all. Left out: as each does by default.

    Returns
    -------
    Comparison
        The same with its `step_times`, medians [s], and its `latencies`, all that were read [ns];
        without those of runs that code of your own ended.

    Raises
    ------
    ConfigError
        The runs kept no records.
    PopsteerError
        The extension module is a debug build, whose times would mean nothing.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer.lab import compare
    >>> from popsteer.lab.compare import parameters
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> params = parameters(["pop"], "default")
    >>> timed = time_steps(compare.run(path, params), params)
    >>> timed.step_times["pop"] > 0.0
    True
    """
    if build_profile == "debug":
        raise PopsteerError("step times of a debug build mean nothing: install a release build")
    times: dict[str, float] = {}
    latencies: dict[str, Sequence[int]] = {}
    for name, run in comparison.runs.items():
        if run.traceback:
            continue  # there is no step to time
        make = partial(
            controller, name, run.path, comparison.believed, params[name], adapt, monitor
        )
        advance = partial(progress or _nothing, f"time {name}")
        times[name], latencies[name] = _step_time(comparison, run, make, advance)
    return replace(comparison, step_times=times, latencies=latencies)


def _nothing(*_: object) -> None:
    """Stand for a `progress` that is not given, or a `reset` that one's own controller lacks."""


def _reset_of(made: Any) -> Callable[[], None]:  # noqa: ANN401 - of one's own
    """Give the `reset` of one's own controller, if it can be called as this would call it."""
    reset: Any = getattr(made, "reset", None)
    try:
        inspect.signature(reset).bind()
    except (TypeError, ValueError):
        return _nothing
    return cast("Callable[[], None]", reset)


def _step_time(
    comparison: Comparison,
    run: Run,
    make: Callable[[], Any],
    progress: Callable[[float], object],
) -> tuple[float, Sequence[int]]:
    """Give the median of a run's controller [s], and what each single step took [ns]."""
    records = run.records
    if not len(records["x"]):
        raise ConfigError("keep_records", value=False, requirement="true where steps are timed")
    table = np.column_stack([records[column] for column in ("x", "y", "yaw", "speed")])
    states = [(x, y, yaw, speed) for x, y, yaw, speed in table.tolist()]
    drive = Drive(comparison.plant, run.path, states, comparison.believed)

    def driver() -> Driver:
        made = make()
        if run.law not in controller_names():
            return Driver(step_of(made), _reset_of(made))
        # The controllers of popsteer measure errors in `step` besides; `steer` is the angle alone.
        return Driver(made.steer, made.reset)

    measured = time_calls({run.law: driver}, {run.law: _CALLS}, drive, run.dt, progress)
    percentiles = measured.percentiles[run.law]
    net = percentiles.net_p50
    return 1e-9 * (percentiles.p50 if net is None else net), measured.singles[run.law]
