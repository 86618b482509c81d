"""``popsteer matrix``: controllers × plants × tracks."""

from __future__ import annotations

import typer

from popsteer import lab
from popsteer.cli import inputs, options, outputs
from popsteer.cli.outputs import Progress
from popsteer.lab.common.names import differences
from popsteer.lab.compare.runs import DEFAULT_CONTROLLERS
from popsteer.sim import Settings, vehicle_of

_CONTROLLERS = ",".join(DEFAULT_CONTROLLERS)

HELP = """\
Drive several controllers on several plants along several tracks, and time a step of each.

The table has the errors, the median time of a step, and whether the run reached the end; a run that
did not says why. --out also writes the table as matrix.csv and matrix.md, all metrics as
matrix.json, and a figure of the error over the effort of steering.

\b
Examples:
  popsteer matrix --out out
  popsteer matrix --controllers pop,mpc --plants carla-identified,commonroad-mb-2
  popsteer matrix --plants car.toml,loaded-car.toml --vehicle car.toml --constant-speed 10
  popsteer matrix --tracks racetrack,slalom --waypoints waypoints.csv --report matrix.html
"""


def matrix(
    *,
    controllers: options.Controllers = _CONTROLLERS,
    preset: options.Preset = "default",
    params: options.Params = None,
    set_: options.Set = None,
    waypoints: options.SeveralWaypoints = None,
    tracks: options.Tracks = None,
    closed: options.Closed = False,
    columns: options.Columns = None,
    origin: options.Origin = None,
    plants: options.Plants = "carla-identified,kinematic-bicycle",
    vehicle: options.Vehicle = None,
    set_vehicle: options.SetVehicle = None,
    no_adapt: options.NoAdapt = False,
    start_offset: options.StartOffset = None,
    speed: options.Speed = None,
    constant_speed: options.ConstantSpeed = None,
    longitudinal: options.Longitudinal = None,
    set_longitudinal: options.SetLongitudinal = None,
    dt: options.Dt = options.DEFAULT_DT,
    out: options.Out = None,
    report: options.Report = None,
    context: typer.Context,
) -> None:
    """Drive controllers on plants along tracks."""
    names = inputs.names("--controllers", controllers)
    courses = inputs.courses(waypoints, tracks, closed=closed, columns=columns, origin=origin)
    outputs.check_folder(out, lab.matrix.table.FILES, report)
    with Progress() as progress:
        movers = {name: inputs.plant(name) for name in inputs.names("--plants", plants)}
        given = {
            name: inputs.believed(vehicle, set_vehicle, vehicle_of(mover))
            for name, mover in movers.items()
        }
        tuning = inputs.tuned(names, preset, set_, no_adapt=no_adapt, params=params)
        found = lab.matrix.run(
            {course.name: course.path for course in courses},
            tuning.params,
            movers,
            vehicle=given,
            adapt=tuning.adapt,
            monitor=tuning.monitor,
            preset=tuning.called,
            start_offset=start_offset,
            speed=speed,
            constant_speed=constant_speed,
            longitudinal=inputs.longitudinal(
                longitudinal, set_longitudinal, constant_speed, courses, movers.values()
            ),
            settings=Settings(dt=dt),
            progress=progress.update,
        )
        content = {} if out is None else lab.matrix.table.matrix_files(found)
    line = outputs.command_line(context)
    made_by = lab.report.Origin(line, tuning.params, tuning.adapt, movers, tuning.monitor)
    said = outputs.write(content, out, "--out DIR writes the table, all metrics and a figure.")
    notes = lab.matrix.table.matrix_notes(found)
    for name, believed in given.items():
        if otherwise := differences(believed, vehicle_of(movers[name])):
            notes.append(f"{name}{otherwise}")
    tables = lab.matrix.table.matrix_tables(found, outputs.console().width)
    read = [course.path.source for course in courses]
    caption = lab.matrix.table.matrix_caption(found)

    def draw(_: object) -> bytes:
        return lab.report.of_matrix(found, made_by)

    outputs.show(caption, tables, notes, said, report, read, draw)
    outputs.say_raised(run for each in found.comparisons for run in each.runs.values())
