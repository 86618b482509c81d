"""The identification: the fits, what they cannot tell apart, and the resulting vehicle."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from popsteer._core import Vehicle
from popsteer.extras import require
from popsteer.identification.checks import first_length, refuse_steer
from popsteer.identification.drive import MOST_OUTLIERS, PreparedLog, prepare, size_of
from popsteer.identification.fit import NAMES, NUISANCES, Fit, fit, refit
from popsteer.identification.identifiability import Unknown, rounded, steps, unidentified
from popsteer.identification.innovations import excitation, unexplained
from popsteer.identification.pedals import ASKED, Drive, fit_drive
from popsteer.identification.result import Identification, compared, described
from popsteer.identification.signals import centred, checked
from popsteer.identification.whiten import Error
from popsteer.logs import Log, LogError

if TYPE_CHECKING:
    from collections.abc import Callable

    from popsteer.identification.point import Point

_NO_LENGTH = 0.15
_DEAD_TIME = 0.15
"""What is believed of a car of which nothing is given [s]."""
_SHIFT = 0.1
"""By how much of it hard braking may change the turning length."""
_SLIP = 0.01
"""The slip of front tyres at 1 m/s² to the side [rad]: that of cars is 0.005 to 0.01."""
_TYRE_LAG = 0.1
"""By how much the yaw rate may lag behind the wheels [s]: that of cars is 0.02 to 0.1."""
# For a full-size car [m].
_SAME_POINT = 0.05
_SURE_POINT = 0.1
_SURE_SLIP = 0.2
_FROZEN = -0.5


def identify(
    log: Log,
    vehicle: Vehicle | None = None,
    *,
    course: bool = False,
    stops: Log | None = None,
    progress: Callable[[float], object] | None = None,
) -> Identification:
    """Find out from the log of a drive what the vehicle is.

    The chain of `Vehicle`, driven by the log's commands and speeds, is fitted to the measured
    headings; the no-slip point, which moves along the heading, is fitted to the positions:

        wheel' = clip((command(t - dead_time) + steer_offset - wheel) / steer_lag, ±max_steer_rate)
        yaw'   = v tan(wheel) / (turning_wheelbase + understeer v²)

    Outliers, gaps and rests are left out. What the log cannot show keeps the value of `vehicle`,
    and `unknown` says why, and what to drive to learn it.

    Parameters
    ----------
    log : Log
        The drive: 10 s at least, with bends. Two minutes of bends to both sides at two speeds or
        more, with steering that is not slow, show everything. Its angles are the commanded ones; if
        they are measured ones, dead time and lag are those from the wheels to the motion.
    vehicle : Vehicle, optional
        What a tape measure and the manual say: `wheelbase`, `rear_axle`, `antenna_left`, the
        limits. Without it
        the positions of the axles are estimated from the motion of the car.
    course : bool, default False
        Whether `yaw` is the course over ground of the pose's point, not the car's heading.
    stops : Log, optional
        A second log, of stops and starts, to learn the drive from; by default `log` itself, where
        it has commands of the drive.
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

    given = Vehicle() if vehicle is None else vehicle
    centre = centred(log, given.antenna_left)
    seen = checked(centre, given.rear_axle, course=course)
    drive = prepare(seen.log, size_of(given.wheelbase), seen.whole)
    length = first_length(drive, log.name)
    found, unknown, delay_error = _heading(drive, length, vehicle, log.name, progress)
    drive = found.candidates[0].task.drive  # with the likelier commands
    found = found.scaled(seen.scale_error)
    point = fit_point(drive, found.yaw, found.place, found.theta)
    made, errors = _vehicle(vehicle, found, unknown, point, drive)
    unknown.notes += described(vehicle, found, point, seen)
    values, speed = found.values, drive.usual_speed
    drive_found = fit_drive(seen.whole if stops is None else stops, drive.size)
    made, more = _with_drive(made, drive_found, unknown)
    errors |= more
    delay_error = delay_error.wider(seen.age_error)
    if "dead_time" in errors:
        errors["dead_time"] = errors["dead_time"].wider(seen.age_error)
    turning_error = found.split(turning_wheelbase=1.0, understeer=speed**2)
    left, octaves = unexplained(found, drive)
    models = errors | {"delay": delay_error, "turning_length": turning_error}
    return Identification(
        vehicle=made,
        errors={name: error.noise for name, error in errors.items()},
        model_errors={name: error.model for name, error in models.items()},
        unknown=unknown.why,
        ranges=unknown.ranges,
        delay=values["steer_lag"] + values["dead_time"],
        delay_error=delay_error.noise,
        turning_length=values["turning_wheelbase"] + values["understeer"] * speed**2,
        turning_length_error=turning_error.noise,
        speed=speed,
        lag_of=found.lag_of,
        notes=(
            *seen.notes,
            *_outliers(drive),
            *unknown.notes,
            *dict.fromkeys(unknown.why.values()),
        ),
        noise={
            "yaw": math.sqrt(found.theta) * found.noise,
            "yaw_drift": (1.0 - found.theta) * found.noise / math.sqrt(drive.usual_step),
            "position": point.noise,
        },
        excitation=excitation(drive, length),
        unexplained=left,
        octaves=octaves,
        records=compared(seen.log, drive, found.yaw, found.theta, point),
        log=seen.log,
        fit=found,
        drive=drive_found,
    )


def _heading(
    drive: PreparedLog,
    length: float,
    given: Vehicle | None,
    name: str,
    progress: Callable[[float], object] | None,
) -> tuple[Fit, Unknown, Error]:
    """Fit the heading; what the log does not show is fixed at what was given, all at once."""
    known = Vehicle() if given is None else given
    dead_time = _DEAD_TIME if given is None else given.dead_time
    square = drive.usual_speed**2
    hardest = max(float(np.quantile(np.abs(drive.acceleration[drive.speed != 0.0]), 0.9)), 0.1)
    prior = {
        "understeer": (known.understeer, 0.5 * length / square),
        "steer_offset": (known.steer_offset, 0.1),
        "steer_lag": (known.steer_lag, 0.2),
        "dead_time": (dead_time, 0.2),
        "load_shift": (0.0, _SHIFT * length / (hardest * square)),
        "front_slip": (0.0, _SLIP),
        "tyre_lag": (0.0, _TYRE_LAG),
    }
    rate, both = known.max_steer_rate, {"steer_lag": 1.0, "dead_time": 1.0}
    fixed = {} if rate is None else {"max_steer_rate": rate}
    found = fit(drive, {"turning_wheelbase": length, **fixed}, fixed, prior, progress)
    refuse_steer(found, given, name)  # before what is assumed bends the heading, too
    unknown = unidentified(found, drive, known)
    delay_error = found.split(**both)
    if unknown.fixed:
        free, found = found, refit(found, unknown.fixed)
        # The sum is as well known as where both were fitted; and the assumption may move it.
        off = {name: found.values[name] - free.values[name] for name in NAMES}
        if "steer_lag" in unknown.fixed:
            delay_error = delay_error.wider(sum(off[name] for name in both))
        if "understeer" in unknown.fixed and "understeer" not in unknown.why:
            # 0 is as sure as the slope that came out below it.
            wheelbase = "turning_wheelbase"
            unknown.moved = {wheelbase: math.hypot(off[wheelbase], free.errors[wheelbase])}
    rounded(unknown, found)
    error = found.errors.get("turning_wheelbase", 0.0)
    if not error < _NO_LENGTH * found.values["turning_wheelbase"]:
        why = "drive bends to both sides, and see that steer is the angle of the front wheels"
        why = f"steer is recorded in steps of {found.rounded:.3g} rad" if found.rounded else why
        raise LogError(
            f"{name}: the log does not show how the car turns: the wheelbase that it turns by comes"
            f" out as {found.values['turning_wheelbase']:.3g} ± {error:.2g} m; {why}"
        )
    return found, unknown, delay_error


def _vehicle(
    given: Vehicle | None, found: Fit, unknown: Unknown, point: Point, drive: PreparedLog
) -> tuple[Vehicle, dict[str, Error]]:
    """Make the vehicle of what was found, and of what was given for the rest."""
    values, why = found.values, unknown.why
    errors = {
        name: found.split(**{name: 1.0}).wider(unknown.moved.get(name, 0.0))
        for name in found.names
        if name not in NUISANCES and name not in why
    }
    base = Vehicle() if given is None else given
    names = ["steer_offset", "steer_lag", "dead_time"]
    if "steer_lag" in why and "steer_lag" not in unknown.fixed:
        names = names[:1]  # not even their sum is known: both stay as given
    changes: dict[str, float | None] = {name: values[name] for name in names}
    length = values["turning_wheelbase"]
    if given is None:
        changes["wheelbase"] = length
        told: tuple[dict[str, Any], ...] = (errors, why, unknown.ranges)
        for each in told:
            if "turning_wheelbase" in each:
                each["wheelbase"] = each.pop("turning_wheelbase")
    elif "turning_wheelbase" not in why:
        changes["turning_wheelbase"] = length
    for name in ("max_steer_rate", "steer_play"):
        if name in errors:
            changes[name] = values[name]
    changes["understeer"] = max(float(values["understeer"]), 0.0)
    moved, more = _place(given, point, drive, length, why)
    steepest = float(np.max(np.abs(drive.commands)))
    if steepest > base.max_steer + 1e-3:
        unknown.notes.append(
            f"the log commands up to {steepest:.3g} rad, more than max_steer, {base.max_steer:g}"
        )
    return base.replace(**changes, **moved), errors | more


def _with_drive(
    car: Vehicle, drive: Drive | None, unknown: Unknown
) -> tuple[Vehicle, dict[str, Error]]:
    """Add what is known of the drive to the vehicle; what is not is asked for."""
    if drive is None:
        unknown.notes.append(
            "the log has no commands of the drive (throttle and brake, acceleration_command or"
            f" speed_command): what a stop needs stays as given: {ASKED}, in this log or in --stops"
        )
        return car, {}
    own = [name for name in ("drive_delay", "drive_lag") if name in drive.errors]
    unknown.why.update(drive.unknown)
    changes = {name: drive.values[name] for name in own}
    return car.replace(**changes), {name: Error(drive.errors[name], 0.0) for name in own}


def _place(
    given: Vehicle | None, point: Point, drive: PreparedLog, length: float, unknown: dict[str, str]
) -> tuple[dict[str, float], dict[str, Error]]:
    """Say where the pose's point and the no-slip point lie, and how well that is known."""
    size = size_of(length)
    same, sure = _SAME_POINT * size, _SURE_POINT * size
    rear, slip = point.values["rear_axle"], point.values["slip"]
    error, slip_error = point.errors["rear_axle"], point.errors["slip"]
    square = drive.usual_speed**2
    sliding, at_speed = rear + slip * square, point.error_at(drive.usual_speed)
    stated, stated_sliding = point.split(0.0), point.split(drive.usual_speed)
    slips = abs(slip) > 3.0 * slip_error and abs(sliding - rear) > same
    if point.values["speed_excess"] < _FROZEN:
        share = 100.0 * (1.0 + point.values["speed_excess"])
        unknown["rear_axle"] = unknown["no_slip_point"] = (
            f"the positions move {share:.0f} % as far as the measured speed says: they do not show"
            " where the pose's point lies on the car; it stays as given: log positions that move"
        )
        return {}, {}
    if at_speed > sure:
        unknown["rear_axle"] = unknown["no_slip_point"] = (
            "the positions do not show where the pose's point lies on the car (rear_axle would be"
            f" {sliding:.2f} ± {at_speed:.2g} m): it stays as given: drive tight bends, or for"
            " longer"
        )
        return {}, {}
    if not slips and error > sure:
        rear, stated = sliding, stated_sliding  # one speed: nothing slips that one could see
    if given is not None:
        own = given.rear_axle if given.no_slip_point is None else given.no_slip_point
        if abs(sliding - own) > max(2.0 * at_speed, same):
            return {"no_slip_point": sliding}, {"no_slip_point": stated_sliding}
        name = "no_slip_point" if given.no_slip_point is not None else "rear_axle"
        # What is kept has the error of the estimate, and its distance from it besides.
        return {}, {name: stated_sliding.wider(sliding - own)}
    if slips and error <= sure:
        return (
            {"rear_axle": rear, "no_slip_point": sliding},
            {"rear_axle": stated, "no_slip_point": stated_sliding},
        )
    if not slip_error * square <= _SURE_SLIP * size:
        unknown["no_slip_point"] = (
            "how far the car slides sideways at speed cannot be seen; rear_axle is where it does"
            f" not slide at {drive.usual_speed:.1f} m/s: drive bends of {steps(drive, 0.6)} and of"
            f" {steps(drive, 1.4)}"
        )
    return {"rear_axle": rear}, {"rear_axle": stated}


def _outliers(drive: PreparedLog) -> list[str]:
    """Say what stands out from its neighbours, and whether it was replaced."""
    many = {k: n / len(drive.t) for k, n in drive.outliers.items()}
    many = {k: share for k, share in many.items() if share > MOST_OUTLIERS}
    notes = [
        f"{100.0 * share:.0f} % of the numbers of {name} stand out from their neighbours: that is"
        " no noise; see what the signal is (held, filtered, on another clock)"
        for name, share in many.items()
    ]
    total = sum(count for name, count in drive.outliers.items() if name not in many)
    if total:
        stand = "number stands" if total == 1 else "numbers stand"
        whose = "its" if total == 1 else "their"
        notes.append(f"{total} measured {stand} out from {whose} neighbours: replaced")
    return notes
