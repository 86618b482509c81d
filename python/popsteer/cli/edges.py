"""``popsteer edges``: the controllers on pathological paths."""

from __future__ import annotations

from typing import Annotated

import typer

from popsteer import lab
from popsteer.cli import inputs, options
from popsteer.cli.outputs import deliver_table
from popsteer.cli.progress import Progress
from popsteer.errors import ConfigError
from popsteer.files import check_files
from popsteer.lab.edges.runs import EDGE_PLANT
from popsteer.sim import vehicle_of

__all__ = ["HELP", "edges"]

HELP = """\
Drive the controllers along pathological paths, and tell how it went.

Paths that cross, touch or come back beside themselves, repeated waypoints, waypoints a centimetre
and a hundred metres apart, parking manoeuvres with two cusps, and starts 3 m beside the path, 90°
and 180° off. The plant is the kinematic bicycle, its wheels turn by 0.6 rad at most. docs/edges.md
has the table and what it means.

\b
Examples:
  popsteer edges
  popsteer edges --laws pop,stanley --tracks out-and-back,parallel-parking
  popsteer edges --csv edges.csv --json edges.json
  popsteer edges --plant car.toml --tracks parallel-parking
"""


def edges(
    *,
    laws: Annotated[
        str,
        typer.Option(
            metavar="LAWS",
            help=f"The controllers, of {', '.join(lab.edges.runs.EDGE_CONTROLLERS)}.",
        ),
    ] = ",".join(lab.edges.runs.EDGE_CONTROLLERS),
    tracks: Annotated[
        str | None,
        typer.Option(
            metavar="TRACKS", help="Tracks of the table; all by default.", show_default=False
        ),
    ] = None,
    plant: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|FILE",
            help="What moves, as compare's --plant names it; it has to reverse on some tracks.",
            show_default=False,
        ),
    ] = None,
    vehicle: options.Vehicle = None,
    set_vehicle: options.SetVehicle = None,
    csv: options.Csv = None,
    json: options.Json = None,
) -> None:
    """Drive the controllers along pathological paths."""
    from popsteer.lab.edges.table import edges_caption, edges_csv, edges_json, edges_table

    known = {track.name: track for track in lab.edges.edge_tracks()}
    wanted = list(known) if tracks is None else inputs.names(tracks)
    for name in wanted:
        if name not in known:
            raise ConfigError.unknown("track", name, tuple(known))
    check_files(file for file in (csv, json) if file is not None)
    with Progress() as progress:
        mover = EDGE_PLANT if plant is None else inputs.plant(plant)
        told = inputs.believed(vehicle, set_vehicle, vehicle_of(mover))
        rows = lab.edges.run(
            inputs.names(laws),
            [known[name] for name in wanted],
            plant=mover,
            vehicle=told,
            progress=progress.update,
        )
    deliver_table(
        edges_caption(mover, told),
        edges_table(rows),
        csv=(csv, lambda: edges_csv(rows)),
        json=(json, lambda: edges_json(rows, mover, told)),
    )
