"""What CARLA says of a vehicle."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from popsteer import Vehicle
from popsteer.adapters.carla.conversions import Steering, axles_of, curve_of

if TYPE_CHECKING:
    import carla


def vehicle_of(actor: carla.Vehicle, **fields: Any) -> Vehicle:  # noqa: ANN401 - `Vehicle` checks them
    """Describe a vehicle of CARLA: width, wheelbase, rear axle and largest angle of the wheels.

    The vehicle's point is the actor's, and what stops at the end of a plan. What a physics control
    does not say has `Vehicle`'s default: above all `steer_lag`, `dead_time` and
    `max_lateral_acceleration`.

    Parameters
    ----------
    actor : carla.Vehicle
        After the world has ticked once: before, an actor does not know where it is.
    **fields
        Fields of `Vehicle`, in place of what the actor says or beside it.

    Returns
    -------
    Vehicle
        Of the actor.

    Raises
    ------
    PopsteerError
        The physics control does not say where the wheels are, and they are not given.
    ConfigError
        `Vehicle` refuses a field.

    Notes
    -----
    CARLA 0.9 gives the places of the wheels in the world and in [cm]. `max_steer` is the mean of
    the front wheels' ``max_steer_angle``.
    """
    physics = actor.get_physics_control()
    read: dict[str, Any] = {}
    if not {"wheelbase", "rear_axle"} <= fields.keys():
        wheelbase, rear_axle = axles_of(physics.wheels, actor.get_transform())
        read |= {"wheelbase": wheelbase, "rear_axle": rear_axle}
    if "max_steer" not in fields:
        read["max_steer"] = _lock(physics)
    if "width" not in fields:
        read["width"] = 2.0 * actor.bounding_box.extent.y
    return Vehicle(**({"stop_point": 0.0} | read | fields))


def steering_of(actor: carla.Vehicle) -> Steering:
    """Read from an actor what a share of full lock is, and its steering curve.

    The lock is the mean largest angle of the front wheels. Raises ConfigError where they do not
    turn.
    """
    physics = actor.get_physics_control()
    return Steering(_lock(physics), curve_of(physics.steering_curve))


def _lock(physics: carla.VehiclePhysicsControl) -> float:
    front = physics.wheels[:2]
    return math.radians(math.fsum(wheel.max_steer_angle for wheel in front) / max(len(front), 1))
