"""The page of comparisons: each controller a car on the map of each plant and track."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape
from itertools import cycle
from typing import Any

import numpy as np

from popsteer.errors import ConfigError
from popsteer.lab.common.layout import number, this_machine
from popsteer.lab.common.names import counted, title_of
from popsteer.lab.compare import Comparison
from popsteer.lab.compare.comparison import distances
from popsteer.lab.compare.table import heading, notes, tables
from popsteer.lab.report.colours import Colour, colours_of, dots, figure, log_axis, stairs
from popsteer.lab.report.markup import badge, html_table, paragraphs, plain_table, table
from popsteer.lab.report.page import NOWHERE, Origin, Page, settings_block, tuning, vehicles
from popsteer.lab.report.scene import ANGLES, Actor, Panel, Scene
from popsteer.sim import Run

_MARKERS = ("circle", "square", "diamond", "triangle-up", "cross", "star", "hexagon", "x")
PANELS = (
    Panel("cross_track_error", "Cross-track error [m]", "e [m]", 3),
    Panel("heading_error_deg", "Heading error [deg]", "ψe [deg]", 2),
    ANGLES,
    Panel("speed", "Speed [m/s]", "v [m/s]", 2),
    Panel("status", "Status", "status"),
)
"""What is drawn of a run."""


def of_comparison(*comparisons: Comparison, origin: Origin = NOWHERE) -> bytes:
    """Make the page of a comparison, or of several, whose maps are chosen by plant and track.

    The page is one HTML file, which needs nothing from the network. `origin` is the command and the
    parameters that made it. Raises ConfigError where the runs kept no records, and
    ModuleNotFoundError where plotly is not installed; the extra ``lab`` brings it.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer.lab import compare
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> page = of_comparison(compare.run(path, ["stanley", "pop"]))
    >>> page.startswith(b"<!doctype html>"), len(page) < 2_500_000
    (True, True)
    """
    first, *others = comparisons
    if not first.first.settings.keep_records:
        raise ConfigError("keep_records", value=False, requirement="true where a report is wanted")
    titles = [title_of(name, first.runs) for name in first.runs]
    shown = titles[0] if len(titles) == 1 else f"{', '.join(titles[:-1])} and {titles[-1]}"
    place = f" on {first.track}" if first.track else ""
    results = "".join(table(each, "Errors of the controllers") for each in tables(*comparisons))
    if others:
        results = f"<details><summary>All figures</summary>{results}</details>"
    return Page(
        title=heading(*comparisons).rpartition(",")[0] if others else f"{shown}{place}",
        lead=heading(*comparisons),
        command=origin.command,
        results=verdict(comparisons)
        + (_pivot(comparisons) if others else "")
        + results
        + paragraphs(notes(*comparisons)),
        below="" if others else latency_table(first),
        scenes=[scene_of(each) for each in comparisons],
        choice="Plant, track",
        figures=_effort(comparisons) if others else [],
        roles=colours_of(first.runs),
        sections=[
            vehicles(*((each.plant, each.vehicle, each.believed) for each in comparisons)),
            tuning(origin, settings_block(first.first.settings)),
        ],
    ).content()


def verdict(comparisons: Sequence[Comparison]) -> str:
    """Say how many runs finished without a fault, and what the others did."""
    runs = [(each, name, run) for each in comparisons for name, run in each.runs.items()]
    wrong = []
    for each, name, run in runs:
        said = [] if run.metrics.finished else [f"did not finish: {run.ending}"]
        if run.metrics.faults:
            said.append(f"fault: {', '.join(run.metrics.faults.names)}")
        if said:
            where = ", ".join(part for part in (each.plant, each.track) if part)
            on = f" on {where}" if len(comparisons) > 1 else ""
            wrong.append(f"{title_of(name, each.runs)}{on} ({'; '.join(said)})")
    head = f"{len(runs) - len(wrong)} of {counted(len(runs), 'run')} finished without a fault"
    return badge(head, wrong, good=not wrong)


def _pivot(comparisons: Sequence[Comparison]) -> str:
    """Set out the errors after settling: a row for each plant and track, which leads to its map."""
    names = list(comparisons[0].runs)
    settling = comparisons[0].first.settings.settling_time
    rows = []
    for place, each in enumerate(comparisons):
        errors = [run.metrics.settled_mean_abs_cross_track_error for run in each.runs.values()]
        ended = [run.metrics.finished for run in each.runs.values()]
        best = min((error for error, good in zip(errors, ended, strict=True) if good), default=None)
        cells = []
        for error, good in zip(errors, ended, strict=True):
            text = number(error, ".4f") if good else f"({number(error, '.4f')})"
            cells.append(f"<strong>{text}</strong>" if error == best else text)
        link = f'<a href="#drive" data-scene="{place}">{escape(each.track)}</a>'
        rows.append([escape(each.plant), link, *cells])
    return html_table(
        f"Mean |cross-track error| after {settling:g} s [m]",
        ["plant", "track", *(title_of(name, names) for name in names)],
        rows,
        [False, False, *[True] * len(names)],
    ) + paragraphs(["In brackets: did not finish. A track leads to its map."])


def _effort(comparisons: Sequence[Comparison]) -> list[dict[str, Any]]:
    """Draw the error over the effort of steering on each plant; a marker for each track."""
    tracks = dict.fromkeys(each.track for each in comparisons)
    symbols = dict(zip(tracks, cycle(_MARKERS), strict=False))
    marks = ", ".join(f"{track}: {symbol}" for track, symbol in symbols.items())
    since = f"after {comparisons[0].first.settings.settling_time:g} s"
    hover = "%{text}: %{y:.4f} m, %{x:.2f} deg/s"
    figures = []
    for plant in dict.fromkeys(each.plant for each in comparisons):
        traces = []
        for law in comparisons[0].runs:
            across: list[float] = []
            up: list[float] = []
            said: list[str] = []
            marker: dict[str, Any] = {"color": f"@{law}", "size": 11, "symbol": []}
            for each in comparisons:
                found = each.runs[law].metrics
                if each.plant == plant and found.settled_mean_abs_cross_track_error > 0.0:
                    across.append(math.degrees(found.rms_steer_rate))
                    up.append(found.settled_mean_abs_cross_track_error)
                    said.append(each.track + ("" if found.finished else ", did not finish"))
                    end = "" if found.finished else "-open"
                    marker["symbol"].append(symbols[each.track] + end)
            titled = title_of(law, comparisons[0].runs)
            traces.append(dots(titled, across, up, said, marker, hover))
        figures.append(
            figure(
                f"Error over the effort of steering, {plant}",
                f"Marks by track: {marks}; open where the run did not finish.",
                traces,
                log_axis("rate of the command, rms [deg/s]", *_ends(traces, "x")),
                log_axis(f"mean |cross-track error| {since} [m]", *_ends(traces, "y")),
                hovermode="closest",
            )
        )
    return figures


def _ends(traces: list[dict[str, Any]], axis: str) -> tuple[float, float]:
    values = [value for trace in traces for value in trace[axis]] or [1.0]
    return min(values), max(values)


def scene_of(comparison: Comparison) -> Scene:
    """Let the cars of a comparison drive on one map; the runs need their records."""
    colours = colours_of(comparison.runs)
    parts = (comparison.plant, comparison.track)
    return Scene(
        title=", ".join(part for part in parts if part),
        actors=[
            actor_of(run, name, title_of(name, comparison.runs), colours[name])
            for name, run in comparison.runs.items()
        ],
        panels=PANELS,
        vehicle=comparison.vehicle,
        paths=[comparison.path],
        settled=comparison.first.settings.settling_time,
        figures=latency_figure(comparison),
    )


def actor_of(run: Run, name: str, title: str, colour: Colour) -> Actor:
    """Make a car of a run, which needs its records."""
    records = run.records
    x, y, yaw, speed = (records[key] for key in ("x", "y", "yaw", "speed"))
    columns = {
        "time": records["time"],
        "distance": distances(run.path, x, y, yaw, speed),
        "x": x,
        "y": y,
        "yaw": yaw,
        "speed": speed,
        "steer_deg": np.degrees(records["steer"]),
        "cross_track_error": records["cross_track_error"],
        "heading_error_deg": np.degrees(records["heading_error"]),
        "status": records["status"],
    }
    return Actor(name, title, colour, columns)


_PER_DECADE = 20
_SHARES = (50.0, 90.0, 99.0, 99.9)


def latency_figure(comparison: Comparison) -> list[dict[str, Any]]:
    """Draw how long the steps took, where they were timed; else nothing."""
    if not comparison.latencies:
        return []
    times = {
        name: np.maximum(np.array(each) * 1e-3, 1e-3)  # a clock that is coarse may read 0
        for name, each in comparison.latencies.items()
    }
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
        hover = "%{y:.1f} % of the steps from %{x:.3g} µs"
        # Up at the first edge.
        steps = (edges[0], *edges), (0.0, *shares, 0.0)
        traces.append(stairs(name, comparison.latencies, *steps, 2, hover))
    on = this_machine()
    machine = f"{on['cpu']}, {on['cores']} cores, {on['python']}"
    note = f"Share of the steps, as the clock read each; {machine}.{beyond}"
    up = {"title": {"text": "steps [%]"}, "rangemode": "tozero"}
    return [figure("Time of a control step", note, traces, axis, up)]


def latency_table(comparison: Comparison) -> str:
    """Set out percentiles of the times as HTML, where steps were timed; else nothing."""
    if not comparison.latencies:
        return ""
    rows = []
    for name, each in comparison.latencies.items():
        values = np.percentile(np.array(each), _SHARES, method="higher")
        net = f"{1e6 * comparison.step_times[name]:.2f}"
        shown = [f"{1e-3 * value:.2f}" for value in values]
        most, count = f"{1e-3 * max(each):.1f}", str(len(each))
        rows.append((title_of(name, comparison.latencies), net, *shown, most, count))
    percentiles = [f"p{share:g} [µs]" for share in _SHARES]
    heads = ("controller", "net median [µs]", *percentiles, "max [µs]", "calls")
    note = (
        "Steps of fresh controllers on the states of their own runs. p50 to max are of single"
        " calls and hold one reading of the clock each; the net median does not."
    )
    return plain_table("Time of a control step, percentiles", heads, rows) + paragraphs([note])
