"""What ``popsteer ros2`` and ``popsteer record`` have in common."""

from __future__ import annotations

import signal
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from popsteer.cli import logs, options
from popsteer.errors import ConfigError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from popsteer.adapters.ros2.topics import Topics

__all__ = [
    "Autoware",
    "CommandType",
    "Domain",
    "Localhost",
    "PathType",
    "Timeout",
    "Topic",
    "stop_on_signals",
    "topics_of",
]


Domain: TypeAlias = Annotated[
    int | None,
    options.optional(
        "ID", "DDS domain, 0 to 232. The default is that of ROS_DOMAIN_ID, or else 0."
    ),
]
Localhost: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--localhost", help="Stay on this machine, as with ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST."
    ),
]
Autoware: TypeAlias = Annotated[
    bool, typer.Option("--autoware", help="Autoware's messages and names of topics.")
]
PathType: TypeAlias = Annotated[
    str | None,
    options.optional(
        "path|trajectory", "What the path is: nav_msgs/Path, the default, or Autoware's Trajectory."
    ),
]
CommandType: TypeAlias = Annotated[
    str | None,
    options.optional(
        "ackermann|control",
        "What the command is: AckermannDriveStamped, the default, or Autoware's Control.",
    ),
]
Topic: TypeAlias = Annotated[
    list[str] | None,
    options.optional(
        "NAME=TOPIC",
        "Another topic for odometry, path, command, predicted, diagnostics or clock. Can be"
        " repeated.",
    ),
]
Timeout: TypeAlias = Annotated[
    float, typer.Option(metavar="SECONDS", help="How long to wait for the first messages.")
]


def stop_on_signals() -> Callable[[], bool]:
    """Catch Ctrl-C and SIGTERM; gives a function that says whether one has come."""
    came: list[int] = []
    for kind in (signal.SIGINT, signal.SIGTERM):
        signal.signal(kind, lambda number, _: came.append(number))
    return lambda: bool(came)


def topics_of(
    renamed: list[str] | None, path_type: str | None, command_type: str | None, *, autoware: bool
) -> Topics:
    """Give the topics that the options ask for.

    `renamed` are ``NAME=TOPIC`` each. Names and types are Autoware's where `autoware` says so and
    nothing else is given. Raises ConfigError where a name or a type is not known.
    """
    # Here, so that the other commands do not load the adapter.
    from popsteer.adapters.ros2.messages import ACKERMANN, CONTROL, PATH, TRAJECTORY
    from popsteer.adapters.ros2.topics import Topics

    paths = {"path": PATH, "trajectory": TRAJECTORY}
    commands = {"ackermann": ACKERMANN, "control": CONTROL}
    topics = Topics.of_autoware() if autoware else Topics()
    return replace(
        topics.renamed(logs.pairs("--topic", renamed)),
        path_type=_chosen("--path-type", path_type, paths, topics.path_type),
        command_type=_chosen("--command-type", command_type, commands, topics.command_type),
    )


def _chosen(option: str, word: str | None, known: Mapping[str, str], default: str) -> str:
    if word is not None and word not in known:
        raise ConfigError.unknown(option, word, known)
    return default if word is None else known[word]
