"""``popsteer edges``: the controllers on pathological paths."""

from __future__ import annotations

from typing import Annotated

from popsteer import lab
from popsteer.cli import inputs, options, outputs, vehicle_inputs
from popsteer.cli.progress import Progress
from popsteer.errors import ConfigError
from popsteer.files import check_folder
from popsteer.lab.edges.runs import EDGE_CONTROLLERS, EDGE_PLANT
from popsteer.sim import vehicle_of

__all__ = ["HELP", "edges"]

_CONTROLLERS = ",".join(EDGE_CONTROLLERS)

HELP = """\
Drive the controllers along pathological paths.

The paths cross themselves, touch, return beside themselves, repeat waypoints, have waypoints a
centimetre or a hundred metres apart, or park with two cusps. Other runs start 3 m beside the path,
or pointing 90° or 180° away from it. The default plant is the kinematic bicycle with wheels that
turn by 0.6 rad at most. docs/edges.md explains the table.

\b
Examples:
  popsteer edges
  popsteer edges --controllers pop,stanley --tracks out-and-back,parallel-parking
  popsteer edges --plant car.toml --tracks parallel-parking
  popsteer edges --controllers preview-pop --set min_speed=2 --out out
"""


def edges(
    *,
    controllers: options.OwnControllers = _CONTROLLERS,
    params: options.Params = None,
    set_: options.Set = None,
    tracks: Annotated[
        str | None,
        options.optional(
            "NAMES",
            "The pathological paths, separated by commas; all by default:"
            f" {', '.join(track.name for track in lab.edges.edge_tracks())}.",
        ),
    ] = None,
    plant: Annotated[
        str | None,
        options.optional(
            "NAME|FILE",
            "The plant, as compare's --plant names it. Some of the paths need one that can"
            " reverse. The default is the kinematic bicycle with max_steer=0.6.",
        ),
    ] = None,
    set_plant: options.SetPlant = None,
    vehicle: options.Vehicle = None,
    set_vehicle: options.SetVehicle = None,
    no_adapt: options.NoAdapt = False,
    dt: options.Dt = options.DEFAULT_DT,
    out: options.Out = None,
) -> None:
    """Drive the controllers along pathological paths."""
    names = inputs.names("--controllers", controllers)
    known = {track.name: track for track in lab.edges.edge_tracks()}
    wanted = list(known) if tracks is None else inputs.names("--tracks", tracks)
    for name in wanted:
        if name not in known:
            raise ConfigError.unknown("track", name, tuple(known))
    if out is not None:
        check_folder(out, ["edges.csv", "edges.json"])
    with Progress() as progress:
        mover = EDGE_PLANT if plant is None else vehicle_inputs.plant(plant)
        mover = vehicle_inputs.changed_plant(mover, "the plant", set_plant)
        given = vehicle_inputs.believed(vehicle, set_vehicle, vehicle_of(mover))
        tuning = inputs.tuned(
            names,
            "default",
            set_,
            no_adapt=no_adapt,
            params=params,
            known=inputs.OWN_CONTROLLERS,
            given=lab.edges.edge_params,
        )
        rows = lab.edges.run(
            tuning.params,
            [known[name] for name in wanted],
            plant=mover,
            vehicle=given,
            adapt=tuning.adapt,
            dt=dt,
            progress=progress.update,
        )
    content = {
        "edges.csv": lab.edges.table.edges_csv(rows).encode(),
        "edges.json": lab.edges.table.edges_json(rows, mover, given).encode(),
    }
    said = outputs.write(content, out, "--out DIR writes edges.csv and edges.json.")
    outputs.show(
        lab.edges.table.edges_caption(mover, given),
        [lab.edges.table.edges_table(rows)],
        lab.edges.table.edges_notes(rows),
    )
    print(said)
