"""``popsteer simulate``: one law, every parameter at hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any

import typer

from popsteer import baselines, laws, plants, presets, report, study
from popsteer._core import (
    CoupledLongitudinal,
    CoupledLongitudinalParams,
    SpeedPid,
    SpeedPidParams,
)
from popsteer.cli import inputs, options, outputs
from popsteer.cli.assignments import assigned, listed
from popsteer.cli.progress import Progress
from popsteer.errors import ConfigError
from popsteer.files import check_folder
from popsteer.plants.pedals import MujocoCarParams, PedalParams
from popsteer.sim import (
    CarlaIdentified,
    KinematicBicycle,
    Plant,
    Settings,
    plant_name,
    plant_names,
)
from popsteer.study.compare import parameters

__all__ = ["HELP", "simulate"]

_PLANTS: dict[str, type[Any]] = dict(
    zip(plant_names(), (CarlaIdentified, KinematicBicycle), strict=True)
)
_PARAMS = {**_PLANTS, "commonroad-...": PedalParams, "mujoco-car": MujocoCarParams}
_LONGITUDINAL: dict[str, type[Any]] = {
    "coupled": CoupledLongitudinalParams,
    "speed-pid": SpeedPidParams,
}


def _section(title: str, kind: type[object]) -> str:
    # \b keeps the lines as they are.
    return f"\b\n{title}\n{listed(kind)}\n"


HELP = "\n".join(
    [
        """\
Drive one law along a track, with every parameter at hand.

The law's parameters start from a preset and from the plant's axles; --set changes any of them, and
may be given again and again. The same goes for the plant, the pedals and the run.

\b
Examples:
  popsteer simulate --controller pop --set lookahead_gain=0.3 --set min_lookahead=4
  popsteer simulate --controller pid --preset published-code --out out
  popsteer simulate --longitudinal speed-pid --set-longitudinal kp=0.8
  popsteer simulate --plant mujoco-car --set-plant friction=0.6 --constant-speed 12
  popsteer simulate --plant kinematic-bicycle --set-plant wheelbase=2.5 --set-run time_limit=60
""",
        *(
            _section(f"--controller {name}, parameters for --set:", laws.get(name).params)
            for name in laws.names()
        ),
        *(
            _section(f"--controller {name}, parameters for --set:", baselines.get(name).params)
            for name in baselines.names()
        ),
        *(
            _section(f"--plant {name}, parameters for --set-plant:", kind)
            for name, kind in _PARAMS.items()
        ),
        *(
            _section(f"--longitudinal {name}, parameters for --set-longitudinal:", kind)
            for name, kind in _LONGITUDINAL.items()
        ),
        _section("Parameters for --set-run:", Settings),
    ]
)


def simulate(
    *,
    controller: Annotated[
        str,
        typer.Option(
            metavar="LAW",
            help=f"The law, of {', '.join(laws.names())}; with the extra 'mpc' also"
            f" {', '.join(baselines.names())}.",
        ),
    ] = "pop",
    set_: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="NAME=VALUE", help="Set a parameter of the law.", show_default=False
        ),
    ] = None,
    preset: options.Preset = presets.REPRODUCTION,
    waypoints: options.Waypoints = None,
    track: options.Track = None,
    closed: options.Closed = False,
    plant: options.Plant = "carla-identified",
    set_plant: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE", help="Set a parameter of the plant.", show_default=False
        ),
    ] = None,
    longitudinal: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="What works the pedals: coupled (the paper's law, the default) or speed-pid"
            " (follows the waypoints' reference speeds).",
            show_default=False,
        ),
    ] = None,
    set_longitudinal: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE", help="Set a parameter of the pedals' law.", show_default=False
        ),
    ] = None,
    start: options.Start = None,
    start_offset: options.StartOffset = None,
    speed: options.Speed = None,
    constant_speed: options.ConstantSpeed = None,
    dt: options.Dt = options.DEFAULT_DT,
    set_run: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=VALUE", help="Set a parameter of the run.", show_default=False),
    ] = None,
    out: options.Out = None,
) -> None:
    """Drive one law along a track."""
    vehicle = _vehicle(plant, set_plant or [])
    params = assigned(parameters([controller], preset, vehicle)[controller], set_ or [], controller)
    if constant_speed is not None and (longitudinal or set_longitudinal):
        raise ConfigError("--constant-speed", constant_speed, "given without a longitudinal law")
    pedals = None if constant_speed is not None else _pedals(longitudinal, set_longitudinal or [])
    settings = assigned(Settings(dt=dt), set_run or [], "the run")
    course = inputs.course(waypoints, track, closed=closed)
    if out is not None:
        check_folder(out, report.file_names([controller]))
    changed = " with changes" if set_ else ""
    with Progress() as progress:
        comparison = study.compare(
            course.path,
            {controller: params},
            vehicle,
            preset=f"{preset}{changed}",
            start=inputs.start(course.path, start, start_offset),
            speed=speed,
            constant_speed=constant_speed,
            longitudinal=pedals,
            settings=settings,
            progress=progress.update,
        )
        comparison = replace(comparison, track=course.name)
        outputs.deliver(comparison, out, progress)


def _vehicle(name: str, assignments: list[str]) -> Plant:
    """Make the plant."""
    if plant_name(name) in _PLANTS:
        plant: Plant = assigned(_PLANTS[name](), assignments, name)
        return plant
    vehicle = plants.get(name)
    return vehicle.with_params(assigned(vehicle.params, assignments, name))


def _pedals(name: str | None, assignments: list[str]) -> CoupledLongitudinal | SpeedPid:
    """Make the law of the pedals."""
    name = "coupled" if name is None else name
    if name == "coupled":
        return CoupledLongitudinal(assigned(CoupledLongitudinalParams(), assignments, name))
    if name == "speed-pid":
        return SpeedPid(assigned(SpeedPidParams(), assignments, name))
    raise ConfigError.unknown("longitudinal law", name, _LONGITUDINAL)
