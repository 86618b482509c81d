"""The latency of a control step, called from Python.

The whole step as the paper counts it (pre-processing of the window, lookahead, prediction,
optimisation) on the states of a recorded drive, beside the other controllers, the pure-Python
reference, an empty method of the same binding and signature, the yardsticks from outside where they
are at hand, and the paper's 3.239 ms. How the clock is read is explained in
`popsteer.lab.common.timing`; all figures are of one run, and all ratios of its medians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import popsteer
from popsteer.errors import ConfigError, PopsteerError
from popsteer.files import write_text_atomic
from popsteer.lab.bench import yardsticks
from popsteer.lab.bench.calls import PAPER_NS, SLOW_STEPS, lineup
from popsteer.lab.bench.report import LatencyReport, table, to_json
from popsteer.lab.bench.states import DT, at_hand
from popsteer.lab.common import machine
from popsteer.lab.common.timing import BATCH, Drive, Percentiles, time_calls
from popsteer.ranges import check_count

if TYPE_CHECKING:
    import os
    from collections.abc import Callable

    from rich.console import Console

    from popsteer.lab.bench.yardsticks import Yardsticks

__all__ = ["PAPER_NS", "LatencyReport", "Percentiles", "measure", "run", "table", "to_json"]

# Enough for p99.9 and max to say something: a thousand calls lie above p99.9.
_CALLS = 1_000_000
_MOST_CALLS = 1_000_000_000


def measure(
    drive: Drive | None = None,
    *,
    calls: int = _CALLS,
    reference_calls: int | None = None,
    outside: Yardsticks | None = None,
    progress: Callable[[float], object] | None = None,
) -> LatencyReport:
    """Time the control step on the states of `drive`, those of `states.at_hand` by default.

    `calls` is how many calls of each Rust controller are timed one by one, at least, and as many in
    batches; `reference_calls` the same for the pure-Python reference, which takes far longer: the
    drive once by default. The yardsticks `outside` are timed beside them. `progress` is called now
    and then with the part that is done, 0 to 1.

    Raises ConfigError where the extension is no release build or a count is not positive, PathError
    where the recorded drive cannot be read, PopsteerError where the clock is too coarse.
    """
    if popsteer.build_profile != "release":
        raise ConfigError(
            "build_profile", popsteer.build_profile, "'release' for a benchmark (try `make wheel`)"
        )
    drive = at_hand() if drive is None else drive
    if reference_calls is None:
        reference_calls = len(drive.states)
    for name, count in (("calls", calls), ("reference_calls", reference_calls)):
        check_count(name, count, 1, _MOST_CALLS)
    outside = yardsticks.Yardsticks() if outside is None else outside
    makers = {**lineup(drive), **outside.makers}
    counts = {name: min(calls, outside.calls.get(name, calls)) for name in makers}
    counts |= dict.fromkeys(SLOW_STEPS, reference_calls)
    result = time_calls(makers, counts, drive, DT, progress)
    for name, percentiles in result.percentiles.items():
        if percentiles.net_p50 is not None and percentiles.net_p50 <= 0.0:
            raise PopsteerError(f"{name} came out as 0: the clock of this machine is too coarse")
    return LatencyReport(
        build_profile=popsteer.build_profile,
        results={**result.percentiles, **dict.fromkeys(outside.absent)},
        absent=dict(outside.absent),
        states={"source": drive.source, "count": len(drive.states)},
        machine=machine.describe(),
        timing={
            "calls": result.calls,
            "batch": BATCH,
            "timer_floor_ns": result.timer_floor_ns,
            "loop_ns": result.loop_ns,
        },
    )


def run(
    json_file: str | os.PathLike[str] | None,
    console: Console,
    *,
    yardsticks_folder: str | os.PathLike[str] | None = None,
) -> LatencyReport:
    """Measure, print the table, and write the JSON file: what ``popsteer bench`` does; needs rich.

    Table and progress bar go to `console`. Raises, besides what
    `measure` does, PopsteerError where the folder of the yardsticks does not hold them, and OSError
    where the JSON file cannot be written; the table is printed all the same.
    """
    from rich.progress import Progress

    drive = at_hand()
    outside = yardsticks.at_hand(drive, yardsticks_folder)
    # Without auto_refresh rich starts no thread, which would run in the midst of what is timed.
    with Progress(
        console=console, transient=True, auto_refresh=False, disable=not console.is_terminal
    ) as bar:
        task = bar.add_task("timing", total=1.0)

        def show(part: float) -> None:
            bar.update(task, completed=part, refresh=True)

        report = measure(drive, calls=_CALLS, outside=outside, progress=show)
    console.print(table(report))
    if json_file is not None:
        write_text_atomic(json_file, to_json(report))
    return report
