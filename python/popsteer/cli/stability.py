"""``popsteer stability``: how far the steering loops are from instability."""

from __future__ import annotations

from typing import Annotated

import typer

from popsteer import lab
from popsteer.cli import inputs, options, outputs
from popsteer.cli.options import optional
from popsteer.cli.outputs import Progress
from popsteer.errors import ConfigError

_CONTROLLERS = ",".join(inputs.OWN_CONTROLLERS)
# The map is drawn of controllers with a lookahead alone.
_FIGURES = ("stability-margins", "stability-loops", "stability-map")
_FILES = ["stability.json", *(f"{name}{dark}.png" for name in _FIGURES for dark in ("", "-dark"))]

HELP = """\
Show how far the steering loop of each controller is from instability.

The loop is linear, for small deviations from straight driving: the controller, the command held for
a control period, the dead time, a first-order lag, and the kinematic bicycle. It has three margins:
the gain margin, the phase margin, and the dead time that can be added before the loop becomes
unstable. A controller that is given a dead time predicts through it, as when it drives.

\b
Examples:
  popsteer stability
  popsteer stability --vehicle car.toml --out out
  popsteer stability --controllers pop --set min_lookahead=3 --speeds 5,10,15
  popsteer stability --vehicle carla-identified --set-vehicle dead_time=0.1
  popsteer stability --set-plant dead_time=0.1    which nobody is told of
"""


def stability(
    *,
    controllers: options.OwnControllers = _CONTROLLERS,
    preset: options.Preset = "default",
    params: options.Params = None,
    set_: options.Set = None,
    speeds: Annotated[
        str | None, optional("M/S", "By commas; else 2 to 25, up to the vehicle's top speed.")
    ] = None,
    vehicle: Annotated[
        str | None, optional("NAME|FILE", "What controllers know; else that of --plant, or paper.")
    ] = None,
    set_vehicle: options.SetVehicle = None,
    plant: Annotated[
        str | None, optional("NAME|FILE", "The real vehicle; by default the same.")
    ] = None,
    set_plant: Annotated[
        list[str] | None, optional("NAME=VALUE", "A field of the real vehicle alone.")
    ] = None,
    dt: options.Dt = options.DEFAULT_DT,
    out: options.Out = None,
    report: options.Report = None,
    context: typer.Context,
) -> None:
    """Show how far the steering loops are from instability."""
    names = inputs.names("--controllers", controllers)
    given = inputs.believed(vehicle or plant or "paper", set_vehicle)
    itself = inputs.believed(plant, set_plant, given)
    tuning = inputs.tuned(
        names,
        preset,
        set_,
        params=params,
        known=inputs.OWN_CONTROLLERS,
        own_too=False,
        in_loop=False,
    )
    at = None if speeds is None else _speeds(speeds)
    outputs.check_folder(out, _FILES, report)
    with Progress() as progress:
        result = lab.stability.run(
            tuning.params, itself, at, believed=given, preset=tuning.preset, dt=dt
        )
        content: dict[str, bytes] = {}
        if out is not None:
            from popsteer.lab.stability.figures import stability_figures

            content = stability_figures(result, progress.update)
            content["stability.json"] = lab.stability.table.stability_json(result).encode()
    said = outputs.write(content, out, "--out DIR writes stability.json and figures.")
    table = lab.stability.table
    made_by = lab.report.Origin(outputs.command_line(context), tuning.params)
    shown = table.stability_caption(result), [table.stability_table(result)], [table.NOTE], said
    outputs.show(*shown, report, draw=lambda _: lab.report.of_stability(result, made_by))


def _speeds(text: str) -> list[float]:
    try:
        found = [float(part) for part in text.split(",") if part.strip()]
    except ValueError:
        found = []
    if not found:
        raise ConfigError("--speeds", text, "numbers [m/s], separated by commas")
    return found
