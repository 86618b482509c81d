"""The files of a comparison, all computed before the first is written."""

from __future__ import annotations

import re
from dataclasses import asdict
from functools import partial
from itertools import chain, count
from typing import TYPE_CHECKING, Any

import numpy as np

from popsteer._core import __version__
from popsteer.errors import ConfigError
from popsteer.lab.common.layout import csv_text, figure_names, finite, json_text
from popsteer.lab.compare.paper import PAPER
from popsteer.status import Status

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from popsteer.lab.compare import Comparison
    from popsteer.sim import Metrics, Run

_METRICS = "metrics.json"
_DRAWN = ("results", "overview")


def files(
    comparison: Comparison, progress: Callable[[str, float], object] | None = None
) -> dict[str, bytes]:
    """Compute the files of a comparison, by the names of `file_names`.

    `progress` is called with what is being done and the share of it that is done, 0 to 1. Raises
    ConfigError where the runs kept no records.
    """
    from popsteer.lab.common.draw import files_of
    from popsteer.lab.compare.figures import overview_figure, results_figure

    if not comparison.first.settings.keep_records:
        raise ConfigError("keep_records", value=False, requirement="true where files are wanted")
    named = zip(_record_names(comparison.runs), comparison.runs.values(), strict=True)
    content = {name: run_csv(run).encode() for name, run in named}
    figures = zip(_DRAWN, (results_figure, overview_figure), strict=True)
    content |= files_of({name: partial(draw, comparison) for name, draw in figures}, progress)
    # Written last: where it exists, the others do too.
    content[_METRICS] = metrics_json(comparison).encode()
    return content


def file_names(laws: Iterable[str]) -> list[str]:
    """Name the files: records of each controller, the figures for both backgrounds, the metrics."""
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
    "time": "s",
    "x": "m",
    "y": "m",
    "yaw": "rad",
    "speed": "m/s",
    "steer": "rad",
    "throttle": "0 to 1",
    "brake": "0 to 1",
    "reference_x": "m",
    "reference_y": "m",
    "cross_track_error": "m",
    "heading_error": "rad",
    "rear_cross_track_error": "m",
    "rear_heading_error": "rad",
    "target_x": "m",
    "target_y": "m",
    "status": "bits: " + " | ".join(f"{int(each)} {each}" for each in Status if each),
}


def run_csv(run: Run) -> str:
    """Write the records of a run as CSV, a row for each control step, to the last bit."""
    units = ", ".join(f"{name} [{_UNITS[name]}]" for name in run.records)
    head = f"{' '.join(run.law.split())} on {run.plant}, dt = {run.dt:g} s"
    columns = [np.asarray(column).tolist() for column in run.records.values()]
    rows = (map(repr, row) for row in zip(*columns, strict=True))
    return csv_text([head, units], run.records, rows)


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


def metrics_json(comparison: Comparison) -> str:
    """Write `metrics_document` as JSON."""
    return json_text(metrics_document(comparison))


def _controller(run: Run) -> dict[str, Any]:
    """Lay out one run: its metrics, and the controller's tuning and vehicle."""
    return {
        **_metrics(run.metrics),
        "ending": run.ending,
        **({"traceback": run.traceback} if run.traceback else {}),
        "params": {name: finite(value) for name, value in run.params.items()},
        "vehicle": None if run.vehicle is None else run.vehicle.as_dict(),
    }


def _metrics(metrics: Metrics) -> dict[str, Any]:
    plain: dict[str, Any] = {}
    rear: dict[str, Any] = {}
    for name, value in asdict(metrics).items():
        if name.startswith(_REAR):
            rear[name.removeprefix(_REAR)] = finite(value)
        else:
            plain[name] = list(value.names) if isinstance(value, Status) else finite(value)
    return {**plain, "rear_axle": rear}
