"""``popsteer identify``: a vehicle from the log of a drive."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from popsteer import lab
from popsteer._core import Vehicle
from popsteer.cli import inputs, options, outputs
from popsteer.cli.options import optional
from popsteer.cli.outputs import Progress
from popsteer.files import write_files_atomic
from popsteer.identification import Identification

HELP = """\
Identify a vehicle from the log of a drive.

LOG is a table with t, x, y, yaw, speed, steer [s, m, m, rad, m/s, rad], MCAP, or a ROS 2 bag. steer
is the angle of the front wheels that was commanded. Two minutes of bends to both sides at several
speeds, steered briskly, show everything; notes say what a log does not show. Give what a tape
measure and the manual say by --vehicle or --set-vehicle. See docs/identify.md.

\b
Examples:
  popsteer identify drive.mcap --out car.toml
  popsteer identify drive.csv --unit steer=deg --columns yaw=heading
  popsteer identify drive.csv --set-vehicle wheelbase=2.7
  popsteer identify bag/ --topic odometry=/ego/odom --report drive.html
"""


def identify(
    *,
    log: options.Log,
    out: Annotated[
        Path | None,
        optional("FILE", "File for the vehicle, *.toml; a figure and data are written beside it."),
    ] = None,
    vehicle: Annotated[
        str | None, optional("NAME|FILE", "What is known already: a vehicle *.toml or a name.")
    ] = None,
    set_vehicle: options.SetVehicle = None,
    columns: options.Columns = None,
    origin: options.Origin = None,
    topic: options.Topic = None,
    unit: options.Unit = None,
    course: Annotated[
        bool, options.flag("--course", "The yaw is the course over ground, not the heading.")
    ] = False,
    stops: Annotated[
        Path | None, optional("LOG", "A second log, of stops and starts, to learn the drive.")
    ] = None,
    report: options.Report = None,
    context: typer.Context,
) -> None:
    """Identify a vehicle from the log of a drive."""
    from popsteer.identification import identify as identified
    from popsteer.lab.identify import caption, identified_table

    given: Vehicle | None = None
    if vehicle is not None or set_vehicle:
        given = inputs.believed(vehicle, set_vehicle)
    outputs.check_file(out, report, ".toml")
    with Progress() as progress:
        how = columns, topic, unit, origin, progress
        drive = inputs.log(log, *how)
        second = None if stops is None else inputs.log([stops], *how)
        update = partial(progress.update, "identify")
        update(0.0)
        found = identified(drive, given, course=course, stops=second, progress=update)
        told = inputs.told(vehicle, set_vehicle)
        content = {} if out is None else _files(found, told, out, progress)
    nothing = "--out FILE writes the vehicle, and a figure of how well it explains the log."
    said = outputs.written(out, (file for file in content if file != out), nothing)
    write_files_atomic(content)
    below = (found.verdict, found.driven, *(f"- {note}" for note in found.notes))
    shown = caption(found), [identified_table(found, given)], below, said, report, [drive.source]
    made_by = lab.report.Origin(outputs.command_line(context))
    outputs.show(*shown, lambda _: lab.report.of_identification(found, given, made_by))


def _files(
    found: Identification, told: set[str], out: Path, progress: Progress
) -> dict[Path, bytes]:
    from popsteer.lab.identify import identified_csv, identified_json
    from popsteer.lab.identify.figure import identified_figure

    content = {
        out: found.as_toml(told).encode(),
        out.with_suffix(".json"): identified_json(found).encode(),
        out.with_name(f"{out.stem}-motion.csv"): identified_csv(found).encode(),
    }
    return content | outputs.draw_figures(out, partial(identified_figure, found), progress)
