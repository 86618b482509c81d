"""What ``popsteer ros2`` and ``popsteer record`` have in common."""

from __future__ import annotations

import signal
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["Autoware", "Domain", "Localhost", "Timeout", "Topic", "stop_on_signals"]

Domain: TypeAlias = Annotated[
    int | None,
    typer.Option(
        metavar="ID",
        help="DDS domain, 0 to 232. The default is that of ROS_DOMAIN_ID, or else 0.",
        show_default=False,
    ),
]
Localhost: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--localhost",
        help="Stay on this machine, as with ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST.",
    ),
]
Autoware: TypeAlias = Annotated[
    bool, typer.Option("--autoware", help="Autoware's messages and names of topics.")
]
Topic: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        metavar="NAME=TOPIC",
        help="Another topic for odometry, path, command, predicted, diagnostics or clock. Can be"
        " repeated.",
        show_default=False,
    ),
]
Timeout: TypeAlias = Annotated[
    float,
    typer.Option(metavar="SECONDS", help="How long to wait for the first messages."),
]


def stop_on_signals() -> Callable[[], bool]:
    """Take Ctrl-C and SIGTERM as the wish to end in order.

    Returns
    -------
    callable
        Says whether one has come.
    """
    came: list[int] = []
    for kind in (signal.SIGINT, signal.SIGTERM):
        signal.signal(kind, lambda number, _: came.append(number))
    return lambda: bool(came)
