"""The identification: the fits, what they cannot tell apart, and the resulting vehicle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from popsteer._core import Vehicle
from popsteer.extras import require
from popsteer.identification.checks import first_length, refuse_units
from popsteer.identification.drive import prepare
from popsteer.identification.fit import Fit, fit
from popsteer.identification.identifiability import error_of, unsure
from popsteer.identification.notes import described
from popsteer.identification.result import Identification
from popsteer.identification.simulate import compared
from popsteer.logs import LogError

if TYPE_CHECKING:
    from collections.abc import Callable

    from popsteer.identification.drive import PreparedLog
    from popsteer.identification.point import Point
    from popsteer.logs import Log

__all__ = ["identify"]

_MOST_ROUNDS = 5
_NO_LENGTH = 0.15
_SURE_POINT = 0.1
_STRETCH = 0.2
"""A rate that the wheels kept for this time is known well [s]."""


def identify(
    log: Log,
    vehicle: Vehicle | None = None,
    *,
    progress: Callable[[float], object] | None = None,
) -> Identification:
    """Find out from the log of a drive what the vehicle is.

    The chain of `Vehicle`, driven by the log's commands and speeds, is fitted to the measured
    headings; the no-slip point, which moves along the heading, is fitted to the positions:

        wheel' = clip((command(t - dead_time) + steer_offset - wheel) / steer_lag, ±max_steer_rate)
        yaw'   = v tan(wheel) / (turning_wheelbase + understeer v²)

    Outliers and gaps are left out. What the log cannot show keeps the value of `vehicle`, and
    `notes` say so.

    Parameters
    ----------
    log : Log
        The drive: 10 s at least, with bends. Two minutes of bends to both sides at two speeds or
        more, with steering that is not slow, show everything. Its angles are the commanded ones; if
        they are measured ones, dead time and lag are those from the wheels to the motion.
    vehicle : Vehicle, optional
        What a tape measure and the manual say: `wheelbase`, `rear_axle`, the limits. Without it
        the positions of the axles are estimated from the motion of the car.
    progress : callable, optional
        Called now and then with the share done, 0 to 1.

    Returns
    -------
    Identification
        The vehicle, standard errors, what could not be distinguished, and the simulated drive.

    Raises
    ------
    LogError
        The log is too short or too straight, or the car does not turn as its wheels do: a sign or
        a unit is wrong.
    PopsteerError
        The extra ``lab`` is not installed.

    Examples
    --------
    >>> import numpy as np
    >>> from popsteer.logs import Log
    >>> t = np.arange(0.0, 60.0, 0.05)
    >>> steer = 0.05 * np.sin(0.9 * t) + 0.04 * np.sign(np.sin(0.5 * t))
    >>> speed = 8.0 + 3.0 * np.sin(0.2 * t)
    >>> yaw = np.cumsum(0.05 * speed * np.tan(steer) / 2.7)  # no lag, no offset
    >>> x, y = np.cumsum(0.05 * speed * np.cos(yaw)), np.cumsum(0.05 * speed * np.sin(yaw))
    >>> found = identify(Log(t, x, y, yaw, speed, steer))
    >>> round(found.vehicle.wheelbase, 1), abs(found.vehicle.steer_offset) < 1e-3
    (2.7, True)
    """
    require("identifying a vehicle", "lab", "scipy")
    from popsteer.identification.point import fit_point

    refuse_units(log)
    drive = prepare(log)
    length = first_length(drive, log.name)
    given = Vehicle() if vehicle is None else vehicle
    found, fixed, notes = _heading(drive, length, given, log.name, progress)
    point = fit_point(drive, found.yaw, found.theta)
    rate = _rate(found, notes)
    made, errors = _vehicle(vehicle, found, point, rate, fixed, drive, notes)
    values = found.values
    speed = drive.usual_speed
    return Identification(
        vehicle=made,
        errors=errors,
        delay=values["steer_lag"] + values["dead_time"],
        delay_error=error_of(found, {"steer_lag": 1.0, "dead_time": 1.0}),
        turning_length=values["turning_wheelbase"] + values["understeer"] * speed**2,
        turning_length_error=error_of(found, {"turning_wheelbase": 1.0, "understeer": speed**2}),
        speed=speed,
        lag_of=found.lag_of,
        notes=(*log.remarks, *_outliers(drive), *notes),
        noise={"yaw": found.noise, "position": point.noise},
        records=compared(
            log,
            drive,
            found.yaw,
            found.theta,
            (point.values["rear_axle"], point.values["slip"], point.values["heading_bias"]),
        ),
        log=log,
    )


def _heading(
    drive: PreparedLog,
    length: float,
    given: Vehicle,
    name: str,
    progress: Callable[[float], object] | None,
) -> tuple[Fit, dict[str, float], list[str]]:
    """Fit the heading; what the log cannot tell apart is fixed, one thing after the other."""
    fixed: dict[str, float] = {}
    if float(np.std(drive.acceleration[drive.speed != 0.0])) < 0.05:
        fixed["load_shift"] = 0.0
    if given.max_steer_rate is not None:
        fixed["max_steer_rate"] = given.max_steer_rate
    notes: list[str] = []
    start = {"turning_wheelbase": length}
    for turn in range(_MOST_ROUNDS + 1):
        part = None if progress is None else _share(progress, turn)
        found = fit(drive, start, fixed, part)
        doubt = unsure(found, drive, given) if turn < _MOST_ROUNDS else None
        if doubt is None:
            break
        more, why = doubt
        fixed.update(more)
        notes += [why] if why else []
        start = {**found.values, **fixed}
        if "max_steer_rate" not in fixed:
            start.pop("max_steer_rate", None)
    error = found.errors.get("turning_wheelbase", 0.0)
    if not error < _NO_LENGTH * found.values["turning_wheelbase"]:
        raise LogError(
            f"{name}: the log does not show how the car turns: the wheelbase that it turns by comes"
            f" out as {found.values['turning_wheelbase']:.3g} ± {error:.2g} m; drive bends to both"
            " sides, and see that steer is the angle of the front wheels"
        )
    return found, fixed, notes


def _share(progress: Callable[[float], object], turn: int) -> Callable[[float], object]:
    return lambda share: progress(1.0 - 0.2**turn * (1.0 - 0.8 * share))


def _rate(found: Fit, notes: list[str]) -> float | None:
    """Give the limit of the wheels' rate where it was reached."""
    wheels = found.wheels
    if "max_steer_rate" not in found.errors and "max_steer_rate" in found.values:
        return None  # given
    rate = found.values.get("max_steer_rate")
    if rate is None:
        between = np.diff(wheels.angle) / np.diff(wheels.times)
        fastest = float(np.quantile(np.abs(between), 0.999)) if len(between) else 0.0
        notes.append(
            "a limit of the wheels' rate was not reached; it lies above"
            f" {fastest:.2f} rad/s, if there is one"
        )
        return None
    longest, length = 0.0, 0.0
    for step, turning in zip(np.diff(wheels.times), wheels.turning[:-1], strict=True):
        length += turning
        longest = max(longest, length)
        if turning < 0.999 * step:
            length = 0.0
    if longest < _STRETCH:
        notes.append(
            f"the wheels turned at their limit for {1e3 * longest:.0f} ms at a time at most:"
            " max_steer_rate is rough, and may be too high"
        )
    return rate


def _vehicle(
    given: Vehicle | None,
    found: Fit,
    point: Point,
    rate: float | None,
    fixed: dict[str, float],
    drive: PreparedLog,
    notes: list[str],
) -> tuple[Vehicle, dict[str, float]]:
    """Make the vehicle of what was found, and of what was given for the rest."""
    values = found.values
    errors = {
        name: error
        for name, error in found.errors.items()
        if name not in ("load_shift", "max_steer_rate")
    }
    changes: dict[str, float | None] = {
        name: values[name] for name in ("understeer", "steer_offset", "steer_lag", "dead_time")
    }
    length = values["turning_wheelbase"]
    if given is None:
        changes["wheelbase"] = length
        errors["wheelbase"] = errors.pop("turning_wheelbase")
    else:
        changes["turning_wheelbase"] = length
    if rate is not None:
        changes["max_steer_rate"] = rate
        errors["max_steer_rate"] = found.errors["max_steer_rate"]
    changes["understeer"] = max(float(values["understeer"]), 0.0)
    _place(given, point, drive, changes, errors, notes)
    base = Vehicle() if given is None else given
    notes += described(base if given is not None else None, found, point, fixed)
    steepest = float(np.max(np.abs(drive.commands)))
    if steepest > base.max_steer + 1e-3:
        notes.append(
            f"the log commands up to {steepest:.3g} rad, more than max_steer, {base.max_steer:g}"
        )
    return base.replace(**changes), errors


def _place(
    given: Vehicle | None,
    point: Point,
    drive: PreparedLog,
    changes: dict[str, float | None],
    errors: dict[str, float],
    notes: list[str],
) -> None:
    """Say where the pose's point and the no-slip point lie."""
    rear, slip = point.values["rear_axle"], point.values["slip"]
    error, slip_error = point.errors["rear_axle"], point.errors["slip"]
    sliding = rear + slip * drive.usual_speed**2
    slips = abs(slip) > 3.0 * slip_error and abs(sliding - rear) > 0.05
    at_speed = point.error_at(drive.usual_speed)
    if at_speed > _SURE_POINT:
        notes.append(
            "the positions do not show where the pose's point lies on the car (rear_axle would be"
            f" {sliding:.2f} ± {at_speed:.2f} m): it stays as given"
        )
        return
    if not slips and error > _SURE_POINT:
        rear, error = sliding, at_speed  # one speed: nothing slips that one could see
    if given is None:
        changes["rear_axle"], errors["rear_axle"] = rear, error
        if slips and error <= _SURE_POINT:
            changes["no_slip_point"], errors["no_slip_point"] = sliding, at_speed
        return
    own = given.rear_axle if given.no_slip_point is None else given.no_slip_point
    if abs(sliding - own) > max(2.0 * at_speed, 0.05):
        changes["no_slip_point"], errors["no_slip_point"] = sliding, at_speed
    else:
        errors["no_slip_point" if given.no_slip_point is not None else "rear_axle"] = at_speed


def _outliers(drive: PreparedLog) -> list[str]:
    if not drive.outliers:
        return []
    numbers = "number stands" if drive.outliers == 1 else "numbers stand"
    whose = "its" if drive.outliers == 1 else "their"
    return [f"{drive.outliers} measured {numbers} out from {whose} neighbours: replaced"]
