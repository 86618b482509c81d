"""``popsteer stability``: how far the steering loops are from instability."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from popsteer import presets, sim, study
from popsteer.cli import inputs, options
from popsteer.cli.assignments import assigned
from popsteer.cli.progress import Progress
from popsteer.errors import ConfigError
from popsteer.files import check_files, check_folder, write_files_atomic
from popsteer.study.stability import DEFAULT_SPEEDS

__all__ = ["HELP", "stability"]

_SPEEDS = ",".join(f"{speed:g}" for speed in DEFAULT_SPEEDS)
# All that there may be: some are drawn for some laws alone.
_FIGURES = tuple(
    f"{name}{theme}.png"
    for name in ("stability-margins", "stability-map", "carrot-offset", "preview-choice")
    for theme in ("", "-dark")
)

HELP = """\
Tell how far the steering loop of each law is from instability.

The loop is that of small signals about straight driving: the law, linear; the command, held for
the control period; the dead time; a lag of first order; the kinematic bicycle. Broken at the
command it has three margins: the factor by which the steering may act more strongly, the phase
that it may lag more, and the dead time that may be added.

The vehicle's figures are those of a plant, and any of them can be set.

\b
Examples:
  popsteer stability
  popsteer stability --controllers pop --set min_lookahead=3 --speeds 5,10,15
  popsteer stability --plant carla-identified --dead-time 0.1
  popsteer stability --wheelbase 2.7 --lag 0.2 --json margins.json --figures figures
"""


def stability(
    *,
    controllers: Annotated[
        str,
        typer.Option(metavar="LAWS", help=f"The laws, of {', '.join(study.LINEAR_LAWS)}."),
    ] = ",".join(study.LINEAR_LAWS),
    preset: options.Preset = "default",
    set_: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="Set a parameter of each of the laws.",
            show_default=False,
        ),
    ] = None,
    speeds: Annotated[
        str, typer.Option(metavar="SPEEDS", help="Speeds [m/s], separated by commas.")
    ] = _SPEEDS,
    plant: Annotated[
        str,
        typer.Option(
            metavar="NAME", help=f"Whose figures to begin with: {', '.join(sim.plant_names())}."
        ),
    ] = "kinematic-bicycle",
    wheelbase: Annotated[
        float | None,
        typer.Option(help="Wheelbase that its turning obeys [m].", show_default=False),
    ] = None,
    lag: Annotated[
        float | None,
        typer.Option(
            help="Time constant from command to yaw rate [s]; by default the plant's,"
            " and 0.1 where it has none.",
            show_default=False,
        ),
    ] = None,
    dead_time: Annotated[float, typer.Option(help="Time until a command begins to act [s].")] = 0.0,
    front_offset: Annotated[
        float | None,
        typer.Option(
            help="Front axle ahead of the point that does not slip [m].", show_default=False
        ),
    ] = None,
    rear_offset: Annotated[
        float | None,
        typer.Option(
            help="Rear axle ahead of that point [m]; negative behind it.", show_default=False
        ),
    ] = None,
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
    """Tell how far the steering loop of each law is from instability."""
    from rich.console import Console
    from rich.text import Text

    from popsteer.report.stability import NOTE, stability_caption, stability_json, stability_table

    vehicle = _vehicle(plant, wheelbase, lag, dead_time, front_offset, rear_offset)
    params = {
        name: assigned(vehicle.fitted(presets.get(name, preset)), set_ or [], name)
        for name in inputs.names(controllers)
    }
    changed = " with changes" if set_ else ""
    if figures is not None:
        check_folder(figures, _FIGURES)
    if json is not None:
        check_files([json])
    result = study.stability(params, vehicle, _speeds(speeds), preset=f"{preset}{changed}", dt=dt)
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


def _vehicle(
    plant: str,
    wheelbase: float | None,
    lag: float | None,
    dead_time: float,
    front_offset: float | None,
    rear_offset: float | None,
) -> study.Vehicle:
    """Take a plant's figures, and change what is given."""
    vehicle = study.Vehicle.of(plant, dead_time=dead_time)
    if lag is None:
        lag = vehicle.lag or 0.1
    if wheelbase is not None and front_offset is None and vehicle.rear_offset == 0.0:
        front_offset = wheelbase  # the front axle goes with the wheelbase
    changes = {
        "wheelbase": wheelbase,
        "lag": lag,
        "front_offset": front_offset,
        "rear_offset": rear_offset,
    }
    given = {name: value for name, value in changes.items() if value is not None}
    return replace(vehicle, **given)


def _speeds(text: str) -> list[float]:
    """Read a list of speeds."""
    try:
        found = [float(part) for part in text.split(",") if part.strip()]
    except ValueError:
        found = []
    if not found:
        raise ConfigError("--speeds", text, "numbers [m/s], separated by commas")
    return found


def _drawn(result: study.Stability, folder: Path) -> dict[Path, bytes]:
    """Draw the figures that go into a folder."""
    from popsteer.report.figures.stability import stability_figures

    with Progress() as progress:
        figures = stability_figures(result, progress.update)
    return {folder / name: data for name, data in figures.items()}
