"""The notes of an identification, in sentences."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from popsteer._core import Vehicle
    from popsteer.identification.fit import Fit
    from popsteer.identification.point import Point

_NOTABLE_TURN = math.radians(0.2)
_NOTABLE_SPEED = 0.01
_HAND_WHEEL = 12.0


def described(
    given: Vehicle | None, found: Fit, point: Point, fixed: dict[str, float]
) -> list[str]:
    """Say what a reader should know beyond the figures, a sentence each."""
    notes = []
    length = found.values["turning_wheelbase"]
    if given is not None and not 0.6 < length / given.wheelbase < 1.7:
        notes.append(
            f"the car turns by {length:.2f} m, with {given.wheelbase:g} m between its axles: is"
            " steer the angle of the front wheels, in rad?"
        )
    elif given is None and length > _HAND_WHEEL:
        notes.append(
            f"a wheelbase of {length:.1f} m: is steer the angle of the front wheels, not of the"
            " hand wheel?"
        )
    if found.lag_of == "tyres" and "steer_lag" not in fixed:
        notes.append(
            "the lag grows with the speed, as tyres have it; it is that of the usual speed"
        )
    bias, excess = point.values["heading_bias"], point.values["speed_excess"]
    if abs(bias) > max(_NOTABLE_TURN, 4.0 * point.errors["heading_bias"]):
        side = "right" if bias > 0.0 else "left"
        notes.append(
            f"the measured heading points {math.degrees(abs(bias)):.2f} degrees to the {side} of"
            " where the car moves on a straight: turn the sensor's heading by that"
        )
    if abs(excess) > max(_NOTABLE_SPEED, 4.0 * point.errors["speed_excess"]):
        notes.append(
            f"the positions move {100.0 * excess:+.1f} % faster than the measured speed says"
        )
    if given is None:
        notes.append(
            "no vehicle was given: the wheelbase is the one that the car turns by, and limits are"
            " defaults; measure wheelbase, rear axle and max_steer, and tell them"
        )
    return notes
