"""The log that a command is given, and what its columns are called."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from popsteer import logs
from popsteer.cli.options import optional
from popsteer.cli.outputs import Progress
from popsteer.errors import ConfigError
from popsteer.logs.log import COLUMNS
from popsteer.logs.units import UNITS

Log: TypeAlias = Annotated[
    Path,
    typer.Argument(
        metavar="LOG", help="CSV, MCAP, or the folder of a ROS 2 bag.", show_default=False
    ),
]
Column: TypeAlias = Annotated[
    list[str] | None,
    optional(
        "NAME=COLUMN", f"What a column of a CSV file is called; NAME of {', '.join(COLUMNS)}."
    ),
]
Topic: TypeAlias = Annotated[
    list[str] | None,
    optional("NAME=TOPIC", "The topic of a bag; NAME of odometry, steer. By type, if left out."),
]
Unit: TypeAlias = Annotated[
    list[str] | None,
    optional(
        "NAME=UNIT",
        "The unit of a column: "
        + "; ".join(f"{name} in {', '.join(known)}" for name, known in UNITS.items())
        + "; or a factor: -1, deg/15.5.",
    ),
]


def read(
    file: Path,
    columns: list[str] | None,
    topics: list[str] | None,
    units: list[str] | None,
    progress: Progress,
) -> logs.Log:
    """Read the log that the options name; LogError where it cannot be read."""
    return logs.read(
        file,
        columns=pairs("--column", columns),
        topics=pairs("--topic", topics),
        units=pairs("--unit", units),
        progress=partial(progress.update, "read"),
    )


def pairs(option: str, given: list[str] | None) -> dict[str, str]:
    """Read what an option sets by name, ``NAME=VALUE`` each; ConfigError where it is not."""
    found = {}
    for entry in given or []:
        name, equals, value = (part.strip() for part in entry.partition("="))
        if not (name and equals and value):
            raise ConfigError(option, entry, "written NAME=VALUE")
        found[name] = value
    return found
