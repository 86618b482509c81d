"""The time of the controllers' steps: a histogram, and percentiles."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from popsteer.lab.common.machine import describe
from popsteer.lab.common.names import title_of
from popsteer.lab.report.axes import log_axis, rounded
from popsteer.lab.report.markup import paragraphs, plain_table

if TYPE_CHECKING:
    from popsteer.lab.compare import Comparison

_PER_DECADE = 20
_SHARES = (50.0, 90.0, 99.0, 99.9)


def latency_figure(comparison: Comparison) -> list[dict[str, Any]]:
    """Draw how long the steps took, where they were timed; else nothing."""
    if not comparison.latencies:
        return []
    times = {name: np.array(each) * 1e-3 for name, each in comparison.latencies.items()}
    # A clock that is coarse may read 0.
    times = {name: np.maximum(each, 1e-3) for name, each in times.items()}
    low = math.floor(_PER_DECADE * math.log10(min(each.min() for each in times.values())))
    high = math.ceil(_PER_DECADE * math.log10(max(each.max() for each in times.values())))
    edges = 10.0 ** (np.arange(low, high + 2) / _PER_DECADE)
    # What the machine did meanwhile may take a thousand times as long; the table tells of it.
    usual = 1.5 * max(float(np.percentile(each, 99.9)) for each in times.values())
    most = max(float(each.max()) for each in times.values())
    beyond = f" Single ones took up to {most:.0f} µs: double-click." if most > usual else ""
    axis = log_axis("time of a step [µs]", edges[0], edges[-1])
    axis["range"] = [math.log10(edges[0]), math.log10(min(usual, edges[-1]))]
    traces = []
    for name, each in times.items():
        counts, _ = np.histogram(each, edges)
        shares = 100.0 * counts / len(each)
        traces.append(
            {
                "type": "scatter",
                "mode": "lines",
                "name": title_of(name),
                # Up at the first edge; a step holds until the next one.
                "x": rounded((edges[0], *edges)),
                "y": [round(float(share), 3) for share in (0.0, *shares, 0.0)],
                "line": {"color": f"@{name}", "shape": "hv", "width": 2},
                "hovertemplate": "%{y:.1f} % of the steps from %{x:.3g} µs",
            }
        )
    return [
        {
            "title": "Time of a control step",
            "note": f"Share of the steps, as the clock read each; {_machine()}.{beyond}",
            "traces": traces,
            "layout": {
                "xaxis": axis,
                "yaxis": {"title": {"text": "steps [%]"}, "rangemode": "tozero"},
            },
        }
    ]


def latency_table(comparison: Comparison) -> str:
    """Set out percentiles of the times as HTML, where steps were timed; else nothing."""
    if not comparison.latencies:
        return ""
    rows = []
    for name, each in comparison.latencies.items():
        values = np.percentile(np.array(each), _SHARES, method="higher")
        net = 1e6 * comparison.step_times[name]
        cells = (f"{net:.2f}", *(f"{1e-3 * value:.2f}" for value in values))
        rows.append((title_of(name), *cells, f"{1e-3 * max(each):.1f}", str(len(each))))
    heads = ("controller", "net median [µs]", *(f"p{share:g} [µs]" for share in _SHARES))
    note = (
        "Steps of fresh controllers on the states of their own runs. p50 to max are of single"
        " calls and hold one reading of the clock each; the net median does not."
    )
    shown = plain_table("Time of a control step, percentiles", (*heads, "max [µs]", "calls"), rows)
    return shown + paragraphs([note])


def _machine() -> str:
    on = describe()
    return f"{on['cpu']}, {on['cores']} cores, {on['python']}"
