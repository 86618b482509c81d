"""Laws × plants × tracks: every combination driven once, in one table."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from popsteer import presets
from popsteer.errors import ConfigError
from popsteer.sim import default_start
from popsteer.sim.geometry import made, plant_name
from popsteer.study.compare import compare, parameters
from popsteer.study.step_time import time_steps

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from popsteer._core import Path, Settings
    from popsteer.sim import Plant
    from popsteer.sim.run import Pose
    from popsteer.study.compare import Comparison

__all__ = ["Matrix", "matrix"]


@dataclass(frozen=True, eq=False)
class Matrix:
    """Comparisons of the same laws on several plants and tracks.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> found = matrix({"straight": path}, ["pop"], ["kinematic-bicycle"])
    >>> [(each.plant, each.track, list(each.runs)) for each in found.comparisons]
    [('kinematic-bicycle', 'straight', ['pop'])]
    """

    comparisons: Sequence[Comparison]
    """One for each plant and track, with step times; at least one."""
    constant_speed: float | None
    """Speed kept all the way [m/s]; None where the paper's law worked the pedals."""


def matrix(
    paths: Mapping[str, Path],
    names: Sequence[str],
    plants: Sequence[Plant],
    *,
    preset: str = presets.REPRODUCTION,
    start_offset: float | None = None,
    constant_speed: float | None = None,
    settings: Settings | None = None,
    progress: Callable[[str, float], object] | None = None,
) -> Matrix:
    """Let several laws drive several plants along several paths, and time their steps.

    Parameters
    ----------
    paths : mapping of str to Path
        What they follow, by name.
    names : sequence of str
        The laws, of `popsteer.study.law_names`.
    plants : sequence of str or plants
        What moves.
    preset : str, default "reproduction"
        Where the parameters of the laws come from; preview-pop is the same in all, and the
        baselines have none.
    start_offset : float, optional
        How far to the left of the first waypoint the front axle starts [m], as
        `popsteer.sim.default_start` has it.
    constant_speed : float, optional
        Speed to be kept all the way [m/s], as `popsteer.sim.run` has it.
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
        There is no path, law or plant, or one is not known; nothing was driven then.
    PopsteerError
        A law or a plant needs an extra that is not installed; nothing was driven then.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> found = matrix({"straight": path}, ["stanley", "pop"], ["carla-identified"])
    >>> sorted(found.comparisons[0].step_times)
    ['pop', 'stanley']
    """
    for field, given in (("tracks", paths), ("laws", names), ("plants", plants)):
        if not given:
            raise ConfigError(field, list(given), "at least one")
    vehicles = [made(plant) for plant in plants]
    starts: dict[str, Pose | None] = dict.fromkeys(paths)
    if start_offset is not None:
        starts = {track: default_start(path, start_offset) for track, path in paths.items()}
    prepared = [(vehicle, parameters(names, preset, vehicle)) for vehicle in vehicles]
    total = len(vehicles) * len(paths) * len(names) * 2  # each law drives, then is timed
    done = 0
    comparisons = []
    for vehicle, params in prepared:
        for track, path in paths.items():
            where = f"{plant_name(vehicle)}, {track}"

            def advance(what: str, share: float, where: str = where) -> None:
                nonlocal done
                if progress is not None:
                    progress(f"{where}: {what}", min((done + share) / total, 1.0))
                done += share >= 1.0

            comparison = compare(
                path,
                params,
                vehicle,
                preset=preset,
                start=starts[track],
                constant_speed=constant_speed,
                settings=settings,
                progress=advance,
            )
            comparison = replace(comparison, track=track)
            comparisons.append(time_steps(comparison, params, advance))
    return Matrix(comparisons, constant_speed)
