"""The trajectory that a controller intends: it drives its own vehicle ahead, step by step."""

from __future__ import annotations

from dataclasses import replace
from math import copysign, floor
from typing import TYPE_CHECKING, Generic, NamedTuple, TypeVar

import numpy as np

from popsteer import errors
from popsteer.prediction import Prediction
from popsteer.reference.bounds import MAX_DT
from popsteer.reference.error import input_in_range
from popsteer.reference.tracker.state import (
    TrackerState,
    estimator_of,
    in_flight_of,
    with_past,
)
from popsteer.reference.vehicle.bicycle import Rollout
from popsteer.reference.vehicle.delay import InFlight
from popsteer.reference.vehicle.estimate import Corrections
from popsteer.reference.vehicle.state import VehicleState, checked_dt
from popsteer.reference.vehicle.timed import clipped

if TYPE_CHECKING:
    from collections.abc import Callable

    from popsteer.reference.tracker.command import Command
    from popsteer.reference.vehicle import Vehicle

__all__ = ["Predicted", "Predicting", "instants", "predict", "standing"]

StateT = TypeVar("StateT", bound=TrackerState)

MOST = 100_000
"""More instants than this are a mistake."""


class Predicted(NamedTuple):
    """One instant of a predicted trajectory."""

    time: float
    """Time since the last step [s]."""
    vehicle: VehicleState
    """Pose of the vehicle's point, and speed."""
    steer: float
    """Angle commanded then [rad]."""


def instants(time: float, dt: float) -> int:
    """Return how many instants `time` [s] has, one each `dt` [s].

    Raises
    ------
    InputError
        Where a number is out of its range, or there are too many.

    Examples
    --------
    >>> instants(1.0, 0.05)
    21
    """
    time = input_in_range("time", time, 0.0, MAX_DT)
    periods = floor(time / checked_dt(dt) + 0.5)
    if periods > MOST:
        raise errors.InputError("time / dt", periods, errors.count_in_range(0, MOST))
    return periods + 1


def standing(vehicle: Vehicle, steer: float, wheel: float | None) -> InFlight:
    """Return the command `steer` [rad] in flight, and the wheels at the angle `wheel` [rad]."""
    settled = InFlight.settled(vehicle, steer)
    return settled if wheel is None else replace(settled, wheel=wheel)


def predict(
    car: Vehicle,
    state: TrackerState,
    step: Callable[[VehicleState], float],
    dt: float,
    count: int,
    *,
    models: bool,
) -> Prediction:
    """Let `step` drive the estimated vehicle, from the last step of `state` on.

    At its present acceleration, and to the next stop at most.
    """
    answer, steer = state.answer, state.steer
    if answer is None:
        wanted = "known: predict goes on from the last step, take one first"
        raise errors.InputError("state.answer", None, wanted)
    plant, estimate = in_flight_of(state), estimator_of(state).estimate
    if plant is None or not models:
        plant, estimate = standing(car, steer, state.past_wheel), Corrections()
    vehicle, remaining = VehicleState(*answer.vehicle), answer.ahead.distance_to_stop
    trajectory = []
    for k in range(count):
        trajectory.append(Predicted(k * dt, vehicle, steer))
        if k + 1 == count:
            break
        if (vehicle.speed < 0.0) == answer.reverse:
            most = remaining / dt if remaining > 0.0 else 0.0
            if abs(vehicle.speed) > most:
                vehicle = replace(vehicle, speed=copysign(most, vehicle.speed))
        remaining -= abs(vehicle.speed) * dt
        start = vehicle.ahead(car.no_slip)
        rollout = Rollout(car, estimate, start)
        rollout.drive(plant.wheel, clipped((*plant.commands, (steer, dt)), dt))
        plant = plant.elapse(car, steer, dt, 0.0)
        vehicle = rollout.state.bounded().ahead(-car.no_slip).bounded()
        steer = step(vehicle)
    vehicles = [each.vehicle for each in trajectory]
    return Prediction(
        time=np.array([each.time for each in trajectory]),
        x=np.array([vehicle.x for vehicle in vehicles]),
        y=np.array([vehicle.y for vehicle in vehicles]),
        yaw=np.array([vehicle.yaw for vehicle in vehicles]),
        speed=np.array([vehicle.speed for vehicle in vehicles]),
        steer=np.array([each.steer for each in trajectory]),
    )


class Predicting(Generic[StateT]):
    """The method `predict` of a tracker."""

    _vehicle: Vehicle
    _models: bool
    _state: StateT
    step: Callable[..., Command]

    def predict(self, time: float = 1.0, dt: float = 0.05) -> Prediction:
        """Predict the trajectory that the controller intends, from the last step on.

        For `time` [s], an instant each `dt` [s], which is the period of the steps to come too. The
        controller itself stays as it is; see `predict.predict`.

        Raises
        ------
        InputError
            Where a number is out of its range, or no step was taken before.
        """
        count, dt = instants(time, dt), checked_dt(dt)
        before = self._state

        def step(vehicle: VehicleState) -> float:
            return self.step(vehicle.x, vehicle.y, vehicle.yaw, vehicle.speed, dt).steer

        # Predicted poses have no age, and carry no information on the vehicle.
        self._state = replace(with_past(before, None), last_measured=None, held_time=0.0)
        try:
            return predict(self._vehicle, before, step, dt, count, models=self._models)
        finally:
            self._state = before
