"""``popsteer tracks``: the tracks that come with popsteer."""

from __future__ import annotations

from typing import Annotated

from rich.console import Console
from rich.padding import Padding
from rich.text import Text

from popsteer import tracks as shipped
from popsteer.cli import inputs, options, outputs
from popsteer.cli.options import optional
from popsteer.errors import printable

HELP = """\
List the tracks that come with popsteer, or write them as files.

A file has a row for each waypoint: x [m], y [m] and reference speed [m/s].

\b
Examples:
  popsteer tracks
  popsteer tracks --out out                       all of them, as out/NAME.csv
  popsteer tracks --tracks slalom,circle --out out
"""


def tracks(
    *,
    names: Annotated[
        str | None,
        optional("NAMES", "The tracks, separated by commas; all by default.", "--tracks"),
    ] = None,
    out: options.Out = None,
) -> None:
    """List the tracks that come with popsteer, or write them as files."""
    chosen = shipped.names() if names is None else inputs.names("--tracks", names)
    found = [shipped.get(name) for name in chosen]  # refuses an unknown one
    outputs.check_folder(out, [f"{track.name}.csv" for track in found])
    for track in found:
        if out is None:
            _show(track)
        else:
            file = out / f"{track.name}.csv"
            track.to_csv(file)
            print(f"{track.name}: {len(track.xy)} waypoints written to {printable(str(file))}")


def _show(track: shipped.Track) -> None:
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
