"""What a step of each controller takes, on the states of its own run."""

from __future__ import annotations

import inspect
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np

from popsteer import controllers
from popsteer._core import AdaptParams, MonitorParams, build_profile
from popsteer.errors import ConfigError, PopsteerError
from popsteer.lab.common.experiment import controller
from popsteer.lab.common.timing import Drive, Driver, time_calls
from popsteer.sim.steering import step_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from popsteer.lab.compare.comparison import Comparison
    from popsteer.sim import Run

# Of a slow controller as many as take a second or so, of a fast one as many as steady its median.
_CALLS = 1000


def time_steps(
    comparison: Comparison,
    params: Mapping[str, Any],
    progress: Callable[[str, float], object] | None = None,
    *,
    adapt: AdaptParams | Literal["auto"] | None = "auto",
    monitor: MonitorParams | Literal["auto"] | None = "auto",
) -> Comparison:
    """Measure the step of each controller on the states of its own run.

    Each controller, fresh, is shown the recorded states from the start, again and again, and asked
    for the angle alone, as `popsteer.lab.common.timing` does: warm caches, no garbage collection,
    net of the clock where a step is so short that reading it counts.

    Parameters
    ----------
    comparison : Comparison
        The runs, with their records.
    params : mapping
        The tuning by name of the controller, as `popsteer.lab.compare.runs.parameters` gives it.
    progress : callable, optional
        Called with the name of the controller and the share of its timing done, 0 to 1.
    adapt : AdaptParams or None, optional
        How the controllers adapt; None: not at all. Left out: as each does by default.
    monitor : MonitorParams or None, optional
        How they watch for faults; None: not at all. Left out: as each does by default.

    Returns
    -------
    Comparison
        The same with its `step_times`, medians [s], and its `latencies`, all that were read [ns];
        without those of runs that code of your own ended.

    Raises
    ------
    ConfigError
        The runs kept no records.
    PopsteerError
        The extension module is a debug build, whose times would mean nothing.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer.lab import compare
    >>> from popsteer.lab.compare import parameters
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> params = parameters(["pop"], "default")
    >>> timed = time_steps(compare.run(path, params), params)
    >>> timed.step_times["pop"] > 0.0
    True
    """
    if build_profile == "debug":
        raise PopsteerError("step times of a debug build mean nothing: install a release build")
    times: dict[str, float] = {}
    latencies: dict[str, Sequence[int]] = {}
    for name, run in comparison.runs.items():
        if run.traceback:
            continue  # there is no step to time
        make = partial(
            controller, name, run.path, comparison.believed, params[name], adapt, monitor
        )
        advance = partial(progress or nothing, f"time {name}")
        times[name], latencies[name] = _step_time(comparison, run, make, advance)
    return replace(comparison, step_times=times, latencies=latencies)


def nothing(*_: object) -> None:
    """Stand for a `progress` that is not given, or a `reset` that one's own controller lacks."""


def _reset_of(made: Any) -> Callable[[], None]:  # noqa: ANN401 - of one's own
    """Give the `reset` of one's own controller, if it can be called as this would call it."""
    reset: Any = getattr(made, "reset", None)
    try:
        inspect.signature(reset).bind()
    except (TypeError, ValueError):
        return nothing
    return cast("Callable[[], None]", reset)


def _step_time(
    comparison: Comparison,
    run: Run,
    make: Callable[[], Any],
    progress: Callable[[float], object],
) -> tuple[float, Sequence[int]]:
    """Give the median of a run's controller [s], and what each single step took [ns]."""
    records = run.records
    if not len(records["x"]):
        raise ConfigError("keep_records", value=False, requirement="true where steps are timed")
    table = np.column_stack([records[column] for column in ("x", "y", "yaw", "speed")])
    states = [(x, y, yaw, speed) for x, y, yaw, speed in table.tolist()]
    drive = Drive(comparison.plant, run.path, states, comparison.believed)

    def driver() -> Driver:
        made = make()
        if run.law not in controllers.names():
            return Driver(step_of(made), _reset_of(made))
        # The controllers of popsteer measure errors in `step` besides; `steer` is the angle alone.
        return Driver(made.steer, made.reset)

    measured = time_calls({run.law: driver}, {run.law: _CALLS}, drive, run.dt, progress)
    percentiles = measured.percentiles[run.law]
    net = percentiles.net_p50
    return 1e-9 * (percentiles.p50 if net is None else net), measured.singles[run.law]
