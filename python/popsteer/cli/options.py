"""Options that several commands have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from popsteer import plants, presets, sim, tracks
from popsteer.sim import Settings

__all__ = [
    "DEFAULT_DT",
    "Closed",
    "ConstantSpeed",
    "Csv",
    "Dt",
    "Json",
    "Out",
    "Plant",
    "Preset",
    "Speed",
    "Start",
    "StartOffset",
    "Track",
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
        metavar="NAME",
        help=f"What moves: {', '.join(sim.plant_names())}; with the extra 'plants'"
        " commonroad-MODEL-VEHICLE (MODEL st, std or mb, VEHICLE 1 to 3) and"
        f" {plants.names()[-1]}.",
    ),
]
Preset: TypeAlias = Annotated[
    str,
    typer.Option(
        metavar="NAME",
        help=f"Parameters of the laws: {', '.join(presets.names('pop'))}. Where the paper and its"
        " authors' code differ, 'paper' and 'published-code' are the two, and 'reproduction' takes"
        " for each law the reading that comes closest to the paper's table. preview-pop, which is"
        " not the paper's, is the same in all; mpc has none.",
    ),
]
Start: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="X,Y,YAW",
        help="Pose of the front axle at the start [m, m, rad]; by default"
        f" {sim.START_OFFSET} m to the right of the first waypoint, looking along the path.",
        show_default=False,
    ),
]
StartOffset: TypeAlias = Annotated[
    float | None,
    typer.Option(
        metavar="METRES",
        help="Start with the front axle this far to the left of the first waypoint, looking along"
        f" the path; negative is to the right, by default {-sim.START_OFFSET}.",
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
