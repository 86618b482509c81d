"""``popsteer dead-time``: late wheels, and laws that see ahead of them."""

from __future__ import annotations

from typing import Annotated

import typer

from popsteer import presets, study
from popsteer.cli import inputs, options
from popsteer.cli.outputs import deliver_table
from popsteer.cli.progress import Progress
from popsteer.files import check_files
from popsteer.sim.geometry import LEARNING_TIME

__all__ = ["HELP", "dead_time"]

HELP = """\
Drive the laws with dead time between command and wheels, and with an actuator that predicts it.

For each law: without dead time; with it, and nothing done about it; with it, and the law shown the
vehicle as it will be when its command arrives; and the same with the model's wheelbase 15 % wrong
and its dead time 50 ms wrong. The plant is the one identified from the run of the paper's authors.

\b
Examples:
  popsteer dead-time
  popsteer dead-time --laws pop,stanley --dead-time 0.1
  popsteer dead-time --learning-time 0
  popsteer dead-time --waypoints waypoints.csv --start=-183.8,78.7,-1.574 --json dead-time.json
"""


def dead_time(
    *,
    laws: Annotated[
        str, typer.Option(metavar="LAWS", help=f"The laws, of {', '.join(study.DEAD_TIME_LAWS)}.")
    ] = ",".join(study.DEAD_TIME_LAWS),
    dead_time: Annotated[
        float,
        typer.Option(
            metavar="SECONDS", help="Time from a command to its first effect on the wheels."
        ),
    ] = study.DEAD_TIME,
    learning_time: Annotated[
        float,
        typer.Option(
            metavar="SECONDS",
            help="Time over which the actuator learns how wrong its model is; 0 never.",
        ),
    ] = LEARNING_TIME,
    waypoints: options.Waypoints = None,
    closed: options.Closed = False,
    track: options.Track = None,
    start: options.Start = None,
    preset: options.Preset = presets.REPRODUCTION,
    csv: options.Csv = None,
    json: options.Json = None,
) -> None:
    """Drive the laws with dead time and with an actuator that predicts it."""
    from popsteer.report.dead_time import (
        dead_time_caption,
        dead_time_csv,
        dead_time_json,
        dead_time_table,
    )

    course = inputs.course(waypoints, track, closed=closed)
    check_files(file for file in (csv, json) if file is not None)
    with Progress() as progress:
        rows = study.dead_times(
            course.path,
            inputs.names(laws),
            start=inputs.start(course.path, start, None),
            preset=preset,
            dead_time=dead_time,
            learning_time=learning_time,
            progress=progress.update,
        )
    deliver_table(
        dead_time_caption(rows, course.name),
        dead_time_table(rows),
        csv=(csv, lambda: dead_time_csv(rows)),
        json=(json, lambda: dead_time_json(rows, course.name)),
    )
