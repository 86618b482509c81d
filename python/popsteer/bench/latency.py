"""The latency of a control step, called from Python.

The whole step as the paper counts it (pre-processing of the window, lookahead, prediction,
optimisation) on the states of a recorded drive, beside the other laws, the pure-Python reference,
an empty method of the same binding and signature, and the paper's 3.239 ms. How the clock is read
is told in `popsteer.bench.timing`; all figures are of one run, and all ratios of its medians.

Examples
--------
>>> from popsteer.bench import latency
>>> report = latency.measure(calls=1000, reference_calls=32)
>>> sorted(report.ratios)
['paper_over_step', 'reference_over_step', 'step_over_empty_call']
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import popsteer
from popsteer.bench import machine
from popsteer.bench.laws import (
    EMPTY_CALL,
    LABELS,
    POP_COMMAND,
    POP_STEP,
    REFERENCE_STEP,
    lineup,
)
from popsteer.bench.states import DT, Drive, at_hand
from popsteer.bench.timing import BATCH, Percentiles, time_calls
from popsteer.errors import ConfigError, PopsteerError, count_in_range
from popsteer.files import write_text_atomic

if TYPE_CHECKING:
    import os
    from collections.abc import Callable

    from rich.console import Console
    from rich.table import Table

__all__ = ["PAPER_NS", "LatencyReport", "Percentiles", "measure", "run", "table", "to_json"]

PAPER_NS = 3.239e6
"""Mean latency of POP in the paper, on its laptop [ns]."""

_CALLS = 100_000
_THOROUGH_CALLS = 1_000_000
_MOST_CALLS = 1_000_000_000
_IN_PAPER = frozenset({POP_STEP, POP_COMMAND, REFERENCE_STEP})


@dataclass(frozen=True)
class LatencyReport:
    """What one run has measured.

    Attributes
    ----------
    build_profile : str
        How the extension was built: "release".
    results : dict
        Name of each call, such as ``pop_step_ns``, to its `Percentiles` [ns].
    states : dict
        ``source`` and ``count`` of the states that were driven through.
    machine : dict
        ``cpu``, ``python`` and ``platform``.
    timing : dict
        ``calls`` timed one by one for each name, ``batch`` size, what the clock
        (``timer_floor_ns``) and the empty loop (``loop_ns``) take, and ``singles_p50_ns``, the
        medians with the clock in them.
    """

    build_profile: str
    results: dict[str, Percentiles]
    states: dict[str, Any]
    machine: dict[str, str]
    timing: dict[str, Any]

    @property
    def ratios(self) -> dict[str, float]:
        """What the step is compared with, from p50.

        Returns
        -------
        dict
            ``reference_over_step``, ``step_over_empty_call`` and ``paper_over_step``.
        """
        step = self.results[POP_STEP].p50
        return {
            "reference_over_step": self.results[REFERENCE_STEP].p50 / step,
            "step_over_empty_call": step / self.results[EMPTY_CALL].p50,
            "paper_over_step": PAPER_NS / step,
        }


def measure(
    drive: Drive | None = None,
    *,
    calls: int = _CALLS,
    reference_calls: int | None = None,
    progress: Callable[[float], object] | None = None,
) -> LatencyReport:
    """Time the control step.

    Parameters
    ----------
    drive : Drive, optional
        The states to drive through; by default those of `popsteer.bench.states.at_hand`.
    calls : int, optional
        How many calls of each Rust law to time one by one, at least; as many in batches.
    reference_calls : int, optional
        The same for the pure-Python reference, which takes far longer; by default the drive once.
    progress : callable, optional
        Called now and then with the part that is done, in 0 to 1.

    Returns
    -------
    LatencyReport
        The figures.

    Raises
    ------
    ConfigError
        The extension is no release build, or a count is not positive.
    PathError
        The recorded drive is there but cannot be read.
    PopsteerError
        The clock is too coarse to see an empty call.
    """
    if popsteer.build_profile != "release":
        raise ConfigError(
            "build_profile", popsteer.build_profile, "'release' for a benchmark (try `make wheel`)"
        )
    drive = at_hand() if drive is None else drive
    if reference_calls is None:
        reference_calls = len(drive.states)
    for name, count in (("calls", calls), ("reference_calls", reference_calls)):
        if not 1 <= count <= _MOST_CALLS:
            raise ConfigError(name, count, count_in_range(1, _MOST_CALLS))
    makers = lineup(drive)
    counts = {name: reference_calls if name == REFERENCE_STEP else calls for name in makers}
    result = time_calls(makers, counts, drive, DT, progress)
    for name, percentiles in result.percentiles.items():
        if percentiles.p50 <= 0.0:
            raise PopsteerError(f"{name} came out as 0: the clock of this machine is too coarse")
    return LatencyReport(
        build_profile=popsteer.build_profile,
        results=result.percentiles,
        states={"source": drive.source, "count": len(drive.states)},
        machine=machine.describe(),
        timing={
            "calls": result.calls,
            "batch": BATCH,
            "timer_floor_ns": result.timer_floor_ns,
            "loop_ns": result.loop_ns,
            "singles_p50_ns": result.singles_p50_ns,
        },
    )


def to_json(report: LatencyReport) -> str:
    """Write a report as JSON.

    Parameters
    ----------
    report : LatencyReport
        The report.

    Returns
    -------
    str
        An object with ``build_profile``, ``results``, ``ratios``, ``states``, ``machine`` and
        ``timing``, and a line feed.
    """
    fields = asdict(report)
    ordered = {
        "build_profile": fields.pop("build_profile"),
        "results": fields.pop("results"),
        "ratios": report.ratios,
        **fields,
    }
    return json.dumps(ordered, indent=2, allow_nan=False) + "\n"


def table(report: LatencyReport) -> Table:
    """Lay out a report as a table for the terminal; needs rich.

    Parameters
    ----------
    report : LatencyReport
        The report.

    Returns
    -------
    rich.table.Table
        A row for each call: percentiles, p50 over that of the empty call, and, for POP, the
        paper's latency over p50.
    """
    from rich.table import Table

    layout = Table(
        title="Latency of a control step, called from Python",
        caption=(
            f"{report.states['count']} states of {report.states['source']}; "
            f"{report.machine['cpu']}, {report.machine['python']}.\n"
            "p50 is net of clock and loop, the rest as read: one reading of the clock, "
            f"{report.timing['timer_floor_ns']:.0f} ns, is in it."
        ),
        caption_justify="left",
    )
    layout.add_column("law", no_wrap=True)
    for heading in ("p50", "p99", "p99.9", "max", "/ empty", "paper /"):
        layout.add_column(heading, justify="right", no_wrap=True)
    empty = report.results[EMPTY_CALL].p50
    for name, row in report.results.items():
        times = [_duration(value) for value in (row.p50, row.p99, row.p999, row.max)]
        of_paper = _digits(PAPER_NS / row.p50) if name in _IN_PAPER else "-"
        layout.add_row(LABELS.get(name, name), *times, _digits(row.p50 / empty), of_paper)
    return layout


def _duration(nanoseconds: float) -> str:
    """Write a time with three digits or more."""
    for size, unit in ((1e9, "s"), (1e6, "ms"), (1e3, "µs")):
        if nanoseconds >= size:
            return f"{_digits(nanoseconds / size)} {unit}"
    return f"{nanoseconds:.0f} ns"


def _digits(value: float) -> str:
    """Write a number with no more than two places, and fewer the larger it is."""
    return f"{value:,.{2 if value < 10 else 1 if value < 100 else 0}f}"


def run(
    json_file: str | os.PathLike[str] | None = None,
    console: Console | None = None,
    *,
    data: str | os.PathLike[str] | None = None,
    thorough: bool = False,
) -> LatencyReport:
    """Measure, print the table, and write the JSON file: what ``popsteer bench`` does; needs rich.

    Parameters
    ----------
    json_file : str or os.PathLike, optional
        Where `to_json` goes, whole or not at all; nowhere by default.
    console : rich.console.Console, optional
        Where the table and a progress bar go; by default standard output.
    data : str or os.PathLike, optional
        Folder of the authors' recorded run, as `popsteer.bench.states.at_hand` takes it.
    thorough : bool, optional
        Whether to time a million calls instead of a hundred thousand.

    Returns
    -------
    LatencyReport
        The figures.

    Raises
    ------
    ConfigError
        The extension is no release build.
    PathError
        The recorded run cannot be read.
    OSError
        The JSON file cannot be written; the table is printed all the same.
    """
    from rich.console import Console
    from rich.progress import Progress

    console = Console() if console is None else console
    calls = _THOROUGH_CALLS if thorough else _CALLS
    # Without auto_refresh rich starts no thread, which would run in the midst of what is timed.
    with Progress(
        console=console, transient=True, auto_refresh=False, disable=not console.is_terminal
    ) as bar:
        task = bar.add_task("timing", total=1.0)

        def show(part: float) -> None:
            bar.update(task, completed=part, refresh=True)

        report = measure(at_hand(data), calls=calls, progress=show)
    console.print(table(report))
    if json_file is not None:
        write_text_atomic(json_file, to_json(report))
    return report
