"""The log that a command is given, and what its columns are called."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from popsteer import logs
from popsteer.cli.assignments import pairs
from popsteer.cli.options import optional
from popsteer.cli.outputs import Progress
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
        columns=dict(pairs("--column", columns, whole=True)),
        topics=dict(pairs("--topic", topics, whole=True)),
        units=dict(pairs("--unit", units, whole=True)),
        progress=partial(progress.update, "read"),
    )
