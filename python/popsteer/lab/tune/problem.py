"""What is tuned, on what, and how one tuning is judged."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from popsteer import controllers, own
from popsteer._core import Path, Vehicle, __version__
from popsteer.controllers import Params
from popsteer.errors import ConfigError, PopsteerError
from popsteer.lab.common.document import of_fields
from popsteer.lab.common.experiment import Experiment
from popsteer.lab.common.varied import Distribution, distribution, draws, run_seed, varied
from popsteer.ranges import check_count, check_known

SCHEMA = "popsteer-tune/3"
"""What a study says it is."""
_FAILED = 100.0  # m, rad/s: worse than any figure of a run that finished
_MAX_CARS = 1000
_SEARCHED = {
    "pid": ("kp", "ki", "kd"),
    "pure-pursuit": ("lookahead_gain", "min_lookahead"),
    "stanley": ("cross_track_gain", "speed_gain"),
    "pop": ("lookahead_gain", "min_lookahead"),
    "preview-pop": ("horizon", "heading_cost", "steer_rate_cost"),
}


class Score(NamedTuple):
    """What a tuning comes to, over all tracks and cars."""

    errors: Mapping[str, tuple[float, ...]]
    """Mean |cross-track error| after settling of each car by track [m], the unvaried car first."""
    efforts: Mapping[str, tuple[float, ...]]
    """Root of the mean square of the steering rate of each car by track [rad/s]."""

    @property
    def mean(self) -> float:
        """Mean error of all runs [m]."""
        return float(np.mean(list(self.errors.values())))

    @property
    def worst(self) -> float:
        """Greatest error of a run [m]."""
        return float(np.max(list(self.errors.values())))

    @property
    def error(self) -> float:
        """What is minimised: the mean of `mean` and `worst` [m]."""
        return 0.5 * (self.mean + self.worst)

    @property
    def effort(self) -> float:
        """Mean effort of all runs [rad/s]."""
        return float(np.mean(list(self.efforts.values())))

    def effort_ratio(self, usual: Score) -> float:
        """Tell how many times as much the wheels move as with another tuning, `usual`.

        It is the ratio of the mean efforts, or that of the unvaried car on a track if greater.
        """
        nominal = [self.efforts[k][0] / max(usual.efforts[k][0], 1e-9) for k in self.efforts]
        return max(self.effort / max(usual.effort, 1e-9), *nominal)


@dataclass(frozen=True, eq=False)
class Problem(Experiment):
    """A controller, its vehicle, tracks, cars that differ from it, and what is searched.

    What it shares with a sweep, vehicle, pedals and settings, are the fields of
    `popsteer.lab.common.experiment.Experiment`.

    Raises
    ------
    ConfigError
        What is searched or varied is not known, or out of its range.
    """

    paths: Mapping[str, Path]
    """The tracks, by name."""
    controller: str
    """Name of the controller; of your own as `popsteer.own` has it."""
    base: Params
    """The tuning to begin with; what is not searched stays."""
    search: Mapping[str, Distribution]
    """The parameters that are searched, ``uniform`` or ``loguniform`` each."""
    plant: Any
    """What moves."""
    vary: Mapping[str, Distribution]
    """What varies from car to car, of `popsteer.lab.common.varied.varying`."""
    cars: int = 7
    """How many cars that differ, beside the one that does not."""
    seed: int = 0
    """Where the cars come from."""

    def __post_init__(self) -> None:
        if not own.is_named("controller", self.controller):
            check_known("controller", self.controller, controllers.names())
        check_count("cars", self.cars, 0, _MAX_CARS)
        if not self.search:
            raise ConfigError("search", "nothing", "at least one parameter")
        known = self.base.as_dict()
        for name, each in self.search.items():
            check_known(f"parameter of {self.controller}", name, known)
            if each.name not in ("uniform", "loguniform") or isinstance(known[name], bool):
                raise ConfigError(name, str(each), "uniform(LOW,HIGH) or loguniform(LOW,HIGH)")
            for end in each.bounds:
                self.changed({name: end})  # refuses what is out of its range
        _ = self.scenarios

    @cached_property
    def scenarios(self) -> list[tuple[str, Any, Any, int]]:
        """Track, path with pedals, car and seed of each run."""
        drawn = draws(self.vary, self.cars, self.seed) if self.cars else {}
        found = []
        for name, path in self.paths.items():
            road = self.road_of(path)
            for car in range(self.cars + 1):
                values = {k: float(v[car - 1]) for k, v in drawn.items()} if car else {}
                made = varied(self.plant, path, values)
                found.append((name, road, made, run_seed(self.seed, car)))
        return found

    def beginnings(self) -> list[tuple[str, str, str]]:
        """Say where the runs on each track start: the vehicle itself, and cars that differ."""
        found = []
        for name, road, made, _ in self.scenarios[:: self.cars + 1]:
            itself = self.begins(road, made.plant, {})
            others = self.begins(road, made.plant, self.vary if self.cars else {})
            found.append((name, itself, others if others != itself else ""))
        return found

    def changed(self, values: Mapping[str, float]) -> Params:
        """Give the tuning with other values of what is searched; whole numbers stay whole."""
        usual = self.base.as_dict()
        whole = {k: round(v) if isinstance(usual[k], int) else v for k, v in values.items()}
        return self.base.replace(**whole)

    def score(self, params: Params, progress: Callable[[float], object] | None = None) -> Score:
        """Drive all tracks with all cars, and judge a tuning.

        `progress` is called now and then with the share that is done. A run that does not finish
        counts as 100 m off. Raises PopsteerError where one is over before it has settled.
        """
        errors: dict[str, tuple[float, ...]] = dict.fromkeys(self.paths, ())
        efforts = dict(errors)
        runs = [scenario[1:] for scenario in self.scenarios]
        figures = self.drive_each(params, runs, len(runs), progress)
        for (name, *_), found in zip(self.scenarios, figures, strict=True):
            ended, effort = found["finished"], found["rms_steer_rate"]
            error = found["settled_mean_abs_cross_track_error"]
            if ended and not (math.isfinite(error) and math.isfinite(effort)):
                raise PopsteerError(
                    f"{name}: a run is over within the settling time, and nothing can be judged:"
                    " the path is too short, or a lap that is not said to be closed (--closed)"
                )
            errors[name] += (error if ended else _FAILED,)
            efforts[name] += (effort if math.isfinite(effort) else _FAILED,)
        return Score(errors, efforts)

    @cached_property
    def document(self) -> dict[str, Any]:
        """What makes this problem, for the study to say."""
        document = of_fields(self, vehicle=self.given)
        paths = json.dumps(document["paths"], sort_keys=True).encode()
        waypoints = hashlib.sha256(paths).hexdigest()
        document["paths"] = {**dict.fromkeys(self.paths), "waypoints": waypoints}
        return {"schema": SCHEMA, "version": __version__, **document, **self.code}


def usual_search(name: str, base: Params, vehicle: Vehicle) -> dict[str, Distribution]:
    """Give what is searched by default about a controller, of the tuning that it begins with.

    That is a quarter to four times each value, scaled with the vehicle; a gain that may vanish from
    0 on. Of a controller of your own it is the `RANGES` of its parameters.

    Examples
    --------
    >>> import popsteer
    >>> found = usual_search("pop", popsteer.PopParams(), popsteer.Vehicle())
    >>> [f"{name} {each}" for name, each in found.items()]
    ['lookahead_gain uniform(0.0,0.6)', 'min_lookahead loguniform(1.5,24.0)']
    """
    if name not in _SEARCHED:
        ranges: Mapping[str, tuple[float, float]] = getattr(base, "RANGES", {})
        return {
            field: distribution(field, f"{'log' if low > 0.0 else ''}uniform({low!r},{high!r})")
            for field, (low, high) in ranges.items()
        }
    resolved = base.resolved(vehicle).as_dict()
    found = {}
    for field in _SEARCHED[name]:
        value = float(resolved[field])
        text = f"loguniform({value / 4!r},{value * 4!r})"
        if field == "lookahead_gain" or value == 0.0:
            text = f"uniform(0.0,{round(3 * value, 9) or 1.0!r})"
        found[field] = distribution(field, text)
    return found
