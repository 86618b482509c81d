"""A sweep from its first run to its last; one that was stopped is continued."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from popsteer.lab.sweep import workers as who
from popsteer.lab.sweep.rows import Journal, check_same, journal_of, read, write
from popsteer.ranges import check_count

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from popsteer.lab.sweep.job import Job

_MAX_WORKERS = 1024


def run(
    job: Job,
    out: Path | None = None,
    *,
    dask: str | None = None,
    workers: int | None = None,
    progress: Callable[[str, float], object] | None = None,
) -> list[dict[str, Any]]:
    """Drive all runs of a sweep.

    Parameters
    ----------
    job : Job
        The sweep.
    out : pathlib.Path, optional
        The file for the rows, ``*.parquet`` or ``*.csv``. Until all are there, they are in a
        journal beside it, ``*.part``, from which the same sweep goes on after it was stopped.
    dask : str, optional
        The address of a Dask scheduler, or ``local:N``.
    workers : int, optional
        How many threads, or processes where plant or controller are in Python; as many as there
        are cores by default.
    progress : callable, optional
        Called now and then with what is being done and the share of it that is done.

    Returns
    -------
    list of dict
        A row for each run, in their order.

    Raises
    ------
    ConfigError
        A draw is out of its range; nothing was driven then.
    PopsteerError
        `out` or its journal is of another sweep, or the cluster does not answer.
    OSError
        A row cannot be written; those before it stand.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer.lab.sweep.job import Job
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> job = Job(path, "pop", popsteer.PopParams(), "kinematic-bicycle", {}, runs=3)
    >>> [row["success"] for row in run(job)]
    [True, True, True]
    """
    if workers is not None:
        check_count("--workers", workers, 1, _MAX_WORKERS)
    if out is None:
        found = _driven(job, {}, dask, workers, progress, lambda _: None)
        return _ordered(found)
    part = journal_of(out)
    if out.exists():
        other, rows = read(out)
        check_same(out, other, job)
        return rows
    with Journal(part, job) as journal:
        found = _driven(job, journal.rows, dask, workers, progress, journal.add)
        write(out, job, found.values())
        journal.remove()
    return _ordered(found)


def _ordered(found: dict[int, dict[str, Any]]) -> list[dict[str, Any]]:
    return [found[k] for k in sorted(found)]


def _driven(
    job: Job,
    known: dict[int, dict[str, Any]],
    dask: str | None,
    count: int | None,
    progress: Callable[[str, float], object] | None,
    keep: Callable[[list[dict[str, Any]]], object],
) -> dict[int, dict[str, Any]]:
    """Drive the runs that are not known yet."""
    found = dict(known)
    remaining = [k for k in range(job.runs) if k not in found]
    before = len(found)

    def advance(done: float) -> None:
        if progress is not None:
            progress(f"{int(before + done)} of {job.runs} runs", (before + done) / job.runs)

    if not remaining:
        return found
    if job.is_of_core:
        for k in remaining:
            job.made(k)  # refuses a draw that is out of range before anything is driven
    for rows in _who(job, remaining, dask, count, advance):
        keep(rows)
        found.update((row["run"], row) for row in rows)
    return found


def _who(
    job: Job,
    remaining: list[int],
    dask: str | None,
    count: int | None,
    advance: Callable[[float], None],
) -> Iterator[list[dict[str, Any]]]:
    if dask is not None:
        return who.on_dask(job, remaining, dask, advance)
    if job.is_of_core:
        return who.on_core(job, remaining, count, advance)
    return who.on_processes(job, remaining, count, advance)
