"""The lateral controllers, one a file, behind `LateralLaw`, and `Tracker`, which steps them.

A controller decides an angle for a located vehicle; it is a vehicle, validated parameters and a
small frozen state. A `Tracker` is all of a step around it: estimate, predict, locate, limit.
"""

from __future__ import annotations

import enum
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, Generic, TypeVar

from popsteer.reference.error import config_optional, input_within
from popsteer.reference.path.follow import Follow, Located
from popsteer.reference.tracker.command import Command
from popsteer.reference.vehicle.estimate import AdaptParams
from popsteer.status import Status

if TYPE_CHECKING:
    from typing_extensions import Self

    from popsteer.reference.geometry import Point
    from popsteer.reference.path.view import PathView
    from popsteer.reference.vehicle import Vehicle
    from popsteer.reference.vehicle.estimate import Corrections

__all__ = ["Belief", "Command", "Decision", "LateralLaw"]


@dataclass(frozen=True)
class Decision:
    """What a controller decides, for the vehicle as one that drives forward.

    Attributes
    ----------
    steer : float
        Angle of the front wheels that is wanted [rad], within the vehicle's `max_steer`.
    target : tuple of float
        The point aimed at: the lookahead point, or the projection onto the path, (x, y) [m].
    status : Status
        Saturated or lookahead lost, where that is so.
    """

    steer: float
    target: Point
    status: Status


@dataclass(frozen=True)
class Belief:
    """What a controller may know of the vehicle besides its parameters, in the vehicle's own frame.

    Attributes
    ----------
    wheel : float
        Angle of the wheels when the command to be decided reaches them, without the estimated
        offset [rad].
    estimate : Corrections
        The estimates.
    """

    wheel: float
    estimate: Corrections


@dataclass(frozen=True, kw_only=True)
class Params:
    """What the parameters of all controllers share: `search_distance` and `lost_distance`.

    Each class has them as its last fields.
    """

    def __post_init__(self) -> None:
        config_optional(self, "search_distance", 0.0, 1e6)
        config_optional(self, "lost_distance", 1e-3, 1e9)

    def _scaled(self, vehicle: Vehicle) -> dict[str, float]:
        """Return the defaults that scale with `vehicle`, by parameter."""
        wheelbase = vehicle.wheelbase
        return {"search_distance": 2.0 * wheelbase, "lost_distance": 10.0 * wheelbase}

    def resolved(self, vehicle: Vehicle) -> Self:
        """Return the parameters with the defaults that scale with `vehicle` filled in.

        Examples
        --------
        >>> from popsteer.reference import PopParams, Vehicle
        >>> PopParams(window_ahead=9).resolved(Vehicle(wheelbase=2.5)).min_lookahead
        5.0
        """
        scaled = self._scaled(vehicle).items()
        return replace(self, **{name: at for name, at in scaled if getattr(self, name) is None})


ParamsT = TypeVar("ParamsT", bound=Params)
StateT = TypeVar("StateT")


class LateralLaw(ABC, Generic[ParamsT, StateT]):
    """A steering controller: a vehicle and validated parameters that decide an angle."""

    def __init__(self, path: PathView, vehicle: Vehicle, params: ParamsT) -> None:
        self._path = path
        self._vehicle = vehicle
        self._params = params
        # By the same names; none that scales with the vehicle is None.
        self._resolved = SimpleNamespace(**vars(params.resolved(vehicle)))

    @property
    def path(self) -> PathView:
        """The path that is followed."""
        return self._path

    @property
    def vehicle(self) -> Vehicle:
        """The vehicle that is steered."""
        return self._vehicle

    @property
    def params(self) -> ParamsT:
        """The parameters, as given."""
        return self._params

    def reads_belief(self) -> bool:
        """Tell whether the controller reads the `Belief`: every step then models the wheels."""
        return False

    @abstractmethod
    def decide(self, at: Located, belief: Belief) -> Decision:
        """Decide the angle for a located vehicle, and remember what is to be remembered."""

    def restore(self, state: StateT) -> StateT:
        """Return `state`, where what the controller remembers in it can be put together at all.

        Raises
        ------
        InputError
            Naming the field that cannot.
        """
        return state

    def check_law_state(self, state: StateT) -> StateT:
        """Return `state` if this controller could be in it.

        Raises
        ------
        InputError
            Naming the field that is not.
        """
        return state

    def forget_path(self, state: StateT) -> StateT:
        """Forget what was measured against the path: it leads another way from now on."""
        return state

    def change_path(self, state: StateT, _offset: float | None) -> StateT:
        """Follow another path, against which the last error is so much larger [m].

        None if that is unknown.
        """
        return state

    def set_steer(self, state: StateT, _steer: float) -> tuple[StateT, bool]:
        """Take note of the angle that the wheels were given instead of the controller's answer.

        Returns the state, and whether the controller's next answer goes on from it.
        """
        return state, False

    def default_adapt(self) -> AdaptParams | None:
        """Return how the controller adapts by default.

        It adapts if it uses the estimates: if it predicts, or if commands are in flight.
        """
        return AdaptParams() if self.reads_belief() or self._vehicle.dead_time > 0.0 else None


class Tracked(enum.Enum):
    """Which point of the vehicle a controller steers by."""

    FRONT_AXLE = enum.auto()
    REAR_AXLE = enum.auto()
    NO_SLIP_POINT = enum.auto()

    def follow(self, vehicle: Vehicle, params: SimpleNamespace) -> Follow:
        """Return how the point is followed, with the distances of resolved parameters."""
        wheelbase = vehicle.wheelbase
        if self is Tracked.FRONT_AXLE:
            base, reference_offset = vehicle.rear_axle, wheelbase
        elif self is Tracked.REAR_AXLE:
            base, reference_offset = vehicle.rear_axle, 0.0
        else:
            base, reference_offset = vehicle.no_slip, 0.0
        return replace(
            Follow.of(vehicle, base, reference_offset),
            search_distance=params.search_distance,
            lost_distance=params.lost_distance,
        )


def limit_steer(vehicle: Vehicle, steer: float) -> tuple[float, Status]:
    """Bring an angle [rad] within `max_steer`, and tell the status of that."""
    if steer > vehicle.max_steer:
        return vehicle.max_steer, Status.SATURATED
    if steer < -vehicle.max_steer:
        return -vehicle.max_steer, Status.SATURATED
    return steer, Status.OK


def check_steer(field: str, steer: float, max_steer: float) -> float:
    """Return a remembered angle [rad], where it is within the limit."""
    return input_within(field, steer, max_steer)
