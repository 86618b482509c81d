"""``popsteer compare``: several controllers on one track."""

from __future__ import annotations

from typing import Annotated

import typer

from popsteer import lab, presets, sim
from popsteer.cli import inputs, options, outputs, vehicle_inputs
from popsteer.cli.progress import Progress
from popsteer.cli.report import check, command_line
from popsteer.files import check_folder
from popsteer.lab.common.longitudinal import made
from popsteer.lab.compare.runs import DEFAULT_CONTROLLERS
from popsteer.sim import Settings

__all__ = ["HELP", "compare"]

_CONTROLLERS = ",".join(DEFAULT_CONTROLLERS)

HELP = """\
Drive several controllers along one track and show their errors beside the paper's.

Errors are measured at the point that each controller tracks, as in the paper: the rear axle for
Pure-Pursuit, the front axle for the paper's other controllers. They are measured again at the rear
axle, which is the same point for all. The controllers know the plant's vehicle unless --vehicle or
--set-vehicle gives them another.

\b
Examples:
  popsteer compare
  popsteer compare --controllers stanley,pop --track figure-eight --out out
  popsteer compare --waypoints waypoints.csv --start=-183.797,79.760,-1.574 --out out
  popsteer compare --waypoints waypoints.csv --start=-183.8,78.7,-1.574 --start-at front
  popsteer compare --preset paper --plant kinematic-bicycle
  popsteer compare --plant commonroad-mb-2 --constant-speed 14 --start-offset 1
  popsteer compare --waypoints course.csv --longitudinal speed-tracker
  popsteer compare --controllers pop,mpc --step-time
  popsteer compare --track slalom --report slalom.html
  popsteer compare --plant car.toml --set-vehicle dead_time=0
  popsteer compare --vehicle car.toml --plant heavier-car.toml
"""


def compare(
    *,
    controllers: options.Controllers = _CONTROLLERS,
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
    step_time: Annotated[
        bool, typer.Option("--step-time", help="Measure the time of a control step as well.")
    ] = False,
    out: options.Out = None,
    report: options.Report = None,
    context: typer.Context,
) -> None:
    """Drive several controllers along one track."""
    names = inputs.names("--controllers", controllers)
    course = inputs.course(waypoints, track, closed=closed)
    chosen = inputs.longitudinal(longitudinal, set_longitudinal, constant_speed)
    with Progress() as progress:
        mover = vehicle_inputs.plant(plant, set_plant)
        itself = sim.vehicle_of(mover)
        given = vehicle_inputs.believed(vehicle, set_vehicle, itself)
        begin = inputs.start(course.path, start, start_at, start_offset, itself)
        tuning = inputs.tuned(names, preset, set_, no_adapt=no_adapt, params=params)
        if out is not None:
            check_folder(out, lab.compare.files.file_names(tuning.params))
        check(report)
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
            settings=Settings(dt=dt),
        )
        if step_time:
            comparison = lab.compare.time_steps(
                comparison, tuning.params, progress.update, adapt=tuning.adapt
            )
        origin = lab.report.Origin(
            command_line(context), tuning.params, tuning.adapt, {comparison.plant: mover}
        )
        outputs.deliver(comparison, out, progress, report, origin)
