"""The vehicle that a plant from elsewhere is, from what is published of it."""

from __future__ import annotations

from popsteer._core import Vehicle

STEER_LAG = 0.1
"""Lag of the wheels that a plant from elsewhere is taken to have [s]: nothing is fitted to it."""
GRIP_SHARE = 0.8
"""Share of the tyres' grip that a command may ask for: a bend must leave some for the way back."""
OVERTURNING_SHARE = 0.71
"""Share of g T / (2 h), at which a rigid vehicle lifts its inner wheels. Its body rolls, and
braking shifts the load: on circuits with 4 m/s² of braking wheels lift from 0.75 of it on."""


def published(
    *,
    wheelbase: float,
    max_steer: float,
    max_steer_rate: float,
    grip: float,
    overturning: float,
    dead_time: float,
    steer_offset: float,
) -> Vehicle:
    """Give a vehicle whose pose is that of the middle of its rear axle, from published numbers.

    It has the lag `STEER_LAG`, and for its lateral acceleration `GRIP_SHARE` of `grip`, the largest
    of the tyres [m/s²], but at most `OVERTURNING_SHARE` of `overturning`, the least at which the
    vehicle would lift its inner wheels if it were rigid [m/s²]. `dead_time` and `steer_offset` are
    what the closed loop adds [s, rad].
    Raises ConfigError where a number is out of its range.
    """
    return Vehicle(
        wheelbase=wheelbase,
        max_steer=max_steer,
        max_steer_rate=max_steer_rate,
        # On ice without any grip at all nothing may be asked for; the vehicle wants a number.
        max_lateral_acceleration=max(min(GRIP_SHARE * grip, OVERTURNING_SHARE * overturning), 1e-3),
        steer_lag=STEER_LAG,
        dead_time=dead_time,
        steer_offset=steer_offset,
    )
