"""The options of the commands: one name and one meaning for each, in every command."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Annotated, TypeAlias

import typer
from typer.models import OptionInfo

from popsteer.errors import ConfigError
from popsteer.logs.bag import TOPICS
from popsteer.sim import Settings


def optional(metavar: str, text: str, *names: str) -> OptionInfo:
    """Describe an option that may be left out; `names` are spellings other than the argument's."""
    option: OptionInfo = typer.Option(*names, metavar=metavar, help=text, show_default=False)
    return option


def valued(metavar: str, text: str, *names: str) -> OptionInfo:
    """Describe an option whose default is shown; `names` as `optional` has them."""
    option: OptionInfo = typer.Option(*names, metavar=metavar, help=text)
    return option


def flag(name: str, text: str) -> OptionInfo:
    """Describe an option that takes no value."""
    option: OptionInfo = typer.Option(name, help=text)
    return option


Controllers: TypeAlias = Annotated[
    str, valued("NAMES", "Who steers, by commas; FILE.py:NAME is your own.")
]
OwnControllers: TypeAlias = Annotated[str, valued("NAMES", "The controllers, by commas.")]
Controller: TypeAlias = Annotated[
    str | None, optional("NAME", "By default preview-pop, or that of --params.")
]
Preset: TypeAlias = Annotated[str, valued("NAME", "One of popsteer params.")]
Params: TypeAlias = Annotated[
    Path | None, optional("FILE", "Tuning, *.toml, as popsteer tune writes it.")
]
Record: TypeAlias = Annotated[
    Path | None,
    optional("FILE.mcap", "Messages of ROS 2, for Foxglove and identify."),
]
Seed: TypeAlias = Annotated[int, valued("N", "Where all draws come from.")]
Set: TypeAlias = Annotated[
    list[str] | None,
    optional("NAME=VALUE", "A parameter of controllers, adapt or monitor.", "--set"),
]
Waypoints: TypeAlias = Annotated[
    Path | None, optional("FILE", "A table, GPX or GeoJSON (docs/files.md).")
]
SeveralWaypoints: TypeAlias = Annotated[
    list[Path] | None,
    optional("FILE", "A table, GPX or GeoJSON (docs/files.md)."),
]
COLUMNS = "Its columns: x,y,-,'v [km/h]' or yaw=psi."
Columns: TypeAlias = Annotated[str | None, optional("NAMES", COLUMNS)]
Origin: TypeAlias = Annotated[
    str | None, optional("LAT,LON", "Where x = y = 0 [deg]; needs the extra 'geo'.")
]
Track: TypeAlias = Annotated[
    str | None, optional("NAME", "One of popsteer tracks, or FILE.py:NAME.")
]
Tracks: TypeAlias = Annotated[
    str | None,
    optional("NAMES", "Some of popsteer tracks, or FILE.py:NAME.", "--tracks", "--track"),
]
Closed: TypeAlias = Annotated[bool, flag("--closed", "The last waypoint joins the first.")]
Plants: TypeAlias = Annotated[
    str, valued("NAMES", "What is driven, by commas; or *.toml.", "--plants", "--plant")
]
OwnPlant: TypeAlias = Annotated[
    str | None,
    optional("NAME|FILE", "What is driven; else a bicycle of --vehicle."),
]
SetPlant: TypeAlias = Annotated[
    list[str] | None, optional("NAME=VALUE", "A parameter of it, or a field of its vehicle.")
]
Vehicle: TypeAlias = Annotated[
    str | None, optional("NAME|FILE", "What controllers know; else the plant's.")
]
SetVehicle: TypeAlias = Annotated[
    list[str] | None, optional("NAME=VALUE", "A field of it; 'none' removes a limit.")
]
NoAdapt: TypeAlias = Annotated[bool, flag("--no-adapt", "The controllers estimate nothing.")]
Start: TypeAlias = Annotated[str | None, optional("X,Y,YAW", "Pose at the start [m, m, rad].")]
StartAt: TypeAlias = Annotated[str, valued("pose|rear|front", "Whose pose that is.")]
StartOffset: TypeAlias = Annotated[
    float | None, optional("METRES", "The front axle this far left of the path.")
]
Vary: TypeAlias = Annotated[
    list[str] | None,
    optional("NAME=DISTRIBUTION", "What varies, and how (docs/sweep.md)."),
]
Distributions: TypeAlias = Annotated[Path | None, optional("FILE", "The same, as TOML.")]
Speed: TypeAlias = Annotated[float | None, optional("M/S", "Speed at the start.")]
ConstantSpeed: TypeAlias = Annotated[float | None, optional("M/S", "Drive at this speed.")]
Longitudinal: TypeAlias = Annotated[
    str | None, optional("NAME", "Pedals: speed-tracker, speed-pid or coupled.")
]
SetLongitudinal: TypeAlias = Annotated[
    list[str] | None, optional("NAME=VALUE", "A parameter of these.")
]
DEFAULT_DT = Settings().dt
"""The paper's control period [s]."""
Dt: TypeAlias = Annotated[float, valued("SECONDS", "Control period.")]
Out: TypeAlias = Annotated[Path | None, optional("DIR", "Folder for tables, figures and records.")]
Report: TypeAlias = Annotated[
    Path | None, optional("FILE", "One page *.html to look at (docs/report.md).")
]

Log: TypeAlias = Annotated[
    list[Path],
    typer.Argument(
        metavar="LOG...",
        help="A table, or several with one clock; MCAP; a ROS 2 bag.",
        show_default=False,
    ),
]
Topic: TypeAlias = Annotated[
    list[str] | None, optional("NAME=TOPIC", f"The topic of a bag; NAME of {', '.join(TOPICS)}.")
]
Unit: TypeAlias = Annotated[
    list[str] | None,
    optional("NAME=UNIT", "A unit, as steer=deg, speed=km/h, or a factor: steer=deg/15.5."),
]


def is_given(context: typer.Context, name: str) -> bool:
    """Whether the command line has an option, by the name of its parameter."""
    source = context.get_parameter_source(name)
    return source is not None and source.name != "DEFAULT"


def check_alone(context: typer.Context, option: str, beside: Collection[str]) -> None:
    """Refuse by ConfigError what is given beside an option that only goes with some parameters."""
    for name, value in context.params.items():
        if name not in beside and is_given(context, name):
            given = f"--{name.rstrip('_').replace('_', '-')}"
            raise ConfigError(given, value, f"left out where {option} is given")
