"""What a controller was shown in a step, which the Rust core keeps to itself: the reference's."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from popsteer import reference
from popsteer.reference.laws.law import Belief
from popsteer.reference.vehicle.delay import InFlight
from popsteer.reference.vehicle.state import VehicleState

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tests.parity.laws import Law


def decided(
    law: Law, controller: Any, before: Any, after: Any, step: Sequence[float]
) -> tuple[Any, Any]:
    """Return the located vehicle and the decision of a step of `controller` between two states.

    The vehicle is the one predicted through the dead time, the decision the controller's own,
    before the limits of the vehicle.
    """
    path = reference.Path(
        list(zip(controller.path.x.tolist(), controller.path.y.tolist(), strict=True)),
        speed=None if controller.path.speed is None else controller.path.speed.tolist(),
        closed=controller.path.closed,
    )
    car = reference.Vehicle(**controller.vehicle.as_dict())
    params = getattr(reference, law.params_name)(**controller.params.as_dict())
    twin = getattr(reference, law.name)(car, params)
    x, y, yaw, speed, dt = step
    vehicle = VehicleState(x, y, yaw, speed)
    wheel, estimate = before.steer, reference.Estimate()
    if after.in_flight is not None:
        in_flight = InFlight(after.in_flight.commands, after.in_flight.wheel)
        wheel = in_flight.wheel
        # The slip is estimated after the prediction.
        estimate = _estimate(after, slip_of=before)
        if car.dead_time > 0.0:
            then, wheel = in_flight.predict(car, vehicle.ahead(car.no_slip), estimate)
            vehicle = then.bounded().ahead(-car.no_slip).bounded()
        estimate = _estimate(after, slip_of=after)
    faster = 0.0 if before.answer is None else abs(before.answer.vehicle.speed)
    travelled = max(abs(speed), faster) * dt
    at = twin.follow.locate(path, before.waypoint, vehicle, dt, travelled)
    state = twin.STATE()
    # What a buffer holds stands in the law itself here.
    own = before.law.as_dict()
    own.update(own.pop("buffer", {}))
    for name in vars(state):
        value = own[name]
        setattr(state, name, list(value) if isinstance(value, tuple) and name == "terms" else value)
    offset = car.steer_offset + estimate.steer_offset
    twin.set_steer(state, car.at_wheels(before.steer + offset))
    return at, twin.decide(path, state, at, Belief(wheel, estimate))


def _estimate(state: Any, slip_of: Any) -> reference.Estimate:
    found, slipping = state.estimator.estimate, slip_of.estimator.estimate
    return reference.Estimate(
        gain=found.gain,
        steer_offset=found.steer_offset,
        slip=slipping.slip,
        slip_length=slipping.slip_length,
        acceleration=found.acceleration,
    )
