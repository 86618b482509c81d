"""``popsteer simulate``: one controller, every parameter at hand."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Annotated

import typer

from popsteer import controllers, lab, presets
from popsteer._core import AdaptParams, Vehicle
from popsteer.cli import inputs, options, outputs, vehicle_inputs
from popsteer.cli.assignments import assigned, listed
from popsteer.cli.progress import Progress
from popsteer.cli.report import check, command_line
from popsteer.errors import ConfigError
from popsteer.files import check_files, check_folder
from popsteer.lab import baselines
from popsteer.lab.common.longitudinal import KINDS, made
from popsteer.plants.pedals import MujocoCarParams, PedalParams
from popsteer.sim import Settings, vehicle_of
from popsteer.sim.geometry import CORE_PLANTS

__all__ = ["HELP", "simulate"]

_PARAMS = {**CORE_PLANTS, "commonroad-...": PedalParams, "mujoco-car": MujocoCarParams}


def _section(title: str, kind: type[object]) -> str:
    # \b keeps the lines as they are.
    return f"\b\n{title}\n{listed(kind, without=['vehicle'])}\n"


HELP = "\n".join(
    [
        """\
Drive one controller along a track, with all its parameters at hand.

--preset chooses the controller's tuning. --set then changes any parameter of the controller or of
its estimation, --set-plant one of the plant or of its vehicle, --set-vehicle one of the vehicle
that the controller is given, --set-longitudinal one of the pedals, --set-run one of the run. All of
them can be repeated.

\b
Examples:
  popsteer simulate --controller pop --set lookahead_gain=0.3 --set min_lookahead=4
  popsteer simulate --controller pid --preset published-code --out out
  popsteer simulate --longitudinal speed-pid --set-longitudinal kp=0.8
  popsteer simulate --waypoints course.csv --plant car.toml --longitudinal speed-tracker
  popsteer simulate --plant mujoco-car --set-plant friction=0.6 --constant-speed 12
  popsteer simulate --plant kinematic-bicycle --set-plant wheelbase=2.5 --set-run time_limit=60
  popsteer simulate --replay-run sweep.parquet:17 --out out
  popsteer simulate --controller preview-pop --set-vehicle turning_wheelbase=3.02 --set turn_time=2
""",
        *(
            _section(f"--controller {name}, parameters for --set:", controllers.get(name).params)
            for name in controllers.names()
        ),
        *(
            _section(f"--controller {name}, parameters for --set:", baselines.get(name).params)
            for name in baselines.names()
        ),
        _section("Estimation of the controllers of popsteer, parameters for --set:", AdaptParams),
        _section(
            "The vehicle, fields for --set-vehicle, and for --set-plant of the first two plants:",
            Vehicle,
        ),
        *(
            _section(f"--plant {name}, parameters for --set-plant:", kind)
            for name, kind in _PARAMS.items()
        ),
        *(
            _section(f"--longitudinal {name}, parameters for --set-longitudinal:", kind)
            for name, kind in KINDS.items()
        ),
        _section("Parameters for --set-run:", Settings),
    ]
)


def simulate(
    *,
    controller: options.Controller = "pop",
    preset: options.Preset = presets.REPRODUCTION,
    params: options.Params = None,
    set_: options.Set = None,
    waypoints: options.Waypoints = None,
    track: options.Track = None,
    closed: options.Closed = False,
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
        list[str] | None,
        options.optional("NAME=VALUE", "Set a parameter of the run. Can be repeated."),
    ] = None,
    replay_run: Annotated[
        str | None,
        options.optional(
            "FILE:RUN",
            "Drive one run of a popsteer sweep's FILE again, equal to the last bit."
            " Only --out and --report go with it.",
        ),
    ] = None,
    record: options.Record = None,
    out: options.Out = None,
    report: options.Report = None,
    context: typer.Context,
) -> None:
    """Drive one controller along a track."""
    if replay_run is not None:
        _alone(context)
        _again(replay_run, out, report, command_line(context))
        return
    mover = vehicle_inputs.plant(plant, set_plant)
    itself = vehicle_of(mover)
    given = vehicle_inputs.believed(vehicle, set_vehicle, itself)
    tuning = inputs.tuned([controller], preset, set_, no_adapt=no_adapt, params=params)
    chosen = inputs.longitudinal(longitudinal, set_longitudinal, constant_speed)
    settings = assigned(Settings(dt=dt), set_run or [], "the run")
    course = inputs.course(waypoints, track, closed=closed)
    begin = inputs.start(course.path, start, start_at, start_offset, itself)
    if out is not None:
        check_folder(out, lab.compare.files.file_names([controller]))
    _check_record(record)
    check(report)
    with Progress() as progress:
        comparison = outputs.driven(
            course,
            tuning,
            mover,
            vehicle_inputs.plant_label(plant),
            progress,
            vehicle=given,
            start=begin.pose,
            start_at=begin.at,
            speed=speed,
            constant_speed=constant_speed,
            longitudinal=made(chosen, course.path, given),
            settings=settings,
        )
        origin = lab.report.Origin(
            command_line(context), tuning.params, tuning.adapt, {comparison.plant: mover}
        )
        outputs.deliver(comparison, out, progress, report, origin)
    _write_record(comparison, record)


def _check_record(file: FilePath | None) -> None:
    """Refuse a file that could not be written, before anything is driven."""
    if file is not None:
        if file.suffix != ".mcap":
            raise ConfigError("--record", str(file), "a file *.mcap")
        check_files([file])


def _write_record(comparison: lab.compare.Comparison, file: FilePath | None) -> None:
    if file is not None:
        from popsteer.adapters.ros2.recording import record_run

        print(f"Written to {file}: {record_run(comparison.first, file)} messages")


def _alone(context: typer.Context) -> None:
    """Refuse options that would change the run."""
    for name, value in context.params.items():
        source = context.get_parameter_source(name)
        if (
            name not in ("replay_run", "out", "report")
            and source is not None
            and source.name != "DEFAULT"
        ):
            option = f"--{name.rstrip('_').replace('_', '-')}"
            raise ConfigError(option, value, "left out where --replay-run is given")


def _again(text: str, out: FilePath | None, report: FilePath | None, command: str) -> None:
    """Drive one run of a sweep again."""
    file, _, number = text.rpartition(":")
    if not file or not number.isdecimal():
        raise ConfigError("--replay-run", text, "written FILE:RUN")
    run = int(number)
    job, row = lab.sweep.rows.read_row(FilePath(file), run)
    if out is not None:
        check_folder(out, lab.compare.files.file_names([job.controller]))
    check(report)
    with Progress() as progress:
        found = lab.sweep.repeat(
            job, run, progress=lambda share: progress.update(job.controller, share)
        )
        drawn = ", ".join(f"{name} {value:.6g}" for name, value in job.drawn(run).items())
        comparison = lab.compare.Comparison(
            {job.controller: found},
            preset=f"run {run} of {FilePath(file).name}",
            plant=job.label,
            track=job.course,
        )
        varied = job.made(run).plant
        origin = lab.report.Origin(
            command, {job.controller: job.params}, job.adapt, {job.label: varied}
        )
        outputs.deliver(comparison, out, progress, report, origin)
    figures = vars(found.metrics)
    same = all(row[name] == figures[name] or row[name] != row[name] for name in figures)
    print(f"Drawn: {drawn or 'nothing'}.")
    said = "to the last bit what its row says" if same else "NOT what its row says"
    print(f"Run {run} of {file} is {said}; it {'succeeded' if row['success'] else 'failed'}.")
