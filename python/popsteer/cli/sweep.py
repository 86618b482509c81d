"""``popsteer sweep``: thousands of runs that differ."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from shlex import quote
from typing import Annotated

import typer

from popsteer import lab, own, sim
from popsteer.cli import inputs, options, outputs
from popsteer.cli.options import optional, valued
from popsteer.cli.outputs import Progress, kept_in
from popsteer.errors import ConfigError, PopsteerError, printable
from popsteer.files import write_files_atomic
from popsteer.lab.sweep.rows import journal_of
from popsteer.sim import Settings

# What goes with --run.
_WITH_RUN = ("run", "out", "report", "controller", "plant")

HELP = """\
Drive one controller thousands of times, each time with another vehicle, start and noise.

The controller is told the vehicle without the draws. A run succeeds if it finishes without a fault,
within --deviation after settling. --out keeps the rows as they come: the same command resumes where
it was stopped. --run goes with --out, --report, and your own --controller and --plant.

\b
Examples:
  popsteer sweep --runs 10000 --out sweep.parquet --report sweep.html
  popsteer sweep --run sweep.parquet:17 --out run-17
  popsteer sweep --vehicle car.toml --params tuned.toml --waypoints course.csv
  popsteer sweep --vary "steer_lag=uniform(0.05,0.2)"
  popsteer sweep --plant mujoco-car --vary "friction=uniform(0.3,1)"
"""


def sweep(
    *,
    controller: options.Controller = None,
    params: options.Params = None,
    preset: options.Preset = "default",
    set_: options.Set = None,
    no_adapt: options.NoAdapt = False,
    waypoints: options.Waypoints = None,
    track: options.Track = None,
    closed: options.Closed = False,
    columns: options.Columns = None,
    origin: options.Origin = None,
    plant: options.OwnPlant = None,
    set_plant: options.SetPlant = None,
    vehicle: options.Vehicle = None,
    set_vehicle: options.SetVehicle = None,
    vary: options.Vary = None,
    distributions: options.Distributions = None,
    runs: Annotated[int, valued("N", "How many runs.")] = 1000,
    seed: options.Seed = 0,
    deviation: Annotated[float, valued("METRES", "Most that a success is off.")] = 0.5,
    start_offset: options.StartOffset = None,
    speed: options.Speed = None,
    constant_speed: options.ConstantSpeed = None,
    longitudinal: options.Longitudinal = None,
    set_longitudinal: options.SetLongitudinal = None,
    dt: options.Dt = options.DEFAULT_DT,
    workers: Annotated[int | None, optional("N", "Threads or processes; else one a core.")] = None,
    dask: Annotated[str | None, optional("ADDRESS", "Scheduler of Dask; extra 'dask'.")] = None,
    run: Annotated[
        str | None, optional("FILE:RUN", "Drive this run again, to the last bit.")
    ] = None,
    out: Annotated[
        Path | None, optional("FILE", "Rows, *.parquet or *.csv; a folder of --run.")
    ] = None,
    report: options.Report = None,
    context: typer.Context,
) -> None:
    """Drive one controller thousands of times, each time otherwise."""
    if run is not None:
        _again(run, {"controller": controller, "plant": plant}, out, report, context)
        return
    moved, given, label = inputs.varied(plant, set_plant, vehicle, set_vehicle)
    name, tuning = inputs.tuning(controller, params, preset, set_, no_adapt=no_adapt)
    course = inputs.course(waypoints, track, closed=closed, columns=columns, origin=origin)
    pedals = inputs.longitudinal(longitudinal, set_longitudinal, constant_speed, [moved])
    varies = inputs.distributions(vary, distributions, moved)
    job = lab.sweep.Job(
        course.path,
        name,
        tuning.params[name],
        moved,
        varies,
        runs,
        seed,
        vehicle=given,
        adapt=tuning.adapt,
        monitor=tuning.monitor,
        deviation=deviation,
        start_offset=start_offset,
        speed=speed,
        constant_speed=constant_speed,
        longitudinal=pedals,
        settings=Settings(dt=dt),
        course=course.name,
        label=label,
    )
    job = replace(job, settings=job.joining([course.path]), joined=True)
    pictures = outputs.check_file(out, report)
    with kept_in(out and journal_of(out)), Progress() as progress:
        rows = lab.sweep.run(job, out, dask=dask, workers=workers, progress=progress.update)
        if out is not None:
            from popsteer.lab.sweep.figure import sweep_figure

            draw = partial(sweep_figure, job, rows)
            write_files_atomic(outputs.draw_figures(out, draw, progress))
    summary = lab.sweep.summary
    nothing = "--out FILE writes the rows, to repeat any run, and a figure of where it fails."
    said = outputs.written(out, pictures, nothing)
    if out is not None:
        worst = summary.worst(rows, 1)[0]["run"]
        own_code = {"controller": job.controller, "plant": sim.plant_name(job.whole)}
        named = [f" --{k} {quote(v)}" for k, v in own_code.items() if own.is_reference(v)]
        again = f"{quote(f'{out}:{worst}')}{''.join(named)}"
        said += f"\nThe worst run again: popsteer sweep --run {again}"
    shown = summary.caption(job, rows), summary.tables(job, rows), summary.notes(job, rows), said
    page = job, rows, str(out or ""), lab.report.Origin(outputs.command_line(context))
    read = [course.path.source]
    outputs.show(*shown, report, read, lambda bar: lab.report.of_sweep(*page, bar.update))
    if not job.is_of_core:
        stopped = next((row["run"] for row in rows if not row["finished"]), None)
        outputs.say_raised([] if stopped is None else [lab.sweep.repeat(job, stopped)])


def _again(
    text: str,
    named: dict[str, str | None],
    out: Path | None,
    report: Path | None,
    context: typer.Context,
) -> None:
    """Drive one run of a sweep, given as ``FILE:RUN``, and compare it with its row.

    Controller and plant of one's own are run where they are `named`.
    """
    options.check_alone(context, "--run", _WITH_RUN)
    file, _, number = text.rpartition(":")
    if not file or not number.isdecimal():
        raise ConfigError("--run", text, "written FILE:RUN")
    run = int(number)
    job, row = lab.sweep.rows.read_row(Path(file), run, [name for name in named.values() if name])
    there = {"controller": job.controller, "plant": sim.plant_name(job.whole)}
    for option, name in named.items():
        if name not in (None, there[option]):
            raise ConfigError(f"--{option}", name, f"that of the sweep, {there[option]}")
    outputs.check_folder(out, lab.compare.files.file_names([job.controller]), report)
    with Progress() as progress:
        try:
            found = lab.sweep.repeat(job, run, progress=partial(progress.update, job.controller))
        except ConfigError as error:  # what the file says cannot be driven
            raise PopsteerError(f"{file}: {error}") from None
        drawn = ", ".join(f"{name} {value:.6g}" for name, value in job.drawn(run).items())
        comparison = lab.compare.Comparison(
            {job.controller: found},
            {job.controller: f"run {run} of {printable(Path(file).name)}"},
            plant=job.label,
            track=job.course,
        )
        line, driven = outputs.command_line(context), {job.label: job.made(run).plant}
        tuned = {job.controller: job.params}
        made_by = lab.report.Origin(line, tuned, job.adapt, driven, job.monitor)
        outputs.deliver([comparison], out, progress, report, made_by)
    figures = vars(found.metrics)
    same = all(row[name] == figures[name] or row[name] != row[name] for name in figures)
    print(f"Drawn: {drawn or 'nothing'}.")
    said = "to the last bit what its row says" if same else "NOT what its row says"
    ended = "succeeded" if row["success"] else "failed"
    print(f"Run {run} of {printable(file)} is {said}; it {ended}.")
