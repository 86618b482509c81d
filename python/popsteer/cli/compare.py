"""``popsteer compare``: several controllers on one track."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Literal

import typer

from popsteer import controllers, lab, presets, sim
from popsteer.cli import inputs, options, outputs
from popsteer.cli.progress import Progress
from popsteer.files import check_folder
from popsteer.lab import baselines
from popsteer.sim import Settings

__all__ = ["HELP", "compare"]

HELP = """\
Drive several controllers along one track, and set their figures beside the paper's.

Errors are measured at each controller's own tracked point, as the paper did (the rear axle for
Pure-Pursuit, the front axle for the others), and once more at the rear axle, one point for all.
The controllers are told the plant's vehicle, unless --vehicle or --set-vehicle says otherwise.

\b
Examples:
  popsteer compare
  popsteer compare --controllers stanley,pop --track figure-eight --out out
  popsteer compare --waypoints waypoints.csv --start=-183.797,79.760,-1.574 --out out
  popsteer compare --waypoints waypoints.csv --start=-183.8,78.7,-1.574 --start-at front
  popsteer compare --preset paper --plant kinematic-bicycle
  popsteer compare --plant commonroad-mb-2 --constant-speed 14 --start-offset 1
  popsteer compare --laws pop,mpc --step-time
  popsteer compare --plant car.toml --set-vehicle dead_time=0
  popsteer compare --vehicle car.toml --plant heavier-car.toml
"""


def compare(
    *,
    waypoints: options.Waypoints = None,
    track: options.Track = None,
    closed: options.Closed = False,
    controllers: Annotated[
        str,
        typer.Option(
            "--controllers",
            "--laws",
            metavar="LAWS",
            help=f"The controllers, of {', '.join(controllers.names())}; with the extra 'mpc' also"
            f" {', '.join(baselines.names())}.",
        ),
    ] = ",".join(lab.compare.runs.DEFAULT_CONTROLLERS),
    preset: options.Preset = presets.REPRODUCTION,
    plant: options.Plant = "carla-identified",
    vehicle: options.Vehicle = None,
    set_vehicle: options.SetVehicle = None,
    no_adapt: options.NoAdapt = False,
    start: options.Start = None,
    start_at: options.StartAt = "pose",
    start_offset: options.StartOffset = None,
    speed: options.Speed = None,
    constant_speed: options.ConstantSpeed = None,
    dt: options.Dt = options.DEFAULT_DT,
    step_time: Annotated[
        bool,
        typer.Option(
            "--step-time", help="Measure how long a control step of each controller takes."
        ),
    ] = False,
    out: options.Out = None,
) -> None:
    """Drive several controllers along one track."""
    names = inputs.names(controllers)
    course = inputs.course(waypoints, track, closed=closed)
    with Progress() as progress:
        mover = inputs.plant(plant)
        itself = sim.vehicle_of(mover)
        told = inputs.believed(vehicle, set_vehicle, itself)
        begin = inputs.start(course.path, start, start_at, start_offset, itself)
        params = lab.compare.parameters(names, preset)
        adapt: Literal["auto"] | None = None if no_adapt else "auto"
        if out is not None:
            check_folder(out, lab.compare.files.file_names(params))
        comparison = lab.compare.run(
            course.path,
            params,
            mover,
            vehicle=told,
            adapt=adapt,
            preset=preset,
            start=begin.pose,
            start_at=begin.at,
            speed=speed,
            constant_speed=constant_speed,
            settings=Settings(dt=dt),
            progress=progress.update,
        )
        comparison = replace(comparison, track=course.name, plant=inputs.plant_label(plant))
        if step_time:
            comparison = lab.compare.time_steps(comparison, params, progress.update, adapt=adapt)
        outputs.deliver(comparison, out, progress)
