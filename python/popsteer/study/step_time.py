"""How long a control step of each law of a comparison takes."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from popsteer._core import build_profile
from popsteer.bench.laws import Driver
from popsteer.bench.states import Drive
from popsteer.bench.timing import time_calls
from popsteer.errors import ConfigError, PopsteerError
from popsteer.study.compare import controller

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from popsteer.sim import Run
    from popsteer.study.compare import Comparison

__all__ = ["time_steps"]

# Of a slow law as many as take a second or so, of a fast one as many as steady its median.
_CALLS = 1000


def time_steps(
    comparison: Comparison,
    params: Mapping[str, Any],
    progress: Callable[[str, float], object] | None = None,
) -> Comparison:
    """Measure the step of each law on the states of its own run.

    Each law, fresh, is shown the recorded states from the start, again and again, and asked for the
    angle alone, as `popsteer.bench.timing` does: warm caches, no garbage collection, net of the
    clock where a step is so short that reading it counts.

    Parameters
    ----------
    comparison : Comparison
        The runs, with their records.
    params : mapping
        The parameters by name of the law, as `popsteer.study.compare.parameters` gives them.
    progress : callable, optional
        Called with the name of the law and the share of its timing done, 0 to 1.

    Returns
    -------
    Comparison
        The same with its `step_times`: medians [s].

    Raises
    ------
    ConfigError
        The runs kept no records.
    PopsteerError
        The extension module is a debug build, whose times would mean nothing.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer.study import compare, parameters
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> params = parameters(["pop"], "default", "carla-identified")
    >>> timed = time_steps(compare(path, params), params)
    >>> timed.step_times["pop"] > 0.0
    True
    """
    if build_profile == "debug":
        raise PopsteerError("step times of a debug build mean nothing: install a release build")
    times = {}
    for name, run in comparison.runs.items():

        def advance(share: float, name: str = name) -> None:
            if progress is not None:
                progress(f"time {name}", share)

        times[name] = _step_time(run, partial(_driver, name, run, params[name]), advance)
    return replace(comparison, step_times=times)


def _driver(name: str, run: Run, params: Any) -> Driver:  # noqa: ANN401 - of any law
    law: Any = controller(name, run.path, params)
    # The laws of popsteer measure errors in `step` besides; `steer` is the angle alone.
    return Driver(getattr(law, "steer", law.step), law.reset)


def _step_time(run: Run, make: Callable[[], Driver], progress: Callable[[float], object]) -> float:
    """Give the median of a run's law [s]."""
    records = run.records
    if not len(records["x"]):
        raise ConfigError("keep_records", value=False, requirement="true where steps are timed")
    table = np.column_stack([records[column] for column in ("x", "y", "yaw", "speed")])
    states = [(x, y, yaw, speed) for x, y, yaw, speed in table.tolist()]
    drive = Drive(run.plant, run.path, states, 0.0, 0.0)
    measured = time_calls({run.law: make}, {run.law: _CALLS}, drive, run.dt, progress)
    percentiles = measured.percentiles[run.law]
    net = percentiles.net_p50
    return 1e-9 * (percentiles.p50 if net is None else net)
