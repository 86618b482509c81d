"""The table of comparisons, the paper's figures beside the measured ones."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from popsteer.lab.common.experiment import JOINED
from popsteer.lab.common.layout import (
    SIGN,
    WIDE,
    add_names,
    add_numbers,
    blank_table,
    fits,
    number,
    outcome,
)
from popsteer.lab.common.names import counted, differences, title_of, where_they_differ
from popsteer.lab.compare.comparison import Comparison
from popsteer.lab.compare.paper import PAPER, is_authors_path
from popsteer.sim import Run

if TYPE_CHECKING:
    from rich.table import Table


WHERE = (
    "Errors are measured at the point that each controller tracks, as the paper did, and at the"
    " rear axle, one point for all."
)
"""What a reader has to know of all errors."""


def caption(comparison: Comparison) -> str:
    """Say in one line what was compared: track, plant, vehicle believed, control period."""
    path = comparison.path
    name = f"{comparison.track}, " if comparison.track else ""
    believed = differences(comparison.believed, comparison.vehicle)
    return (
        f"{name}{len(path)} waypoints, {path.length:.0f} m, plant {comparison.plant}{believed}, "
        f"dt {comparison.dt:g} s"
    )


def heading(*comparisons: Comparison) -> str:
    """Say in one line what was compared: as `caption`, or how many plants and tracks."""
    first, *others = comparisons
    if not others:
        return caption(first)
    plants, tracks = ({getattr(each, of) for each in comparisons} for of in ("plant", "track"))
    driven = f"{counted(len(plants), 'plant')} and {counted(len(tracks), 'track')}"
    return f"{counted(len(first.runs), 'controller')} on {driven}, dt {first.dt:g} s"


def notes(*comparisons: Comparison) -> list[str]:
    """Say what a reader has to know of the figures."""
    ended, faulty = [], []
    for each in comparisons:
        where = f" on {each.plant}, {each.track}" if len(comparisons) > 1 else ""
        for name, run in each.runs.items():
            who, found = f"{title_of(name, each.runs)}{where}", run.metrics
            if not found.finished:
                ended.append(f"{SIGN} {who} came to an end after {found.time:.1f} s: {run.ending}.")
            if found.faults:
                named = ", ".join(found.faults.names)
                faulty.append(f"{SIGN} Fault of {who}: {named}{_while_faulty(run)}.")
    said = ended + faulty
    begun = (((each.plant, each.track), each.begins) for each in comparisons if each.begins)
    said += [*where_they_differ(begun), WHERE]
    first = comparisons[0]
    if first.joined:
        settling = first.first.settings.settling_time
        lengths = {each.vehicle.wheelbase for each in comparisons}
        far = f" ({JOINED * max(lengths):.3g} m)" if len(lengths) == 1 else ""
        said.append(
            f"In the first {settling:g} s the vehicle joins its path: it drives {JOINED:g}"
            f" wheelbases{far}."
        )
    if len(comparisons) > 1:
        believed = {each.plant: differences(each.believed, each.vehicle) for each in comparisons}
        return said + [f"{plant}{which}" for plant, which in believed.items() if which]
    (comparison,) = comparisons
    if "pid" in comparison.runs and is_authors_path(comparison.path):
        said.append(
            "The paper's PID row could not be reproduced; with the gains of its table and Δt in the"
            " integral, PID tracks as closely as POP."
        )
    return said


def _while_faulty(run: Run) -> str:
    """Say how far off the path it was while its faults held, with time and place."""
    held = np.flatnonzero(run.records["status"] & np.uint32(run.metrics.faults))
    if not len(held):  # the records were not kept
        return ""
    errors = np.abs(run.records["cross_track_error"][held])
    time, x, y = (run.records[name][held[np.argmax(errors)]] for name in ("time", "x", "y"))
    place = f"{time:.1f} s and ({x:.1f}, {y:.1f})"
    return f"; up to {errors.max():.2f} m off its path while that held, at {place}"


def tables(*comparisons: Comparison, width: int = WIDE) -> list[Table]:
    """Set out the figures, the best of a column bold; several tables where one is wider.

    Of one comparison they are of some columns each, of several of one comparison each. Where
    several runs are equal to the last digit shown, none is the best.
    """
    first, *others = comparisons
    more = _more(first.first.settings.settling_time, several=bool(others))
    if any(each.step_times for each in comparisons):
        more.append(_step_time(comparisons))
    if others:
        whole = _table(comparisons, more, named=True)
        parts = [_table([each], more, titled=True) for each in comparisons]
    else:
        # On another track the paper's figures would be no target.
        there = is_authors_path(first.path)
        against_paper = [each for each in _AGAINST_PAPER if there or not each.of_paper]
        whole = _table(comparisons, against_paper + more)
        parts = [_table(comparisons, against_paper), _table(comparisons, more, told=False)]
    return [whole] if fits(whole, width) else parts


def _table(
    comparisons: Sequence[Comparison],
    columns: list[_Column],
    *,
    told: bool = True,
    named: bool = False,
    titled: bool = False,
) -> Table:
    """Set out some columns, after tuning and place of measurement where that is `told`.

    Plant and track are columns where they are `named`, or the table is `titled` by them.
    """
    from rich.text import Text

    table = blank_table(0 if titled else 1)
    if titled:
        table.title = f"plant {comparisons[0].plant} | track {comparisons[0].track}"
        table.title_justify, table.title_style = "left", "bold"
    if named:
        add_names(table, "plant", (each.plant for each in comparisons))
        add_names(table, "track", (each.track for each in comparisons))
    titles = (title_of(name, each.runs) for each in comparisons for name in each.runs)
    add_names(table, "controller", titles)
    if told:
        table.add_column("outcome", overflow="fold")
        add_names(table, "tuning", (of for each in comparisons for of in each.tuning.values()))
        add_names(table, "errors\nat", (of for each in comparisons for of in each.points.values()))
    add_numbers(table, *(column.head for column in columns))
    for comparison in comparisons:
        best = [_best(comparison, column) for column in columns]
        for name, run in comparison.runs.items():
            cells = [Text(comparison.plant), Text(comparison.track)] if named else []
            cells.append(Text(title_of(name, comparison.runs)))
            if told:
                cells.append(outcome(run.metrics.faults, finished=run.metrics.finished))
                cells += [Text(comparison.tuning[name]), Text(comparison.points[name])]
            for column, least in zip(columns, best, strict=True):
                value = column.value(run)
                style = "bold" if value is not None and value == least else ""
                cells.append(Text(column.show(run), style=style))
            table.add_row(*cells)
    return table


class _Column(NamedTuple):
    """A column: its head, where its numbers come from, and how they are shown."""

    head: str
    value: Callable[[Run], float | None]
    form: str
    ranked: bool = False
    """Whether less is better."""
    of_paper: bool = False
    """Whether it says something of the paper's track alone."""

    def show(self, run: Run) -> str:
        """Show the number of a run; a dash where there is none."""
        return number(self.value(run), self.form)


def _best(comparison: Comparison, column: _Column) -> float | None:
    """Find the least figure of the runs without a fault that finished; None where several show it.

    Only a column that is ranked has one, of several runs.
    """
    runs = comparison.runs.values()
    sound = [run for run in runs if run.metrics.finished and not run.metrics.faults]
    shown = [(value, column.show(run)) for run in sound if (value := column.value(run)) is not None]
    if not column.ranked or len(runs) < 2 or not shown:
        return None
    least, said = min(shown)
    return None if [word for _, word in shown].count(said) > 1 else least


def _metric(head: str, name: str, form: str, scale: float = 1.0) -> _Column:
    """Make a column of a figure of `popsteer.sim.Metrics` that is the better the less it is."""
    return _Column(head, lambda run: scale * getattr(run.metrics, name), form, ranked=True)


def _of_paper(name: str) -> Callable[[Run], float | None]:
    return lambda run: getattr(PAPER.get(run.law), name, None)


def _ratio(run: Run) -> float | None:
    paper = _of_paper(_CROSS)(run)
    return None if paper is None else run.metrics.mean_abs_cross_track_error / paper


_CROSS, _HEADING = "mean_abs_cross_track_error", "mean_abs_heading_error"
_AGAINST_PAPER = [
    _metric("mean\n|e|\n[m]", _CROSS, ".4f"),
    _Column("paper\n\n[m]", _of_paper(_CROSS), ".4f", of_paper=True),
    _Column("ratio\n\n", _ratio, ".2f", of_paper=True),
    _metric("mean\n|ψe|\n[rad]", _HEADING, ".4f"),
    _Column("paper\n\n[rad]", _of_paper(_HEADING), ".4f", of_paper=True),
]
_DEGREES = math.degrees(1.0)


def _step_time(comparisons: Sequence[Comparison]) -> _Column:
    times = {
        id(run): each.step_times.get(name, math.nan)
        for each in comparisons
        for name, run in each.runs.items()
    }
    return _Column("step\np50\n[µs]", lambda run: 1e6 * times[id(run)], ".2f", ranked=True)


def _more(settling_time: float, *, several: bool) -> list[_Column]:
    """Give the columns of several comparisons, or those of one besides `_AGAINST_PAPER`."""
    since = f"after\n{settling_time:g} s"
    settled = [
        _metric(f"{since}\n[m]", f"settled_{_CROSS}", ".4f"),
        _metric(f"max [m]\n{since}", "settled_max_abs_cross_track_error", ".3f"),
    ]
    rate = _metric("rms\nδ rate\n[deg/s]", "rms_steer_rate", ".1f", _DEGREES)
    if several:
        rear = _metric(f"rear\n{since}", f"rear_axle_settled_{_CROSS}", ".4f")
        return [*settled, rear, rate]
    return [
        _metric("rms\ne\n[m]", "rms_cross_track_error", ".3f"),
        _metric("max\n|e|\n[m]", "max_abs_cross_track_error", ".2f"),
        *settled,
        _metric("rear\naxle\n[m]", f"rear_axle_{_CROSS}", ".4f"),
        _metric("max\n|δ|\n[deg]", "max_abs_steer", ".1f", _DEGREES),
        rate,
        _Column("time\n\n[s]", lambda r: r.metrics.time, ".1f"),
    ]
