"""The latency of a control step, called from Python.

The whole step as the paper counts it (pre-processing of the window, lookahead, prediction,
optimisation) on the states of a recorded drive, beside the other controllers, the pure-Python
reference, an empty method of the same binding and signature, the yardsticks from outside where they
are at hand, and the paper's 3.239 ms. How the clock is read is explained in
`benches.latency.timing`; all figures are of one run, and all ratios of its medians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import popsteer
from benches.latency import yardsticks
from benches.latency.calls import SLOW_STEPS, lineup
from benches.latency.report import LatencyReport
from benches.latency.states import DT
from benches.latency.timing import BATCH, Drive, time_calls
from popsteer.errors import ConfigError, PopsteerError
from popsteer.lab.common.layout import this_machine

if TYPE_CHECKING:
    from collections.abc import Callable

    from benches.latency.yardsticks import Yardsticks

# Enough for p99.9 and max to say something: a thousand calls lie above p99.9.
_CALLS = 1_000_000


def measure(
    drive: Drive,
    *,
    calls: int = _CALLS,
    reference_calls: int | None = None,
    outside: Yardsticks | None = None,
    progress: Callable[[float], object] | None = None,
) -> LatencyReport:
    """Time the control step on the states of `drive`.

    `calls` is how many calls of each Rust controller are timed one by one, at least, and as many in
    batches; `reference_calls` the same for the pure-Python reference, which takes far longer: the
    drive once by default. The yardsticks `outside` are timed beside them. `progress` is called now
    and then with the part that is done, 0 to 1.

    Raises ConfigError where the extension is no release build, PopsteerError where the clock is too
    coarse.
    """
    if popsteer.build_profile != "release":
        raise ConfigError(
            "build_profile", popsteer.build_profile, "'release' for a benchmark (try `make wheel`)"
        )
    if reference_calls is None:
        reference_calls = len(drive.states)
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
        machine=this_machine(),
        timing={
            "calls": result.calls,
            "batch": BATCH,
            "timer_floor_ns": result.timer_floor_ns,
            "loop_ns": result.loop_ns,
        },
    )
