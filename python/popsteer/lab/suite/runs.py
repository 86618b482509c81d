"""All cells of a suite: scenarios × conditions × plants × controllers."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from popsteer._core import KinematicBicycle
from popsteer.errors import ConfigError
from popsteer.lab.common.experiment import Adapt, Monitor, controller
from popsteer.lab.common.names import law_of
from popsteer.lab.suite.drive import GIVE_UP, Driven, drive, seed_of
from popsteer.lab.suite.scenarios import CONDITIONS, SCENARIOS, suite_car
from popsteer.ranges import check_known
from popsteer.sim.geometry import object_of

SUITE_CAR = "suite-car"
PLANTS = (SUITE_CAR, "carla-identified")
"""The plants of standard-2."""
# The least error that counts as a success [m], in wheelbases: half of one, as `deviating`.
_WITHIN = 0.5
# Smaller errors count as this [m].
_LEAST = 1e-5


def names() -> tuple[str, ...]:
    """Name the suites."""
    return ("standard-2",)


@dataclass(frozen=True)
class Cell:
    """One controller in one scenario under one condition on one plant; errors of the rear axle."""

    scenario: str
    condition: str
    plant: str
    controller: str
    mean_error: float
    """Mean of the absolute cross-track error [m]; `GIVE_UP` where it did not reach the end."""
    max_error: float
    """Largest absolute cross-track error [m], up to where it ended."""
    end_error: float
    """Absolute cross-track error of the last step [m]."""
    steer_rate: float
    """Root mean square of the rate of the command [rad/s]."""
    lateral_jerk: float
    """Root mean square of the change of the lateral acceleration [m/s³]."""
    faults: float
    """Share of the steps with a fault."""
    success: bool
    """Whether it reached the end without a fault, within half a wheelbase, or its start."""
    ending: str
    """How it ended."""


@dataclass(frozen=True, eq=False)
class Suite:
    """What a suite came to."""

    name: str
    cells: Sequence[Cell]
    step_times: Mapping[str, float]
    """Median time of a step by controller [s], over all runs; of this machine."""
    tracebacks: Sequence[str]
    """What code of your own raised, each once."""


def run(
    names: Sequence[str] | Mapping[str, Any],
    plants: Sequence[str] | Mapping[str, Any] = PLANTS,
    *,
    scenarios: Sequence[str] | None = None,
    conditions: Sequence[str] | None = None,
    adapt: Adapt = "auto",
    monitor: Monitor = "auto",
    progress: Callable[[str, float], object] | None = None,
) -> Suite:
    """Drive every controller in every scenario, under every condition, on every plant.

    Parameters
    ----------
    names : sequence of str, or mapping of str to parameters
        The controllers, as `popsteer.lab.compare.run` has them; a mapping gives each its tuning. A
        controller of popsteer has its defaults otherwise, not a preset of the paper.
    plants : sequence of str, or mapping of str to plants
        What moves; ``suite-car`` is the suite's own.
    scenarios, conditions : sequence of str, optional
        Some of `SCENARIOS` and `CONDITIONS`; all by default. A cell is the same whatever else is
        driven.
    adapt, monitor : parameters or None, optional
        How the controllers of popsteer adapt and watch for faults, as `popsteer.lab.compare.run`
        has it.
    progress : callable, optional
        Called now and then with what is being done and the share of all that is done, 0 to 1.

    Returns
    -------
    Suite
        The cells.

    Raises
    ------
    ConfigError
        A name is not known; nothing was driven then.
    PopsteerError
        A controller or a plant needs what is not installed.
    """
    roads = _chosen("scenario", scenarios, SCENARIOS)
    under = _chosen("condition", conditions, CONDITIONS)
    kinds: dict[str, Any] = {name: law_of(name) for name in names}  # with its own parameters
    given = names if isinstance(names, Mapping) else {k: kind.params() for k, kind in kinds.items()}
    movers = dict(plants) if isinstance(plants, Mapping) else {name: name for name in plants}
    parts = {"controllers": kinds, "plants": movers, "scenarios": roads, "conditions": under}
    if lacking := [field for field, part in parts.items() if not part]:
        raise ConfigError(lacking[0], [], "at least one")
    moved = {
        k: suite_car() if isinstance(v, str) and v == SUITE_CAR else object_of(v)
        for k, v in movers.items()
    }
    how: Any = {"adapt": adapt, "monitor": monitor}
    makers = {name: partial(controller, name, params=given[name], **how) for name in kinds}
    # A plant that does not reverse has no cells where the path is driven backwards.
    places = [
        (road, condition, plant)
        for road, condition, (plant, mover) in itertools.product(roads, under, moved.items())
        if SCENARIOS[road].path().reverse is None
        or getattr(mover, "reverses", isinstance(mover, KinematicBicycle))
    ]
    cells: list[Cell] = []
    times: dict[str, list[float]] = {name: [] for name in makers}
    traces: dict[str, None] = {}
    total = len(places) * len(makers)
    for road, condition, plant in places:
        for name, make in makers.items():
            if progress is not None:
                progress(f"{road}, {condition}, {plant}: {name}", len(cells) / total)
            scenario, under_it = SCENARIOS[road], CONDITIONS[condition]
            found = drive(scenario, under_it, moved[plant], make, seed_of(road, condition))
            cells.append(_cell(road, condition, plant, name, found))
            times[name].append(found.step_time)
            if found.traceback:
                traces[found.traceback] = None
    if not places:
        said = "one that drives backwards, as these scenarios are"
        raise ConfigError("plants", list(moved), said)
    middle = {name: sorted(each)[len(each) // 2] for name, each in times.items()}
    return Suite("standard-2", cells, middle, list(traces))


def _chosen(what: str, wanted: Sequence[str] | None, known: Mapping[str, Any]) -> list[str]:
    for name in wanted or ():
        check_known(what, name, known)
    return list(known if wanted is None else wanted)


def _cell(scenario: str, condition: str, plant: str, name: str, found: Driven) -> Cell:
    metrics = found.metrics
    aside = abs(SCENARIOS[scenario].start_offset)
    largest = metrics.rear_axle_max_abs_cross_track_error
    reached = metrics.finished and not found.traceback
    error = metrics.rear_axle_mean_abs_cross_track_error if reached else GIVE_UP
    within = largest <= max(_WITHIN * found.wheelbase, aside + 0.1)
    copied = ("end_error", "steer_rate", "lateral_jerk", "faults", "ending")
    alike: dict[str, Any] = {each: getattr(found, each) for each in copied}
    success = reached and not found.faults and within
    return Cell(scenario, condition, plant, name, error, largest, success=success, **alike)


def mean_error(cells: Iterable[Cell]) -> float:
    """Give the geometric mean of the mean errors [m]; not a number of no cells."""
    logs = [math.log(max(each.mean_error, _LEAST)) for each in cells]
    return math.exp(sum(logs) / len(logs)) if logs else math.nan


def grouped(cells: Iterable[Cell], field: str) -> dict[str, list[Cell]]:
    """Give the cells by one of their fields, in the order in which its values come."""
    groups: dict[str, list[Cell]] = {}
    for each in cells:
        groups.setdefault(getattr(each, field), []).append(each)
    return groups


def rows(found: Suite) -> list[tuple[str, dict[str, list[Cell]]]]:
    """Give the cells of each scenario, condition and plant of several, then all, by controller."""
    known: dict[str, Any] = {"scenario": SCENARIOS, "condition": CONDITIONS}
    parts = [
        (known[field][name].title if field in known else f"On {name}", cells)
        for field in ("scenario", "condition", "plant")
        for name, cells in grouped(found.cells, field).items()
        if field != "plant" or len(cells) < len(found.cells)
    ]
    parts.append(("All", list(found.cells)))
    return [(title, grouped(cells, "controller")) for title, cells in parts]


def leaders(cells: Mapping[str, Sequence[Cell]]) -> list[str]:
    """Name who has the least error in a row, and who cannot be told from it.

    Those are within the 95 % interval of the ratio to its errors, cell by cell, by the bootstrap:
    B. Efron, *Bootstrap Methods: Another Look at the Jackknife*, 1979.
    """
    logs = {
        name: np.log([max(each.mean_error, _LEAST) for each in own]) for name, own in cells.items()
    }
    best = min(logs, key=lambda name: float(logs[name].mean()))
    count = len(logs[best])
    drawn = np.random.default_rng(0).integers(count, size=(2000, count))
    low = {k: np.quantile((own - logs[best])[drawn].mean(axis=1), 0.025) for k, own in logs.items()}
    return [best, *(name for name in cells if name != best and low[name] <= 0.0)]
