"""What a sweep is, in one document, and its runs: a row for each, the same whoever drives it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from popsteer import own, sim
from popsteer._core import AdaptParams, MonitorParams, Path, Settings, Vehicle, __version__
from popsteer.controllers import Params
from popsteer.errors import ConfigError, PopsteerError
from popsteer.lab.common import longitudinal
from popsteer.lab.common.document import of_fields, path_of, plant_of
from popsteer.lab.common.experiment import Experiment, Road
from popsteer.lab.common.names import law_of
from popsteer.lab.common.varied import Distribution, Varied, distribution, draws, run_seed, varied
from popsteer.own import What
from popsteer.parameters import Parameters
from popsteer.ranges import check_count, check_in_range
from popsteer.sim import Plant, Run, plant_name

SCHEMA = "popsteer-sweep/3"
"""What a file of a sweep says it is."""
_MAX_RUNS = 10_000_000


@dataclass(frozen=True, eq=False)
class Job(Experiment):
    """A sweep: one controller, one plant and one path, and what varies from run to run.

    Run k is the same wherever and whenever it is driven: its draw is row k of a Latin hypercube of
    all runs, its noise comes from a seed of its own. What it shares with a search, vehicle, pedals
    and settings, are the fields of `popsteer.lab.common.experiment.Experiment`.

    Raises
    ------
    ConfigError
        A number is out of its range, or what varies is not known.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> lag = {"steer_lag": distribution("steer_lag", "uniform(0.05,0.2)")}
    >>> job = Job(path, "pop", popsteer.PopParams(), "kinematic-bicycle", {}, runs=10)
    >>> from_text(job.text).text == job.text
    True
    """

    path: Path
    """What is followed."""
    controller: str
    """Name of the controller; of your own as `popsteer.own` has it."""
    params: Params | Parameters
    """Tuning of the controller."""
    plant: Plant
    """What moves where nothing varies."""
    vary: Mapping[str, Distribution]
    """What varies, of `popsteer.lab.common.varied.varying`."""
    runs: int
    """How many runs."""
    seed: int = 0
    """Where all draws come from."""
    deviation: float = field(default=0.5, kw_only=True)
    """A run succeeds where its cross-track error after settling stays within this [m]."""
    start_offset: float | None = field(default=None, kw_only=True)
    """Start to the left of the path [m], on it by default; left out where the draws have it."""
    course: str = field(default="", kw_only=True)
    """What to call the path."""
    label: str = field(default="", kw_only=True)
    """What to call the plant."""

    def __post_init__(self) -> None:
        check_count("runs", self.runs, 1, _MAX_RUNS)
        check_in_range("deviation", self.deviation, 0.0, 1e3, above=True)
        sim.closed_loop.check_seed(self.seed)
        for option, name in (("start_offset", "start_offset"), ("speed", "start_speed")):
            given = getattr(self, option)
            if given is not None and name in self.vary:
                said = f"left out where {name} is drawn (--vary {name}=none)"
                raise ConfigError(option, given, said)
        middle = {name: each.quantile(0.5) for name, each in self.vary.items()}
        varied(self.whole, self.path, middle, self.start_offset)  # refuses what cannot vary
        _ = self.road  # refuses pedals that do not fit

    @cached_property
    def draws(self) -> dict[str, NDArray[np.float64]]:
        """The values of what varies, by name, one a run."""
        return draws(self.vary, self.runs, self.seed)

    def drawn(self, run: int) -> dict[str, float]:
        """Give the values of one run, by name."""
        return {name: float(column[run]) for name, column in self.draws.items()}

    def seed_of(self, run: int) -> int:
        """Give the seed of the noise of one run, as `popsteer.sim.run` takes it."""
        return run_seed(self.seed, run)

    def made(self, run: int) -> Varied:
        """Make plant, start and noise of one run; ConfigError, which names the run, otherwise."""
        try:
            return varied(self.whole, self.path, self.drawn(run), self.start_offset)
        except ConfigError as error:
            error.args = (f"run {run}: {error}",)
            raise

    @cached_property
    def road(self) -> Road:
        """The path that is driven, and what works the pedals: None for those of the paper."""
        return self.road_of(self.path)

    @cached_property
    def text(self) -> str:
        """The sweep as JSON in one line, with every field: what its files begin with."""
        label = self.label or plant_name(self.whole)
        document = of_fields(self, plant=self.whole, vehicle=self.given, label=label)
        document = {"schema": SCHEMA, "version": __version__, **document}
        return json.dumps(document | self.code, separators=(",", ":"))

    @property
    def key(self) -> str:
        """A short name of exactly this sweep: a hash of `text`."""
        return hashlib.sha256(self.text.encode()).hexdigest()[:16]


def document_of(text: str) -> dict[str, Any]:
    """Read `Job.text` as JSON; PopsteerError where that is none of this version."""
    try:
        document = json.loads(text)
        schema, version = document["schema"], document["version"]
    except (ValueError, KeyError, TypeError, RecursionError):
        raise PopsteerError("no sweep of popsteer") from None
    if schema != SCHEMA or version != __version__:
        raise PopsteerError(
            f"a sweep of popsteer {version} ({schema}); this is {__version__} ({SCHEMA})"
        )
    return cast("dict[str, Any]", document)


def from_text(text: str, named: Collection[str] | None = None) -> Job:
    """Make a sweep of its `Job.text`; PopsteerError where that is none of this version.

    Code of one's own is run only if it is `named`, None: all that the text names, and only as it
    was when the sweep was driven.
    """
    document = document_of(text)
    try:
        code = _checked_code(document, named)
        job = _made(document)
        if code:  # as it was, though where it runs more, or less, may be loaded
            vars(job)["code"] = {"files": code}
        same = job.text == text
    except (PopsteerError, OSError):
        raise
    except Exception as error:  # what is damaged may break anything that is made of it
        raise PopsteerError(f"line 1 is no sweep of popsteer: {error!r}") from error
    if not same:
        raise PopsteerError("line 1 is no sweep of popsteer: it is not as it was written")
    return job


def _checked_code(document: dict[str, Any], named: Collection[str] | None) -> dict[str, Any]:
    """Give the hashes of code of one's own; refuse what is not named, or not as it was."""
    checked = {}
    used: dict[What, str] = {
        "controller": document["controller"],
        "plant": document["plant"]["name"],
    }
    for what, name in used.items():
        if not own.is_named(what, name):
            continue
        if named is not None and own.is_reference(name) and name not in named:
            raise PopsteerError(f"drives code of your own: name it by --{what} {name}")
        if file := own.changed(what, name, document["files"][name]):
            raise PopsteerError(
                f"{name} is not there as it was when the sweep was driven: {file} is another"
            )
        checked[name] = document["files"][name]
    return checked


def _made(document: dict[str, Any]) -> Job:
    for name in ("schema", "version"):
        del document[name]
    document.pop("files", None)
    text = dict.fromkeys(("controller", "course", "label"), str)
    said = {str: "text", int: "a whole number", bool: "true or false"}
    for name, wanted in {**text, "runs": int, "seed": int, "joined": bool}.items():
        if type(document[name]) is not wanted:
            raise ConfigError(name, document[name], said[wanted])
    for name in ("speed", "start_offset", "constant_speed"):
        if isinstance(document[name], str | bool | list | dict):
            raise ConfigError(name, document[name], "a number")
    pedals = document["longitudinal"]
    made = {
        "path": path_of(document["path"]),
        "params": law_of(document["controller"]).params(**document["params"]),
        "plant": plant_of(document["plant"]),
        "vary": {k: distribution(k, v) for k, v in document["vary"].items()},
        "vehicle": Vehicle(**document["vehicle"]),
        **{
            field: of(**document[field])
            for field, of in (("adapt", AdaptParams), ("monitor", MonitorParams))
            if isinstance(document.get(field), dict)
        },
        "longitudinal": pedals and longitudinal.KINDS[pedals["name"]](**pedals["params"]),
        "settings": Settings(**document["settings"]),
    }
    return Job(**(document | made))


# A worker keeps the jobs that it got last: the draws of all runs take time to make.
_last_jobs = lru_cache(maxsize=2)(from_text)


def drive(
    job: Job,
    runs: Sequence[int],
    threads: int | None = None,
    progress: Callable[[float], object] | None = None,
) -> list[dict[str, Any]]:
    """Drive some runs of a sweep, by their numbers.

    Gives a row for each: its number, its seed, whether it succeeded, what was drawn, and every
    figure of `popsteer.sim.Metrics`. `threads` are for what the core alone drives, and `progress`
    is called with the share that is done, as `popsteer.sim.run_many` has both.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> job = Job(path, "pop", popsteer.PopParams(), "kinematic-bicycle", {}, runs=2)
    >>> [row["success"] for row in drive(job, [0, 1])]
    [True, True]
    """
    made = ((job.road, job.made(run), job.seed_of(run)) for run in runs)
    count = len(runs)
    figures = job.drive_each(job.params, made, count, progress, threads=threads, keep_going=True)
    return [_row(job, run, each) for run, each in zip(runs, figures, strict=True)]


def drive_text(text: str, runs: Sequence[int]) -> list[dict[str, Any]]:
    """Drive some runs as `drive`, on one thread of a process that has `Job.text` alone."""
    return drive(_last_jobs(text), runs, threads=1)


def repeat(
    job: Job,
    run: int,
    *,
    keep_records: bool = True,
    progress: Callable[[float], object] | None = None,
) -> Run:
    """Drive one run of a sweep by its number, to the bit what the sweep drove, with its records.

    `keep_records` says whether these are kept; `progress` is as `popsteer.sim.run` has it.
    """
    driven = job.params, job.road, job.made(run), job.seed_of(run)
    how: Any = {"keep_records": keep_records, "progress": progress}
    return job.drive_one(*driven, keep_going=True, **how)


def _row(job: Job, run: int, figures: dict[str, Any]) -> dict[str, Any]:
    figures = dict(figures)
    faults = int(figures.pop("faults"))
    within = figures["settled_max_abs_cross_track_error"] <= job.deviation
    good = bool(figures["finished"] and not faults and within)
    named = {"run": run, "seed": job.seed_of(run), "success": good}
    return {**named, **job.drawn(run), **figures, "faults": faults}
