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


# What an option takes that may be left out.
Text: TypeAlias = str | None
Texts: TypeAlias = list[str] | None
File: TypeAlias = Path | None

Controllers = Annotated[str, valued("NAMES", "Who steers, by commas; FILE.py:NAME is your own.")]
OwnControllers = Annotated[str, valued("NAMES", "The controllers, by commas.")]
Controller = Annotated[Text, optional("NAME", "By default preview-pop, or that of --params.")]
Preset = Annotated[str, valued("NAME", "One of popsteer params.")]
Params = Annotated[File, optional("FILE", "Tuning, *.toml, as popsteer tune writes it.")]
Record = Annotated[File, optional("FILE.mcap", "Messages of ROS 2, for Foxglove and identify.")]
Seed = Annotated[int, valued("N", "Where all draws come from.")]
Set = Annotated[
    Texts, optional("NAME=VALUE", "A parameter of controllers, adapt or monitor.", "--set")
]
Waypoints = Annotated[File, optional("FILE", "A table, GPX or GeoJSON (docs/files.md).")]
SeveralWaypoints = Annotated[
    list[Path] | None, optional("FILE", "A table, GPX or GeoJSON (docs/files.md).")
]
Columns = Annotated[Text, optional("NAMES", "Its columns: x,y,-,'v [km/h]' or yaw=psi.")]
Origin = Annotated[Text, optional("LAT,LON", "Where x = y = 0 [deg]; needs the extra 'geo'.")]
Track = Annotated[Text, optional("NAME", "One of popsteer tracks, or FILE.py:NAME.")]
Tracks = Annotated[
    Text, optional("NAMES", "Some of popsteer tracks, or FILE.py:NAME.", "--tracks", "--track")
]
Closed = Annotated[bool, flag("--closed", "The last waypoint joins the first.")]
Plants = Annotated[
    str, valued("NAMES", "What is driven, by commas; or *.toml.", "--plants", "--plant")
]
OwnPlant = Annotated[Text, optional("NAME|FILE", "What is driven; else a bicycle of --vehicle.")]
SetPlant = Annotated[Texts, optional("NAME=VALUE", "A parameter of it, or a field of its vehicle.")]
Vehicle = Annotated[Text, optional("NAME|FILE", "What controllers know; else the plant's.")]
SetVehicle = Annotated[Texts, optional("NAME=VALUE", "A field of it; 'none' removes a limit.")]
NoAdapt = Annotated[bool, flag("--no-adapt", "The controllers estimate nothing.")]
Start = Annotated[Text, optional("X,Y,YAW", "Pose at the start [m, m, rad].")]
StartAt = Annotated[str, valued("pose|rear|front", "Whose pose that is.")]
StartOffset = Annotated[
    float | None, optional("METRES", "The front axle this far left of the path.")
]
Vary = Annotated[Texts, optional("NAME=DISTRIBUTION", "What varies, and how (docs/sweep.md).")]
Distributions = Annotated[File, optional("FILE", "The same, as TOML.")]
Speed = Annotated[float | None, optional("M/S", "Speed at the start.")]
ConstantSpeed = Annotated[float | None, optional("M/S", "Drive at this speed.")]
Longitudinal = Annotated[Text, optional("NAME", "Pedals: speed-tracker, speed-pid or coupled.")]
SetLongitudinal = Annotated[Texts, optional("NAME=VALUE", "A parameter of these.")]
DEFAULT_DT = Settings().dt
"""The paper's control period [s]."""
Dt = Annotated[float, valued("SECONDS", "Control period.")]
Out = Annotated[File, optional("DIR", "Folder for tables, figures and records.")]
Report = Annotated[File, optional("FILE", "One page *.html to look at (docs/report.md).")]

_LOG = "A table, or several with one clock; MCAP; a ROS 2 bag."
Log = Annotated[list[Path], typer.Argument(metavar="LOG...", help=_LOG, show_default=False)]
Topic = Annotated[
    Texts, optional("NAME=TOPIC", f"The topic of a bag; NAME of {', '.join(TOPICS)}.")
]
Unit = Annotated[
    Texts, optional("NAME=UNIT", "A unit, as steer=deg, speed=km/h, or a factor: steer=deg/15.5.")
]


def check_alone(context: typer.Context, option: str, beside: Collection[str]) -> None:
    """Refuse by ConfigError what is given beside an option that only goes with some parameters."""
    for name, value in context.params.items():
        source = context.get_parameter_source(name)
        if name not in beside and source is not None and source.name != "DEFAULT":
            given = f"--{name.rstrip('_').replace('_', '-')}"
            raise ConfigError(given, value, f"left out where {option} is given")
