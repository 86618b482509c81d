"""The runs of a sweep: a row for each, the same whoever drives it."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

from popsteer.lab.sweep.job import Job, from_text

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
    made = ((job.road, job.made(run), job.seed_of(run)) for run in runs)
    count = len(runs)
    figures = job.drive_each(job.params, made, count, progress, threads=threads, keep_going=True)
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
    return job.drive_one(
        job.params,
        job.road,
        job.made(run),
        job.seed_of(run),
        keep_records=keep_records,
        keep_going=True,
        progress=progress,
    )


@lru_cache(maxsize=2)
def _job(text: str) -> Job:
    """Keep the jobs that a worker got last: the draws of all runs take time to make."""
    return from_text(text)


def _row(job: Job, run: int, figures: dict[str, Any]) -> dict[str, Any]:
    faults = int(figures["faults"])
    good = (
        figures["finished"]
        and faults == 0
        and figures["settled_max_abs_cross_track_error"] <= job.deviation
    )
    return {
        "run": run,
        "seed": job.seed_of(run),
        "success": bool(good),
        **job.drawn(run),
        **{name: value for name, value in figures.items() if name != "faults"},
        "faults": faults,
    }
