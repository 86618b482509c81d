"""What was identified, as a table and for programs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from popsteer._core import __version__
from popsteer.lab.common.layout import add_numbers, blank_table, csv_text, json_text

if TYPE_CHECKING:
    from rich.table import Table

    from popsteer._core import Vehicle
    from popsteer.identification import Identification

__all__ = ["caption", "identified_csv", "identified_json", "identified_table"]

SCHEMA = 1
"""Version of the document's layout."""
_LAGS = {
    "wheels": "before the wheels",
    "yaw rate": "of the yaw rate behind the wheels",
    "tyres": "of the yaw rate, growing with the speed",
}


class _Row(NamedTuple):
    field: str
    head: str
    unit: str
    scale: float
    decimals: int


_ROWS = (
    _Row("wheelbase", "wheelbase", "m", 1.0, 3),
    _Row("turning_wheelbase", "turning wheelbase", "m", 1.0, 3),
    _Row("understeer", "understeer", "s²/m", 1.0, 5),
    _Row("steer_offset", "steering offset", "deg", math.degrees(1.0), 3),
    _Row("steer_lag", "lag", "ms", 1e3, 0),
    _Row("dead_time", "dead time", "ms", 1e3, 0),
    _Row("max_steer_rate", "rate of the wheels", "rad/s", 1.0, 3),
    _Row("rear_axle", "rear axle, from the pose", "m", 1.0, 3),
    _Row("no_slip_point", "no-slip point, from the pose", "m", 1.0, 3),
)


def caption(found: Identification) -> str:
    """Say in one line what was identified from what: the log, its length and its period."""
    log = found.log
    return (
        f"{log.name}: {log.duration:.1f} s, {len(log)} rows every {1e3 * log.period:.0f} ms;"
        f" lag {_LAGS[found.lag_of]}"
    )


def identified_table(found: Identification, given: Vehicle | None = None) -> Table:
    """Set out what was found, with its standard errors, beside what was known before, `given`."""
    table = blank_table()
    table.add_column("", no_wrap=True)
    add_numbers(table, "found", "± error", "given")
    table.add_column("", no_wrap=True)
    for row in _ROWS:
        value, error = getattr(found.vehicle, row.field), found.errors.get(row.field)
        before = None if given is None else getattr(given, row.field)
        if value is None and before is None:
            continue
        table.add_row(
            row.head,
            "–" if error is None else _number(value, row),
            "" if error is None else f"{row.scale * error:.{row.decimals}f}",
            "" if before is None else _number(before, row),
            row.unit,
        )
    table.add_section()
    table.add_row(
        f"turning length at {found.speed:.1f} m/s",
        f"{found.turning_length:.3f}",
        f"{found.turning_length_error:.3f}",
        "" if given is None else f"{given.turning_length(found.speed):.3f}",
        "m",
    )
    table.add_row(
        "dead time and lag together",
        f"{1e3 * found.delay:.0f}",
        f"{1e3 * found.delay_error:.0f}",
        "" if given is None else f"{1e3 * (given.dead_time + given.steer_lag):.0f}",
        "ms",
    )
    table.add_row("yaw rate left over, rms", f"{found.yaw_rate_residual:.4f}", "", "", "rad/s")
    table.add_row("yaw rate, rms", f"{found.yaw_rate_rms:.4f}", "", "", "rad/s")
    table.add_row("noise of the yaw", f"{found.noise['yaw']:.4f}", "", "", "rad")
    table.add_row("off to the side within 10 s, rms", f"{found.position_residual:.3f}", "", "", "m")
    return table


def identified_json(found: Identification) -> str:
    """Write what was found as JSON, in SI units and radians."""
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "version": __version__,
        "log": found.log.name,
        "vehicle": found.vehicle.as_dict(),
        "errors": found.errors,
        "delay": found.delay,
        "delay_error": found.delay_error,
        "turning_length": found.turning_length,
        "turning_length_error": found.turning_length_error,
        "speed": found.speed,
        "lag_of": found.lag_of,
        "yaw_rate_residual": found.yaw_rate_residual,
        "yaw_rate_rms": found.yaw_rate_rms,
        "position_residual": found.position_residual,
        "noise": found.noise,
        "notes": list(found.notes),
    }
    return json_text(document)


def identified_csv(found: Identification) -> str:
    """Write the measured and the simulated motion as CSV, a row for each of the log's."""
    records = {name: np.asarray(values, dtype=np.float64) for name, values in found.records.items()}
    columns = [values.tolist() for values in records.values()]
    rows = ([f"{value:.9g}" for value in row] for row in zip(*columns, strict=True))
    return csv_text(["SI units and radians; counts: 1 where the row counts"], records, rows)


def _number(value: float | None, row: _Row) -> str:
    return "none" if value is None else f"{row.scale * value:.{row.decimals}f}"
