"""Options that several commands have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from popsteer import presets, sim, tracks
from popsteer.sim import Settings

__all__ = ["DEFAULT_DT", "Closed", "Dt", "Out", "Plant", "Preset", "Start", "Track", "Waypoints"]

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
    str, typer.Option(metavar="NAME", help=f"What moves: {', '.join(sim.plant_names())}.")
]
Preset: TypeAlias = Annotated[
    str,
    typer.Option(
        metavar="NAME",
        help=f"Parameters of the laws: {', '.join(presets.names('pop'))}. Where the paper and its"
        " authors' code differ, 'paper' and 'published-code' are the two, and 'reproduction' takes"
        " for each law the reading that comes closest to the paper's table.",
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
DEFAULT_DT = Settings().dt
"""The paper's control period [s]."""
Dt: TypeAlias = Annotated[float, typer.Option(metavar="SECONDS", help="Control period.")]
Out: TypeAlias = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Where to write the files.", show_default=False),
]
