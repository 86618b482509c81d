"""``popsteer compare``: controllers on one track, every parameter at hand."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from popsteer import lab, sim
from popsteer.cli import inputs, options, outputs
from popsteer.cli.assignments import assigned
from popsteer.cli.options import flag, optional
from popsteer.cli.outputs import Progress
from popsteer.errors import ConfigError, printable
from popsteer.files import check_files
from popsteer.lab.common.longitudinal import made
from popsteer.lab.compare.runs import DEFAULT_CONTROLLERS
from popsteer.sim import Settings

_CONTROLLERS = ",".join(DEFAULT_CONTROLLERS)

HELP = """\
Drive controllers along one track and show their errors.

Errors are measured at the point that each controller tracks, and again at the rear axle, one point
for all. The controllers know the plant's vehicle unless --vehicle or --set-vehicle gives them
another. popsteer params lists the names, and what NAME=VALUE can set.

\b
Examples:
  popsteer compare --report out.html
  popsteer compare --controllers stanley,pop --track figure-eight --out out
  popsteer compare --waypoints course.csv --plant car.toml --set-vehicle dead_time=0
  popsteer compare --controllers pop --set lookahead_gain=0.3 --set deviation_limit=1
  popsteer compare --plant mujoco-car --set-plant friction=0.6 --constant-speed 12
"""


def compare(
    *,
    controllers: options.Controllers = _CONTROLLERS,
    preset: options.Preset = "default",
    params: options.Params = None,
    set_: options.Set = None,
    waypoints: options.Waypoints = None,
    track: options.Track = None,
    closed: options.Closed = False,
    columns: options.Columns = None,
    origin: options.Origin = None,
    plant: options.Plant = "carla-identified",
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
        bool, flag("--step-time", "Measure the time of a control step as well.")
    ] = False,
    record: options.Record = None,
    out: options.Out = None,
    report: options.Report = None,
    context: typer.Context,
) -> None:
    """Drive controllers along one track."""
    names = inputs.names("--controllers", controllers)
    course = inputs.course(waypoints, track, closed=closed, columns=columns, origin=origin)
    settings = assigned(Settings(dt=dt), set_run, "the run")
    with Progress() as progress:
        mover = inputs.plant(plant, set_plant)
        chosen = inputs.longitudinal(
            longitudinal, set_longitudinal, constant_speed, [course], [mover]
        )
        itself = sim.vehicle_of(mover)
        given = inputs.believed(vehicle, set_vehicle, itself)
        pose, at = inputs.start(course.path, start, start_at, start_offset, itself)
        tuning = inputs.tuned(names, preset, set_, no_adapt=no_adapt, params=params)
        outputs.check_folder(out, lab.compare.files.file_names(tuning.params), report)
        _check_record(record, names)
        comparison = lab.compare.run(
            course.path,
            tuning.params,
            mover,
            vehicle=given,
            adapt=tuning.adapt,
            monitor=tuning.monitor,
            preset=tuning.called,
            start=pose,
            start_at=at,
            speed=speed,
            constant_speed=constant_speed,
            longitudinal=made(chosen, course.path, given),
            settings=settings,
            progress=progress.update,
        )
        comparison = replace(comparison, track=course.name, plant=inputs.plant_label(plant))
        if step_time:
            comparison = lab.compare.time_steps(
                comparison,
                tuning.params,
                progress.update,
                adapt=tuning.adapt,
                monitor=tuning.monitor,
            )
        made_by = lab.report.Origin(
            outputs.command_line(context),
            tuning.params,
            tuning.adapt,
            {comparison.plant: mover},
            tuning.monitor,
        )
        fastest = float(np.max(np.abs(comparison.first.records["speed"]), initial=0.0))
        stops = not course.path.closed
        hangs = inputs.defaults_note(vehicle, set_vehicle, fastest, stops=stops)
        read = [course.path.source]
        outputs.deliver(comparison, out, progress, report, made_by, read, hangs)
    if record is not None:
        from popsteer.adapters.ros2.recording import record_run

        count = record_run(comparison.first, record)
        print(f"Written to {printable(str(record))}: {count} messages")


def _check_record(file: Path | None, controllers: list[str]) -> None:
    if file is not None:
        if file.suffix != ".mcap":
            raise ConfigError("--record", str(file), "a file *.mcap")
        if len(controllers) > 1:
            raise ConfigError("--record", str(file), "given with one controller")
        check_files([file])
