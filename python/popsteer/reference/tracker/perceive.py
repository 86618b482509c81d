"""Measured and predicted vehicle of a step, from the pose, its age and the applied angle."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from popsteer.reference.bounds import MIN_DT
from popsteer.reference.laws.law import Belief
from popsteer.reference.math import saturate
from popsteer.reference.path.preview import Preview
from popsteer.reference.tracker.state import (
    TrackerState,
    estimator_of,
    in_flight_of,
    past_of,
    with_estimator,
    with_in_flight,
    with_past,
)
from popsteer.reference.vehicle.estimate import Corrections
from popsteer.reference.vehicle.past import Past

if TYPE_CHECKING:
    from popsteer.reference.laws.law import LateralLaw
    from popsteer.reference.path.follow import Follow, Located
    from popsteer.reference.tracker.reported import Reported
    from popsteer.reference.vehicle import Vehicle
    from popsteer.reference.vehicle.delay import InFlight
    from popsteer.reference.vehicle.estimate import AdaptParams
    from popsteer.reference.vehicle.estimator import Estimator
    from popsteer.reference.vehicle.state import VehicleState

__all__ = ["Perception", "observe_slip", "perceive"]

StateT = TypeVar("StateT", bound=TrackerState)


class Perception(NamedTuple):
    """The vehicle at a step: as it is measured, and as it is predicted for the controller."""

    here: VehicleState
    """The vehicle now; an old pose is rolled forward to now."""
    predicted: VehicleState
    """The vehicle when the next command reaches the wheels."""
    belief: Belief
    observed: float
    """Time between the last pose and this one [s]; 0 or less for a pose given before."""
    travel: float
    """Distance travelled since the pose was measured [m]."""


def perceive(
    law: LateralLaw[Any, StateT],
    adapt: AdaptParams | None,
    state: StateT,
    vehicle: VehicleState,
    dt: float,
    reported: Reported,
    *,
    models: bool,
) -> tuple[StateT, Perception]:
    """Return measured and predicted vehicle, after all that is `reported`, which is checked."""
    car, (applied, age) = law.vehicle, reported
    if applied is not None:
        # The angle that was applied takes the place of the last command.
        state, _ = law.set_steer(replace(state, steer=applied), applied)
    if age > 0.0 or past_of(state) is not None:
        return _perceive_aged(car, adapt, state, vehicle, dt, age, models=models)
    state, predicted, belief = _predict_now(car, adapt, state, vehicle, dt)
    return state, Perception(vehicle, predicted, belief, observed=dt, travel=0.0)


def _perceive_aged(
    car: Vehicle,
    adapt: AdaptParams | None,
    state: StateT,
    vehicle: VehicleState,
    dt: float,
    age: float,
    *,
    models: bool,
) -> tuple[StateT, Perception]:
    """Give measured and predicted vehicle for a pose that was measured `age` [s] ago.

    Observes the motion between the poses, puts the last command in flight, and predicts.
    """
    past, in_flight = past_of(state), in_flight_of(state) if models else None
    if past is None:
        # Nothing is remembered before the first pose with an age: the wheels count as still.
        still = car.at_wheels(state.steer + car.steer_offset)
        past = Past.settled(still if in_flight is None else in_flight.wheel)
    past = _remember(car, past, in_flight, state.steer, dt)
    observed = past.since - age
    old = vehicle.ahead(car.no_slip)
    estimator = estimator_of(state)
    before = estimator.estimate.longer_dead_time
    # A pose that was given before carries no new information.
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
    predicted, wheel = here, state.steer
    if in_flight is not None:
        longer = estimate.longer_dead_time - before
        in_flight = in_flight.elapse(car, state.steer, dt, longer)
        wheel = in_flight.wheel
        if car.dead_time > 0.0:
            predicted, wheel = in_flight.predict(car, now, estimate)
            predicted = predicted.bounded().ahead(-car.no_slip).bounded()
        state = with_in_flight(state, in_flight)
    state = with_past(with_estimator(state, estimator), past)
    return state, Perception(
        here, predicted, Belief(wheel, estimate), observed, vehicle.speed * age
    )


def _predict_now(
    car: Vehicle, adapt: AdaptParams | None, state: StateT, vehicle: VehicleState, dt: float
) -> tuple[StateT, VehicleState, Belief]:
    """Return the state, and the vehicle as the controller is to see it.

    Before, its motion since the last step is observed, and the last command takes flight.
    """
    in_flight = in_flight_of(state)
    if in_flight is None:
        return state, vehicle, Belief(state.steer, Corrections())
    estimator = estimator_of(state)
    now = vehicle.ahead(car.no_slip)
    before = estimator.estimate.longer_dead_time
    if adapt is not None:
        reached = in_flight.reaching(car, state.steer, dt)
        estimator = estimator.observe_turn(adapt, car, now, reached, dt)
    estimate = estimator.estimate
    in_flight = in_flight.elapse(car, state.steer, dt, estimate.longer_dead_time - before)
    state = with_in_flight(with_estimator(state, estimator), in_flight)
    if car.dead_time > 0.0:
        predicted, wheel = in_flight.predict(car, now, estimate)
        # The input was valid, so its prediction is put within the bounds and not refused.
        predicted = predicted.bounded().ahead(-car.no_slip).bounded()
        return state, predicted, Belief(wheel, estimate)
    return state, vehicle, Belief(in_flight.wheel, estimate)


def observe_slip(
    law: LateralLaw[Any, Any],
    follow: Follow,
    adapt: AdaptParams,
    estimator: Estimator,
    here: Located,
    vehicle: VehicleState,
    since: tuple[float, float],
) -> Estimator:
    """Update the estimated slip.

    `vehicle` is the measured pose; `since` are the time [s] since the last pose and the distance
    [m] travelled from that pose to `here`, the vehicle now. A change of the driving direction
    interrupts the estimation.
    """
    (dt, travelled), car, path = since, law.vehicle, law.path
    now = vehicle.ahead(car.no_slip)
    if here.direction_changed or here.vehicle.speed <= 0.0:
        return replace(estimator, last_measured=now)

    def curvature(travel: float) -> float:
        travel = abs(travel)
        # The tracked point lies ahead of the no-slip point by about `reference_offset`.
        start = here.closest.arc_length(path) - follow.reference_offset - travel
        start -= abs(travelled)
        smoothing = 2.0 / 3.0 * car.wheelbase
        preview = Preview(path, smoothing, here.closest.segment, start, travel)
        _, (turn,) = preview.turns(start, travel, 1)
        return here.mirror(turn / travel)

    estimator = estimator.observe_slip(adapt, car, now, curvature, dt)
    return replace(estimator, last_measured=now)


def _remember(car: Vehicle, past: Past, in_flight: InFlight | None, last: float, dt: float) -> Past:
    """Record `dt` [s] of the commanded angle `last` [rad]; in flight first if commands are."""
    if in_flight is None:
        return past.elapse(car, [(last, dt)], past.wheel, dt)
    return past.elapse(car, (*in_flight.commands, (last, dt)), in_flight.wheel, dt)
