"""``popsteer matrix``: controllers × plants × tracks."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from popsteer import lab, presets
from popsteer.cli import inputs, options
from popsteer.cli.progress import Progress
from popsteer.files import check_folder
from popsteer.sim import Settings, vehicle_of

__all__ = ["HELP", "matrix"]

_FILES = (
    *("matrix.csv", "matrix.md", "matrix.json"),
    *(f"matrix{theme}.{kind}" for theme in ("", "-dark") for kind in ("png", "svg")),
)

HELP = """\
Drive several controllers on several plants along several tracks, and time a step of each.

Prints a table; with --out also writes it (matrix.csv, matrix.md), all metrics (matrix.json), and a
figure of the error against the time of a step. A run that does not finish
says why: a plant's limit is named.

\b
Examples:
  popsteer matrix
  popsteer matrix --laws pop,mpc --plants carla-identified,commonroad-mb-2 --constant-speed 10
  popsteer matrix --tracks slalom --start-offset 0
  popsteer matrix --plants car.toml,loaded-car.toml --vehicle car.toml
  popsteer matrix --tracks racetrack,slalom --waypoints waypoints.csv --out out
"""


def matrix(
    *,
    laws: Annotated[
        str,
        typer.Option(
            metavar="LAWS",
            help=f"The controllers, of {', '.join(lab.common.names.controller_names())}.",
        ),
    ] = ",".join(lab.compare.runs.DEFAULT_CONTROLLERS),
    plants: Annotated[
        str, typer.Option(metavar="PLANTS", help="The plants, as compare's --plant names them.")
    ] = "carla-identified,kinematic-bicycle",
    tracks: Annotated[
        str | None,
        typer.Option(
            metavar="TRACKS",
            help=f"Shipped tracks; {inputs.DEFAULT_TRACK} where no --waypoints are given.",
            show_default=False,
        ),
    ] = None,
    vehicle: options.Vehicle = None,
    set_vehicle: options.SetVehicle = None,
    waypoints: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FILE",
            help="Waypoints to follow besides; may be given again and again.",
            show_default=False,
        ),
    ] = None,
    preset: options.Preset = presets.REPRODUCTION,
    start_offset: options.StartOffset = None,
    constant_speed: options.ConstantSpeed = None,
    dt: options.Dt = options.DEFAULT_DT,
    out: options.Out = None,
) -> None:
    """Drive controllers on plants along tracks."""
    from rich.console import Console

    from popsteer import lab
    from popsteer.lab.common.vehicle import differences
    from popsteer.lab.matrix.table import matrix_files, matrix_table

    files = waypoints or []
    default = None if files else inputs.DEFAULT_TRACK
    shipped = [] if (tracks or default) is None else inputs.names(tracks or default or "")
    courses = [inputs.course(None, name, closed=False) for name in shipped]
    courses += [inputs.course(file, None, closed=False) for file in files]
    if out is not None:
        check_folder(out, _FILES)
    with Progress() as progress:
        movers = {name: inputs.plant(name) for name in inputs.names(plants)}
        told = {
            name: inputs.believed(vehicle, set_vehicle, vehicle_of(mover))
            for name, mover in movers.items()
        }
        found = lab.matrix.run(
            {course.name: course.path for course in courses},
            inputs.names(laws),
            movers,
            vehicle=told,
            preset=preset,
            start_offset=start_offset,
            constant_speed=constant_speed,
            settings=Settings(dt=dt),
            progress=progress.update,
        )
        said = "--out DIR writes matrix.csv, matrix.md, matrix.json and the figure."
        if out is not None:
            content = matrix_files(found)
            lab.common.files.write(content, out)
            said = f"Written to {out}{os.sep}: {', '.join(sorted(content))}"
        progress.stop()
    console = Console()
    if not console.is_terminal:
        console = Console(width=160)
    console.print(matrix_table(found))
    for name, believed in told.items():
        if otherwise := differences(believed, vehicle_of(movers[name])):
            print(f"{name}{otherwise}")
    print(said)
