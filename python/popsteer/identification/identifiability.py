"""What a log does not identify: why, within which range it lies, and what to drive to learn it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from popsteer._core import Vehicle
    from popsteer.identification.drive import PreparedLog
    from popsteer.identification.fit import Fit

SURE_LENGTH = 0.05
"""Largest standard error of what turns the car, as a share: beyond it two causes are one."""
SURE_ROUNDED = 0.005
"""The same of a length, where commands were rounded: nothing else in the log shows its error."""
SURE_OFFSET = math.radians(0.3)
SURE_DELAY = 0.02
SURE_SUM = 0.05
SURE_RATE = 0.1
"""Largest standard error of the wheels' rate, as a share."""
SURE_PLAY = math.radians(0.2)
LIKELY = 2.0
"""Ranges are this many standard errors wide to both sides."""


@dataclass
class Unknown:
    """What the log does not identify, by the vehicle's field."""

    why: dict[str, str] = field(default_factory=dict)
    ranges: dict[str, tuple[float, float]] = field(default_factory=dict)
    """Within which it lies."""
    fixed: dict[str, float] = field(default_factory=dict)
    """What is to be taken as known, at which value, for the others to be known."""
    moved: dict[str, float] = field(default_factory=dict)
    """By how much that moves others: what it is taken for may be wrong."""
    notes: list[str] = field(default_factory=list)

    def add(self, name: str, found: Fit, least: float, why: str) -> None:
        """Add a field with its range."""
        value, error = found.values[name], LIKELY * found.errors.get(name, math.inf)
        self.ranges[name] = (max(value - error, least), value + error)
        if found.rounded:
            why += f"; steer is recorded in steps of {found.rounded:.3g} rad: record more digits"
        self.why[name] = why


def unidentified(found: Fit, drive: PreparedLog, given: Vehicle) -> Unknown:
    """Give what the log does not identify, to be taken from `given`."""
    unknown = Unknown()
    for rule in (_understeer, _offset, _delay, _rate, _play):
        rule(unknown, found, drive, given)
    return unknown


def rounded(unknown: Unknown, found: Fit) -> None:
    """Add the length, where rounded commands hide it, once all else that is unknown is fixed."""
    length, error = found.values["turning_wheelbase"], found.errors.get("turning_wheelbase", 0.0)
    if found.rounded and found.split(turning_wheelbase=1.0).model > SURE_ROUNDED * length:
        unknown.add(
            "turning_wheelbase", found, 0.0, f"the car turns by {length:.3g} ± {error:.2g} m"
        )


def steps(drive: PreparedLog, share: float = 1.0) -> str:
    """Word steps of the steering at a share of the usual speed, of 2 m/s² to the side."""
    speed = share * drive.usual_speed
    length = 2.7 if speed > 3.0 else 1.0
    return f"{min(2.0 * length / speed**2, 0.3):.1g} rad at {speed:.2g} m/s"


def _understeer(unknown: Unknown, found: Fit, drive: PreparedLog, given: Vehicle) -> None:
    square, length, errors = drive.usual_speed**2, found.values["turning_wheelbase"], found.errors
    if "understeer" not in errors:
        return
    at_speed = found.error_of(turning_wheelbase=1.0, understeer=square)
    error = max(errors["understeer"] * square, errors["turning_wheelbase"])
    if error > max(SURE_LENGTH * length, 2.0 * at_speed):
        why = (
            "one speed only, or nearly: turning wheelbase and understeer cannot be distinguished;"
            f" understeer is taken as {given.understeer:g} s²/m, and the turning wheelbase holds at"
            f" {drive.usual_speed:.1f} m/s: drive steps of {steps(drive, 0.6)} and of"
            f" {steps(drive, 1.4)}"
        )
        unknown.add("understeer", found, 0.0, why)
        unknown.fixed["understeer"] = given.understeer
    elif (slope := found.values["understeer"]) < 0.0:
        unknown.fixed["understeer"] = 0.0
        if slope < -3.0 * errors["understeer"]:
            unknown.notes.append(
                "the faster, the more the car turns (oversteer, understeer ="
                f" {slope:.2g} s²/m): a vehicle has none below 0, and 0 is taken"
            )


def _offset(unknown: Unknown, found: Fit, _: PreparedLog, given: Vehicle) -> None:
    if found.errors.get("steer_offset", 0.0) > SURE_OFFSET:
        why = (
            "bends to one side only, or nearly: the steering offset cannot be distinguished from"
            f" the gain; it is taken as {math.degrees(given.steer_offset):g} degrees: drive bends"
            " to both sides"
        )
        unknown.add("steer_offset", found, -0.5, why)
        unknown.fixed["steer_offset"] = given.steer_offset


def _delay(unknown: Unknown, found: Fit, drive: PreparedLog, given: Vehicle) -> None:
    values, errors = found.values, found.errors
    if max(errors.get("dead_time", 0.0), errors.get("steer_lag", 0.0)) <= SURE_DELAY:
        return
    total = values["steer_lag"] + values["dead_time"]
    error = found.error_of(steer_lag=1.0, dead_time=1.0)
    if error > SURE_SUM:
        why = (
            "the steering does not change enough to show a delay: lag and dead time are taken as"
            f" {given.steer_lag:g} and {given.dead_time:g} s: drive steps of {steps(drive)}"
        )
    else:
        off = 3.0 * errors["steer_lag"]  # what is assumed the log must not refute
        lag = max(values["steer_lag"] - off, min(given.steer_lag, values["steer_lag"] + off, total))
        why = (
            "the steering is too slow to tell lag and dead time apart: only their sum,"
            f" {total:.3f} ± {error:.2g} s, is known; that {lag:.3g} s of it are lag is assumed:"
            f" drive steps of {steps(drive)}, held for 2 s"
        )
        unknown.fixed["steer_lag"] = lag
    for name in ("steer_lag", "dead_time"):
        unknown.add(name, found, 0.0, why)
        low, high = unknown.ranges[name]
        unknown.ranges[name] = (low, min(high, total + LIKELY * error))


def _rate(unknown: Unknown, found: Fit, _: PreparedLog, given: Vehicle) -> None:
    rate = found.values.get("max_steer_rate")
    if given.max_steer_rate is not None:
        return
    error = found.errors.get("max_steer_rate", math.inf)
    if rate is not None and found.rate_seen and error <= SURE_RATE * rate:
        return
    wheels = found.wheels
    between = np.abs(np.diff(wheels.angle) / np.diff(wheels.times))
    fastest = float(np.quantile(between, 0.999)) if len(between) else 0.0
    unknown.ranges["max_steer_rate"] = (fastest, math.inf)
    unknown.why["max_steer_rate"] = (
        "the wheels were not seen against a limit of their rate for long enough; it lies above"
        f" {fastest:.2f} rad/s, if there is one: drive steps of 0.2 rad and more, to both sides, at"
        " low speed"
    )


def _play(unknown: Unknown, found: Fit, drive: PreparedLog, _: Vehicle) -> None:
    play, error = found.values.get("steer_play", 0.0), found.errors.get("steer_play", 0.0)
    if found.play_seen and error <= SURE_PLAY and play > found.rounded:
        return
    most = max(play + LIKELY * error if play else _bound(found), found.rounded)
    unknown.ranges["steer_play"] = (0.0, most)
    unknown.why["steer_play"] = (
        f"no play of the steering is seen; there are at most {math.degrees(most):.1f} degrees of it"
        f": to learn it, turn the wheels to and fro by little, {steps(drive, 0.5)}"
    )


def _bound(found: Fit) -> float:
    """Give the play at which the log is less likely, by two standard deviations, than without."""
    plays = [0.002, 0.005, 0.01, 0.02, 0.04, 0.08]
    behind = found.profile("steer_play", plays)
    refused = [play for play, each in zip(plays, behind, strict=True) if -each > 0.5 * LIKELY**2]
    return min(refused, default=0.2)
