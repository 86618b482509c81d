"""The figures of a comparison as JSON, for programs."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from popsteer._core import __version__
from popsteer.lab.common.layout import json_text
from popsteer.lab.compare.paper import PAPER
from popsteer.status import Status

if TYPE_CHECKING:
    from popsteer.lab.compare import Comparison
    from popsteer.sim import Metrics, Run

SCHEMA = 2
"""Version of the layout; a change that would mislead readers of the old one raises it.

2: `start` is the pose of the vehicle's point, no longer that of the front axle.
"""

_REAR = "rear_axle_"


def metrics_document(comparison: Comparison) -> dict[str, Any]:
    """Lay out the figures of a comparison.

    The document has `schema`, `dt` [s], `plant`, `plant_vehicle` (what it is), `path` with
    `waypoints` and `length` [m], `start` (pose of the vehicle's point), `controllers` with the
    metrics of each controller in SI units and radians (those of the rear axle under `rear_axle`,
    the vehicle that it believed under `vehicle`, the median time of a step under `step_time` [s]
    where that was measured; `faults` lists by name what the controller said), and `paper` with the
    paper's figures. A number that is not finite is None.
    """
    path = comparison.path
    return {
        "schema": SCHEMA,
        "version": __version__,
        "dt": comparison.dt,
        "plant": comparison.plant,
        "plant_vehicle": comparison.vehicle.as_dict(),
        "preset": comparison.preset,
        "path": {
            "name": comparison.track,
            "waypoints": len(path),
            "length": path.length,
            "closed": path.closed,
        },
        "start": dict(zip(("x", "y", "yaw"), comparison.first.start, strict=True)),
        "controllers": {
            name: _controller(run)
            # Times differ from run to run; without them the file is the same each time.
            | ({"step_time": times[name]} if name in (times := comparison.step_times) else {})
            for name, run in comparison.runs.items()
        },
        "paper": {name: figures._asdict() for name, figures in PAPER.items()},
    }


def metrics_json(comparison: Comparison) -> str:
    """Write `metrics_document` as JSON."""
    document = metrics_document(comparison)
    return json_text(document)


def _controller(run: Run) -> dict[str, Any]:
    """Lay out one run: its metrics, and the controller's tuning and vehicle."""
    params = {name: _finite(value) for name, value in run.params.items()}
    vehicle = None if run.vehicle is None else run.vehicle.as_dict()
    raised = {"traceback": run.traceback} if run.traceback else {}
    return {
        **_metrics(run.metrics),
        "ending": run.ending,
        **raised,
        "params": params,
        "vehicle": vehicle,
    }


def _metrics(metrics: Metrics) -> dict[str, Any]:
    plain: dict[str, Any] = {}
    rear: dict[str, Any] = {}
    for name, value in asdict(metrics).items():
        if name.startswith(_REAR):
            rear[name.removeprefix(_REAR)] = _finite(value)
        elif isinstance(value, Status):
            plain[name] = list(value.names)
        else:
            plain[name] = _finite(value)
    return {**plain, "rear_axle": rear}


def _finite(value: object) -> object:
    """Give None for what JSON has no number for."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
