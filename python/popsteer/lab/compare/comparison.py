"""What several controllers did on one plant and one path, and what their steps took."""

from __future__ import annotations

import gc
import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from time import perf_counter_ns
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from popsteer import controllers
from popsteer._core import Path, Vehicle, build_profile
from popsteer.errors import ConfigError, PopsteerError
from popsteer.lab.common.experiment import Adapt, Monitor, controller
from popsteer.sim import Run
from popsteer.sim.steering import step_of, told


@dataclass(frozen=True, eq=False)
class Comparison:
    """Runs of several controllers on one plant and one path.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer.lab.compare import run
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> comparison = run(path, ["stanley", "pop"])
    >>> comparison.plant, list(comparison.runs)
    ('carla-identified', ['stanley', 'pop'])
    """

    runs: Mapping[str, Run]
    """The runs by name of the controller, in the order to show them; at least one."""
    tuning: Mapping[str, str]
    """Where the tuning of each controller comes from, by its name: a preset, a file, changes."""
    plant: str
    """What the plant is called."""
    track: str = ""
    """What the path is called; ``dataclasses.replace`` gives it a name."""
    joined: bool = False
    """Whether the settling time is that in which the vehicle drives `JOINED` wheelbases."""
    begins: str = ""
    """Where the runs start and how fast they drive, in one line."""
    constant_speed: float | None = None
    """Speed kept throughout [m/s]; None where another controller worked the pedals."""
    step_times: Mapping[str, float] = field(default_factory=dict)
    """What a step of each controller takes [s], where that was measured: see `time_steps`."""
    latencies: Mapping[str, Sequence[int]] = field(default_factory=dict)
    """What each of the timed steps took, as the clock read it [ns]; by controller."""

    @property
    def first(self) -> Run:
        """Any of the runs, for what they have in common: the first."""
        return next(iter(self.runs.values()))

    @property
    def points(self) -> dict[str, str]:
        """The point at which the errors of each controller are measured, by its name."""
        return {name: _point(run.tracked_point, self.believed) for name, run in self.runs.items()}

    @property
    def vehicle(self) -> Vehicle:
        """What the plant is: the same for all runs."""
        return self.first.plant_vehicle

    @property
    def believed(self) -> Vehicle:
        """What the controllers were given of the vehicle: the same for all."""
        return self.first.vehicle or self.vehicle

    @property
    def path(self) -> Path:
        """What was followed: the same for all runs."""
        return self.first.path

    @property
    def dt(self) -> float:
        """Control period [s]."""
        return self.first.dt


def _point(at: float | None, vehicle: Vehicle) -> str:
    """Name a point `at` [m] ahead of the pose's, None for the front axle."""
    at = vehicle.front_axle if at is None else at
    no_slip = vehicle.rear_axle if vehicle.no_slip_point is None else vehicle.no_slip_point
    known = ((vehicle.front_axle, "front"), (vehicle.rear_axle, "rear"), (no_slip, "no-slip"))
    return next((name for ahead, name in known if at == ahead), f"{at:.3g} m ahead")


# Of a slow controller as many as take a second or so, of a fast one as many as steady its median.
_CALLS = 1000
_BATCH = 32
_REACH = 10.0  # m of path, either way, in which the next place is looked for


def time_steps(
    comparison: Comparison,
    params: Mapping[str, Any],
    progress: Callable[[str, float], object] | None = None,
    *,
    adapt: Adapt = "auto",
    monitor: Monitor = "auto",
) -> Comparison:
    """Measure the step of each controller on the states of its own run.

    Each controller, fresh, is shown the recorded states from the start, again and again, and asked
    for the angle alone, with warm caches and no garbage collection: 32 states one by one, as the
    clock reads each, then the same as a whole, whose mean holds 1/32 of a reading.

    Parameters
    ----------
    comparison : Comparison
        The runs, with their records.
    params : mapping
        The tuning by name of the controller, as `popsteer.lab.compare.runs.parameters` gives it.
    progress : callable, optional
        Called with the name of the controller and the share of its timing done, 0 to 1.
    adapt, monitor : AdaptParams or None, MonitorParams or None, optional
        As `popsteer.lab.compare.run` has them.

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
        times[name], latencies[name] = _step_time(run, make, advance)
    return replace(comparison, step_times=times, latencies=latencies)


def nothing(*_: object) -> None:
    """Stand for a `progress` that is not given, or a `reset` that one's own controller lacks."""


def _reset_of(made: Any) -> Callable[[], None]:
    """Give the `reset` of one's own controller, if it can be called as this would call it."""
    reset = told(made, "reset", object)
    try:
        inspect.signature(reset).bind()
    except (TypeError, ValueError):
        return nothing
    return cast("Callable[[], None]", reset)


def _step_time(
    run: Run, make: Callable[[], Any], progress: Callable[[float], object]
) -> tuple[float, Sequence[int]]:
    """Give the median of a run's controller [s], and what each single step took [ns]."""
    records = run.records
    if not len(records["x"]):
        raise ConfigError("keep_records", value=False, requirement="true where steps are timed")
    table = np.column_stack([records[column] for column in ("x", "y", "yaw", "speed")])
    blocks = [table[at : at + _BATCH].tolist() for at in range(0, len(table), _BATCH)]
    # The controllers of popsteer measure errors in `step` besides; `steer` is the angle alone.
    own = run.law not in controllers.names()
    made = [make(), make()]
    single, batched = ((step_of(each) if own else each.steer) for each in made)
    resets = [_reset_of(each) if own else each.reset for each in made]
    singles: list[int] = []
    means: list[float] = []
    clock, dt = perf_counter_ns, run.dt
    was_on = gc.isenabled()
    gc.disable()
    try:
        for turn in range(1 + -(-_CALLS // len(table))):  # the first warms up
            for reset in resets:
                reset()
            for block in blocks:
                took = []
                for x, y, yaw, speed in block:
                    begin = clock()
                    single(x, y, yaw, speed, dt)
                    took.append(clock() - begin)
                begin = clock()
                for x, y, yaw, speed in block:
                    batched(x, y, yaw, speed, dt)
                if turn:
                    means.append((clock() - begin) / len(block))
                    singles += took
            progress(len(singles) / max(_CALLS, len(table)))
    finally:
        if was_on:
            gc.enable()
    return 1e-9 * float(np.median(means)), singles


def distances(path: Path, *driven: NDArray[Any]) -> NDArray[np.float64]:
    """Tell how far along a path a vehicle was [m], never less than before; as `arcs` takes it."""
    return np.maximum.accumulate(arcs(path, *driven))


def arcs(path: Path, *driven: NDArray[Any]) -> NDArray[np.float64]:
    """Give the arc lengths [m] of the closest points, from sample to sample, lap after lap.

    What was `driven` are the poses x, y, yaw [m, m, rad] and the speeds [m/s].
    """
    rows = np.column_stack(driven).tolist()
    found = np.empty(len(rows))
    laps, last, waypoint = 0.0, math.nan, -1
    for k, (px, py, heading, v) in enumerate(rows):
        if waypoint < 0:
            waypoint = path.relocalise(px, py, heading)
        driving = heading + math.pi if v < 0.0 else heading
        place = path.locate(px, py, driving, waypoint, _REACH)
        waypoint = place.segment
        if k == 0 and path.closed and path.length - place.arc_length < _REACH:
            laps = -path.length  # just before the start of its first lap
        if path.closed and last - place.arc_length > 0.5 * path.length:
            laps += path.length
        last = place.arc_length
        found[k] = laps + last
    return found
