"""Margins of steering loops, as a table and for programs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from popsteer._core import __version__
from popsteer.lab.common.layout import add_names, add_numbers, blank_table, finite, json_text
from popsteer.lab.common.names import differences, title_of
from popsteer.lab.stability.linear import lookahead
from popsteer.lab.stability.runs import Stability

if TYPE_CHECKING:
    from rich.table import Table

SCHEMA = 2
"""Version of the document's layout."""
NOTE = (
    "Small signals about straight driving. gain: gain margin, a factor; phase: phase margin; dead"
    " time: what may be added to the vehicle's without telling the controller. A dash: the loop is"
    " unstable as it is."
)
"""What a reader of the table has to know."""


def stability_caption(result: Stability) -> str:
    """Say in one line what was measured: vehicle, preset and control period."""
    car = result.vehicle
    length, understeer = car.turning_length(0.0), car.understeer
    turning = f", turns as {length:g} m" if length != car.wheelbase else ""
    turning += f", understeer {understeer:g} s²/m" if understeer else ""
    return (
        f"wheelbase {car.wheelbase:g} m{turning}, axles at {car.front_axle:g} and"
        f" {car.rear_axle:g} m, lag {car.steer_lag:g} s, dead time {car.dead_time:g} s"
        f"{differences(result.believed, car)}, preset {result.preset}, dt {result.dt:g} s"
    )


def stability_table(result: Stability) -> Table:
    """Set out margins, a row for each controller and speed."""
    table = blank_table()
    add_names(table, "controller", (title_of(name, result.margins) for name in result.margins))
    add_numbers(table, "speed\n[m/s]", "lookahead\n[m]", "gain\n[-]")
    add_numbers(table, "phase\n[deg]", "dead time\n[ms]")
    for name, rows in result.margins.items():
        for index, (speed, found) in enumerate(zip(result.speeds, rows, strict=True)):
            table.add_row(
                title_of(name, result.margins) if index == 0 else "",
                f"{speed:g}",
                "" if (ahead := _lookahead(result, name, speed)) is None else f"{ahead:.1f}",
                _number(found.gain, 1.0, 2),
                _number(found.phase, math.degrees(1.0), 1),
                _number(found.dead_time, 1e3, 0),
                end_section=speed == result.speeds[-1],
            )
    return table


def stability_json(result: Stability) -> str:
    """Write margins as JSON, in SI units and radians; infinite or missing ones are null."""
    document = {
        "schema": SCHEMA,
        "version": __version__,
        "vehicle": result.believed.as_dict(),
        "plant_vehicle": result.vehicle.as_dict(),
        "preset": result.preset,
        "dt": result.dt,
        "laws": {
            name: [
                {"speed": speed, "lookahead": _lookahead(result, name, speed)}
                | {k: finite(v) for k, v in found._asdict().items()}
                for speed, found in zip(result.speeds, rows, strict=True)
            ]
            for name, rows in result.margins.items()
        },
        "params": {
            name: params.resolved(result.believed).as_dict()
            for name, params in result.params.items()
        },
    }
    return json_text(document)


def _lookahead(result: Stability, name: str, speed: float) -> float | None:
    return lookahead(result.params[name], result.believed, speed)


def _number(value: float, scale: float, decimals: int) -> str:
    if math.isnan(value):
        return "–"
    return "∞" if math.isinf(value) else f"{scale * value:.{decimals}f}"
