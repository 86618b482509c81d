"""``popsteer paper``: the paper's experiment."""

from __future__ import annotations

from dataclasses import replace

import typer

from popsteer import lab, presets
from popsteer.cli import inputs, options, outputs
from popsteer.cli.outputs import Progress
from popsteer.lab.compare.runs import DEFAULT_CONTROLLERS, parameters
from popsteer.sim import CarlaIdentified

HELP = """\
Drive the paper's experiment: its four controllers with its tuning and its pedals.

The plant is the vehicle identified from the run that the authors recorded, the path the shipped
race track, or --waypoints. On the authors' own waypoints (carla_racetrack) the start is theirs, and
the table has the paper's figures beside those measured. popsteer compare drives controllers with
their defaults.

\b
Examples:
  popsteer paper
  popsteer paper --out out
  popsteer paper --waypoints waypoints.csv --columns x,y,speed
"""


def paper(
    *,
    preset: options.Preset = presets.REPRODUCTION,
    waypoints: options.Waypoints = None,
    columns: options.Columns = None,
    out: options.Out = None,
    report: options.Report = None,
    context: typer.Context,
) -> None:
    """Drive the paper's experiment."""
    course = inputs.course(waypoints, None, closed=False, columns=columns)
    params = parameters(DEFAULT_CONTROLLERS, preset)
    outputs.check_folder(out, lab.compare.files.file_names(DEFAULT_CONTROLLERS), report)
    with Progress() as progress:
        found = lab.compare.paper.run(course.path, preset, progress.update)
        found = replace(found, track=course.name)
        line, driven = outputs.command_line(context), {found.plant: CarlaIdentified()}
        origin = lab.report.Origin(line, params, plants=driven)
        outputs.deliver([found], out, progress, report, origin)
