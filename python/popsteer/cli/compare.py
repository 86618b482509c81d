"""``popsteer compare``: several laws on one track."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import typer

from popsteer import baselines, laws, presets, report, study
from popsteer.cli import inputs, options, outputs
from popsteer.cli.progress import Progress
from popsteer.files import check_folder
from popsteer.sim import Settings
from popsteer.sim.geometry import made

__all__ = ["HELP", "compare"]

HELP = """\
Drive several laws along one track, and set their figures beside the paper's.

Errors are measured at each law's own reference point, as the paper did (the rear axle for
Pure-Pursuit, the front axle for the others), and once more at the rear axle, one point for all.
The reference points are those of the plant's axles.

\b
Examples:
  popsteer compare
  popsteer compare --controllers stanley,pop --track figure-eight --out out
  popsteer compare --waypoints waypoints.csv --start=-183.8,78.7,-1.574 --out out
  popsteer compare --preset paper --plant kinematic-bicycle
  popsteer compare --plant commonroad-mb-2 --constant-speed 14 --start-offset 1
  popsteer compare --laws pop,mpc --step-time
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
            help=f"The laws, of {', '.join(laws.names())}; with the extra 'mpc' also"
            f" {', '.join(baselines.names())}.",
        ),
    ] = ",".join(study.DEFAULT_LAWS),
    preset: options.Preset = presets.REPRODUCTION,
    plant: options.Plant = "carla-identified",
    start: options.Start = None,
    start_offset: options.StartOffset = None,
    speed: options.Speed = None,
    constant_speed: options.ConstantSpeed = None,
    dt: options.Dt = options.DEFAULT_DT,
    step_time: Annotated[
        bool,
        typer.Option("--step-time", help="Measure how long a control step of each law takes."),
    ] = False,
    out: options.Out = None,
) -> None:
    """Drive several laws along one track."""
    names = inputs.names(controllers)
    course = inputs.course(waypoints, track, closed=closed)
    with Progress() as progress:
        vehicle = made(plant)
        params = study.parameters(names, preset, vehicle)
        if out is not None:
            check_folder(out, report.file_names(params))
        comparison = study.compare(
            course.path,
            params,
            vehicle,
            preset=preset,
            start=inputs.start(course.path, start, start_offset),
            speed=speed,
            constant_speed=constant_speed,
            settings=Settings(dt=dt),
            progress=progress.update,
        )
        comparison = replace(comparison, track=course.name)
        if step_time:
            comparison = study.time_steps(comparison, params, progress.update)
        outputs.deliver(comparison, out, progress)
