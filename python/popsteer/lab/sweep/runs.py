"""A sweep from its first run to its last; one that was stopped is continued.

The core's threads, processes or a Dask cluster drive: each takes runs in chunks and returns rows.
If a worker dies, another one gets its chunk.
"""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager, suppress
from multiprocessing import resource_tracker
from pathlib import Path
from typing import Any

from popsteer import own
from popsteer._core import __version__
from popsteer.errors import PopsteerError
from popsteer.extras import require
from popsteer.lab.sweep.job import Job, drive, drive_text
from popsteer.lab.sweep.rows import Journal, journal_of, read_rows, write
from popsteer.ranges import check_count
from popsteer.sim import plant_name

Rows = list[dict[str, Any]]

_LOOK = 0.05  # s between looks at signals
_CORE_CHUNK = 250  # runs between writes: seconds of work, and cores that seldom wait for the last
_ATTEMPTS = 5  # how often a pool of processes is made anew
_DASK_TIMEOUT = 10.0  # s for a scheduler to answer
_receiving = threading.Lock()  # a worker of Dask may have many threads


def on_core(
    job: Job, runs: Sequence[int], threads: int | None, progress: Callable[[float], object]
) -> Generator[Rows, None, None]:
    """Drive runs on the core's threads; `progress` gets the number of runs that are done."""
    for begin in range(0, len(runs), _CORE_CHUNK):
        chunk = runs[begin : begin + _CORE_CHUNK]

        def advance(share: float, begin: int = begin, size: int = len(chunk)) -> None:
            progress(begin + share * size)

        yield drive(job, chunk, threads, advance)


def on_processes(
    job: Job, runs: Sequence[int], workers: int | None, progress: Callable[[float], object]
) -> Generator[Rows, None, None]:
    """Drive runs on processes of their own, as many as cores by default; give rows as they come."""
    if workers is None:
        # Windows and macOS do not tell which cores a process may use.
        affinity = getattr(os, "sched_getaffinity", None)
        workers = (os.cpu_count() or 1) if affinity is None else len(affinity(0))
    remaining = _chunks(runs, workers)
    done = 0
    for _ in range(_ATTEMPTS):
        pool = ProcessPoolExecutor(
            workers,
            mp_context=multiprocessing.get_context("spawn"),
            initializer=signal.signal,  # Ctrl-C is left to this process
            initargs=(signal.SIGINT, signal.SIG_IGN),
        )
        try:
            with _interrupts_held():
                pending = {pool.submit(drive_text, job.text, chunk): chunk for chunk in remaining}
            while pending:
                ready, _waiting = wait(pending, timeout=_LOOK, return_when=FIRST_COMPLETED)
                for future in ready:
                    rows = future.result()  # raises where a worker died: its chunk stays
                    pending.pop(future)
                    done += len(rows)
                    yield rows
                progress(done)
        except BrokenProcessPool:
            remaining = list(pending.values())
        else:
            return
        finally:
            _end(pool)
    raise PopsteerError(f"the processes of the sweep died {_ATTEMPTS} times")


def on_dask(
    job: Job, runs: Sequence[int], where: str, progress: Callable[[float], object]
) -> Generator[Rows, None, None]:
    """Drive runs on a Dask cluster, by the address of its scheduler."""
    require("--dask", "dask")
    import dask
    from distributed import Client, as_completed

    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    # A task is given up only after many workers have died with it.
    dask.config.set({"distributed.scheduler.allowed-failures": 20})
    try:
        client = Client(where, timeout=_DASK_TIMEOUT)
    except (OSError, ValueError) as error:
        raise PopsteerError(f"--dask {where}: no scheduler answers: {error}") from None
    try:
        _check_versions(client, where)
        workers = max(len(client.nthreads()), 1)
        sent = client.scatter((job.text, _code(job)), broadcast=True)
        futures = [
            client.submit(_drive_sent, sent, chunk, pure=False, retries=3)
            for chunk in _chunks(runs, workers)
        ]
        done = 0
        for _, rows in as_completed(futures, with_results=True):
            done += len(rows)
            yield rows
            progress(done)
    finally:
        with suppress(Exception):
            client.close(timeout=0.2)


def _code(job: Job) -> tuple[tuple[str, bytes], ...]:
    """Give the files of code of one's own that a sweep drives; two of one name are refused."""
    files = dict(own.sent("controller", job.controller))
    for name, content in own.sent("plant", plant_name(job.whole)):
        if files.setdefault(name, content) != content:
            raise PopsteerError(f"--dask: controller and plant have two files {name} that differ")
    return tuple(files.items())


def _drive_sent(sent: tuple[str, tuple[tuple[str, bytes], ...]], runs: Sequence[int]) -> Rows:
    """Drive runs in a worker, which has `Job.text` and the files of code of one's own alone."""
    from distributed import get_worker

    text, files = sent
    with _receiving:
        own.receive(files, Path(get_worker().local_directory))
    return drive_text(text, runs)


def _check_versions(client: Any, where: str) -> None:
    found = client.run(_version, on_error="return")
    for worker, version in found.items():
        if version != __version__:
            said = f"popsteer {version}" if isinstance(version, str) else f"no popsteer: {version}"
            raise PopsteerError(f"--dask {where}: {worker} has {said}; this is {__version__}")
    if not found:
        raise PopsteerError(f"--dask {where}: the scheduler has no workers")


def _version() -> str:
    return __version__


def _chunks(runs: Sequence[int], workers: int) -> list[Sequence[int]]:
    """Cut runs into chunks: many for each worker, so that none waits long for the last."""
    size = min(max(len(runs) // (16 * workers), 1), _CORE_CHUNK)
    return [runs[begin : begin + size] for begin in range(0, len(runs), size)]


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Start processes that leave Ctrl-C to this one from their first moment on.

    It comes after that, as none may be half started and unknown to what ends them: a mask alone
    would let another thread take it, for this one to handle.
    """
    if not hasattr(signal, "pthread_sigmask"):  # not on Windows
        yield
        return
    resource_tracker.ensure_running()  # it unblocks them where it is started later
    came: list[int] = []
    usual = signal.getsignal(signal.SIGINT)
    is_held = callable(usual) and threading.current_thread() is threading.main_thread()
    if is_held:
        signal.signal(signal.SIGINT, lambda number, _: came.append(number))
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        if is_held:
            signal.signal(signal.SIGINT, usual)
            if came:
                signal.raise_signal(signal.SIGINT)


def _end(pool: ProcessPoolExecutor) -> None:
    """End the processes of a pool at once; done ones have nothing to lose."""
    processes = list((getattr(pool, "_processes", None) or {}).values())
    pool.shutdown(wait=False, cancel_futures=True)
    for process in processes:
        process.terminate()


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
        The address of a Dask scheduler.
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
    part = None if out is None else journal_of(out)
    if out is not None and out.exists():
        return read_rows(out, job)
    # Ranges have no gaps, so that of plants in Python, which take longer to make, the least and the
    # greatest draws tell.
    ends = {int(end) for each in job.draws.values() for end in (each.argmin(), each.argmax())}
    for k in range(job.runs) if job.is_of_core else sorted(ends):
        job.made(k)
    if out is None or part is None:
        return _driven(job, {}, dask, workers, progress, lambda _: None)
    with Journal(part, job) as journal:
        rows = _driven(job, journal.rows, dask, workers, progress, journal.add)
        write(out, job, rows)
        part.unlink(missing_ok=True)
    return rows


def _driven(
    job: Job,
    known: dict[int, dict[str, Any]],
    dask: str | None,
    count: int | None,
    progress: Callable[[str, float], object] | None,
    keep: Callable[[Rows], object],
) -> Rows:
    """Drive the runs that are not `known`; give all rows, in order."""
    found = dict(known)
    remaining = [k for k in range(job.runs) if k not in found]
    before = len(found)

    def advance(done: float) -> None:
        if progress is not None:
            progress(f"{int(before + done)} of {job.runs} runs", (before + done) / job.runs)

    if remaining:
        drivers: Any = on_dask if dask is not None else on_core if job.is_of_core else on_processes
        # Closed: an interrupt of what keeps the rows ends the processes, too.
        with closing(drivers(job, remaining, dask or count, advance)) as driven:
            for rows in driven:
                keep(rows)
                found.update((row["run"], row) for row in rows)
    return [found[k] for k in sorted(found)]
