"""The commands of ``popsteer``."""

from __future__ import annotations

from typing import Annotated

import typer

from popsteer._core import __version__
from popsteer.cli import (
    bench,
    compare,
    identify,
    matrix,
    new,
    paper,
    plan,
    record,
    replay,
    ros2,
    stability,
    sweep,
    tracks,
    tune,
)

# In the order of the list: each has a function of its name, whose docstring is its line there.
_PAGES = (
    *(compare, paper, new, plan, identify, replay),
    *(stability, matrix, tune, sweep, ros2, record, bench),
)

_HELP = """\
Path-tracking controllers, driven along a track and measured.

The controllers are POP (proximally optimal predictive), preview POP, PID, Pure-Pursuit and
Stanley. The default plant is the vehicle identified from the run that the
paper's authors recorded in CARLA; the default track comes with popsteer. The controllers know the
plant's vehicle unless --vehicle gives them another.

\b
Examples:
  popsteer paper                         the paper's experiment, on the shipped race track
  popsteer compare                       the same controllers as this library drives them
  popsteer compare --out out             the same, with figures, records and metrics in out/
  popsteer compare --report report.html  the same, to look at: cars that drive, plots, tables
  popsteer compare --waypoints mine.csv  a track of your own: x [m], y [m], speed [m/s]
  popsteer compare --plant car.toml      a car of your own, as popsteer.Vehicle.save writes it
  popsteer compare --controllers pop --set lookahead_gain=0.3
  popsteer matrix --out out              controllers × plants × tracks: error and step time
  popsteer new my-car                    a project to begin from: control loop, vehicle, test
  popsteer plan waypoints.csv --vehicle car.toml --out course.csv
  popsteer stability --vehicle car.toml  how far each controller's loop is from instability
  popsteer identify drive.mcap           what is my car? from the log of a drive
  popsteer replay drive.mcap --vehicle car.toml      what would a controller have done?
  popsteer tune --controller pop         parameters for a vehicle: error against steering effort
  popsteer sweep --runs 10000            thousands of runs that differ: how often it succeeds
  popsteer ros2 --vehicle car.toml       a ROS 2 node that steers, without ROS
  popsteer record drive.mcap             record the topics of that node
  popsteer bench                         how long a control step takes
  popsteer tracks export racetrack racetrack.csv

\b
An option means the same in every command that has it:
  --controllers NAMES  --controller NAME    who steers
  --plants NAMES       --plant NAME|FILE    what is driven
  --tracks NAMES       --track NAME         where; --waypoints FILE for a path of your own
  --vehicle NAME|FILE                       the vehicle that the controllers are given
  --set NAME=VALUE                          a parameter of the controllers
  --set-vehicle, --set-plant NAME=VALUE     a field of that vehicle, of the plant
  --start, --start-offset                   where the vehicle starts
  --speed, --constant-speed                 its speed at the start, its speed all the way
  --out DIR                                 the folder to write to; the file, with figures beside
                                            it, for plan, identify, tune and sweep: --out FILE
  --report FILE                             one page *.html to look at, see docs/report.md

\b
What `compare --out DIR` writes:
  DIR/metrics.json            the metrics of all controllers, for programs
  DIR/runs/CONTROLLER.csv     what was measured, a row for each control step
  DIR/results.png .svg        path, errors and steering over time, a column for each controller
  DIR/overview.png .svg       all controllers in one plot, and their mean errors
  DIR/*-dark.png .svg         the same figures for a dark background

Units are SI and radians; degrees are marked. x points forward, y left, and angles are positive to
the left. A pose is the pose of the vehicle's point, from which its rear_axle is measured. Files are
written completely or not at all. An error in the input is reported in one line on stderr, with exit
status 2.
"""

app = typer.Typer(
    name="popsteer",
    help=_HELP,
    no_args_is_help=False,
    pretty_exceptions_enable=False,
    # Plain text reads the same on a terminal, in a file and through a pager.
    rich_markup_mode=None,
    context_settings={"help_option_names": ["--help", "-h"], "max_content_width": 100},
)


def _show_version(wanted: bool) -> None:
    if wanted:
        print(f"popsteer {__version__}")
        raise typer.Exit


@app.callback(invoke_without_command=True)
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


for _page in _PAGES:
    _name = _page.__name__.rpartition(".")[2]
    _command = getattr(_page, _name)
    app.command(_name, help=_page.HELP, short_help=_command.__doc__)(_command)
app.add_typer(tracks.app, name="tracks", short_help=tracks.list_tracks.__doc__)
