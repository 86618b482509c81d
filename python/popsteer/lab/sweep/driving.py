"""The runs of a sweep: a row for each, the same whoever drives it."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

from popsteer import sim
from popsteer._core import Settings
from popsteer.lab.compare.runs import controller
from popsteer.lab.sweep.job import Job, from_text
from popsteer.sim.closed_loop import start_speed

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from popsteer.sim import Run


def drive(
    job: Job,
    runs: Sequence[int],
    threads: int | None = None,
    progress: Callable[[float], object] | None = None,
) -> list[dict[str, Any]]:
    """Drive some runs of a sweep.

    Parameters
    ----------
    job : Job
        The sweep.
    runs : sequence of int
        Which of its runs.
    threads : int, optional
        How many threads drive where the core alone does, as `popsteer.sim.run_many` has it.
    progress : callable, optional
        Called now and then with the share of them that is done.

    Returns
    -------
    list of dict
        A row for each run: its number, its seed, whether it succeeded, what was drawn, and every
        figure of `popsteer.sim.Metrics`.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> job = Job(path, "pop", popsteer.PopParams(), "kinematic-bicycle", {}, runs=2)
    >>> [row["success"] for row in drive(job, [0, 1])]
    [True, True]
    """
    if job.is_of_core:
        figures = _by_core(job, runs, threads, progress)
    else:
        figures = []
        for done, run in enumerate(runs):
            figures.append(vars(repeat(job, run, keep_records=False).metrics))
            if progress is not None:
                progress((done + 1) / len(runs))
    return [_row(job, run, each) for run, each in zip(runs, figures, strict=True)]


def drive_text(text: str, runs: Sequence[int]) -> list[dict[str, Any]]:
    """Drive some runs as `drive`, on one thread of a process that has `Job.text` alone."""
    return drive(_job(text), runs, threads=1)


def repeat(
    job: Job,
    run: int,
    *,
    keep_records: bool = True,
    progress: Callable[[float], object] | None = None,
) -> Run:
    """Drive one run of a sweep, with its records.

    Parameters
    ----------
    job : Job
        The sweep.
    run : int
        Which of its runs.
    keep_records : bool, default True
        Whether what happens at each step is kept.
    progress : callable, optional
        As `popsteer.sim.run` has it.

    Returns
    -------
    Run
        To the bit what the sweep drove.
    """
    made = job.made(run)
    path, pedals = job.road
    settings = Settings() if job.settings is None else job.settings
    return sim.run(
        controller(job.controller, path, job.given, job.params, job.adapt),
        made.plant,
        path=path,
        start=made.start,
        speed=_speed(job, made.speed),
        longitudinal=pedals,
        pedals=job.pedals,
        settings=settings.replace(keep_records=keep_records),
        noise=made.noise,
        seed=job.seed_of(run),
        progress=progress,
        keep_going=True,
    )


@lru_cache(maxsize=2)
def _job(text: str) -> Job:
    """Keep the jobs that a worker got last: the draws of all runs take time to make."""
    return from_text(text)


def _by_core(
    job: Job,
    runs: Sequence[int],
    threads: int | None,
    progress: Callable[[float], object] | None,
) -> list[dict[str, Any]]:
    made = [job.made(run) for run in runs]
    path, pedals = job.road
    driver: Any = controller(job.controller, path, job.given, job.params, job.adapt)
    columns = sim.run_many(
        driver,
        [each.plant for each in made],
        start=[each.start for each in made],
        speed=[_speed(job, each.speed) for each in made],
        longitudinal=pedals,
        pedals=job.pedals,
        settings=job.settings,
        noise=[each.noise or sim.Noise() for each in made],
        seed=[job.seed_of(run) for run in runs],
        threads=threads,
        progress=progress,
    )
    lists = {name: column.tolist() for name, column in columns.items()}
    return [{name: column[k] for name, column in lists.items()} for k in range(len(runs))]


def _speed(job: Job, drawn: float | None) -> float:
    if drawn is not None:
        return drawn
    if job.speed is not None:
        return job.speed
    return start_speed(job.path, job.constant_speed)


def _row(job: Job, run: int, figures: dict[str, Any]) -> dict[str, Any]:
    faults = int(figures["faults"])
    good = (
        figures["finished"]
        and faults == 0
        and figures["settled_max_abs_cross_track_error"] <= job.deviation
    )
    drawn = job.drawn(run)
    return {
        "run": run,
        "seed": job.seed_of(run),
        "success": bool(good),
        **drawn,
        **{name: value for name, value in figures.items() if name != "faults"},
        "faults": faults,
    }
