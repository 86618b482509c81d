"""The log that a command is given, and what its columns are called."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from popsteer import logs
from popsteer.cli.assignments import pairs
from popsteer.cli.inputs import place
from popsteer.cli.options import optional
from popsteer.cli.outputs import Progress
from popsteer.logs.bag import TOPICS

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


def read(
    files: list[Path],
    columns: str | None,
    topics: list[str] | None,
    units: list[str] | None,
    origin: str | None,
    progress: Progress,
) -> logs.Log:
    """Read the log that the options name; LogError where it cannot be."""
    return logs.read(
        files,
        columns=columns,
        topics=dict(pairs("--topic", topics, whole=True)),
        units=dict(pairs("--unit", units, whole=True)),
        origin=place(origin),
        progress=partial(progress.update, "read"),
    )
