"""What a log does not identify, one parameter after the other."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from popsteer._core import Vehicle
    from popsteer.identification.drive import PreparedLog
    from popsteer.identification.fit import Fit

__all__ = ["error_of", "unsure"]

Doubt: TypeAlias = "tuple[dict[str, float], str]"
"""What is to be taken for known, and in words why."""
_SURE_LENGTH = 0.05
"""Largest standard error of what turns the car, as a share: beyond it two causes are one."""
_SURE_OFFSET = math.radians(0.3)
_SURE_DELAY = 0.03
_SURE_SHIFT = 0.1


def unsure(found: Fit, drive: PreparedLog, given: Vehicle) -> Doubt | None:
    """Give the first thing that the log does not identify.

    Parameters
    ----------
    found : Fit
        A fit.
    drive : PreparedLog
        The log.
    given : Vehicle
        Gives the values that the log does not show.

    Returns
    -------
    tuple or None
        What to fix at which value, and the note on it; None if everything can be distinguished.
    """
    for rule in (_shift, _understeer, _oversteer, _offset, _delay):
        if (doubt := rule(found, drive, given)) is not None:
            return doubt
    return None


def error_of(found: Fit, weights: dict[str, float]) -> float:
    """Give the standard error of a weighted sum of parameters."""
    vector = np.array([weights.get(name, 0.0) for name in found.errors])
    return float(np.sqrt(max(vector @ found.covariance @ vector, 0.0)))


def _shift(found: Fit, drive: PreparedLog, given: Vehicle) -> Doubt | None:  # noqa: ARG001 - as the others
    hardest = max(float(np.quantile(np.abs(drive.acceleration), 0.9)), 0.1)
    bends = found.errors.get("load_shift", 0.0) * hardest * drive.usual_speed**2
    if bends > _SURE_SHIFT * found.values["turning_wheelbase"]:
        return {"load_shift": 0.0}, ""
    return None


def _understeer(found: Fit, drive: PreparedLog, given: Vehicle) -> Doubt | None:
    square, length = drive.usual_speed**2, found.values["turning_wheelbase"]
    if "understeer" not in found.errors:
        return None
    at_speed = error_of(found, {"turning_wheelbase": 1.0, "understeer": square})
    error = max(found.errors["understeer"] * square, found.errors["turning_wheelbase"])
    if error <= max(_SURE_LENGTH * length, 2.0 * at_speed):
        return None
    return {"understeer": given.understeer}, (
        "one speed only, or nearly: turning wheelbase and understeer cannot be distinguished;"
        f" understeer is taken as {given.understeer:g} s²/m, and the turning wheelbase holds at"
        f" {drive.usual_speed:.1f} m/s"
    )


def _oversteer(found: Fit, drive: PreparedLog, given: Vehicle) -> Doubt | None:  # noqa: ARG001
    slope = found.values["understeer"]
    if "understeer" not in found.errors or slope >= 0.0:
        return None
    clear = slope < -3.0 * found.errors["understeer"]
    return {"understeer": 0.0}, (
        "the faster, the more the car turns (oversteer, understeer ="
        f" {slope:.2g} s²/m): a vehicle has none below 0, and 0 is taken"
        if clear
        else ""
    )


def _offset(found: Fit, drive: PreparedLog, given: Vehicle) -> Doubt | None:  # noqa: ARG001
    if found.errors.get("steer_offset", 0.0) <= _SURE_OFFSET:
        return None
    return {"steer_offset": given.steer_offset}, (
        "bends to one side only, or nearly: the steering offset cannot be distinguished from the"
        f" gain; it is taken as {math.degrees(given.steer_offset):g} degrees"
    )


def _delay(found: Fit, drive: PreparedLog, given: Vehicle) -> Doubt | None:  # noqa: ARG001
    values, errors = found.values, found.errors
    if errors.get("dead_time", 0.0) <= _SURE_DELAY:
        return None
    if "steer_lag" in errors:
        return {"steer_lag": given.steer_lag}, (
            "the steering is too slow to tell lag and dead time apart: only their sum,"
            f" {values['steer_lag'] + values['dead_time']:.3f} s, is known; the lag is taken as"
            f" {given.steer_lag:g} s"
        )
    return {"dead_time": given.dead_time}, (
        "the steering does not change enough to show a delay: lag and dead time are taken as"
        f" {given.steer_lag:g} and {given.dead_time:g} s"
    )
