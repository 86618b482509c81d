"""What the closed loop asks of a controller of your own."""

from __future__ import annotations

from typing import Protocol, TypeAlias


class OwnCommand(Protocol):
    """What a controller of your own may return: an angle, and optionally more.

    `reverse` (whether to drive backwards) is the gear; if it is missing, the direction of the path
    is. `target` (a point [m]) and `status` go into the records where they are given, as
    `Command` has them.
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
