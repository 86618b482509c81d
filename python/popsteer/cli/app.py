"""The commands of ``popsteer``."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Annotated

import typer

from popsteer._core import __version__

# In the order of the list: each is a module with a function of its name, whose docstring is its
# line there.
PAGES = (
    *("compare", "suite", "sweep", "tune", "stability", "paper", "params"),
    *("new", "plan", "identify", "replay", "ros2", "record", "tracks"),
)

_HELP = """\
Path-tracking controllers, driven along a track and measured: POP (proximally optimal predictive),
preview POP, PID, Pure-Pursuit and Stanley.

\b
Examples:
  popsteer compare --report report.html                  on the shipped track
  popsteer compare --waypoints mine.csv --plant car.toml on yours, your car
  popsteer identify drive.mcap --out car.toml            what is my car?
  popsteer tune --vehicle car.toml --out tuned.toml      parameters for it
  popsteer sweep --vehicle car.toml --params tuned.toml  how often it succeeds
  popsteer params pop                                    what --set can set

\b
An option means the same in every command, and can be repeated if it takes
NAME=VALUE:
  --controllers, --plants, --tracks NAMES   who steers, what is driven, where
  --vehicle NAME|FILE                       the vehicle that controllers know
  --set, --set-vehicle, --set-plant         parameters of controllers, ...
  --out DIR or FILE, --report FILE          tables and figures; a page

Units are SI and radians; degrees are marked. x points forward, y left, and angles are positive to
the left. Files are written completely or not at all. An error in the input is one line on stderr,
with exit status 2.
"""


def _show_version(wanted: bool) -> None:
    if wanted:
        print(f"popsteer {__version__}")
        raise typer.Exit


def _popsteer(
    context: typer.Context,
    *,
    _version: Annotated[
        bool,
        typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version."),
    ] = False,
) -> None:
    if context.invoked_subcommand is None:
        print(context.get_help())


def made(pages: Sequence[str] = PAGES) -> typer.Typer:
    """Make the command with the commands of some pages; the others are not loaded."""
    app = typer.Typer(
        name="popsteer",
        help=_HELP,
        no_args_is_help=False,
        pretty_exceptions_enable=False,
        # Plain text reads the same on a terminal, in a file and through a pager.
        rich_markup_mode=None,
        context_settings={"help_option_names": ["--help", "-h"], "max_content_width": 100},
    )
    app.callback(invoke_without_command=True)(_popsteer)
    for name in pages:
        page = import_module(f"popsteer.cli.{name}")
        command = getattr(page, name)
        app.command(name, help=page.HELP, short_help=command.__doc__)(command)
    return app
