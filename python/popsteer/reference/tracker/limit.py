"""From the wanted angle to the command: hand-over, then the limits of the vehicle."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

from popsteer.reference.math import atan, divide, saturate
from popsteer.reference.tracker.state import HANDOVER_TIME, TrackerState, hands_over
from popsteer.reference.vehicle.estimator import MAX_STEER_OFFSET

if TYPE_CHECKING:
    from popsteer.reference.laws.law import LateralLaw
    from popsteer.reference.vehicle import Vehicle
    from popsteer.reference.vehicle.estimate import Corrections

__all__ = ["limit", "widest_offset"]

StateT = TypeVar("StateT", bound=TrackerState)


def limit(
    law: LateralLaw[Any, StateT],
    state: StateT,
    wanted: float,
    speed: float,
    dt: float,
    estimate: Corrections,
) -> tuple[StateT, bool]:
    """Command the angle `wanted` of the wheels [rad] as far as the vehicle allows.

    Returns the state with the command, and whether that had to be limited.
    """
    car, before = law.vehicle, state.steer
    offset = car.steer_offset + estimate.steer_offset
    state, wanted = _fade(car, state, wanted - offset, dt)
    wheel = car.at_wheels(wanted + offset)
    wheel = _limit_lateral_acceleration(car, wheel, speed, estimate.gain)
    steer = saturate(wheel - offset, -car.max_steer, car.max_steer)
    if car.max_steer_rate is not None:
        reach = car.max_steer_rate * dt
        steer = saturate(steer, before - reach, before + reach)
    state, _ = law.set_steer(state, car.at_wheels(steer + offset))
    # The offset is put off and on again, which rounds.
    return replace(state, steer=steer), abs(steer - wanted) > 1e-12


def _fade(car: Vehicle, state: StateT, wanted: float, dt: float) -> tuple[StateT, float]:
    """Return the command of a hand-over: the difference to the last one fades."""
    if not hands_over(state):
        return state, wanted
    offset, before = state.handover_offset, state.handover_remaining
    remaining = before
    if offset is None and before >= HANDOVER_TIME:
        offset = state.steer - wanted
    elif offset is None:
        # The path changed again during a hand-over: the difference fades in the remaining time.
        remaining -= dt
        share = before / HANDOVER_TIME
        offset = 0.0
        if remaining > 0.0:
            widest = widest_offset(car)
            offset = saturate((state.steer - wanted) / share, -widest, widest)
    else:
        remaining -= dt
    share = saturate(remaining / HANDOVER_TIME, 0.0, 1.0)
    if remaining <= 0.0:
        state = replace(state, handover_offset=None, handover_remaining=0.0)
    else:
        state = replace(state, handover_offset=offset, handover_remaining=remaining)
    return state, wanted + share * offset


def widest_offset(car: Vehicle) -> float:
    """Return the widest offset of a hand-over: from one end of the wheels to the other [rad]."""
    return 2.0 * car.max_steer + (abs(car.steer_offset) + MAX_STEER_OFFSET)


def _limit_lateral_acceleration(car: Vehicle, wheel: float, speed: float, gain: float) -> float:
    """Bring the angle `wheel` [rad] within `max_lateral_acceleration` at `speed` [m/s].

    For a vehicle that turns `gain` times as much as its parameters say.
    """
    most = car.max_lateral_acceleration
    if most is None:
        return wheel
    square, length = speed * speed * gain, car.turning_length(speed)
    widest = atan(divide(most * length, square))
    return saturate(wheel, -widest, widest)
