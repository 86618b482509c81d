"""Options that several commands have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from popsteer import plants, presets, sim, tracks, vehicles
from popsteer.sim import Settings
from popsteer.sim.closed_loop import START_OFFSET

__all__ = [
    "DEFAULT_DT",
    "Closed",
    "ConstantSpeed",
    "Csv",
    "Dt",
    "Json",
    "NoAdapt",
    "Out",
    "Plant",
    "Preset",
    "SetVehicle",
    "Speed",
    "Start",
    "StartAt",
    "StartOffset",
    "Track",
    "Vehicle",
    "Waypoints",
]

Waypoints: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Waypoints to follow: a row for each with x [m], y [m] and, optionally, reference"
        " speed [m/s], separated by commas or white space; # starts a comment.",
        show_default=False,
    ),
]
Track: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="NAME",
        help=f"Shipped track to follow: {', '.join(tracks.names())}. By default the first.",
        show_default=False,
    ),
]
Closed: TypeAlias = Annotated[
    bool, typer.Option("--closed", help="The last waypoint of FILE joins its first.")
]
Plant: TypeAlias = Annotated[
    str,
    typer.Option(
        metavar="NAME|FILE",
        help=f"What moves: {', '.join(sim.plant_names())}; with the extra 'plants'"
        " commonroad-MODEL-VEHICLE (MODEL st, std or mb, VEHICLE 1 to 3) and"
        f" {plants.names()[-1]}; or a file *.toml of a vehicle, of which a kinematic bicycle is"
        " made.",
    ),
]
Vehicle: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="FILE|NAME",
        help="The vehicle that the controllers are told: a file *.toml as popsteer.Vehicle.save"
        f" writes it, {', '.join(vehicles.names())}, or a plant's. By default the plant's own.",
        show_default=False,
    ),
]
SetVehicle: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        metavar="NAME=VALUE",
        help="Set a field of that vehicle, such as dead_time=0.1; none for no limit.",
        show_default=False,
    ),
]
NoAdapt: TypeAlias = Annotated[
    bool,
    typer.Option("--no-adapt", help="The controllers estimate nothing of the vehicle."),
]
Preset: TypeAlias = Annotated[
    str,
    typer.Option(
        metavar="NAME",
        help=f"Tuning of the controllers: {', '.join(presets.names('pop'))}. Where the paper and"
        " its authors' code differ, 'paper' and 'published-code' are the two, and 'reproduction'"
        " takes for each controller the reading that comes closest to the paper's table."
        " preview-pop, which is not the paper's, is the same in all; mpc has none.",
    ),
]
Start: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="X,Y,YAW",
        help="Pose at the start [m, m, rad]; by default the front axle is"
        f" {START_OFFSET} m to the right of the first waypoint, looking along the path.",
        show_default=False,
    ),
]
StartAt: TypeAlias = Annotated[
    str,
    typer.Option(
        metavar="pose|rear|front",
        help="Whose pose --start is: that of the vehicle's point, of its rear or its front axle.",
    ),
]
StartOffset: TypeAlias = Annotated[
    float | None,
    typer.Option(
        metavar="METRES",
        help="Start with the front axle this far to the left of the first waypoint, looking along"
        f" the path; negative is to the right, by default {-START_OFFSET}.",
        show_default=False,
    ),
]
Speed: TypeAlias = Annotated[
    float | None,
    typer.Option(
        metavar="M/S",
        help="Speed at the start; by default that of --constant-speed, else 0.",
        show_default=False,
    ),
]
ConstantSpeed: TypeAlias = Annotated[
    float | None,
    typer.Option(
        metavar="M/S",
        help="Keep this speed all the way, by a PI law on the pedals.",
        show_default=False,
    ),
]
DEFAULT_DT = Settings().dt
"""The paper's control period [s]."""
Dt: TypeAlias = Annotated[float, typer.Option(metavar="SECONDS", help="Control period.")]
Out: TypeAlias = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Where to write the files.", show_default=False),
]
Csv: TypeAlias = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Write the table as CSV.", show_default=False),
]
Json: TypeAlias = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Write the table as JSON.", show_default=False),
]
