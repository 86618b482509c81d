"""What a vehicle may report beside its pose and speed.

The angle that was really applied, and how old the pose is.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple, TypeVar

from popsteer.reference.error import input_in_range
from popsteer.reference.lateral import Belief
from popsteer.reference.lateral.tracker_state import (
    TrackerState,
    estimator_of,
    in_flight_of,
    past_of,
    with_estimator,
    with_in_flight,
    with_past,
)
from popsteer.reference.limits import MIN_DT
from popsteer.reference.math import PI, saturate
from popsteer.reference.vehicle.estimator import Corrections
from popsteer.reference.vehicle.past import MAX_POSE_AGE, Past

if TYPE_CHECKING:
    from popsteer.reference.vehicle import Vehicle
    from popsteer.reference.vehicle.delay import InFlight
    from popsteer.reference.vehicle.estimator import AdaptParams
    from popsteer.reference.vehicle.state import VehicleState

__all__ = ["Reported", "Sight", "sight_aged"]

StateT = TypeVar("StateT", bound=TrackerState)


class Reported(NamedTuple):
    """What a step may be told beside pose and speed.

    Examples
    --------
    >>> from popsteer.reference.vehicle import Vehicle
    >>> Reported(1.3).checked(Vehicle(max_steer=0.6))
    Reported(applied_steer=0.6, pose_age=0.0)
    """

    applied_steer: float | None = None
    """The angle that was applied since the last step in place of the commanded one [rad]."""
    pose_age: float = 0.0
    """How long before the step pose and speed were measured [s]."""

    def checked(self, vehicle: Vehicle) -> Reported:
        """Return the same, within what `vehicle` can have done.

        An angle up to a quarter turn counts as the nearest one within `max_steer`.

        Raises
        ------
        InputError
            Naming the number that is not finite or beyond its bound.
        """
        applied = self.applied_steer
        if applied is not None:
            applied = _checked_steer(vehicle, applied)
        return Reported(applied, input_in_range("pose_age", self.pose_age, 0.0, MAX_POSE_AGE))


def _checked_steer(vehicle: Vehicle, steer: float) -> float:
    limit = 0.5 * PI
    return vehicle.at_wheels(input_in_range("applied_steer", steer, -limit, limit))


class Sight(NamedTuple):
    """The vehicle at a step, as it is and as the law is to see it."""

    here: VehicleState
    """The vehicle now."""
    seen: VehicleState
    """The vehicle when the next command reaches the wheels."""
    belief: Belief
    observed: float
    """How long after the last pose this one was measured [s]."""
    travel: float
    """How far the vehicle has come since [m]."""


def sight_aged(
    car: Vehicle,
    adapt: AdaptParams | None,
    state: StateT,
    vehicle: VehicleState,
    dt: float,
    age: float,
    *,
    models: bool,
) -> tuple[StateT, Sight]:
    """Do as a step without ages does, for a pose that was measured `age` [s] before.

    Observes the motion between the poses, lets the last command take flight, and predicts.
    """
    past, in_flight = past_of(state), in_flight_of(state) if models else None
    if past is None:
        # Nothing was remembered: the wheels count as still.
        still = car.at_wheels(state.steer + car.steer_offset)
        past = Past.settled(still if in_flight is None else in_flight.wheel)
    past = _remember(car, past, in_flight, state.steer, dt)
    observed = past.since - age
    old = vehicle.ahead(car.no_slip)
    estimator = estimator_of(state)
    before = estimator.estimate.longer_dead_time
    # A pose that was given before shows nothing new.
    if observed >= MIN_DT:
        if adapt is not None and in_flight is not None:
            estimator = estimator.observe_turn(adapt, car, old, past.reached(age), observed)
            # No command reaches the wheels before it is given, so in a period the flight becomes
            # longer by that at most.
            known = estimator.estimate
            longer = saturate(known.longer_dead_time, before - dt, before + dt)
            estimator = replace(estimator, estimate=replace(known, longer_dead_time=longer))
        past = replace(past, since=age)
    estimate = Corrections() if in_flight is None else estimator.estimate
    here, now = vehicle, old
    if age > 0.0:
        now = past.advance(car, old, age, estimate).bounded()
        here = now.ahead(-car.no_slip).bounded()
    seen, wheel = here, state.steer
    if in_flight is not None:
        longer = estimate.longer_dead_time - before
        in_flight = in_flight.elapse(car, state.steer, dt, longer)
        wheel = in_flight.wheel
        if car.dead_time > 0.0:
            predicted, wheel = in_flight.predict(car, now, estimate)
            seen = predicted.bounded().ahead(-car.no_slip).bounded()
        state = with_in_flight(state, in_flight)
    state = with_past(with_estimator(state, estimator), past)
    return state, Sight(here, seen, Belief(wheel, estimate), observed, vehicle.speed * age)


def _remember(car: Vehicle, past: Past, in_flight: InFlight | None, last: float, dt: float) -> Past:
    """Let `dt` [s] pass under the angle `last` [rad], which takes flight if there is one."""
    if in_flight is None:
        return past.elapse(car, [(last, dt)], past.wheel, dt)
    return past.elapse(car, (*in_flight.commands, (last, dt)), in_flight.wheel, dt)
