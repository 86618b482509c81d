"""``popsteer stability``: how far the steering loops are from instability."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from popsteer import lab, presets, vehicles
from popsteer.cli import inputs, options
from popsteer.cli.assignments import assigned
from popsteer.cli.progress import Progress
from popsteer.errors import ConfigError
from popsteer.files import check_files, check_folder, write_files_atomic
from popsteer.lab.stability.runs import DEFAULT_SPEEDS

__all__ = ["HELP", "stability"]

_SPEEDS = ",".join(f"{speed:g}" for speed in DEFAULT_SPEEDS)
# All that there may be: some are drawn for some laws alone.
_FIGURES = tuple(
    f"{name}{theme}.png"
    for name in ("stability-margins", "stability-map", "carrot-offset", "preview-choice")
    for theme in ("", "-dark")
)

HELP = """\
Tell how far the steering loop of each controller is from instability.

The loop is that of small signals about straight driving: the controller, linear; the command, held
for the control period; the dead time; a lag of first order; the kinematic bicycle. Broken at the
command it has three margins: the gain margin, the phase margin, and the dead time that may be
added. A controller that is told a dead time predicts through it, as it does when it drives.

\b
Examples:
  popsteer stability
  popsteer stability --vehicle car.toml --json margins.json --figures figures
  popsteer stability --controllers pop --set min_lookahead=3 --speeds 5,10,15
  popsteer stability --vehicle carla-identified --set-vehicle dead_time=0.1
  popsteer stability --set-plant dead_time=0.1    nobody tells the controllers of it
"""


def stability(
    *,
    controllers: Annotated[
        str,
        typer.Option(
            metavar="LAWS",
            help=f"The controllers, of {', '.join(lab.stability.runs.LINEAR_CONTROLLERS)}.",
        ),
    ] = ",".join(lab.stability.runs.LINEAR_CONTROLLERS),
    preset: options.Preset = "default",
    set_: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="Set a parameter of each of the controllers.",
            show_default=False,
        ),
    ] = None,
    speeds: Annotated[
        str, typer.Option(metavar="SPEEDS", help="Speeds [m/s], separated by commas.")
    ] = _SPEEDS,
    vehicle: Annotated[
        str,
        typer.Option(
            metavar="FILE|NAME",
            help="The vehicle, as the controllers are told: a file *.toml as popsteer.Vehicle.save"
            f" writes it, {', '.join(vehicles.names())}, or a plant's.",
        ),
    ] = "paper",
    set_vehicle: options.SetVehicle = None,
    plant: Annotated[
        str | None,
        typer.Option(
            metavar="FILE|NAME",
            help="The vehicle as it is, where that is another than the controllers are told.",
            show_default=False,
        ),
    ] = None,
    set_plant: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE",
            help="Set a field of the vehicle as it is, without telling the controllers.",
            show_default=False,
        ),
    ] = None,
    no_adapt: options.NoAdapt = False,
    dt: options.Dt = options.DEFAULT_DT,
    json: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write the margins as JSON.", show_default=False),
    ] = None,
    figures: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Draw the margins over speed and lookahead, how POP cuts bends, and what preview"
            " changes.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Tell how far the steering loop of each controller is from instability."""
    from rich.console import Console
    from rich.text import Text

    from popsteer.lab.stability.table import (
        NOTE,
        stability_caption,
        stability_json,
        stability_table,
    )

    told = assigned(inputs.named_vehicle(vehicle), set_vehicle or [], "the vehicle")
    itself = told if plant is None else inputs.named_vehicle(plant)
    itself = assigned(itself, set_plant or [], "the vehicle")
    params = {
        name: assigned(presets.get(name, preset), set_ or [], name)
        for name in inputs.names(controllers)
    }
    changed = " with changes" if set_ else ""
    if figures is not None:
        check_folder(figures, _FIGURES)
    if json is not None:
        check_files([json])
    result = lab.stability.run(
        params,
        itself,
        _speeds(speeds),
        believed=told,
        adapt=None if no_adapt else "auto",
        preset=f"{preset}{changed}",
        dt=dt,
    )
    drawn = {} if figures is None else _drawn(result, figures)
    document = {} if json is None else {json: stability_json(result).encode()}
    write_files_atomic({**drawn, **document})
    console = Console()
    console.print(Text(stability_caption(result), style="bold"), soft_wrap=True)
    console.print()
    console.print(stability_table(result))
    console.print()
    console.print(Text(NOTE, style="dim"), soft_wrap=not console.is_terminal)
    if drawn:
        print(f"Written to {figures}: {', '.join(file.name for file in drawn)}")
    if document:
        print(f"Written to {json}")


def _speeds(text: str) -> list[float]:
    """Read a list of speeds."""
    try:
        found = [float(part) for part in text.split(",") if part.strip()]
    except ValueError:
        found = []
    if not found:
        raise ConfigError("--speeds", text, "numbers [m/s], separated by commas")
    return found


def _drawn(result: lab.stability.Stability, folder: Path) -> dict[Path, bytes]:
    """Draw the figures that go into a folder."""
    from popsteer.lab.stability.figures import stability_figures

    with Progress() as progress:
        figures = stability_figures(result, progress.update)
    return {folder / name: data for name, data in figures.items()}
