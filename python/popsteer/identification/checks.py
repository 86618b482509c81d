"""What a log must show for a vehicle to be identified from it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from popsteer.identification.chain import Chain
from popsteer.identification.fit import LAGS, NAMES, SURE
from popsteer.logs import LogError

if TYPE_CHECKING:
    from popsteer._core import Vehicle
    from popsteer.identification.drive import PreparedLog
    from popsteer.identification.fit import Fit

SHORTEST = 10.0
"""The least time of driving [s]."""
_MOVING = 0.3
_STRAIGHT = math.radians(20.0)
_STIFF = math.radians(0.3)
_DELAYS = np.arange(0.0, 1.01, 0.05).tolist()
_AGREES = 0.3
OTHER_LENGTH = 1.6
"""What the length by which a car turns is off its wheelbase, as a factor."""
LONGEST = 15.0
"""A longer wheelbase than that of any vehicle [m]."""


def first_length(drive: PreparedLog, name: str) -> float:
    """Guess the length by which the car turns [m], by linear regression of v tan(steer) / yaw'.

    LogError where the log is too short or too straight, or the wheels do not turn or turn wrong.
    """
    yaw, speed = (
        np.concatenate([values[part] for part in drive.parts()] or [np.zeros(0)])
        for values in (drive.yaw, drive.sample_speed)
    )
    steer = drive.commands
    least = _MOVING * drive.size
    driven = float(np.sum(np.abs(speed) > least)) * drive.usual_step
    if driven < SHORTEST:
        raise LogError(
            f"{name}: {driven:.1f} s of driving are too short: at least {SHORTEST:g} s faster than"
            f" {least:.2g} m/s are needed, with bends to both sides at two speeds"
        )
    heading = [float(np.median(yaw[k : k + 9])) for k in range(0, len(yaw), 9)]
    turned = max(heading) - min(heading)
    if turned < _STRAIGHT:
        raise LogError(
            f"{name}: the drive is too straight: its heading changes by {math.degrees(turned):.1f}"
            f" degrees in all, at least {math.degrees(_STRAIGHT):.0f} are needed; drive bends to"
            " both sides"
        )
    if (width := float(np.ptp(steer))) < _STIFF:
        raise LogError(
            f"{name}: steer changes by {math.degrees(width):.2f} degrees only: nothing tells how"
            " the car answers to it; drive bends to both sides"
        )
    chain, plain = Chain(drive, LAGS[0]), {**dict.fromkeys(NAMES, 0.0), "turning_wheelbase": 1.0}
    share, slope = max(
        drive.explained(chain.yaw(**{**plain, "dead_time": delay})) for delay in _DELAYS
    )
    if slope < 0.0 and share > _AGREES:
        raise LogError(
            f"{name}: the car turns right where steer says left: the sign of steer or of yaw is"
            " turned (--unit steer=-1 turns it)"
        )
    return float(np.clip(1.0 / max(slope, 1e-3), 0.02, 90.0))


def refuse_steer(found: Fit, given: Vehicle | None, name: str) -> None:
    """Refuse by LogError a command that is not the angle of the front wheels.

    Its tangent bends: where the wheels turn far, the log shows how large an angle a command is.
    """
    length = found.values["turning_wheelbase"]
    scales = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 1.25, 1.6]
    likelihood = found.profile("steer_scale", scales, turning_wheelbase=length)
    best, price = int(np.argmax(likelihood)), 0.5 * math.log(len(found.root))  # Schwarz's
    # Tyres that slide bend the other way, which looks like a tangent that does not bend at all.
    scale, clear = scales[best], likelihood[best] - max(0.0, *likelihood[:2]) > SURE + price
    if given is not None:
        off = length / given.wheelbase  # a tape measure tells better than the tangent
        if not 1.0 / OTHER_LENGTH < off < OTHER_LENGTH:
            scale, clear = 1.0 / off, True
        elif abs(math.log(scale * off)) > abs(math.log(off)):
            clear = False
    elif not clear and length > LONGEST:
        scale, clear = 2.7 / length, True
    if clear:
        raise LogError(
            f"{name}: the car turns as if its wheels had {scale:.3g} times the angle of steer,"
            f" which gives it a wheelbase of {length:.3g} m: is steer normalised (--unit"
            f" steer=MAX_STEER, here some {scale:.2g}) or the hand wheel's (--unit steer=1/RATIO)?"
            + ("" if given else " If it is the wheels' angle, tell the wheelbase that you measured")
        )
