"""What was identified, as a table and for programs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from popsteer._core import Vehicle, __version__
from popsteer.identification import Identification
from popsteer.lab.common.layout import add_numbers, blank_table, csv_columns, finite, json_text

if TYPE_CHECKING:
    from rich.table import Table

__all__ = ["caption", "identified_csv", "identified_json", "identified_table"]

SCHEMA = 4
"""Version of the document's layout."""
_LAGS = {
    "wheels": "before the wheels",
    "yaw rate": "of the yaw rate behind the wheels",
    "tyres": "of the yaw rate, growing with the speed",
}


_DOCUMENT = (
    *("errors", "model_errors", "unknown", "verdict"),
    *("delay", "delay_error", "turning_length", "turning_length_error"),
    *("ranges", "excitation", "unexplained", "octaves"),
    *("speed", "lag_of", "yaw_rate_residual", "yaw_rate_rms", "position_residual", "noise"),
)


class _Row(NamedTuple):
    field: str
    head: str
    unit: str
    scale: float = 1.0


_ROWS = (
    _Row("wheelbase", "wheelbase", "m"),
    _Row("turning_wheelbase", "turning wheelbase", "m"),
    _Row("understeer", "understeer", "s²/m"),
    _Row("steer_offset", "steering offset", "deg", math.degrees(1.0)),
    _Row("steer_lag", "lag", "ms", 1e3),
    _Row("dead_time", "dead time", "ms", 1e3),
    _Row("max_steer_rate", "rate of the wheels", "rad/s"),
    _Row("steer_play", "play of the steering", "deg", math.degrees(1.0)),
    _Row("drive_delay", "delay of the drive", "ms", 1e3),
    _Row("drive_lag", "lag of the drive", "ms", 1e3),
    _Row("rear_axle", "rear axle, from the pose", "m"),
    _Row("no_slip_point", "no-slip point, from the pose", "m"),
)


def caption(found: Identification) -> str:
    """Say in one line what was identified from what: the log, its length and its period."""
    log = found.log
    return (
        f"{log.name}: {log.duration:.1f} s, {len(log)} rows every {1e3 * log.period:.0f} ms;"
        f" lag {_LAGS[found.lag_of]}"
    )


def identified_table(found: Identification, given: Vehicle | None = None) -> Table:
    """Set out what was found, with its errors, beside what was known before, `given`."""
    table = blank_table()
    table.add_column("", no_wrap=True)
    add_numbers(table, "found", "± noise", "± model", *(() if given is None else ("given",)))
    table.add_column("", no_wrap=True)

    def add(row: _Row, value: float | None, error: float | None, before: float | None) -> None:
        cells = "–", "", ""
        if value is not None and error is not None:
            model = with_error(0.0, row.scale * found.model_errors[row.field])[1]
            cells = *with_error(row.scale * value, row.scale * error), model
        earlier = "none" if before is None else f"{row.scale * before:.4g}"
        table.add_row(row.head, *cells, *(() if given is None else (earlier,)), row.unit)

    for row in _ROWS:
        value, error = getattr(found.vehicle, row.field), found.errors.get(row.field)
        before = getattr(given, row.field, None)
        if error is not None or before is not None or row.field in found.unknown:
            add(row, value, error, before)
    table.add_section()
    length = delay = None
    if given is not None:
        length, delay = given.turning_length(found.speed), given.dead_time + given.steer_lag
    turning = _Row("turning_length", f"turning length at {found.speed:.1f} m/s", "m")
    add(turning, found.turning_length, found.turning_length_error, length)
    both = _Row("delay", "dead time and lag together", "ms", 1e3)
    add(both, found.delay, found.delay_error, delay)
    return table


def with_error(value: float, error: float) -> tuple[str, str]:
    """Word a value and its standard error: two digits of the error, and the value to match.

    Examples
    --------
    >>> with_error(2.70016, 0.00091), with_error(149.66, 23.4), with_error(0.5, math.inf)
    (('2.70016', '0.00091'), ('150', '23'), ('–', ''))
    """
    if not math.isfinite(error):
        return "–", ""
    if error <= 0.0:
        return f"{value:.6g}", "0"
    places = max(1 - math.floor(math.log10(float(f"{error:.1e}"))), 0)
    return f"{value:.{places}f}", f"{error:.{places}f}"


def identified_json(found: Identification) -> str:
    """Write what was found as JSON, in SI units and radians."""
    shown = {name: getattr(found, name) for name in _DOCUMENT}
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "version": __version__,
        "log": found.log.name,
        "vehicle": found.vehicle.as_dict(),
        **{name: finite(value) for name, value in shown.items()},
        "notes": list(found.notes),
    }
    return json_text(document)


def identified_csv(found: Identification) -> str:
    """Write the measured and the simulated motion as CSV, a row for each of the log's."""
    records = {name: np.asarray(values, dtype=np.float64) for name, values in found.records.items()}
    return csv_columns(["SI units and radians; counts: 1 where the row counts"], records)


_WIDTH = 0.25  # s


def smoothed(values: NDArray[Any], period: float) -> NDArray[np.float64]:
    """Smooth a line, sampled every `period` [s], by a Hann window of 0.25 s; its gaps stay."""
    size = max(1, round(_WIDTH / period))
    kernel = np.hanning(2 * size + 1)[1:-1] if size > 1 else np.ones(1)
    if len(kernel) > len(values):
        return values
    whole = np.isfinite(values)
    weight = np.convolve(whole.astype(np.float64), kernel, mode="same")
    smooth = np.convolve(np.where(whole, values, 0.0), kernel, mode="same")
    return np.where(whole, smooth / np.maximum(weight, 1e-12), np.nan)
