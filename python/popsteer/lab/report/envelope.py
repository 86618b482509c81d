"""The worst run of a sweep within the envelope of the others."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from popsteer.lab.report.axes import rounded
from popsteer.lab.report.scene import distances
from popsteer.lab.sweep.driving import repeat
from popsteer.lab.sweep.summary import worst

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from popsteer.lab.sweep import Job

_POINTS = 400
_MOST = {True: 100, False: 12}  # runs driven again, by whether the core drives them: about 2 s


def envelope_figure(
    job: Job, rows: Sequence[dict[str, Any]], progress: Callable[[float], object] | None = None
) -> dict[str, Any]:
    """Draw the cross-track error of the worst run along the path, and what others span.

    All runs are driven again for it, or an even choice where they are many. `progress` is called
    with the share of them that is done.
    """
    last = worst(rows, 1)[0]["run"]
    runs = [row["run"] for row in rows]
    runs = runs[:: -(-len(runs) // _MOST[job.is_of_core])]
    curves = []
    for done, run in enumerate([last, *runs]):
        if progress is not None:
            progress(done / (1 + len(runs)))
        records = repeat(job, run).records
        along = distances(job.path, *(records[name] for name in ("x", "y", "yaw", "speed")))
        curves.append((along, records["cross_track_error"]))
    ends = [along[[0, -1]] for along, _ in curves if len(along)] or [np.zeros(2)]
    grid = np.linspace(np.min(ends), np.max(ends), _POINTS)
    nothing = np.full(_POINTS, np.nan)
    values = np.array(
        [
            np.interp(grid, *curve, left=np.nan, right=np.nan) if len(curve[0]) else nothing
            for curve in curves
        ]
    )
    low, high = np.fmin.reduce(values), np.fmax.reduce(values)
    which = "all runs" if len(runs) == len(rows) else f"{len(runs)} of {len(rows)} runs and it"
    band = {"type": "scatter", "mode": "lines", "line": {"color": "@faint", "width": 0.5}}
    return {
        "title": "The worst run within the envelope",
        "note": f"Cross-track error along the path; the envelope is of {which}, driven again.",
        "traces": [
            band | _points(grid, low) | {"showlegend": False, "hoverinfo": "skip"},
            band
            | _points(grid, high)
            | {"name": "envelope", "fill": "tonexty", "hoverinfo": "skip"},
            {
                "type": "scatter",
                "mode": "lines",
                "name": f"worst: run {last}",
                "line": {"color": "@bad", "width": 1.6},
                "hovertemplate": "%{y:.3g} m at %{x:.4g} m",
                **_points(grid, values[0]),
            },
        ],
        "layout": {
            "xaxis": {"title": {"text": "distance along the path [m]"}},
            "yaxis": {"title": {"text": "cross-track error [m]"}},
        },
    }


def _points(x: Any, y: Any) -> dict[str, list[float]]:  # noqa: ANN401 - arrays
    there = np.isfinite(y)
    return {"x": rounded(x[there]), "y": rounded(y[there])}
