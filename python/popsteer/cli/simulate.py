"""``popsteer simulate``: one controller, every parameter at hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any, Literal

import typer

from popsteer import controllers, lab, presets
from popsteer._core import (
    AdaptParams,
    CoupledLongitudinal,
    CoupledLongitudinalParams,
    SpeedPid,
    SpeedPidParams,
    Vehicle,
)
from popsteer.cli import inputs, options, outputs
from popsteer.cli.assignments import assigned, assigned_each, listed
from popsteer.cli.progress import Progress
from popsteer.errors import ConfigError
from popsteer.files import check_folder
from popsteer.lab import baselines
from popsteer.lab.compare.runs import parameters
from popsteer.plants.pedals import MujocoCarParams, PedalParams
from popsteer.sim import (
    CarlaIdentified,
    KinematicBicycle,
    Plant,
    Settings,
    vehicle_of,
)

__all__ = ["HELP", "simulate"]

_PARAMS = {**inputs.PLANTS, "commonroad-...": PedalParams, "mujoco-car": MujocoCarParams}
_LONGITUDINAL: dict[str, type[Any]] = {
    "coupled": CoupledLongitudinalParams,
    "speed-pid": SpeedPidParams,
}


def _section(title: str, kind: type[object]) -> str:
    # \b keeps the lines as they are.
    return f"\b\n{title}\n{listed(kind, without=['vehicle'])}\n"


HELP = "\n".join(
    [
        """\
Drive one controller along a track, with every parameter at hand.

The controller's tuning starts from a preset; --set changes any of it and how the controller adapts,
and may be given again and again. The same goes for the plant and its vehicle, the vehicle that the
controller is told (the plant's own by default), the pedals and the run.

\b
Examples:
  popsteer simulate --controller pop --set lookahead_gain=0.3 --set min_lookahead=4
  popsteer simulate --controller pid --preset published-code --out out
  popsteer simulate --longitudinal speed-pid --set-longitudinal kp=0.8
  popsteer simulate --plant mujoco-car --set-plant friction=0.6 --constant-speed 12
  popsteer simulate --plant kinematic-bicycle --set-plant wheelbase=2.5 --set-run time_limit=60
  popsteer simulate --controller preview-pop --set-vehicle turning_wheelbase=3.02 --set turn_time=2
""",
        *(
            _section(f"--controller {name}, parameters for --set:", controllers.get(name).params)
            for name in controllers.names()
        ),
        *(
            _section(f"--controller {name}, parameters for --set:", baselines.get(name).params)
            for name in baselines.names()
        ),
        _section("How the controllers of popsteer adapt, parameters for --set:", AdaptParams),
        _section(
            "The vehicle, fields for --set-vehicle, and of the first two plants for --set-plant:",
            Vehicle,
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
            help=f"The controller, of {', '.join(controllers.names())}; with the extra 'mpc' also"
            f" {', '.join(baselines.names())}.",
        ),
    ] = "pop",
    set_: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="Set a parameter of the controller, or of how it adapts.",
            show_default=False,
        ),
    ] = None,
    preset: options.Preset = presets.REPRODUCTION,
    waypoints: options.Waypoints = None,
    track: options.Track = None,
    closed: options.Closed = False,
    vehicle: options.Vehicle = None,
    set_vehicle: options.SetVehicle = None,
    no_adapt: options.NoAdapt = False,
    plant: options.Plant = "carla-identified",
    set_plant: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE",
            help="Set a parameter of the plant, or a field of its vehicle.",
            show_default=False,
        ),
    ] = None,
    longitudinal: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="What works the pedals: coupled (the paper's, the default) or speed-pid"
            " (follows the waypoints' reference speeds).",
            show_default=False,
        ),
    ] = None,
    set_longitudinal: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE",
            help="Set a parameter of what works the pedals.",
            show_default=False,
        ),
    ] = None,
    start: options.Start = None,
    start_at: options.StartAt = "pose",
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
    """Drive one controller along a track."""
    mover = _plant(plant, set_plant or [])
    itself = vehicle_of(mover)
    told = inputs.believed(vehicle, set_vehicle, itself)
    params, adapt = _tuned(controller, preset, set_ or [], no_adapt=no_adapt)
    if constant_speed is not None and (longitudinal or set_longitudinal):
        raise ConfigError("--constant-speed", constant_speed, "given without --longitudinal")
    pedals = None if constant_speed is not None else _pedals(longitudinal, set_longitudinal or [])
    settings = assigned(Settings(dt=dt), set_run or [], "the run")
    course = inputs.course(waypoints, track, closed=closed)
    begin = inputs.start(course.path, start, start_at, start_offset, itself)
    if out is not None:
        check_folder(out, lab.compare.files.file_names([controller]))
    changed = " with changes" if set_ else ""
    with Progress() as progress:
        comparison = lab.compare.run(
            course.path,
            {controller: params},
            mover,
            vehicle=told,
            adapt=adapt,
            preset=f"{preset}{changed}",
            start=begin.pose,
            start_at=begin.at,
            speed=speed,
            constant_speed=constant_speed,
            longitudinal=pedals,
            settings=settings,
            progress=progress.update,
        )
        comparison = replace(comparison, track=course.name, plant=inputs.plant_label(plant))
        outputs.deliver(comparison, out, progress)


def _tuned(
    name: str, preset: str, assignments: list[str], *, no_adapt: bool
) -> tuple[Any, AdaptParams | Literal["auto"] | None]:
    """Give the tuning of a controller, and how it adapts."""
    params = parameters([name], preset)[name]
    if name in baselines.names():
        return assigned(params, assignments, name), "auto"
    usual = AdaptParams()
    params, adapt = assigned_each([params, usual], assignments, name)
    if no_adapt:
        return params, None
    # As the controller does by default, unless something of it was set.
    return params, "auto" if adapt is usual else adapt


def _plant(text: str, assignments: list[str]) -> Plant:
    """Make the plant."""
    plant, name = inputs.plant(text), inputs.plant_label(text)
    if isinstance(plant, CarlaIdentified | KinematicBicycle):
        changed, vehicle = assigned_each([plant, plant.vehicle], assignments, name)
        made: Plant = changed.replace(vehicle=vehicle)
        return made
    configurable: Any = plant
    params = assigned(configurable.params, assignments, name)
    return configurable.with_params(params)  # type: ignore[no-any-return]


def _pedals(name: str | None, assignments: list[str]) -> CoupledLongitudinal | SpeedPid:
    """Make what works the pedals."""
    name = "coupled" if name is None else name
    if name == "coupled":
        return CoupledLongitudinal(assigned(CoupledLongitudinalParams(), assignments, name))
    if name == "speed-pid":
        return SpeedPid(assigned(SpeedPidParams(), assignments, name))
    raise ConfigError.unknown("longitudinal law", name, _LONGITUDINAL)
