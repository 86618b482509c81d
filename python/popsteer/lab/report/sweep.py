"""The page of a sweep: how often it succeeds, where it fails, and the worst runs on the map."""

from __future__ import annotations

import shlex
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from popsteer import sim
from popsteer.lab.common.names import counted, title_of
from popsteer.lab.report.colours import named, ranked
from popsteer.lab.report.compare import PANELS, actor_of
from popsteer.lab.report.markup import badge, block, paragraphs, plain_table, table
from popsteer.lab.report.origin import Origin, settings_block, tuning, vehicles
from popsteer.lab.report.page import Page, Section, page_bytes
from popsteer.lab.report.scene import Scene
from popsteer.lab.report.shares import envelope_figure, error_figure, quantity_figures, start_figure
from popsteer.lab.sweep import summary
from popsteer.lab.sweep.job import repeat
from popsteer.lab.sweep.summary import error_of, worst
from popsteer.status import Status

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from popsteer.lab.sweep import Job

_WORST = 6
_TABLE = 10


def of_sweep(
    job: Job,
    rows: Sequence[dict[str, Any]],
    file: str = "",
    origin: Origin | None = None,
    progress: Callable[[str, float], object] | None = None,
) -> bytes:
    """Make the page of a sweep; its worst runs and its median one are driven again for it.

    `rows` are all rows of the sweep, and `file` is where they were written, to name the commands
    that repeat a run. `progress` is called with what is being done and the share of it that is
    done. The page is one HTML file, which needs nothing from the network. `origin` is the command
    and the parameters that made it. Raises ModuleNotFoundError where plotly is not installed; the
    extra ``lab`` brings it.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer.lab import sweep
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> job = sweep.Job(path, "pop", popsteer.PopParams(), "kinematic-bicycle", {}, runs=3)
    >>> of_sweep(job, sweep.run(job)).startswith(b"<!doctype html>")
    True
    """
    command = "" if origin is None else origin.command
    ranked = [row["run"] for row in worst(rows, len(rows))]
    runs = ranked[:_WORST]
    median = [ranked[len(rows) // 2]] if len(rows) > len(runs) else []
    drawn = "".join(f'{name} = "{each}"\n' for name, each in job.vary.items())
    varies = paragraphs(["Nothing varies."])
    if drawn:
        varies = block("Distributions, as --distributions reads them", drawn, is_open=True)
    label = job.label or "plant"
    made = Origin(command, {job.controller: job.params}, job.adapt, {label: job.whole})
    return page_bytes(
        Page(
            title=f"{title_of(job.controller)}: {len(rows)} runs that differ",
            lead=summary.caption(job, rows),
            command=command,
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
                vehicles({label: sim.vehicle_of(job.whole)}, {label: job.given}),
                tuning(made, settings_block(job.settings or sim.Settings())),
                Section("drawn", "What varies", varies),
            ],
        )
    )


def verdict(rows: Sequence[dict[str, Any]]) -> str:
    """Say how many runs of a sweep succeeded, with confidence, and why the others did not."""
    good, share, low, high = summary.success_of(rows)
    faulty, names = summary.faults_of(rows)
    stopped = sum(not row["finished"] for row in rows)
    said = [f"95 % confidence: {low} to {high} %"]
    said += [f"{stopped} did not finish"] if stopped else []
    said += [f"{faulty} reported a fault: {names}"] if faulty else []
    head = f"{good} of {counted(len(rows), 'run')} succeeded, {share} %"
    return badge(head, said, good=good == len(rows))


def _worst_table(job: Job, rows: Sequence[dict[str, Any]], file: str) -> str:
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
    again = f"popsteer compare --replay-run {shlex.quote(file)}:{worst(rows, 1)[0]['run']}\n"
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
    )
