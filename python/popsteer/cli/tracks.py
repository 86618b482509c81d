"""``popsteer tracks``: the tracks that come with popsteer."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from popsteer import tracks
from popsteer.cli import inputs, options, outputs
from popsteer.cli.options import optional
from popsteer.errors import printable

_HELP = """\
List the tracks that come with popsteer, or write them as files.

A file has a row for each waypoint: x [m], y [m] and reference speed [m/s].

\b
Examples:
  popsteer tracks
  popsteer tracks --out out                       all of them, as out/NAME.csv
  popsteer tracks --tracks slalom,circle --out out
  popsteer tracks export racetrack racetrack.csv
"""

app = typer.Typer(help=_HELP, rich_markup_mode=None, invoke_without_command=True)


@app.callback()
def list_tracks(
    context: typer.Context,
    *,
    names: Annotated[
        str | None,
        optional("NAMES", "The tracks, separated by commas; all by default.", "--tracks"),
    ] = None,
    out: options.Out = None,
) -> None:
    """List the tracks that come with popsteer, or write them as files."""
    if context.invoked_subcommand is not None:
        return
    chosen = tracks.names() if names is None else inputs.names("--tracks", names)
    shown = [tracks.get(name) for name in chosen]  # refuses an unknown one
    outputs.check_folder(out, [f"{track.name}.csv" for track in shown])
    for track in shown:
        if out is None:
            _show(track)
        else:
            export(track.name, out / f"{track.name}.csv")


def _show(track: tracks.Track) -> None:
    from rich.console import Console
    from rich.padding import Padding
    from rich.text import Text

    console = Console()
    kind = "closed" if track.closed else "open"
    console.print(Text(track.name, style="bold"), Text(track.title), sep="  ", soft_wrap=True)
    console.print(
        f"  {len(track.xy)} waypoints, {track.length:.0f} m, {kind},"
        f" {track.speed.min():.1f} to {track.speed.max():.1f} m/s",
        style="dim",
        highlight=False,
        soft_wrap=True,
    )
    console.print(Padding(Text(track.description), (0, 0, 1, 2)))


@app.command("export")
def export(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the track.")],
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The file to write.")],
) -> None:
    """Write one track as a CSV file."""
    track = tracks.get(name)
    track.to_csv(file)
    print(f"{name}: {len(track.xy)} waypoints written to {printable(str(file))}")
