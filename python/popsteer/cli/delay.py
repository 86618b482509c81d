"""``popsteer delay``: steering delay, and controllers that predict through it."""

from __future__ import annotations

from typing import Annotated

import typer

from popsteer import lab, presets
from popsteer.cli import inputs, options, outputs, vehicle_inputs
from popsteer.cli.progress import Progress
from popsteer.errors import ConfigError
from popsteer.files import check_folder
from popsteer.lab.delay.runs import DEAD_TIME, DEAD_TIME_CONTROLLERS
from popsteer.sim import CarlaIdentified, KinematicBicycle, Settings, plant_names

__all__ = ["HELP", "delay"]

_CONTROLLERS = ",".join(DEAD_TIME_CONTROLLERS)

HELP = """\
Drive with dead time between command and wheels, with and without prediction through it.

Each controller drives seven times. First without dead time; then with it, but without prediction;
then with prediction: it steers for where the vehicle will be when the command arrives. Four more
runs predict with wrong values: a wheelbase 15 % too short or too long, a dead time 50 ms too short
or too long.

\b
Examples:
  popsteer delay
  popsteer delay --controllers pop,stanley --dead-time 0.1
  popsteer delay --no-adapt
  popsteer delay --plant car.toml --track slalom
  popsteer delay --waypoints waypoints.csv --start=-183.797,79.760,-1.574 --out out
"""


def delay(
    *,
    controllers: options.OwnControllers = _CONTROLLERS,
    preset: options.Preset = presets.REPRODUCTION,
    params: options.Params = None,
    set_: options.Set = None,
    dead_time: Annotated[
        float,
        typer.Option(
            metavar="SECONDS", help="Time from a command to its first effect on the wheels."
        ),
    ] = DEAD_TIME,
    waypoints: options.Waypoints = None,
    track: options.Track = None,
    closed: options.Closed = False,
    plant: Annotated[
        str,
        typer.Option(
            metavar="NAME|FILE",
            help="The plant: carla-identified, kinematic-bicycle, or the file *.toml of a vehicle."
            " The others have no dead time of their own.",
        ),
    ] = "carla-identified",
    set_plant: options.SetPlant = None,
    no_adapt: options.NoAdapt = False,
    start: options.Start = None,
    start_at: options.StartAt = "pose",
    start_offset: options.StartOffset = None,
    speed: options.Speed = None,
    constant_speed: options.ConstantSpeed = None,
    dt: options.Dt = options.DEFAULT_DT,
    out: options.Out = None,
) -> None:
    """Drive with dead time, with and without prediction through it."""
    names = inputs.names("--controllers", controllers)
    course = inputs.course(waypoints, track, closed=closed)
    if out is not None:
        check_folder(out, ["delay.csv", "delay.json"])
    mover = vehicle_inputs.plant(plant, set_plant)
    if not isinstance(mover, CarlaIdentified | KinematicBicycle):
        raise ConfigError("--plant", plant, f"{', '.join(plant_names())} or a file *.toml")
    begin = inputs.start(course.path, start, start_at, start_offset, mover.vehicle)
    tuning = inputs.tuned(
        names, preset, set_, no_adapt=no_adapt, params=params, known=inputs.OWN_CONTROLLERS
    )
    with Progress() as progress:
        rows = lab.delay.run(
            course.path,
            tuning.params,
            plant=mover,
            start=begin.pose,
            start_at=begin.at,
            speed=speed,
            constant_speed=constant_speed,
            settings=Settings(dt=dt),
            dead_time=dead_time,
            adapt=tuning.adapt,
            progress=progress.update,
        )
    content = {
        "delay.csv": lab.delay.table.delay_csv(rows).encode(),
        "delay.json": lab.delay.table.delay_json(rows, course.name, mover).encode(),
    }
    said = outputs.write(content, out, "--out DIR writes delay.csv and delay.json.")
    tables = lab.delay.table.delay_tables(rows, outputs.console().width)
    outputs.show(lab.delay.table.delay_caption(rows, course.name, mover), tables)
    print(said)
