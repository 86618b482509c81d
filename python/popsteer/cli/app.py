"""The commands, put together."""

from __future__ import annotations

from typing import Annotated

import typer

from popsteer._core import __version__
from popsteer.cli import (
    bench,
    compare,
    dead_time,
    edges,
    identify,
    matrix,
    replay,
    simulate,
    stability,
    tracks,
)

__all__ = ["app"]

_HELP = """\
Path-tracking controllers, driven along a track and measured.

POP, the proximally optimal predictive controller, and those it is measured against: PID,
Pure-Pursuit, Stanley, and bang-bang as the floor. The plant is the one identified from the run that
the paper's authors recorded in CARLA, unless told otherwise, and the track is one that comes with
popsteer. The controllers are told what the plant is, unless --vehicle says otherwise.

\b
Examples:
  popsteer compare                       the paper's four controllers on the shipped race track
  popsteer compare --out out             ... and the figures, records and metrics in out/
  popsteer compare --waypoints mine.csv  ... on a track of your own: x [m], y [m], speed [m/s]
  popsteer compare --plant car.toml      ... with a car of your own, as popsteer.Vehicle.save
                                         writes it
  popsteer simulate --controller pop --set lookahead_gain=0.3
  popsteer matrix --out out              controllers × plants × tracks: error against step time
  popsteer tracks export racetrack racetrack.csv
  popsteer stability --vehicle car.toml  how far each controller's loop is from instability
  popsteer edges                         crossings, cusps, odd spacings and starts
  popsteer dead-time                     steering delay, and controllers that predict through it
  popsteer identify drive.mcap           what is my car? from the log of a drive
  popsteer replay drive.mcap --vehicle car.toml      what would a controller have done?
  popsteer bench                         how long a control step takes

\b
What `--out DIR` writes:
  DIR/metrics.json            the figures of all controllers, for programs
  DIR/runs/CONTROLLER.csv     what was measured, a row for each control step
  DIR/results.png .svg        path, errors and steering over time, a column for each controller
  DIR/overview.png .svg       all controllers on one axis, and their mean errors
  DIR/*-dark.png .svg         the same figures for a dark background

Units are SI and radians; degrees are marked. x points forward, y left, angles turn left. A pose is
that of the vehicle's point: where its `rear_axle` counts from. Files are
written whole or not at all. Whatever is wrong with the input is said in one line on stderr, with
exit status 2.
"""

app = typer.Typer(
    name="popsteer",
    help=_HELP,
    add_completion=False,
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


app.command("compare", help=compare.HELP)(compare.compare)
app.command("simulate", help=simulate.HELP)(simulate.simulate)
app.command("stability", help=stability.HELP)(stability.stability)
app.command("matrix", help=matrix.HELP)(matrix.matrix)
app.command("edges", help=edges.HELP)(edges.edges)
app.command("dead-time", help=dead_time.HELP)(dead_time.dead_time)
app.command("identify", help=identify.HELP)(identify.identify)
app.command("replay", help=replay.HELP)(replay.replay)
app.command("bench", help=bench.HELP)(bench.bench)
app.add_typer(tracks.app, name="tracks")
