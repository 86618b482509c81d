"""What columns are called, and what they are measured in: one table of names, one of units."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, NamedTuple

from popsteer.errors import PopsteerError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_ANGLE = {"rad": 1.0, "radian": 1.0, "radians": 1.0}
_ANGLE |= dict.fromkeys(("deg", "°", "degree", "degrees"), math.pi / 180.0) | {"mrad": 1e-3}
_DEGREES = {"e7": 1e-7, "deg": 1.0, "°": 1.0, "rad": 180.0 / math.pi, "min": 1.0 / 60.0}
_LENGTH = {"m": 1.0, "metre": 1.0, "meter": 1.0, "meters": 1.0, "metres": 1.0}
_LENGTH |= {"cm": 1e-2, "mm": 1e-3, "km": 1e3} | dict.fromkeys(("ft", "feet", "foot"), 0.3048)
_LENGTH |= dict.fromkeys(("in", "inch", "inches"), 0.0254)
_SPEED = dict.fromkeys(("m/s", "mps", "ms-1", "ms^-1", "m/sec", "meters/second"), 1.0)
_SPEED |= dict.fromkeys(("km/h", "kmh", "kph", "kmph", "km/hr", "kilometers/hour"), 1.0 / 3.6)
_SPEED |= {"cm/s": 1e-2, "cmps": 1e-2, "mm/s": 1e-3, "mmps": 1e-3, "ft/s": 0.3048, "fps": 0.3048}
_SPEED |= dict.fromkeys(("in/s", "ips"), 0.0254)
_SPEED |= dict.fromkeys(("mph", "mi/h", "miles/hour"), 0.44704)
_SPEED |= dict.fromkeys(("kn", "kt", "knots", "kts"), 1852.0 / 3600.0)
_TIME = {"s": 1.0, "sec": 1.0, "secs": 1.0, "seconds": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6}
_TIME |= {"ns": 1e-9, "nsec": 1e-9, "nanosec": 1e-9, "min": 60.0, "unixtime": 1.0}
_TIME |= {"day": 86400.0, "days": 86400.0}
_TIME |= {"second": 1.0, "millisecond": 1e-3, "milliseconds": 1e-3, "microseconds": 1e-6}
_TIME |= {"nanoseconds": 1e-9}
_TIME |= dict.fromkeys(("h", "hr", "hours"), 3600.0)
_CURVATURE = dict.fromkeys(("1/m", "rad/m", "radpm", "1pm", "m-1"), 1.0)
_NONE = {"": 1.0, "-": 1.0}
_SHARE = {"1": 1.0} | dict.fromkeys(("%", "percent", "pct"), 1e-2)
_ACCELERATION = dict.fromkeys(("m/s²", "m/s2", "m/s^2", "mps2"), 1.0) | {"g": 9.80665}
_SHARES = dict.fromkeys(("%", "percent", "pct", "percentage"), "ANGLE/100")
_SHARES |= dict.fromkeys(("-", "norm", "normalized", "normalised", "-1..1"), "ANGLE")
_GRADE = {"-": 1.0, "m/m": 1.0, "%": 1e-2, "percent": 1e-2}

UNITS: dict[str, dict[str, float]] = {
    "t": _TIME,
    "x": _LENGTH,
    "y": _LENGTH,
    # From north, clockwise, with x to the east; `converted` turns them.
    "yaw": _ANGLE | {"rad-north": -1.0, "deg-north": -math.pi / 180.0},
    **dict.fromkeys(("speed", "speed_y", "v_east", "v_north"), _SPEED),
    # Shares of the largest angle, which no file tells.
    "steer": _ANGLE | dict.fromkeys(_SHARES, math.nan),
    "curvature": _CURVATURE,
    "grade": _GRADE,
    **dict.fromkeys(("lat", "lon"), _DEGREES),
    **dict.fromkeys(("t_ns", "t_us", "t_ms"), _TIME),
    "direction": _NONE,
    "throttle": _SHARE,
    "brake": _SHARE,
    "acceleration_command": _ACCELERATION,
    "speed_command": _SPEED,
    "z": _LENGTH,
    **{f"q{axis}": _NONE for axis in "xyzw"},
    **dict.fromkeys(("x_normal", "y_normal", "alpha"), _LENGTH),
}
"""What each quantity may be measured in, and what one of it is in the unit of popsteer."""

EPOCH = ((10**17, "ns"), (10**14, "us"), (10**11, "ms"))
"""From where on a stamp counts ns, us or ms since 1970: 2001, and later than any other could."""

_AXIS = (
    "{0} t{0} p_{0} p_rs_r_{0} pos{0} {0}_coordinate coordinate_{0} pos_{0} position_{0} {0}_pos"
    " {0}_position p{0} pose_{0} coord_{0} {0}_coord point_{0} location_{0} translation_{0}"
    " utm_{0} {0}_utm positions_{0} {0}pos {0}_raceline loc_{0} {0}_loc {0}coord utm{0} c{0}"
    " {0}_axis"
)
_PART = "v{1} v_{1} v_{0} vel_{1} vel_{0} velocity_{0} velocity_{1} speed_{0} {0}_velocity {0}_vel"
_NAMES = {
    "t": "t time stamp timestamp stamp_sec stamp_secs sec secs tv_sec s_stamp elapsed time_stamp"
    " header_stamp elapsed_time time_sec seconds rosbagtimestamp session_time sim_time unix_time"
    " utc utc_time time_utc datetime date_time receive_time log_time",
    "t_ms": "millis milliseconds msec stamp_millis",
    "t_us": "usec usecs tv_usec microsec microseconds",
    "t_ns": "ns nsec nsecs tv_nsec nanosec nanoseconds stamp_nanosec stamp_nsec stamp_nsecs"
    " header_stamp_nsecs",
    "x": _AXIS.format("x") + " easting east utm_easting utm_east utm_e",
    "y": _AXIS.format("y") + " northing north utm_northing utm_north utm_n",
    "yaw": "yaw hdg orientation psi theta heading orientation_yaw pose_yaw yaw_angle"
    " heading_angle angle_heading compass_heading euler_yaw orientation_z_yaw rotation_yaw course"
    " bearing azimuth pose_theta psi_racetraj cog phi cyaw",
    "speed": "speed v vx velocity speed_ref v_ref vel linear_x linear_velocity velocity_x vel_x"
    " linear_speed ground_speed vehicle_speed longitudinal_velocity speed_x v_x vref"
    " linear_velocity_x linear_vel_x vx_racetraj target_speed target_velocity ref_speed speed2d"
    " target_v v_target desired_speed reference_speed lin_vel lin_vel_x car_speed forward_velocity"
    " forward_speed vel_forward v_rs_r_x v_vel spd sog v_long vlong long_vel vel_long lon_velocity"
    " x_velocity v_des vdes",
    "speed_y": "vy v_rs_r_y linear_y velocity_y vel_y v_y speed_y linear_velocity_y y_velocity",
    "v_east": _PART.format("east", "e"),
    "v_north": _PART.format("north", "n"),
    "steer": "steer steer_cmd steer_command steering_command steering steering_angle delta"
    " steering_cmd steer_angle steered_angle wheel_angle steering_tire_angle"
    " drive_steering_angle front_wheel_angle delta_f tire_angle",
    "curvature": "curvature kappa curv kappa_racetraj ck",
    "grade": "grade slope gradient incline",
    "direction": "direction gear reverse is_reverse drive_direction motion_direction dir",
    "throttle": "throttle",
    "brake": "brake",
    "acceleration_command": "acceleration_command",
    "speed_command": "speed_command",
    "z": "z",
    "lat": "lat latitude pos_lat",
    "lon": "lon lng long longitude pos_lon",
    **{
        f"q{axis}": f"q{axis} q_{axis} q_rs_{axis} orientation_{axis} quat_{axis} quaternion_{axis}"
        f" rotation_{axis} rot_{axis} {axis}_quat"
        for axis in "xyzw"
    },
    "x_normal": "x_normvec",
    "y_normal": "y_normvec",
    "alpha": "alpha",
}
_PLAIN = {name: key for key, names in _NAMES.items() for name in names.split()}
_PLACES = {name: place for place, name in enumerate(_PLAIN)}
# What says where a value comes from, not what it is: /odom/pose/pose/position/x is an x.
_SAID_OF = (
    "field pose twist odom odometry ego car vehicle state base link map local global world ref data"
    " msg current actual measured robot path wp waypoint waypoints header drive sample raceline"
    " center centre centerline centreline traj trajectory lane route reference desired target gt"
    " true est estimated filtered location gps"
)
_SOURCES = frozenset(_SAID_OF.split())
# What says that a value is not it, but of something else: cmd_vel/linear/x, accel/linear/x.
_NOT_IT = (
    "cmd command commanded accel acceleration gyro residual error err std sigma cov covariance max"
    " min prev previous next predicted lead leader opponent opp obstacle wheel wind"
)
_OTHERS = frozenset(_NOT_IT.split())
_COMMANDED = ("steer", "throttle", "brake")
_UNIT = re.compile(r"\s*[\[(]\s*([^\])]*?)\s*[\])]\s*$")

_HAND_WHEEL = re.compile(r"(steering|hand)_?wheel")  # its angle is not the front wheels'
_CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")  # PositionX, VTarget


class Meaning(NamedTuple):
    """What a column is, and in what unit its name has it; None where the name has none."""

    quantity: str | None
    unit: str | None
    rank: tuple[bool, int] = (True, 0)
    """How plainly: without a source before with one, and `speed` before `target_speed`."""


def meaning(name: str) -> Meaning:
    """Say what a column of a name is: by its last words, without unit and source.

    Examples
    --------
    >>> names = "vx_mps", "/odom/pose/pose/position/x", "Ground Speed [km/h]"
    >>> tuple(meaning(name)[:2] for name in names)
    (('speed', 'mps'), ('x', None), ('speed', 'km/h'))
    """
    bracket = _UNIT.search(name)
    plain = name[: bracket.start()] if bracket else name
    unit = bracket[1].replace(" ", "").replace("²", "2") if bracket else None
    for spelled in dict.fromkeys((plain, _CAMEL.sub("_", plain))):
        words = [word for word in re.split(r"[^0-9a-zµ°%]+", spelled.strip().lower()) if word]
        if (found := _known(words)) is not None:
            is_angle = found.quantity == "direction" and unit in _ANGLE
            return Meaning("yaw" if is_angle else found.quantity, unit or None, found.rank)
        for count in (1, 2) if unit is None else ():  # vx_mps, speed_km_h
            shorter, last = _known(words[:-count]), words[-count:]
            for spelled_unit in ("/".join(last), "".join(last)):
                # But x_in is what comes in.
                known = {} if shorter is None else UNITS[shorter.quantity or ""]
                if shorter is not None and spelled_unit in known.keys() - {"in"}:
                    return shorter._replace(unit=spelled_unit)
    alone = "".join(words)  # MPH
    if alone in _SPEED and len(alone) > 2:
        return Meaning("speed", alone, (True, len(_PLAIN)))
    return Meaning(None, unit or None)


def _known(words: list[str]) -> Meaning | None:
    if _HAND_WHEEL.search("_".join(words)):
        return None
    plain = [word for word in words if word not in _SOURCES]
    last = (plain[k:] for k in range(1, len(plain) - 1))
    for sourced, each in enumerate((words, plain, *last, words[-2:] if len(plain) > 2 else plain)):
        if (name := "_".join(each)) in _PLAIN:
            quantity = _PLAIN[name]
            is_other = sourced > 1 and not _OTHERS.isdisjoint(words[: -len(each)])
            if is_other and quantity not in _COMMANDED:
                return None
            return Meaning(quantity, None, (sourced > 0, _PLACES[name]))
    return None


def factor(quantity: str, unit: str) -> float:
    """Give what a number in a unit is to be multiplied by.

    `unit` is one of `UNITS`, a number, or either of them over a number: ``deg/15.5`` for the hand
    wheel's angle with a ratio of 15.5. A minus before it turns the sign. Raises PopsteerError where
    it is not known.

    Examples
    --------
    >>> factor("speed", "km/h") == 1 / 3.6, factor("steer", "-1"), factor("steer", "rad/20")
    (True, -1.0, 0.05)
    """
    known = UNITS[quantity]
    found = known.get(unit, known.get(unit.lower(), math.nan))
    if not math.isnan(found):
        return found
    sign, text = (-1.0, unit[1:]) if unit.startswith("-") else (1.0, unit)
    name, _, ratio = text.partition("/") if text not in known else (text, "", "")
    try:
        size = known[name] if name in known else float(name)
        found = sign * size / (float(ratio) if ratio else 1.0)
    except (ValueError, ZeroDivisionError):
        found = 0.0
    if not math.isfinite(found) or found == 0.0:
        listed = ", ".join(spelled(quantity))
        raise PopsteerError(
            f"unit of {quantity} must be {listed}, a number, or one of them over a number, got"
            f" {unit[:40]!r}"
        )
    return found


def share(quantity: str | None, unit: str | None) -> str | None:
    """Word the unit that makes an angle of a share of the largest; None of all other units.

    Examples
    --------
    >>> share("steer", "%"), share("steer", "deg")
    ('ANGLE/100', None)
    """
    return _SHARES.get((unit or "").lower()) if quantity == "steer" else None


def converted(quantity: str, unit: str | None, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Bring values into popsteer's unit; in no other they stay, to the bit.

    Examples
    --------
    >>> import numpy as np
    >>> np.degrees(converted("yaw", "deg-north", np.array([90.0, 30.0]))).round(9).tolist()
    [0.0, 60.0]
    """
    found = (1.0 if unit is None else factor(quantity, unit)) * values
    return found + 0.5 * math.pi if unit is not None and unit.endswith("-north") else found


def spelled(quantity: str) -> list[str]:
    """Give a spelling of each unit of a quantity.

    Examples
    --------
    >>> spelled("yaw")
    ['rad', 'deg', 'mrad', 'rad-north', 'deg-north']
    """
    known = UNITS[quantity]
    sizes = {size: unit for unit, size in reversed(known.items()) if not math.isnan(size)}
    return [unit for unit in known if unit in sizes.values()]


def seconds(time: NDArray[np.float64]) -> NDArray[np.float64]:
    """Give a clock in seconds: since 1970 its size says whether it is in ms, us or ns.

    Examples
    --------
    >>> import numpy as np
    >>> seconds(np.array([1.7e12, 1.7e12 + 250.0])).tolist(), seconds(np.array([3.0])).tolist()
    ([0.0, 0.25], [3.0])
    """
    unit = next((unit for least, unit in EPOCH if time[0] > least), None)
    return time if unit is None else converted("t", unit, time - time[0])
