"""``popsteer sweep``: thousands of runs that differ."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from popsteer import lab
from popsteer.cli import inputs, options, outputs
from popsteer.cli.options import optional, valued
from popsteer.cli.outputs import Progress, kept_in
from popsteer.files import write_bytes_atomic, write_files_atomic
from popsteer.lab.sweep.rows import journal_of
from popsteer.sim import Settings

HELP = """\
Drive one controller thousands of times, each time with another vehicle, start and noise.

What varies is drawn from distributions: fields of the plant's vehicle, parameters of the plant
(such as friction, where it has one), noise_position, noise_yaw, noise_speed, start_offset,
start_yaw and start_speed. The controller is given the vehicle as it is before the draws. Without
--vary and --distributions the steering, the start and the noise vary. --vary NAME=none takes one
out.

\b
A distribution is a number or one of
  uniform(LOW,HIGH)  loguniform(LOW,HIGH)  normal(MEAN,DEVIATION)  triangular(LOW,MODE,HIGH)

A run succeeds if it finishes, reports no fault, and stays within --deviation after settling. With
--out the rows are written as they come, and the same command resumes where it was stopped; a figure
shows where the controller fails. Any run can be driven again, to the last bit: popsteer compare
--replay-run FILE:RUN.

\b
Examples:
  popsteer sweep --vehicle car.toml --params tuned.toml --waypoints course.csv --runs 10000
  popsteer sweep --runs 10000 --out sweep.parquet --report sweep.html
  popsteer sweep --vary "steer_lag=uniform(0.05,0.2)" --vary "dead_time=uniform(0,0.2)"
  popsteer sweep --plant mujoco-car --vary "friction=uniform(0.3,1)" --runs 200 --constant-speed 8
  popsteer sweep --runs 100000 --out sweep.parquet --dask tcp://scheduler:8786
"""


def sweep(
    *,
    controller: Annotated[
        str | None,
        optional(
            "NAME",
            "The controller, as compare has them. The default is that of --params, or else"
            f" {inputs.DEFAULT_CONTROLLER}.",
        ),
    ] = None,
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
    vary: Annotated[
        list[str] | None, optional("NAME=DISTRIBUTION", "Let a quantity vary. Can be repeated.")
    ] = None,
    distributions: options.Distributions = None,
    runs: Annotated[int, valued("N", "How many runs.")] = 1000,
    seed: options.Seed = 0,
    deviation: Annotated[
        float, valued("METRES", "How far off the path a successful run may be, after settling.")
    ] = 0.5,
    start_offset: options.StartOffset = None,
    speed: options.Speed = None,
    constant_speed: options.ConstantSpeed = None,
    longitudinal: options.Longitudinal = None,
    set_longitudinal: options.SetLongitudinal = None,
    dt: options.Dt = options.DEFAULT_DT,
    workers: Annotated[
        int | None,
        optional(
            "N",
            "How many threads drive, or processes where plant or controller are in Python."
            " The default is one a core.",
        ),
    ] = None,
    dask: Annotated[
        str | None,
        optional(
            "ADDRESS",
            "Drive on a Dask cluster: the address of its scheduler, or local:N for N processes"
            " of its own. Needs the extra 'dask'.",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        optional("FILE", "File for the rows, *.parquet or *.csv. The figure is drawn beside it."),
    ] = None,
    report: options.Report = None,
    context: typer.Context,
) -> None:
    """Drive one controller thousands of times, each time otherwise."""
    moved, given, label = inputs.varied(plant, set_plant, vehicle, set_vehicle)
    name, tuning = inputs.tuning(controller, params, preset, set_, no_adapt=no_adapt)
    course = inputs.course(waypoints, track, closed=closed, columns=columns, origin=origin)
    pedals = inputs.longitudinal(longitudinal, set_longitudinal, constant_speed, [course], [moved])
    job = lab.sweep.Job(
        course.path,
        name,
        tuning.params[name],
        moved,
        inputs.distributions(vary, distributions, moved),
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
    pictures = outputs.check_file(out)
    outputs.check_page(report)
    with kept_in(out and journal_of(out)), Progress() as progress:
        rows = lab.sweep.run(job, out, dask=dask, workers=workers, progress=progress.update)
        if out is not None:
            from popsteer.lab.sweep.figure import sweep_figure

            draw = partial(sweep_figure, job, rows)
            write_files_atomic(outputs.draw_figures(out, draw, progress))
        if report is not None:
            page = lab.report.of_sweep(
                job,
                rows,
                "" if out is None else str(out),
                lab.report.Origin(outputs.command_line(context)),
                progress.update,
            )
            write_bytes_atomic(report, page)
    summary = lab.sweep.summary
    nothing = "--out FILE writes the rows, to repeat any run, and a figure of where it fails."
    said = outputs.written(out, pictures, nothing)
    if out is not None:
        worst = summary.worst(rows, 1)[0]["run"]
        said += f"\nThe worst run again: popsteer compare --replay-run {out}:{worst}"
    below = summary.notes(job, rows)
    tables, read = summary.tables(job, rows), [course.path.source]
    outputs.show(summary.caption(job, rows), tables, below, said, report, read)
    if not job.is_of_core:
        stopped = next((row["run"] for row in rows if not row["finished"]), None)
        outputs.say_raised([] if stopped is None else [lab.sweep.repeat(job, stopped)])
