"""What a controller believes of the vehicle, beside what the plant is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar, cast

from popsteer import controllers
from popsteer._core import Vehicle
from popsteer.errors import ConfigError

if TYPE_CHECKING:
    from popsteer.sim.steering import OwnController

_C = TypeVar("_C", bound="controllers.Controller | OwnController")


def informed(controller: _C, plant: Vehicle) -> _C:
    """Give the plant's vehicle to a controller that was given none.

    That is another of its kind, in a fresh state, on the same path. A controller that was given a
    vehicle, or knows of none, is returned itself. Raises ConfigError where the vehicle that it was
    given has its rear axle elsewhere: a pose would mean one position to the plant and another to
    the controller.
    """
    if getattr(controller, "vehicle_given", True) is False:
        given: Any = controller
        if not isinstance(controller, controllers.CONTROLLERS):
            return cast("_C", given.with_vehicle(plant))
        # What makes an equal controller: adapting as it was given, or as its kind does.
        (path, _, params), options = given.__getnewargs_ex__()
        return cast("_C", type(given)(path, plant, params, **options))
    given = believed(controller)
    if given is not None and given.rear_axle != plant.rear_axle:
        raise ConfigError("rear_axle", given.rear_axle, f"that of the plant, {plant.rear_axle!r}")
    return controller


def believed(controller: controllers.Controller | OwnController) -> Vehicle | None:
    """Tell which vehicle a controller believes to steer; None where your own does not say."""
    given = getattr(controller, "vehicle", None)
    return given if isinstance(given, Vehicle) else None
