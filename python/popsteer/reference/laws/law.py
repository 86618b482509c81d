"""What every controller is: a vehicle, validated parameters and a small plain state.

From them it decides an angle for a located vehicle; `popsteer.reference.tracker` steps it.
"""

from __future__ import annotations

import enum
from abc import ABC, abstractmethod
from dataclasses import dataclass, fields, replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, ClassVar, Generic, TypeVar

from popsteer.reference.error import Checked, optional
from popsteer.reference.path.follow import Follow, Located
from popsteer.reference.vehicle import Vehicle
from popsteer.status import Status

if TYPE_CHECKING:
    from collections.abc import Callable

    from typing_extensions import Self

    from popsteer.reference.geometry import Point
    from popsteer.reference.path.view import PathView
    from popsteer.reference.vehicle.estimate import Estimate


@dataclass(frozen=True)
class Decision:
    """What a controller decides, for the mirrored vehicle: one that drives forward."""

    steer: float  # angle of its front wheels that is wanted [rad], within `max_steer`
    target: Point  # that is aimed at: the lookahead point, or the projection onto the path [m]
    status: Status  # saturated or lookahead lost, where that is so


@dataclass(frozen=True)
class Belief:
    """What a controller may know of the vehicle besides its parameters, in the vehicle's frame."""

    wheel: float  # angle when the command reaches the wheels, without the estimated offset [rad]
    estimate: Estimate


@dataclass(frozen=True, kw_only=True)
class Params(Checked):
    """What the parameters of all controllers share.

    The texts are those of `popsteer`; a parameter that is None scales with the vehicle.
    """

    # [m]
    search_distance: float | None = optional(0.0, 1e6, scaled=lambda car: 2.0 * car.wheelbase)
    lost_distance: float | None = optional(1e-3, 1e9, scaled=lambda car: 10.0 * car.wheelbase)

    def resolved(self, vehicle: Vehicle) -> Self:
        """Return the parameters with the defaults that scale with `vehicle` filled in.

        Examples
        --------
        >>> from popsteer.reference import PopParams, Vehicle
        >>> PopParams(window_ahead=9).resolved(Vehicle(wheelbase=2.5)).min_lookahead
        5.0
        """
        missing = [each for each in fields(self) if getattr(self, each.name) is None]
        return replace(self, **{each.name: each.metadata["scaled"](vehicle) for each in missing})


class Tracked(enum.Enum):
    """Which point of the vehicle a controller steers by."""

    FRONT_AXLE = enum.auto()
    REAR_AXLE = enum.auto()
    NO_SLIP_POINT = enum.auto()

    def follow(self, vehicle: Vehicle, params: SimpleNamespace) -> Follow:
        """Return how the point is followed, with the distances of resolved parameters."""
        base = vehicle.no_slip if self is Tracked.NO_SLIP_POINT else vehicle.rear_axle
        ahead = vehicle.wheelbase if self is Tracked.FRONT_AXLE else 0.0
        return replace(
            Follow.of(vehicle, base, ahead),
            search_distance=params.search_distance,
            lost_distance=params.lost_distance,
        )


ParamsT = TypeVar("ParamsT", bound=Params)
StateT = TypeVar("StateT")


class LateralLaw(ABC, Generic[ParamsT, StateT]):
    """A steering controller: a vehicle and validated parameters that decide an angle.

    Made of a `Vehicle` and the controller's parameters, the defaults without.
    """

    TRACKED: ClassVar[Tracked]
    READS_BELIEF: ClassVar[bool] = False
    """Whether the controller reads the `Belief`: its wheels are then modelled at every step."""
    PARAMS: Callable[[], ParamsT]
    STATE: Callable[[], StateT]

    def __init__(self, vehicle: Vehicle | None = None, params: ParamsT | None = None) -> None:
        self.vehicle = Vehicle() if vehicle is None else vehicle
        self.params = self.PARAMS() if params is None else params
        # By the same names; none that scales with the vehicle is None.
        self.resolved = SimpleNamespace(**vars(self.params.resolved(self.vehicle)))
        self.follow = self.TRACKED.follow(self.vehicle, self.resolved)

    @abstractmethod
    def decide(self, path: PathView, state: StateT, at: Located, belief: Belief) -> Decision:
        """Decide the angle for a located vehicle, and note in `state` what is to be remembered."""

    def pull(self, at: Located) -> float:  # noqa: ARG002 - not needed here
        """Return the angle that the error alone asks for, times the gain on the heading [rad].

        0 of a controller that takes account of `max_steer_rate`.
        """
        return 0.0

    def leave_path(self, state: StateT) -> None:
        """Forget what holds on the present path alone."""

    def interrupt(self, state: StateT) -> None:
        """Forget what the next step would be compared with: the vehicle stood since."""

    def set_steer(self, state: StateT, steer: float) -> None:
        """Note the angle [rad] that the wheels got in place of the controller's."""


def limit_steer(vehicle: Vehicle, steer: float) -> tuple[float, Status]:
    """Bring an angle [rad] within `max_steer`, and tell the status of that."""
    limited = vehicle.at_wheels(steer)
    if limited == steer:
        return limited, Status.OK
    return limited, Status.SATURATED | Status.STEER_LIMIT
