"""What the closed loop asks of a controller of your own."""

from __future__ import annotations

import inspect
from functools import partial
from numbers import Real
from typing import Any, Protocol, TypeAlias, TypeVar, cast

from popsteer import controllers
from popsteer._core import Vehicle
from popsteer.errors import ConfigError
from popsteer.ranges import check_in_range

_FARTHEST = 1e3  # m from a vehicle's point


class OwnCommand(Protocol):
    """What a controller of your own may return: an angle, and optionally more.

    `reverse` (whether to drive backwards) is the gear; if it is missing, the direction of the path
    is. `acceleration` [m/s²], in the direction of driving, works the pedals in place of the run's
    longitudinal controller: a `popsteer.Driver` has it. `target` (a point [m]) and `status` go into
    the records where they are given, as `Command` has them.
    """

    @property
    def steer(self) -> float:
        """Angle of the front wheels [rad]."""
        ...


class OwnSimpleController(Protocol):
    """What `run` asks of a controller of your own.

    It may carry `path` (what it follows), `tracked_point` (where its errors are measured, ahead of
    the point whose pose it is given [m]; the plant's front axle by default), `vehicle` (the
    `Vehicle` that it believes to steer) and `name`. One whose `vehicle_given` is False takes the
    plant's vehicle: its method ``with_vehicle(vehicle)`` gives what drives then.

    A `step` that accepts a keyword `reverse` gets by it whether the path is driven backwards
    where the rear axle is; one that requires it makes an `OwnReversingController`.
    """

    def step(
        self, x: float, y: float, yaw: float, speed: float, dt: float, /
    ) -> OwnCommand | float:
        """Answer the pose [m, m, rad] and the speed [m/s] with the angle of the wheels [rad]."""
        ...


class OwnReversingController(Protocol):
    """A controller like `OwnSimpleController` whose step takes the direction of the path."""

    def step(
        self, x: float, y: float, yaw: float, speed: float, dt: float, /, *, reverse: bool
    ) -> OwnCommand | float:
        """Answer as that of `OwnSimpleController`, where the path is driven backwards or not."""
        ...


OwnController: TypeAlias = OwnSimpleController | OwnReversingController
"""Either of them."""


_C = TypeVar("_C", bound="controllers.Controller | OwnController")


def informed(controller: _C, plant: Vehicle) -> _C:
    """Give the plant's vehicle to a controller that was given none.

    That is another of its kind, in a fresh state, on the same path; else it is returned itself.
    Raises ConfigError where the vehicle that it was given has its rear axle elsewhere: a pose would
    mean one position to the plant and another to the controller.
    """
    if _attribute(controller, "vehicle_given") is False:
        given: Any = controller
        if not isinstance(controller, controllers.CONTROLLERS):
            made = _attribute(controller, "with_vehicle")
            return cast("_C", made(plant)) if callable(made) else controller
        # What makes an equal controller: adapting as it was given, or as its kind does.
        (path, _, params), options = given.__getnewargs_ex__()
        return cast("_C", type(given)(path, plant, params, **options))
    given = believed(controller)
    if given is not None and given.rear_axle != plant.rear_axle:
        raise ConfigError("rear_axle", given.rear_axle, f"that of the plant, {plant.rear_axle!r}")
    return controller


def _attribute(controller: object, name: str) -> Any:  # noqa: ANN401 - of any kind
    try:
        return getattr(controller, name, None)
    except Exception:  # noqa: BLE001 - a property of one's own, for which nobody has asked
        return None


def told(controller: object, name: str, kind: type) -> Any:  # noqa: ANN401 - of the kind
    """Give what a controller says of itself; None where an attribute of this name is another's."""
    value = _attribute(controller, name)
    return value if isinstance(value, kind) and not isinstance(value, bool) else None


def tracked_point(controller: object) -> float | None:
    """Give where a controller of your own has its errors measured; None where it does not say.

    Raises ConfigError where that is on no vehicle.
    """
    point = told(controller, "tracked_point", Real)
    if point is not None:
        check_in_range("tracked_point", point, -_FARTHEST, _FARTHEST)
    return point  # type: ignore[no-any-return] # of the kind that was asked for


def step_of(controller: Any) -> Any:  # noqa: ANN401 - of your own
    """Give the step of your own controller where all driving is forward: one may ask which way."""
    try:
        inspect.signature(controller.step).bind_partial(reverse=False)
    except (TypeError, ValueError):
        return controller.step
    return partial(controller.step, reverse=False)


def believed(controller: controllers.Controller | OwnController) -> Vehicle | None:
    """Tell which vehicle a controller believes to steer; None where your own does not say."""
    given: Vehicle | None = told(controller, "vehicle", Vehicle)
    return given
