"""Controllers × plants × tracks: every combination driven once, in one table."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, NamedTuple

from popsteer.errors import ConfigError
from popsteer.lab import compare
from popsteer.lab.common.longitudinal import LongitudinalParams
from popsteer.lab.common.longitudinal import made as pedals_of
from popsteer.lab.compare.runs import Comparison, parameters, time_steps
from popsteer.sim import Metrics, Plant, default_start
from popsteer.sim.geometry import object_of, plant_name

if TYPE_CHECKING:
    from popsteer._core import AdaptParams, MonitorParams, Path, Settings, Vehicle
    from popsteer.controllers import Params
    from popsteer.lab.baselines import MpcParams


@dataclass(frozen=True, eq=False)
class Matrix:
    """Comparisons of the same controllers on several plants and tracks.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> found = run({"straight": path}, ["pop"], ["kinematic-bicycle"])
    >>> [(each.plant, each.track, list(each.runs)) for each in found.comparisons]
    [('kinematic-bicycle', 'straight', ['pop'])]
    """

    comparisons: Sequence[Comparison]
    """One for each plant and track, with step times; at least one."""
    constant_speed: float | None
    """Speed kept throughout [m/s]; None where another controller worked the pedals."""


def run(  # noqa: PLR0913 - as `compare`
    paths: Mapping[str, Path],
    names: Sequence[str] | Mapping[str, Params | MpcParams],
    plants: Sequence[Plant] | Mapping[str, Plant],
    *,
    vehicle: Vehicle | Mapping[str, Vehicle] | None = None,
    adapt: AdaptParams | Literal["auto"] | None = "auto",
    monitor: MonitorParams | Literal["auto"] | None = "auto",
    preset: str | Mapping[str, str] = "default",
    start_offset: float | None = None,
    speed: float | None = None,
    constant_speed: float | None = None,
    longitudinal: LongitudinalParams | None = None,
    settings: Settings | None = None,
    progress: Callable[[str, float], object] | None = None,
) -> Matrix:
    """Let several controllers drive several plants along several paths, and time their steps.

    Parameters
    ----------
    paths : mapping of str to Path
        What they follow, by name.
    names : sequence of str, or mapping of str to parameters
        The controllers, of `popsteer.lab.common.names.controller_names`. A mapping gives each its
        tuning, and `preset` then only says what that is called.
    plants : sequence of str or plants, or mapping of str to these
        What moves; a mapping says what each is called.
    vehicle : Vehicle or mapping of str to Vehicle, optional
        The vehicle that the controllers are given, on all plants or by what the plant is called;
        each plant's own by default.
    adapt : AdaptParams or None, optional
        How the controllers of popsteer adapt; None: not at all. Left out: as each does by default.
    monitor : MonitorParams or None, optional
        How they watch for faults; None: not at all. Left out: as each does by default.
    preset : str or mapping of str to str, default "default"
        Where the tuning comes from, as `popsteer.lab.compare.run` has it.
    start_offset : float, optional
        How far to the left of the first waypoint the front axle starts [m]; by default at it.
    speed, constant_speed : float, optional
        Speed at the start, and speed to be kept throughout [m/s]; as `popsteer.sim.run` has them.
    longitudinal : parameters, optional
        Those of the controller of the pedals, `popsteer.lab.common.longitudinal.KINDS`; by default
        what `usual` there gives. A `SpeedTracker` plans for the vehicle that the controllers are
        given.
    settings : Settings, optional
        Control period, limits and the like.
    progress : callable, optional
        Called now and then with what is being done and the share of all that is done, 0 to 1.

    Returns
    -------
    Matrix
        What was measured.

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
    >>> found = run({"straight": path}, ["stanley", "pop"], ["carla-identified"])
    >>> sorted(found.comparisons[0].step_times)
    ['pop', 'stanley']
    """
    for field, given in (("tracks", paths), ("controllers", names), ("plants", plants)):
        if not given:
            raise ConfigError(field, list(given), "at least one")
    if not isinstance(plants, Mapping):
        plants = {plant_name(plant): plant for plant in plants}
    movers = {name: object_of(plant) for name, plant in plants.items()}
    params = dict(names) if isinstance(names, Mapping) else parameters(names, preset)
    total = len(movers) * len(paths) * len(names) * 2  # each controller drives, then is timed
    done = 0
    comparisons = []
    for name, plant in movers.items():
        for track, path in paths.items():
            where = f"{name}, {track}"

            def advance(what: str, share: float, where: str = where) -> None:
                nonlocal done
                if progress is not None:
                    progress(f"{where}: {what}", min((done + share) / total, 1.0))
                done += share >= 1.0

            itself = plant.vehicle
            start = None if start_offset is None else default_start(path, start_offset, itself)
            believed = vehicle.get(name) if isinstance(vehicle, Mapping) else vehicle
            comparison = compare.run(
                path,
                params,
                plant,
                vehicle=believed,
                adapt=adapt,
                monitor=monitor,
                preset=preset,
                start=start,
                speed=speed,
                constant_speed=constant_speed,
                longitudinal=pedals_of(longitudinal, path, believed or itself),
                settings=settings,
                progress=advance,
            )
            comparison = replace(comparison, track=track, plant=name)
            comparisons.append(
                time_steps(comparison, params, advance, adapt=adapt, monitor=monitor)
            )
    return Matrix(comparisons, constant_speed)


class Row(NamedTuple):
    """One controller on one plant and track."""

    plant: str
    track: str
    law: str
    tuning: str
    point: str
    """Where the errors are measured."""
    metrics: Metrics
    step_time: float
    ending: str


def rows(found: Matrix) -> Iterator[Row]:
    """Give the rows in the order of the comparisons: plant by plant, track by track."""
    for comparison in found.comparisons:
        for name, run in comparison.runs.items():
            time = comparison.step_times.get(name, math.nan)
            yield Row(
                comparison.plant,
                comparison.track,
                name,
                comparison.tuning[name],
                comparison.points[name],
                run.metrics,
                time,
                run.ending,
            )
