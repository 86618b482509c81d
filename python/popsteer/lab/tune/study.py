"""The search for a better tuning by Optuna; it can be stopped, continued and shared."""

from __future__ import annotations

import math
import os
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from json import JSONDecodeError
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from popsteer.controllers import Params
from popsteer.errors import ConfigError, PopsteerError
from popsteer.extras import require
from popsteer.lab.common.document import differing
from popsteer.lab.tune.problem import Problem, Score
from popsteer.ranges import check_count, check_in_range

_NAME = "popsteer-tune"
_STARTUP = 15  # random trials before the model of the others proposes any
_MAX_TRIALS = 1_000_000
_KEPT = ("mean", "worst", "ratio")  # what a study keeps of a trial besides its two objectives


class Trial(NamedTuple):
    """One tuning that was tried."""

    number: int
    values: dict[str, float]
    error: float
    """As `Score.error` [m]."""
    effort: float
    """As `Score.effort` [rad/s]."""
    mean: float
    worst: float
    ratio: float
    """As `Score.effort_ratio` to the tuning that it began with."""


@dataclass(frozen=True, eq=False)
class Tuned:
    """What a search found."""

    problem: Problem
    """What was searched."""
    usual: Score
    """What the tuning that it began with comes to."""
    trials: Sequence[Trial]
    """All that were tried."""
    chosen: Trial | None
    """The one with the least error within the limit of the effort; None where none is better than
    what it began with."""
    effort_limit: float
    """How many times the effort of what it began with is allowed."""

    @property
    def params(self) -> Params:
        """The tuning that was chosen, or what it began with; its ``save`` writes it."""
        chosen = self.chosen
        return self.problem.base if chosen is None else self.problem.changed(chosen.values)

    @property
    def front(self) -> list[Trial]:
        """The trials that no other beats in both error and effort, by rising effort."""
        found: list[Trial] = []
        for trial in sorted(self.trials, key=lambda each: (each.effort, each.error)):
            if not found or trial.error < found[-1].error:
                found.append(trial)
        return found


def places(tried: Sequence[Trial | Score]) -> tuple[list[float], list[float]]:
    """Give efforts and errors: where trials lie in a figure."""
    return [each.effort for each in tried], [each.error for each in tried]


def run(
    problem: Problem,
    storage: str | Path | None = None,
    *,
    trials: int | None = 100,
    seconds: float | None = None,
    effort_limit: float = 1.1,
    progress: Callable[[str, float], object] | None = None,
) -> Tuned:
    """Search for the tuning with the least error within a limit of the steering effort.

    Parameters
    ----------
    problem : Problem
        What is tuned, on what.
    storage : str or pathlib.Path, optional
        Where the trials are kept: a URL that Optuna knows, or a file for its journal. The same
        problem goes on with what is there, and several processes may share it. Left out, they are
        kept nowhere.
    trials : int, optional
        How many trials there are to be in the end, those that are there included.
    seconds : float, optional
        How long this call may search.
    effort_limit : float, default 1.1
        How many times the effort of `problem.base` the chosen tuning may take.
    progress : callable, optional
        Called now and then with what is being done and the share of it that is done.

    Returns
    -------
    Tuned
        What was found.

    Raises
    ------
    ConfigError
        A number is out of its range.
    PopsteerError
        Optuna is not installed, or the storage has another study or none that can be read.
    OSError
        The storage cannot be written.

    Notes
    -----
    A third of the trials, and the first, are those of Optuna's tree-structured Parzen estimator for
    error and effort; the others lie near the best one within the limit of the effort. Y. Ozaki et
    al., *Multiobjective Tree-structured Parzen Estimator*, 2022.
    """
    _check(trials, seconds, effort_limit)
    if trials is None and seconds is None:
        trials = 100
    require("tuning", "lab", "optuna")
    import optuna

    optuna.logging.set_verbosity(optuna.logging.ERROR)
    study = _study(optuna, problem, storage, effort_limit)
    usual = problem.score(problem.base)
    begin = time.monotonic()

    def advance(inside: float = 0.0) -> None:
        if progress is not None:
            done = len(_complete(study))
            shares = [(done + inside) / trials] if trials is not None else []
            if seconds is not None:
                shares.append((time.monotonic() - begin) / seconds)
            progress(f"trial {done + 1}", min(max(shares), 1.0))

    def objective(trial: Any) -> tuple[float, float]:
        values = {
            name: trial.suggest_float(name, *each.bounds, log=each.name == "loguniform")
            for name, each in problem.search.items()
        }
        score = problem.score(problem.changed(values), advance)
        trial.set_user_attr("mean", score.mean)
        trial.set_user_attr("worst", score.worst)
        trial.set_user_attr("ratio", score.effort_ratio(usual))
        return score.error, score.effort

    def stop(study: Any, _: Any) -> None:
        if trials is not None and len(_complete(study)) >= trials:
            study.stop()
        elif values := _near_the_best(problem, _tried(study), effort_limit):
            study.enqueue_trial(values)

    if trials is None or len(_complete(study)) < trials:
        _optimize(study, objective, seconds, stop, storage)
    tried = _tried(study)
    chosen = _best_within([each for each in tried if each.error < usual.error], effort_limit)
    return Tuned(problem, usual, tried, chosen, effort_limit)


def _optimize(
    study: Any, objective: Any, seconds: float | None, stop: Any, storage: str | Path | None
) -> None:
    """Search; Ctrl-C and a full disk stay what they are."""
    try:
        study.optimize(objective, timeout=seconds, callbacks=[stop])
    except Exception as error:
        # Optuna trips over both in its own bookkeeping.
        cause: BaseException | None = error
        while cause is not None:
            if isinstance(cause, KeyboardInterrupt):
                raise cause from None
            if isinstance(cause, OSError):
                where = cause.filename or str(storage)
                raise OSError(cause.errno, cause.strerror, where) from None
            cause = cause.__context__
        raise


def _tried(study: Any) -> list[Trial]:
    return [
        Trial(each.number, dict(each.params), *each.values, *(each.user_attrs[k] for k in _KEPT))
        for each in _complete(study)
    ]


def _best_within(tried: Sequence[Trial], effort_limit: float) -> Trial | None:
    within = (each for each in tried if each.ratio <= effort_limit)
    return min(within, key=lambda each: (each.error, each.number), default=None)


def _near_the_best(
    problem: Problem, tried: Sequence[Trial], effort_limit: float
) -> dict[str, float] | None:
    """In two of three trials give something near the best, where the front meets the limit."""
    best = _best_within(tried, effort_limit)
    if len(tried) < _STARTUP or len(tried) % 3 == 0 or best is None:
        return None
    random = np.random.default_rng([problem.seed, len(tried)])
    # Steps of all sizes, as the distance to better ones is not known.
    step = math.exp(random.uniform(math.log(0.01), math.log(0.5)))
    found = {}
    for name, each in problem.search.items():
        low, high = each.bounds
        value = best.values[name]
        share = (value - low) / (high - low)
        if each.name == "loguniform":
            share = math.log(value / low) / math.log(high / low)
        share = min(max(share + step * random.standard_normal(), 0.0), 1.0)
        found[name] = min(max(each.quantile(share), low), high)
    return found


def _check(trials: int | None, seconds: float | None, effort_limit: float) -> None:
    if trials is not None:
        check_count("--trials", trials, 1, _MAX_TRIALS)
    if seconds is not None and not 0.0 < seconds < 1e9:
        raise ConfigError("--seconds", seconds, "positive")
    check_in_range("--effort-limit", effort_limit, 0.0, 1e3, above=True)


def _study(optuna: Any, problem: Problem, storage: str | Path | None, effort_limit: float) -> Any:
    """Open the study, or refuse one of something else."""
    kept: Any = None
    backend: Any = None
    try:
        if isinstance(storage, str) and "://" in storage:
            kept = storage
        elif storage is not None:
            file = Path(storage)
            file.parent.mkdir(parents=True, exist_ok=True)
            # A locked file of Windows cannot be read either.
            journal = optuna.storages.journal
            lock = journal.JournalFileOpenLock(str(file)) if os.name == "nt" else _Lock(file)
            _mend(file, lock)
            backend = _backend(journal, file, lock, problem)
            kept = optuna.storages.JournalStorage(backend)
        study = optuna.create_study(
            study_name=_NAME, storage=kept, directions=["minimize", "minimize"], load_if_exists=True
        )
    except (OSError, PopsteerError):
        raise
    except Exception as error:
        # A storage raises the errors of its database.
        said = str(error).splitlines()[0] if str(error) else type(error).__name__
        where = storage if backend is None else f"{storage}, line {backend.line}"
        raise PopsteerError(f"{where}: no study can be opened there: {said}") from error
    known = study.user_attrs.get("popsteer")
    if known is None:
        if study.trials:
            raise PopsteerError(f"{storage}: holds a study that is not popsteer's")
        study.set_user_attr("popsteer", problem.document)
    elif known != problem.document:
        differs = ", ".join(differing(problem.document, known))
        raise PopsteerError(f"{storage}: holds another study, which differs in {differs}")
    # The first process is the same every time; those that join it, or go on, draw otherwise.
    there = len(study.trials)
    seed = problem.seed if there == 0 else problem.seed + there + os.getpid()
    with warnings.catch_warnings():
        # Constraints have stood as they are since version 3.
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        study.sampler = optuna.samplers.TPESampler(
            seed=seed % 2**32,
            n_startup_trials=_STARTUP,
            # Beyond the limit there is nothing to choose.
            constraints_func=lambda trial: (trial.user_attrs.get("ratio", 0.0) - effort_limit,),
        )
    return study


# What a line does, and how a trial ended, as Optuna numbers them.
_CREATE, _PARAM, _STATE, _ATTRIBUTE, _COMPLETE = 4, 5, 6, 8, 1


def _note(entry: dict[str, Any], trials: dict[int, Any], bounds: Mapping[str, Any]) -> None:
    """Take note of what a line of a journal says of trials; refuse one that does not fit.

    Optuna itself passes over such lines, as of a trial without its beginning.
    """
    what = entry["op_code"]
    if what == _CREATE:
        trials[len(trials)] = {}
    elif what > _CREATE:
        has = trials[entry["trial_id"]]
        if what == _PARAM:
            has[entry["param_name"]] = entry["param_value_internal"]
        elif what == _ATTRIBUTE:
            has |= entry["user_attr"]
        elif what == _STATE and entry["state"] == _COMPLETE:
            _, _ = map(float, entry["values"])
            for name, (low, high) in bounds.items():
                check_in_range(name, has[name], low, high)


def _backend(journal: Any, file: Path, lock: Any, problem: Problem) -> Any:
    """Let Optuna read a journal, and refuse by its line what this search did not write."""
    bounds = {name: each.bounds for name, each in problem.search.items()}
    bounds |= dict.fromkeys(_KEPT, (0.0, math.inf))
    trials: dict[int, dict[str, Any]] = {}

    class Backend(journal.JournalFileBackend):  # type: ignore[misc]
        line = 0

        def read_logs(self, log_number_from: int) -> Iterator[dict[str, Any]]:
            found = super().read_logs(log_number_from)
            self.line = log_number_from
            try:
                for entry in found:
                    self.line += 1
                    _note(entry, trials, bounds)
                    yield entry
            except (ValueError, LookupError, TypeError, AttributeError, RecursionError) as error:
                self.line += isinstance(error, JSONDecodeError)
                kind = f"{type(error).__name__} " if isinstance(error, LookupError) else ""
                said = f"{kind}{error}"
                raise PopsteerError(f"{file}, line {self.line}: {said}") from error

    return Backend(str(file), lock_obj=lock)


class _Lock:
    """Optuna's lock of its journal by the kernel, which takes it from a process that ends."""

    def __init__(self, file: Path) -> None:
        self._file = file

    def acquire(self) -> bool:
        from filelock import lock_descriptor

        self._stream = self._file.open("ab")
        lock_descriptor(self._stream.fileno())
        return True

    def release(self) -> None:
        self._stream.close()


def _mend(file: Path, lock: Any) -> None:
    """Refuse what is no journal: Optuna would write after its end. Drop half a line at its end.

    A full disk leaves one, and the next line would be written onto it.
    """
    if not file.exists():
        return
    if not file.is_file():  # of a pipe its end would be waited for
        raise PopsteerError(f"{file}: is no regular file")
    with file.open("rb") as stream:
        first = stream.readline()
    if first and not first.startswith(b'{"op_code"'):
        raise PopsteerError(f"{file}: is no journal of Optuna")
    lock.acquire()
    try:
        data = file.read_bytes()
        if not data.endswith(b"\n"):
            os.truncate(file, data.rfind(b"\n") + 1)
    finally:
        lock.release()


def _complete(study: Any) -> list[Any]:
    return [each for each in study.get_trials(deepcopy=False) if each.state.name == "COMPLETE"]
