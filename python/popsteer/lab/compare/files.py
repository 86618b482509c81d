"""The files of comparisons, all computed before the first is written."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict
from functools import partial
from itertools import chain, count
from statistics import median
from typing import Any

from popsteer._core import __version__
from popsteer.errors import ConfigError
from popsteer.lab.common.layout import (
    csv_columns,
    csv_text,
    figure_names,
    finite,
    json_text,
    number,
    this_machine,
)
from popsteer.lab.common.names import title_of
from popsteer.lab.compare.comparison import Comparison
from popsteer.lab.compare.paper import PAPER
from popsteer.sim import Metrics, Run
from popsteer.status import Status

_METRICS, _MATRIX = "metrics.json", "matrix"
_DRAWN = ("results", "overview")


def files(
    *comparisons: Comparison, progress: Callable[[str, float], object] | None = None
) -> dict[str, bytes]:
    """Compute the files: of one comparison its records, of several a matrix.

    `progress` is called with what is being done and the share of it that is done, 0 to 1. Raises
    ConfigError where the runs kept no records.
    """
    from popsteer.lab.common.draw import files_of
    from popsteer.lab.compare.figures import effort_figure, overview_figure, results_figure

    comparison, *others = comparisons
    if others:
        content = files_of({_MATRIX: partial(effort_figure, comparisons)}, progress)
        content[f"{_MATRIX}.csv"] = _matrix_csv(comparisons).encode()
        content[f"{_MATRIX}.md"] = _matrix_markdown(comparisons).encode()
        document = {
            "schema": SCHEMA,
            "version": __version__,
            "machine": this_machine(),
            "constant_speed": comparison.constant_speed,
            "comparisons": [metrics_document(each) for each in comparisons],
        }
        content[f"{_MATRIX}.json"] = json_text(document).encode()
        return content
    if not comparison.first.settings.keep_records:
        raise ConfigError("keep_records", value=False, requirement="true where files are wanted")
    named = zip(_record_names(comparison.runs), comparison.runs.values(), strict=True)
    content = {name: run_csv(run).encode() for name, run in named}
    figures = zip(_DRAWN, (results_figure, overview_figure), strict=True)
    content |= files_of({name: partial(draw, comparison) for name, draw in figures}, progress)
    # Written last: where it exists, the others do too.
    content[_METRICS] = json_text(metrics_document(comparison)).encode()
    return content


def file_names(laws: Iterable[str], *, several: bool = False) -> list[str]:
    """Name the files: records of each controller, the figures for both backgrounds, the metrics.

    Those of `several` comparisons are a figure and tables of all.
    """
    if several:
        return [*(f"{_MATRIX}.{kind}" for kind in ("csv", "md", "json")), *figure_names(_MATRIX)]
    figures = [name for figure in _DRAWN for name in figure_names(figure)]
    return [*_record_names(laws), *figures, _METRICS]


def _record_names(laws: Iterable[str]) -> list[str]:
    """Name a file for each controller, also where names differ in what no file is called by."""
    found: dict[str, str] = {}
    for law in laws:
        stem = re.sub(r"[^A-Za-z0-9._-]+", "-", law)
        others = (f"{stem}-{k}" for k in count(2))
        name = next(each for each in chain([stem], others) if each.lower() not in found)
        found[name.lower()] = f"runs/{name}.csv"
    return list(found.values())


_UNITS = {
    **dict.fromkeys(("x", "y", "reference_x", "reference_y", "target_x", "target_y"), "m"),
    **dict.fromkeys(("cross_track_error", "rear_cross_track_error"), "m"),
    **dict.fromkeys(("yaw", "steer", "heading_error", "rear_heading_error"), "rad"),
    **dict.fromkeys(("throttle", "brake"), "0 to 1"),
    "time": "s",
    "speed": "m/s",
    "status": "bits: " + " | ".join(f"{int(each)} {each}" for each in Status if each),
}


def run_csv(run: Run) -> str:
    """Write the records of a run as CSV, a row for each control step, to the last bit."""
    units = ", ".join(f"{name} [{_UNITS[name]}]" for name in run.records)
    head = f"{' '.join(run.law.split())} on {run.plant}, dt = {run.dt:g} s"
    return csv_columns([head, units], run.records)


SCHEMA = 3
"""Version of the layout; a change that would mislead readers of the old one raises it.

2: `start` is the pose of the vehicle's point, no longer that of the front axle. 3: the tuning
stands with each controller, in place of a `preset` of all.
"""

_REAR = "rear_axle_"


def metrics_document(comparison: Comparison) -> dict[str, Any]:
    """Lay out a comparison in SI units and radians; numbers that are not finite are None."""
    path = comparison.path
    return {
        "schema": SCHEMA,
        "version": __version__,
        "dt": comparison.dt,
        "plant": comparison.plant,
        "plant_vehicle": comparison.vehicle.as_dict(),
        "path": {
            "name": comparison.track,
            "waypoints": len(path),
            "length": path.length,
            "closed": path.closed,
        },
        "start": dict(zip(("x", "y", "yaw"), comparison.first.start, strict=True)),
        "controllers": {
            name: {"tuning": comparison.tuning[name], "errors_at": comparison.points[name]}
            | _controller(run)
            # Times differ from run to run; without them the file is the same each time.
            | ({"step_time": times[name]} if name in (times := comparison.step_times) else {})
            for name, run in comparison.runs.items()
        },
        "paper": {name: figures._asdict() for name, figures in PAPER.items()},
    }


def _controller(run: Run) -> dict[str, Any]:
    """Lay out one run: its metrics, and the controller's tuning and vehicle."""
    metrics = asdict(run.metrics)
    rear = {name: metrics.pop(name) for name in list(metrics) if name.startswith(_REAR)}
    metrics["faults"] = list(run.metrics.faults.names)
    return {
        **{name: finite(value) for name, value in metrics.items()},
        "rear_axle": {name.removeprefix(_REAR): finite(value) for name, value in rear.items()},
        "ending": run.ending,
        **({"traceback": run.traceback} if run.traceback else {}),
        "params": {name: finite(value) for name, value in run.params.items()},
        "vehicle": None if run.vehicle is None else run.vehicle.as_dict(),
    }


_REAR_SETTLED = "rear_axle_settled_mean_abs_cross_track_error"
_SETTLED = "settled_mean_abs_cross_track_error"
_COLUMNS = (
    *("mean_abs_cross_track_error", _SETTLED, "settled_max_abs_cross_track_error", _REAR_SETTLED),
    "rms_steer_rate",
)


def _matrix_csv(comparisons: Sequence[Comparison]) -> str:
    rows = [
        [
            *(each.plant, each.track, name, each.tuning[name], each.points[name]),
            *(repr(getattr(run.metrics, column)) for column in _COLUMNS),
            *([repr(each.step_times.get(name, math.nan))] if each.step_times else []),
            run.ending,
        ]
        for each in comparisons
        for name, run in each.runs.items()
    ]
    timed = comparisons[0].step_times
    names = ("plant", "track", "law", "tuning", "errors_at", *_COLUMNS)
    heads = [*names, *(["step_time"] if timed else []), "ending"]
    return csv_text([f"SI units: m, rad/s{', s' if timed else ''}"], heads, rows)


def _matrix_markdown(comparisons: Sequence[Comparison]) -> str:
    """Set out a table for each track: errors after settling, where measured / at the rear axle."""
    plants = list(dict.fromkeys(each.plant for each in comparisons))
    timed = bool(comparisons[0].step_times)
    tables = []
    for track in dict.fromkeys(each.track for each in comparisons):
        here = [each for each in comparisons if each.track == track]
        heads = [track, "errors at", *plants, *(["step [µs]"] if timed else [])]
        lines = [heads, ["---", "---", *["--:"] * (len(heads) - 2)]]
        for law in here[0].runs:
            metrics = [each.runs[law].metrics for each in here]
            cells = [
                f"{_error(each, _SETTLED)} / {_error(each, _REAR_SETTLED)}" for each in metrics
            ]
            points = ", ".join(dict.fromkeys(each.points[law] for each in here))
            times = [each.step_times.get(law, math.nan) for each in here]
            time = [f"{1e6 * median(times):.2f}"] if timed else []
            lines.append([title_of(law, here[0].runs), points, *cells, *time])
        tables.append("".join(f"| {' | '.join(line)} |\n" for line in lines))
    on = this_machine()
    machine = [f"{on['cpu']}, {on['cores']} cores; {on['python']}.\n"] if timed else []
    return "\n".join(tables + machine)


def _error(metrics: Metrics, name: str) -> str:
    """Show a mean error after settling; of a run that did not finish in brackets."""
    said = number(getattr(metrics, name), ".4f")
    return said if metrics.finished or said == "–" else f"({said})"
