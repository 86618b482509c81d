"""``popsteer compare``: controllers on one track, every parameter at hand."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from popsteer import controllers as own_controllers
from popsteer import lab, sim
from popsteer._core import AdaptParams, Vehicle
from popsteer.cli import inputs, options, outputs
from popsteer.cli.assignments import assigned, listed
from popsteer.cli.options import flag, optional
from popsteer.cli.outputs import Progress
from popsteer.errors import ConfigError
from popsteer.files import check_files
from popsteer.lab import baselines
from popsteer.lab.common.longitudinal import KINDS, made
from popsteer.lab.compare.runs import DEFAULT_CONTROLLERS
from popsteer.plants.pedals import MujocoCarParams, PedalParams
from popsteer.sim import Settings
from popsteer.sim.geometry import CORE_PLANTS

_CONTROLLERS = ",".join(DEFAULT_CONTROLLERS)
# What goes with --replay-run.
_WITH_IT = ("replay_run", "out", "report")

_PLANT_PARAMS = {**CORE_PLANTS, "commonroad-...": PedalParams, "mujoco-car": MujocoCarParams}
# What --set and its like change: a section of the help for each class of parameters.
_SECTIONS: list[tuple[str, type[object]]] = [
    *(
        (f"--controllers {name}, parameters for --set:", of.get(name).params)
        for of in (own_controllers, baselines)
        for name in of.names()
    ),
    ("Estimation of the controllers of popsteer, parameters for --set:", AdaptParams),
    (
        "The vehicle, fields for --set-vehicle, and for --set-plant of the first two plants:",
        Vehicle,
    ),
    *(
        (f"--plant {name}, parameters for --set-plant:", kind)
        for name, kind in _PLANT_PARAMS.items()
    ),
    *(
        (f"--longitudinal {name}, parameters for --set-longitudinal:", kind)
        for name, kind in KINDS.items()
    ),
    ("Parameters for --set-run:", Settings),
]

HELP = """\
Drive controllers along one track and show their errors.

Errors are measured at the point that each controller tracks, as in the paper: the rear axle for
Pure-Pursuit, the front axle for the paper's other controllers. They are measured again at the rear
axle, which is the same point for all. The controllers know the plant's vehicle unless --vehicle or
--set-vehicle gives them another.

Each controller has its defaults, unless --preset or --params gives it another tuning; popsteer
paper is the paper's own experiment. --set then changes any parameter of the controllers that have
it or of their estimation, --set-plant one of the plant or of its vehicle, --set-vehicle one of the
vehicle that the controllers are given, --set-longitudinal one of the pedals, --set-run one of the
run. All of them can be repeated; the parameters are listed below.

\b
Examples:
  popsteer compare
  popsteer compare --controllers stanley,pop --track figure-eight --out out
  popsteer compare --waypoints waypoints.csv --start=-183.797,79.760,-1.574 --out out
  popsteer compare --preset paper --plant kinematic-bicycle
  popsteer compare --plant commonroad-mb-2 --constant-speed 14 --start-offset 1
  popsteer compare --waypoints course.csv --longitudinal speed-tracker
  popsteer compare --controllers pop,mpc --step-time
  popsteer compare --track slalom --report slalom.html
  popsteer compare --plant car.toml --set-vehicle dead_time=0
  popsteer compare --vehicle car.toml --plant heavier-car.toml
  popsteer compare --controllers pop --set lookahead_gain=0.3 --set min_lookahead=4
  popsteer compare --controllers pop --longitudinal speed-pid --set-longitudinal kp=0.8
  popsteer compare --plant mujoco-car --set-plant friction=0.6 --constant-speed 12
  popsteer compare --plant kinematic-bicycle --set-plant wheelbase=2.5 --set-run time_limit=60
  popsteer compare --controllers preview-pop --record drive.mcap
  popsteer compare --replay-run sweep.parquet:17 --out out

""" + "\n".join(
    # \b keeps the lines as they are.
    f"\b\n{title}\n{listed(kind, without=['vehicle'])}\n"
    for title, kind in _SECTIONS
)


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
        list[str] | None, optional("NAME=VALUE", "Set a parameter of the run. Can be repeated.")
    ] = None,
    replay_run: Annotated[
        str | None,
        optional(
            "FILE:RUN",
            "Drive one run of a popsteer sweep's FILE again, equal to the last bit."
            " Only --out and --report go with it.",
        ),
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
    if replay_run is not None:
        _replay_run(replay_run, out, report, context)
        return
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

        print(f"Written to {record}: {record_run(comparison.first, record)} messages")


def _check_record(file: Path | None, controllers: list[str]) -> None:
    if file is not None:
        if file.suffix != ".mcap":
            raise ConfigError("--record", str(file), "a file *.mcap")
        if len(controllers) > 1:
            raise ConfigError("--record", str(file), "given with one controller")
        check_files([file])


def _replay_run(text: str, out: Path | None, report: Path | None, context: typer.Context) -> None:
    """Drive one run of a sweep, given as ``FILE:RUN``, and compare it with its row."""
    options.check_alone(context, "--replay-run", _WITH_IT)
    file, _, number = text.rpartition(":")
    if not file or not number.isdecimal():
        raise ConfigError("--replay-run", text, "written FILE:RUN")
    run = int(number)
    job, row = lab.sweep.rows.read_row(Path(file), run)
    outputs.check_folder(out, lab.compare.files.file_names([job.controller]), report)
    with Progress() as progress:
        found = lab.sweep.repeat(job, run, progress=partial(progress.update, job.controller))
        drawn = ", ".join(f"{name} {value:.6g}" for name, value in job.drawn(run).items())
        comparison = lab.compare.Comparison(
            {job.controller: found},
            {job.controller: f"run {run} of {Path(file).name}"},
            plant=job.label,
            track=job.course,
        )
        made_by = lab.report.Origin(
            outputs.command_line(context),
            {job.controller: job.params},
            job.adapt,
            {job.label: job.made(run).plant},
            job.monitor,
        )
        outputs.deliver(comparison, out, progress, report, made_by)
    figures = vars(found.metrics)
    same = all(row[name] == figures[name] or row[name] != row[name] for name in figures)
    print(f"Drawn: {drawn or 'nothing'}.")
    said = "to the last bit what its row says" if same else "NOT what its row says"
    print(f"Run {run} of {file} is {said}; it {'succeeded' if row['success'] else 'failed'}.")
