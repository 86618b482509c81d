"""What a log does not identify, one parameter after the other, and what to drive to learn it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from popsteer._core import Vehicle
    from popsteer.identification.drive import PreparedLog
    from popsteer.identification.fit import Fit

_SURE_LENGTH = 0.05
"""Largest standard error of what turns the car, as a share: beyond it two causes are one."""
_SURE_OFFSET = math.radians(0.3)
_SURE_DELAY = 0.02
_SURE_SUM = 0.05
_SURE_SHIFT = 0.1


class Doubt(NamedTuple):
    """Something that the log does not identify."""

    fixed: dict[str, float]
    """What is to be taken as known, at which value."""
    unknown: dict[str, str]
    """The fields of the vehicle that stay unknown, and why."""
    note: str = ""


def unsure(found: Fit, drive: PreparedLog, given: Vehicle) -> Doubt | None:
    """Give the first thing that the log does not identify, to take from `given`; None if all is."""
    for rule in (_shift, _understeer, _oversteer, _offset, _delay):
        if (doubt := rule(found, drive, given)) is not None:
            return doubt
    return None


def steps(drive: PreparedLog, share: float = 1.0) -> str:
    """Word steps of the steering at a share of the usual speed, of 2 m/s² to the side."""
    speed = share * drive.usual_speed
    length = 2.7 if speed > 3.0 else 1.0
    return f"{min(2.0 * length / speed**2, 0.3):.1g} rad at {speed:.2g} m/s"


def rate_unknown(found: Fit) -> str:
    """Say why no limit of the wheels' rate was found, and above what it lies."""
    wheels = found.wheels
    between = np.abs(np.diff(wheels.angle) / np.diff(wheels.times))
    fastest = float(np.quantile(between, 0.999)) if len(between) else 0.0
    return (
        "a limit of the wheels' rate was not reached long enough to be known; it lies above"
        f" {fastest:.2f} rad/s, if there is one: drive steps of 0.2 rad and more, to both sides,"
        " at low speed"
    )


def _shift(found: Fit, drive: PreparedLog, _: Vehicle) -> Doubt | None:
    hardest = max(float(np.quantile(np.abs(drive.acceleration), 0.9)), 0.1)
    bends = found.errors.get("load_shift", 0.0) * hardest * drive.usual_speed**2
    if bends > _SURE_SHIFT * found.values["turning_wheelbase"]:
        return Doubt({"load_shift": 0.0}, {})
    return None


def _understeer(found: Fit, drive: PreparedLog, given: Vehicle) -> Doubt | None:
    square, length = drive.usual_speed**2, found.values["turning_wheelbase"]
    errors = found.errors
    if "understeer" not in errors:
        return None
    at_speed = found.error_of(turning_wheelbase=1.0, understeer=square)
    error = max(errors["understeer"] * square, errors["turning_wheelbase"])
    if error <= max(_SURE_LENGTH * length, 2.0 * at_speed):
        return None
    why = (
        "one speed only, or nearly: turning wheelbase and understeer cannot be distinguished;"
        f" understeer is taken as {given.understeer:g} s²/m, and the turning wheelbase holds at"
        f" {drive.usual_speed:.1f} m/s: drive steps of {steps(drive, 0.6)} and of"
        f" {steps(drive, 1.4)}"
    )
    return Doubt({"understeer": given.understeer}, {"understeer": why})


def _oversteer(found: Fit, _: PreparedLog, __: Vehicle) -> Doubt | None:
    slope = found.values["understeer"]
    if "understeer" not in found.names or slope >= 0.0:
        return None
    clear = slope < -3.0 * found.errors["understeer"]
    note = (
        f"the faster, the more the car turns (oversteer, understeer = {slope:.2g} s²/m): a vehicle"
        " has none below 0, and 0 is taken"
    )
    return Doubt({"understeer": 0.0}, {}, note if clear else "")


def _offset(found: Fit, _: PreparedLog, given: Vehicle) -> Doubt | None:
    if found.errors.get("steer_offset", 0.0) <= _SURE_OFFSET:
        return None
    why = (
        "bends to one side only, or nearly: the steering offset cannot be distinguished from the"
        f" gain; it is taken as {math.degrees(given.steer_offset):g} degrees: drive bends to both"
        " sides"
    )
    return Doubt({"steer_offset": given.steer_offset}, {"steer_offset": why})


def _delay(found: Fit, drive: PreparedLog, given: Vehicle) -> Doubt | None:
    values, errors = found.values, found.errors
    if errors.get("dead_time", 0.0) <= _SURE_DELAY:
        return None
    total = values.get("steer_lag", 0.0) + values["dead_time"]
    error = found.error_of(steer_lag=1.0, dead_time=1.0)
    if "steer_lag" not in errors or error > _SURE_SUM:
        why = (
            "the steering does not change enough to show a delay: lag and dead time are taken as"
            f" {given.steer_lag:g} and {given.dead_time:g} s: drive steps of {steps(drive)}"
        )
        taken = {"steer_lag": given.steer_lag, "dead_time": given.dead_time}
    else:
        lag = min(given.steer_lag, total)
        why = (
            "the steering is too slow to tell lag and dead time apart: only their sum,"
            f" {total:.3f} ± {error:.2g} s, is known; that {lag:.3g} s of it are lag is assumed:"
            f" drive steps of {steps(drive)}, held for 2 s"
        )
        taken = {"steer_lag": lag}
    return Doubt(taken, dict.fromkeys(("steer_lag", "dead_time"), why))
