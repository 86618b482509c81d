"""The options of the commands: one name and one meaning for each, in every command."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Annotated, TypeAlias

import typer
from typer.models import OptionInfo

from popsteer import controllers, plants, presets, sim, tracks, vehicles
from popsteer.errors import ConfigError
from popsteer.lab.common.names import controller_names
from popsteer.sim import Settings
from popsteer.sim.closed_loop import START_OFFSET

_PLANTS = (
    f"{', '.join(sim.plant_names())}; with the extra 'plants' commonroad-MODEL-VEHICLE (MODEL is"
    f" st, std or mb, VEHICLE is 1 to 3) and {plants.names()[-1]}; or the file *.toml of a vehicle,"
    " which is then driven as a kinematic bicycle. FILE.py:NAME is a plant of your own."
)
_OWN = (
    "Your own are FILE.py:NAME, MODULE:NAME or an entry point, see docs/compare_your_controller.md"
)
_TRACKS = ", ".join(tracks.names())


def optional(metavar: str, text: str, *names: str) -> OptionInfo:
    """Describe an option that may be left out; `names` are spellings other than the argument's."""
    option: OptionInfo = typer.Option(*names, metavar=metavar, help=text, show_default=False)
    return option


def valued(metavar: str, text: str) -> OptionInfo:
    """Describe an option whose default is shown."""
    option: OptionInfo = typer.Option(metavar=metavar, help=text)
    return option


def flag(name: str, text: str) -> OptionInfo:
    """Describe an option that takes no value."""
    option: OptionInfo = typer.Option(name, help=text)
    return option


Controllers: TypeAlias = Annotated[
    str,
    valued(
        "NAMES",
        f"The controllers, separated by commas: {', '.join(controller_names())}."
        f" mpc needs the extra 'mpc'. {_OWN}.",
    ),
]
OwnControllers: TypeAlias = Annotated[
    str, valued("NAMES", f"The controllers, separated by commas: {', '.join(controllers.names())}.")
]
Preset: TypeAlias = Annotated[
    str,
    valued(
        "NAME",
        f"Tuning of the controllers: {', '.join(presets.names('pop'))}. 'paper' is the paper's"
        " text, 'published-code' its authors' code. 'reproduction' takes for each controller the"
        " one that comes closer to the paper's table. preview-pop and mpc have one tuning only.",
    ),
]
Params: TypeAlias = Annotated[
    Path | None,
    optional(
        "FILE",
        "Tuning: a file *.toml as popsteer tune writes it, with a table for each controller,"
        " such as [pop], which replaces the preset of that controller.",
    ),
]
Record: TypeAlias = Annotated[
    Path | None,
    optional(
        "FILE.mcap",
        "Write the messages of ROS 2 as MCAP, which Foxglove, Rerun and popsteer identify read.",
    ),
]
Seed: TypeAlias = Annotated[int, valued("N", "Where all draws come from, 0 to 2**64 - 1.")]
Set: TypeAlias = Annotated[
    list[str] | None,
    optional(
        "NAME=VALUE",
        "Set a parameter of every controller that has it, or of how the controllers adapt."
        " Can be repeated.",
        "--set",
    ),
]
Waypoints: TypeAlias = Annotated[
    Path | None,
    optional(
        "FILE",
        "Waypoints to follow: a table (CSV, semicolons, tabs or spaces), GPX or GeoJSON. Names in a"
        " head say what its columns are; see docs/files.md.",
    ),
]
COLUMNS = (
    "What the columns of the file are, where they do not say so: in their order, as"
    " x,y,-,'speed [km/h]' (- is left out), or by their names, as speed=V,yaw=psi."
)
Columns: TypeAlias = Annotated[str | None, optional("NAMES", COLUMNS)]
Origin: TypeAlias = Annotated[
    str | None,
    optional(
        "LAT,LON",
        "Where x = y = 0 of a file with latitudes and longitudes [deg]; its first waypoint, if left"
        " out. Needs the extra 'geo'.",
    ),
]
Track: TypeAlias = Annotated[
    str | None,
    optional(
        "NAME",
        f"Shipped track to follow: {_TRACKS}. The first is the default; for replay, it is the"
        " trajectory in the log. FILE.py:NAME is a path of your own, or a function that makes one.",
    ),
]
Tracks: TypeAlias = Annotated[
    str | None,
    optional(
        "NAMES",
        f"Shipped tracks to follow, separated by commas: {_TRACKS}. The first is the default.",
    ),
]
Closed: TypeAlias = Annotated[bool, flag("--closed", "The last waypoint of FILE joins the first.")]
Plant: TypeAlias = Annotated[str, valued("NAME|FILE", f"The plant: {_PLANTS}")]
Plants: TypeAlias = Annotated[str, valued("NAMES", f"The plants, separated by commas: {_PLANTS}")]
OwnPlant: TypeAlias = Annotated[
    str | None,
    optional(
        "NAME|FILE",
        f"The plant: {_PLANTS} The default is a kinematic bicycle of --vehicle where that is"
        " given, else carla-identified.",
    ),
]
SetPlant: TypeAlias = Annotated[
    list[str] | None,
    optional(
        "NAME=VALUE", "Set a parameter of the plant or a field of its vehicle. Can be repeated."
    ),
]
Vehicle: TypeAlias = Annotated[
    str | None,
    optional(
        "NAME|FILE",
        "The vehicle that the controllers are given: a file *.toml as popsteer.Vehicle.save"
        f" writes it, {', '.join(vehicles.names())}, or the vehicle of a plant. The default is the"
        " plant's own.",
    ),
]
SetVehicle: TypeAlias = Annotated[
    list[str] | None,
    optional(
        "NAME=VALUE",
        "Set a field of the vehicle of --vehicle, such as dead_time=0.1; 'none' removes a"
        " limit. Can be repeated.",
    ),
]
NoAdapt: TypeAlias = Annotated[bool, flag("--no-adapt", "Switch the controllers' estimation off.")]
Start: TypeAlias = Annotated[
    str | None,
    optional(
        "X,Y,YAW",
        "Pose at the start [m, m, rad]. By default the front axle is"
        f" {START_OFFSET} m, but at most a wheelbase, to the right of the first waypoint, and the"
        " vehicle points along the path.",
    ),
]
StartAt: TypeAlias = Annotated[
    str,
    valued(
        "pose|rear|front",
        "The point that --start is the pose of: the vehicle's point, the rear axle or the"
        " front axle.",
    ),
]
StartOffset: TypeAlias = Annotated[
    float | None,
    optional(
        "METRES",
        "Start with the front axle this far to the left of the first waypoint, pointing along"
        " the path. Negative is to the right.",
    ),
]
Distributions: TypeAlias = Annotated[
    Path | None,
    optional(
        "FILE", 'A TOML file of what varies: NAME = "DISTRIBUTION" in each line. --vary changes it.'
    ),
]
Speed: TypeAlias = Annotated[
    float | None,
    optional(
        "M/S",
        "Speed at the start. The default is that of --constant-speed, or else 0, or the least that"
        " the plant can start with.",
    ),
]
ConstantSpeed: TypeAlias = Annotated[
    float | None, optional("M/S", "Drive at this speed; a PI controller works the pedals.")
]
Longitudinal: TypeAlias = Annotated[
    str | None,
    optional(
        "NAME",
        "The controller of the pedals: speed-tracker, which plans speeds within the limits of the"
        " vehicle that the controllers are given and the speeds of the waypoints, and keeps them;"
        " speed-pid, which tracks the speeds of the waypoints; or coupled, the paper's. The default"
        " is speed-tracker; for a plant of your own that does not say what its pedals do speed-pid,"
        " and without speeds coupled.",
    ),
]
SetLongitudinal: TypeAlias = Annotated[
    list[str] | None,
    optional("NAME=VALUE", "Set a parameter of the controller of the pedals. Can be repeated."),
]
DEFAULT_DT = Settings().dt
"""The paper's control period [s]."""
Dt: TypeAlias = Annotated[float, valued("SECONDS", "Control period.")]
Out: TypeAlias = Annotated[
    Path | None, optional("DIR", "Folder to write the files to. It is created if it is missing.")
]
Report: TypeAlias = Annotated[
    Path | None,
    optional(
        "FILE",
        "Write the results as one page *.html: a map on which the cars drive, plots with a"
        " common cursor, tables, and the command. It needs nothing from the network.",
    ),
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
