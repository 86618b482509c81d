"""``popsteer tracks``: the tracks that come with popsteer."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from popsteer import tracks
from popsteer.files import check_folder

__all__ = ["app"]

_HELP = """\
List the tracks that come with popsteer, or write them as files.

\b
Examples:
  popsteer tracks
  popsteer tracks export racetrack racetrack.csv
  popsteer tracks export-all tracks
"""

app = typer.Typer(help=_HELP, rich_markup_mode=None, invoke_without_command=True)


@app.callback()
def _list(context: typer.Context) -> None:
    if context.invoked_subcommand is not None:
        return
    from rich.console import Console
    from rich.padding import Padding
    from rich.text import Text

    console = Console()
    for name in tracks.names():
        track = tracks.get(name)
        kind = "closed" if track.closed else "open"
        console.print(Text(name, style="bold"), Text(f"{track.title}"), sep="  ", soft_wrap=True)
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
    """Write a track as a CSV file of x [m], y [m] and reference speed [m/s]."""
    track = tracks.get(name)
    track.to_csv(file)
    print(f"{name}: {len(track.xy)} waypoints written to {file}")


@app.command("export-all")
def export_all(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The folder to write to.")],
) -> None:
    """Write every track as DIR/NAME.csv."""
    check_folder(folder, [f"{name}.csv" for name in tracks.names()])
    for name in tracks.names():
        export(name, folder / f"{name}.csv")
