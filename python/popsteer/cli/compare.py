"""``popsteer compare``: controllers on plants along tracks, every parameter at hand."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from popsteer import lab
from popsteer.cli import inputs, options, outputs
from popsteer.cli.assignments import assigned, pairs
from popsteer.cli.options import flag, optional
from popsteer.cli.outputs import Progress
from popsteer.errors import ConfigError, printable
from popsteer.files import check_files
from popsteer.lab.compare.runs import DEFAULT_CONTROLLERS
from popsteer.sim import Settings, vehicle_of

_CONTROLLERS = ",".join(DEFAULT_CONTROLLERS)

HELP = """\
Drive controllers on plants along tracks, each on each, and show their errors.

Errors are measured at the point that each controller tracks, and at the rear axle, one point for
all. popsteer params lists the names, and what NAME=VALUE can set. Of one plant and track, --out
writes figures and records; of several, a table matrix.csv, .md and .json, and a figure.

\b
Examples:
  popsteer compare --report out.html
  popsteer compare --controllers stanley,pop --track figure-eight --out out
  popsteer compare --plants car.toml,mujoco-car --tracks racetrack,slalom
  popsteer compare --waypoints course.csv --plant car.toml
  popsteer compare --controllers pop --set lookahead_gain=0.3
  popsteer compare --plant mujoco-car --set-plant friction=0.6
"""


def compare(
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
    plants: options.Plants = "carla-identified",
    set_plant: options.SetPlant = None,
    vehicle: options.Vehicle = None,
    set_vehicle: options.SetVehicle = None,
    no_adapt: options.NoAdapt = False,
    start: options.Start = None,
    start_at: options.StartAt = "pose",
    start_offset: options.StartOffset = None,
    speed: options.Speed = None,
    constant_speed: options.ConstantSpeed = None,
    longitudinal: options.Longitudinal = None,
    set_longitudinal: options.SetLongitudinal = None,
    dt: options.Dt = options.DEFAULT_DT,
    set_run: Annotated[
        list[str] | None, optional("NAME=VALUE", "A parameter of the run, such as time_limit.")
    ] = None,
    step_time: Annotated[
        bool, flag("--step-time", "Measure the time of a control step, too.")
    ] = False,
    record: options.Record = None,
    out: options.Out = None,
    report: options.Report = None,
    context: typer.Context,
) -> None:
    """Drive controllers on plants along tracks."""
    names = inputs.names("--controllers", controllers)
    courses = inputs.courses(waypoints, tracks, closed=closed, columns=columns, origin=origin)
    settings = assigned(Settings(dt=dt), set_run, "the run")
    with Progress() as progress:
        movers = inputs.movers(plants, set_plant)
        several = len(courses) * len(movers) > 1
        pose, at = inputs.start(start, start_at, start_offset, courses)
        given = {
            name: inputs.believed(vehicle, set_vehicle, vehicle_of(mover))
            for name, mover in movers.items()
        }
        tuning = inputs.tuned(names, preset, set_, no_adapt=no_adapt, params=params)
        wanted = lab.compare.files.file_names(tuning.params, several=several)
        outputs.check_folder(out, wanted, report)
        _check_record(record, len(names) * len(courses) * len(movers))
        pedals = longitudinal, set_longitudinal, constant_speed, movers.values()
        found = lab.compare.run_each(
            {course.name: course.path for course in courses},
            tuning.params,
            movers,
            vehicle=given,
            adapt=tuning.adapt,
            monitor=tuning.monitor,
            preset=tuning.called,
            start=pose,
            start_at=at,
            start_offset=start_offset,
            speed=speed,
            constant_speed=constant_speed,
            longitudinal=inputs.longitudinal(*pedals),
            settings=settings,
            joined=not any(name == "settling_time" for name, _ in pairs("--set-run", set_run)),
            step_time=step_time,
            progress=progress.update,
        )
        line = outputs.command_line(context)
        made_by = lab.report.Origin(line, tuning.params, tuning.adapt, movers, tuning.monitor)
        records = (each.first.records for each in found)
        driven = ((each["time"], each["speed"], each["steer"]) for each in records)
        stops = not all(course.path.closed for course in courses)
        hangs = inputs.defaults_note(vehicle, set_vehicle, driven, stops=stops)
        read = [course.path.source for course in courses]
        outputs.deliver(found, out, progress, report, made_by, read, hangs)
    if record is not None:
        from popsteer.adapters.ros2.recording import record_run

        count = record_run(found[0].first, record)
        print(f"Written to {printable(str(record))}: {count} messages")


def _check_record(file: Path | None, runs: int) -> None:
    if file is not None:
        if file.suffix != ".mcap":
            raise ConfigError("--record", str(file), "a file *.mcap")
        if runs > 1:
            raise ConfigError("--record", str(file), "given with one controller, plant and track")
        check_files([file])
