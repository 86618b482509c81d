"""``popsteer dead-time``: steering delay, and controllers that predict through it."""

from __future__ import annotations

from typing import Annotated

import typer

from popsteer import lab, presets
from popsteer.cli import inputs, options
from popsteer.cli.outputs import deliver_table
from popsteer.cli.progress import Progress
from popsteer.errors import ConfigError
from popsteer.files import check_files
from popsteer.sim import CarlaIdentified, KinematicBicycle

__all__ = ["HELP", "dead_time"]

HELP = """\
Drive the controllers with dead time between command and wheels, and with a prediction through it.

For each controller: without dead time; with it, and the controller told of none; with it, and told:
it sees the vehicle as it will be when its command arrives; and the same told that the vehicle turns
as with a wheelbase 15 % shorter or longer than it does, and told 50 ms less or more.

\b
Examples:
  popsteer dead-time
  popsteer dead-time --laws pop,stanley --dead-time 0.1
  popsteer dead-time --no-adapt
  popsteer dead-time --plant car.toml --track slalom
  popsteer dead-time --waypoints waypoints.csv --start=-183.797,79.760,-1.574 --json dead-time.json
"""


def dead_time(
    *,
    laws: Annotated[
        str,
        typer.Option(
            metavar="LAWS",
            help=f"The controllers, of {', '.join(lab.delay.runs.DEAD_TIME_CONTROLLERS)}.",
        ),
    ] = ",".join(lab.delay.runs.DEAD_TIME_CONTROLLERS),
    dead_time: Annotated[
        float,
        typer.Option(
            metavar="SECONDS", help="Time from a command to its first effect on the wheels."
        ),
    ] = lab.delay.runs.DEAD_TIME,
    no_adapt: options.NoAdapt = False,
    plant: Annotated[
        str,
        typer.Option(
            metavar="NAME|FILE",
            help="What moves: carla-identified, kinematic-bicycle, or a file *.toml of a vehicle.",
        ),
    ] = "carla-identified",
    waypoints: options.Waypoints = None,
    closed: options.Closed = False,
    track: options.Track = None,
    start: options.Start = None,
    start_at: options.StartAt = "pose",
    preset: options.Preset = presets.REPRODUCTION,
    csv: options.Csv = None,
    json: options.Json = None,
) -> None:
    """Drive the controllers with dead time and with a prediction through it."""
    from popsteer.lab.delay.table import (
        delay_caption,
        delay_csv,
        delay_json,
        delay_table,
    )

    course = inputs.course(waypoints, track, closed=closed)
    check_files(file for file in (csv, json) if file is not None)
    mover = _plant(plant)
    begin = inputs.start(course.path, start, start_at, None, mover.vehicle)
    with Progress() as progress:
        rows = lab.delay.run(
            course.path,
            inputs.names(laws),
            plant=mover,
            start=begin.pose,
            start_at=begin.at,
            preset=preset,
            dead_time=dead_time,
            adapt=None if no_adapt else "auto",
            progress=progress.update,
        )
    deliver_table(
        delay_caption(rows, course.name, mover),
        delay_table(rows),
        csv=(csv, lambda: delay_csv(rows)),
        json=(json, lambda: delay_json(rows, course.name, mover)),
    )


def _plant(text: str) -> CarlaIdentified | KinematicBicycle:
    """Give a plant whose vehicle can be given a dead time."""
    found = inputs.plant(text)
    if not isinstance(found, CarlaIdentified | KinematicBicycle):
        raise ConfigError("--plant", text, f"{', '.join(inputs.PLANTS)} or a file *.toml")
    return found
