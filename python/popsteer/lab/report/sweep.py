"""The page of a sweep: how often it succeeds, where it fails, and the worst runs on the map."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from popsteer import sim
from popsteer.lab.common.names import counted, title_of
from popsteer.lab.compare.comparison import distances
from popsteer.lab.report.colours import dots, figure, log_axis, named, ranked, rounded
from popsteer.lab.report.compare import PANELS, actor_of
from popsteer.lab.report.markup import badge, block, paragraphs, plain_table, table
from popsteer.lab.report.page import (
    NOWHERE,
    Origin,
    Page,
    Section,
    settings_block,
    tuning,
    vehicles,
)
from popsteer.lab.report.scene import Scene
from popsteer.lab.sweep import Job, summary
from popsteer.lab.sweep.job import repeat
from popsteer.lab.sweep.summary import error_of, influence, outcomes, worst
from popsteer.status import Status

_WORST = 6
_TABLE = 10


def of_sweep(
    job: Job,
    rows: summary.Rows,
    file: str = "",
    origin: Origin = NOWHERE,
    progress: Callable[[str, float], object] | None = None,
) -> bytes:
    """Make the page of a sweep; its worst runs and its median one are driven again for it.

    `rows` are all rows of the sweep, and `file` is where they were written, to name the commands
    that repeat a run. `progress` is called with what is being done and the share of it that is
    done. `origin` and errors are as `of_comparison` has them.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer.lab import sweep
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> job = sweep.Job(path, "pop", popsteer.PopParams(), "kinematic-bicycle", {}, runs=3)
    >>> of_sweep(job, sweep.run(job)).startswith(b"<!doctype html>")
    True
    """
    ranked = [row["run"] for row in worst(rows, len(rows))]
    runs = ranked[:_WORST]
    median = [ranked[len(rows) // 2]] if len(rows) > len(runs) else []
    drawn = "".join(f'{name} = "{each}"\n' for name, each in job.vary.items())
    varies = paragraphs(["Nothing varies."])
    if drawn:
        varies = block("Distributions, as --distributions reads them", drawn, is_open=True)
    label = job.label or "plant"
    made = Origin(
        origin.command, {job.controller: job.params}, job.adapt, {label: job.whole}, job.monitor
    )
    return Page(
        title=f"{title_of(job.controller)}: {counted(len(rows), 'run')} that differ",
        lead=summary.caption(job, rows),
        command=origin.command,
        results=verdict(rows)
        + table(summary.tables(job, rows)[0], "Percentiles and worst runs")
        + _worst_table(job, rows, file)
        + paragraphs(summary.notes(job, rows)),
        scenes=[_scene(job, median, runs, progress)],
        figures=[
            envelope_figure(job, rows, progress and partial(progress, "envelope")),
            error_figure(job, rows),
            *start_figure(job, rows),
            *quantity_figures(job, rows),
        ],
        roles={"good": named("pop"), "bad": named("pid")},
        sections=[
            vehicles((label, sim.vehicle_of(job.whole), job.given)),
            tuning(made, settings_block(job.settings)),
            Section("drawn", "What varies", varies),
        ],
    ).content()


def verdict(rows: summary.Rows) -> str:
    """Say how many runs of a sweep succeeded, with confidence, and why the others did not."""
    good, share, low, high = summary.success_of(rows)
    said = [f"95 % confidence: {low} to {high} %", *summary.failures(rows)]
    head = f"{good} of {counted(len(rows), 'run')} succeeded, {share} %"
    return badge(head, said, good=good == len(rows))


def _worst_table(job: Job, rows: summary.Rows, file: str) -> str:
    """List the worst runs with their seeds, and how to drive each again."""
    heads = ["run", "finished", "faults", "greatest error [m]"]
    lines = []
    for row in worst(rows, _TABLE):
        cells = [str(row["run"]), "yes" if row["finished"] else "no"]
        cells += [str(Status(row["faults"])) if row["faults"] else "–", f"{error_of(row):.3f}"]
        cells += [*(f"{row[name]:.4g}" for name in job.vary), str(row["seed"])]
        lines.append(cells)
    shown = plain_table("The worst runs", [*heads, *job.vary, "seed"], lines, left=0)
    if not file:
        kept = "--out FILE keeps the rows, so that any run can be driven again."
        return shown + paragraphs([kept])
    again = f"popsteer sweep --run {shlex.quote(file)}:{worst(rows, 1)[0]['run']}\n"
    return shown + block("Drive a run again, to the last bit", again)


def _scene(
    job: Job,
    median: Sequence[int],
    bad: Sequence[int],
    progress: Callable[[str, float], object] | None,
) -> Scene:
    actors, marks = [], []
    for place, run in enumerate((*median, *bad)):
        if progress is not None:
            progress("worst runs", place / (len(median) + len(bad)))
        found = repeat(job, run)
        if place < len(median):
            actors.append(actor_of(found, f"run-{run}", f"median, run {run}", named("text")))
            continue
        colour = ranked(place - len(median))
        actors.append(actor_of(found, f"run-{run}", f"run {run}", colour))
        settling = found.settings.settling_time
        error = np.abs(found.records["cross_track_error"])
        settled = np.where(found.records["time"] >= settling, error, -1.0)
        if len(settled):
            at = int(np.argmax(settled if settled.max() >= 0.0 else error))
            where = (float(found.records["x"][at]), float(found.records["y"][at]))
            marks.append((*where, f"run {run}: {error[at]:.2f} m"))
    first, *others = PANELS
    return Scene(
        title="the worst runs",
        actors=actors,
        panels=[replace(first, limit=job.deviation), *others],
        vehicle=sim.vehicle_of(job.whole),
        paths=[job.path],
        marks=marks,
        settled=job.settings.settling_time,
    )


_MOST = 9
_DOTS = 1500


def error_figure(job: Job, rows: summary.Rows) -> dict[str, Any]:
    """Draw a histogram of the greatest errors of all runs."""
    good, _, error = outcomes(rows)
    low, high = np.log10(error.min()), np.log10(error.max())
    edges = np.logspace(low - 1e-9, max(high, low + 0.1) + 1e-9, 61)
    middles = np.sqrt(edges[1:] * edges[:-1])
    traces = []
    for part, name, role in ((good, "succeeded", "good"), (~good, "failed", "bad")):
        counts, _ = np.histogram(error[part], edges)
        bars = {
            "type": "bar",
            "name": name,
            "x": rounded(middles),
            "y": counts.tolist(),
            "width": rounded(np.diff(edges)),
            "marker": {"color": f"@{role}"},
            "hovertemplate": "%{y} runs around %{x:.3g} m",
        }
        traces += [bars] if part.any() else []
    return figure(
        "Greatest |cross-track error| of a run",
        f"{counted(len(rows), 'run')}, each after settling, or as a whole where it did not finish;"
        f" the limit is {job.deviation:g} m.",
        traces,
        log_axis("greatest |cross-track error| [m]", edges[0], edges[-1]),
        "runs",
        barmode="stack",
        bargap=0.0,
        shapes=[_limit(job.deviation, "x")],
    )


def start_figure(job: Job, rows: summary.Rows) -> list[dict[str, Any]]:
    """Draw from which starts it fails, where offset and heading at the start vary; else nothing."""
    names = ("start_offset", "start_yaw")
    if any(name not in job.vary or job.vary[name].is_constant for name in names):
        return []
    across, up = (np.array([row[name] for row in rows]) for name in names)
    traces, note = _dots(rows, across, np.degrees(up))
    said = f"Offset to the left of the path, and heading against it.{note}"
    axes = "start_offset [m]", "start_yaw [deg]"
    return [figure("Where it starts", said, traces, *axes, hovermode="closest")]


def quantity_figures(job: Job, rows: summary.Rows) -> list[dict[str, Any]]:
    """Draw the error over up to nine quantities that vary, those first that failing depends on."""
    good, _, error = outcomes(rows)
    figures, by_chance = [], summary.chance(rows)
    for name, weight in list(influence(job, rows).items())[:_MOST]:
        values = np.array([row[name] for row in rows])
        traces, note = _dots(rows, values, error)
        axis = log_axis("greatest error [m]", error.min(), error.max())
        axis["domain"] = [0.38, 1.0]
        said = (
            f"Kolmogorov-Smirnov distance of the runs that {summary.badly(rows)} from the others:"
            f" {weight:.2f} (by chance: up to {by_chance:.2f}). "
        )
        drawn = figure(
            name,
            f"{said if weight > 0.0 else ''}Below: the share that succeeds over tenths of the runs,"
            f" with 95 % confidence.{note}",
            [*traces, _rates(values, good)],
            {"title": {"text": summary.axis_title(name)}, "anchor": "y2"},
            axis,
            yaxis2={"domain": [0.0, 0.28], "range": [-5, 105], "title": {"text": "%"}},
            shapes=[_limit(job.deviation, "y")],
            hovermode="closest",
        )
        figures.append(drawn | {"height": 1.25})
    return figures


def _dots(
    rows: summary.Rows, across: NDArray[Any], up: NDArray[Any]
) -> tuple[list[dict[str, Any]], str]:
    """Draw the runs as dots; of those that succeeded not more than can be told apart."""
    good, ended, _ = outcomes(rows)
    kinds = (
        ("succeeded", good, "good", "circle", 5, 0.45 if len(rows) > 300 else 0.8),
        ("failed", ~good & ended, "bad", "circle", 7, 0.9),
        ("did not finish", ~ended, "bad", "x", 8, 0.9),
    )
    traces, left_out = [], []
    for name, part, role, symbol, size, opacity in kinds:
        places = np.flatnonzero(part)
        if not len(places):
            continue
        every = -(-len(places) // _DOTS)
        if every > 1:
            left_out.append(f"{name}: 1 in {every}")
        shown = places[::every]
        marker = {"color": f"@{role}", "symbol": symbol, "size": size, "opacity": opacity}
        said = [f"run {rows[k]['run']}" for k in shown]
        hover = "%{text}: %{x:.3g}, %{y:.3g}"
        traces.append(dots(name, across[shown], up[shown], said, marker, hover))
    note = f" Dots drawn of the runs that {'; '.join(left_out)}." if left_out else ""
    return traces, note


def _rates(values: NDArray[Any], good: NDArray[np.bool_]) -> dict[str, Any]:
    tenths = list(summary.success_rates(values, good))
    up = [round(100.0 * (rate.high - rate.share), 3) for _, _, rate in tenths]
    down = [round(100.0 * (rate.share - rate.low), 3) for _, _, rate in tenths]
    return {
        "type": "scatter",
        "mode": "lines+markers",
        "showlegend": False,
        "x": rounded(0.5 * (low + high) for low, high, _ in tenths),
        "y": [round(100.0 * rate.share, 3) for _, _, rate in tenths],
        "yaxis": "y2",
        "error_y": {"type": "data", "symmetric": False, "array": up, "arrayminus": down},
        "line": {"color": "@good", "width": 1.4},
        "marker": {"color": "@good", "size": 5},
        "hovertemplate": "%{y:.1f} % succeed around %{x:.3g}<extra></extra>",
    }


def _limit(value: float, axis: str) -> dict[str, Any]:
    across = "y" if axis == "x" else "x"
    ends: dict[str, Any] = {f"{axis}0": value, f"{axis}1": value}
    ends |= {f"{across}ref": "paper", f"{across}0": 0, f"{across}1": 1}
    return {"type": "line", **ends, "line": {"color": "@faint", "dash": "dash", "width": 1}}


_POINTS = 400
# Runs driven again, by whether the core drives them: about 2 s.
_MOST_DRIVEN = {True: 100, False: 12}


def envelope_figure(
    job: Job, rows: summary.Rows, progress: Callable[[float], object] | None = None
) -> dict[str, Any]:
    """Draw the worst run's cross-track error along the path and the others' span, driven anew."""
    last = worst(rows, 1)[0]["run"]
    runs = [row["run"] for row in rows]
    runs = runs[:: -(-len(runs) // _MOST_DRIVEN[job.is_of_core])]
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
    inside = partial(np.interp, grid, left=np.nan, right=np.nan)
    values = np.array([inside(*curve) if len(curve[0]) else nothing for curve in curves])
    low, high = np.fmin.reduce(values), np.fmax.reduce(values)
    which = "all runs" if len(runs) == len(rows) else f"{len(runs)} of {len(rows)} runs and it"
    lines = {"type": "scatter", "mode": "lines"}
    band = lines | {"line": {"color": "@faint", "width": 0.5}, "hoverinfo": "skip"}
    shown: dict[str, Any] = {"name": f"worst: run {last}", "line": {"color": "@bad", "width": 1.6}}
    shown["hovertemplate"] = "%{y:.3g} m at %{x:.4g} m"
    return figure(
        "The worst run within the envelope",
        f"Cross-track error along the path; the envelope is of {which}, driven again.",
        [
            band | _points(grid, low) | {"showlegend": False},
            band | _points(grid, high) | {"name": "envelope", "fill": "tonexty"},
            lines | _points(grid, values[0]) | shown,
        ],
        "distance along the path [m]",
        "cross-track error [m]",
    )


def _points(x: Any, y: Any) -> dict[str, list[float]]:
    there = np.isfinite(y)
    return {"x": rounded(x[there]), "y": rounded(y[there])}
