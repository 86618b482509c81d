"""``popsteer identify``: a vehicle from the log of a drive."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from popsteer import lab, vehicles
from popsteer._core import Vehicle
from popsteer.cli import inputs, logs, options
from popsteer.cli.assignments import assigned
from popsteer.cli.progress import Progress
from popsteer.cli.report import check, command_line
from popsteer.files import check_files, check_folder, write_files_atomic
from popsteer.identification import Identification

__all__ = ["HELP", "identify"]

HELP = """\
Identify a vehicle from the log of a drive.

LOG is a CSV file with the columns t, x, y, yaw, speed, steer [s, m, m, rad, m/s, rad], an MCAP file
or a ROS 2 bag with nav_msgs/Odometry and ackermann_msgs/AckermannDriveStamped (or Autoware's
command or steering report). steer is the angle of the front wheels that was commanded.

Prints what was found with its standard errors, and in words what the log does not show. Two minutes
of bends to both sides at several speeds, steered briskly, show everything. What a tape measure and
the manual say goes into --vehicle or --set-vehicle; without, the axles are where the motion of the
car puts them. Needs the extra "identify", and for bags "logs".

\b
Examples:
  popsteer identify drive.mcap --out car.toml
  popsteer identify drive.csv --unit steer=deg --unit speed=km/h --column yaw=heading
  popsteer identify drive.csv --set-vehicle wheelbase=2.7 --set-vehicle rear_axle=-1.35
  popsteer identify drive.csv --report drive.html
  popsteer identify bag/ --topic odometry=/localization/kinematic_state --figures figures
"""


def identify(
    *,
    log: logs.Log,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Write the vehicle, as popsteer.Vehicle.load and --vehicle read it.",
            show_default=False,
        ),
    ] = None,
    vehicle: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|FILE",
            help="What is known of the vehicle already: a file *.toml,"
            f" {', '.join(vehicles.names())}, or a plant's. What the log does not show stays.",
            show_default=False,
        ),
    ] = None,
    set_vehicle: options.SetVehicle = None,
    column: logs.Column = None,
    topic: logs.Topic = None,
    unit: logs.Unit = None,
    figures: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Draw measured against simulated yaw rate and position.",
            show_default=False,
        ),
    ] = None,
    csv: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Write the measured and the simulated motion.", show_default=False
        ),
    ] = None,
    json: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write what was found as JSON.", show_default=False),
    ] = None,
    report: options.Report = None,
    context: typer.Context,
) -> None:
    """Identify a vehicle from the log of a drive."""
    from rich.console import Console
    from rich.text import Text

    from popsteer.identification import identify as identified
    from popsteer.lab.identify import caption, identified_csv, identified_json, identified_table
    from popsteer.lab.identify.table import FILES
    from popsteer.vehicle_file import as_toml

    told: Vehicle | None = None
    if vehicle is not None or set_vehicle:
        base = Vehicle() if vehicle is None else inputs.named_vehicle(vehicle)
        told = assigned(base, set_vehicle or [], "the vehicle")
    check_files([file for file in (out, csv, json) if file is not None])
    if figures is not None:
        check_folder(figures, FILES)
    check(report)
    with Progress() as progress:
        drive = logs.read(log, column, topic, unit, progress)
        found = identified(drive, told, progress=lambda share: progress.update("identify", share))
        drawn = {} if figures is None else _drawn(found, figures, progress)
    texts = {csv: identified_csv(found), json: identified_json(found), out: as_toml(found.vehicle)}
    written = {file: text.encode() for file, text in texts.items() if file is not None}
    if report is not None:
        origin = lab.report.Origin(command_line(context))
        written[report] = lab.report.of_identification(found, told, origin)
    write_files_atomic({**drawn, **written})
    console = Console()
    console.print(Text(caption(found), style="bold"), soft_wrap=True)
    console.print()
    console.print(identified_table(found, told))
    if found.notes:
        console.print()
    for note in found.notes:
        console.print(Text(f"- {note}", style="dim"), soft_wrap=not console.is_terminal)
    if drawn:
        print(f"Written to {figures}: {', '.join(file.name for file in drawn)}")
    for file in written:
        print(f"Written to {file}")


def _drawn(found: Identification, folder: Path, progress: Progress) -> dict[Path, bytes]:
    """Draw the figures that go into a folder."""
    from popsteer.lab.identify.figure import identified_files

    return {folder / name: data for name, data in identified_files(found, progress.update).items()}
