"""The steering laws, one a file, all behind `LateralLaw`.

A law is its validated parameters; what it remembers between steps is a state of its own, a
small frozen value that can be copied, compared and restored.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

from popsteer.reference.error import config_in_range, input_below, input_in_range
from popsteer.reference.math import wrap
from popsteer.reference.path.follow import Follow, Located
from popsteer.reference.path.lookahead import Lookahead, get_crossing, get_lookahead_point
from popsteer.reference.path.resample import grid, window
from popsteer.status import Status

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

    from popsteer.reference.path.view import PathView, Point
    from popsteer.reference.vehicle.state import VehicleState

__all__ = ["Command", "LateralLaw"]


@dataclass(frozen=True)
class Command:
    """What one step answers.

    Attributes
    ----------
    steer : float
        Angle of the front wheels [rad], positive to the left.
    cross_track_error : float
        Offset of the law's reference point from the path [m], positive left of it.
    heading_error : float
        Yaw of the vehicle less direction of the path [rad], in [-π, π].
    target : tuple of float
        The point aimed at: the lookahead point, or the foot on the path, (x, y) [m].
    reverse : bool
        Whether the path is driven backwards here.
    status : Status
        How the step went.

    Examples
    --------
    >>> from popsteer.reference import Path, Stanley
    >>> command = Stanley(Path([(0.0, 0.0), (9.0, 0.0)])).step(1.0, 0.5, 0.0, 5.0, 0.05)
    >>> command.cross_track_error, command.heading_error, command.target, command.status.value
    (0.5, 0.0, (4.0, 0.0), 'ok')
    """

    steer: float
    cross_track_error: float
    heading_error: float
    target: Point
    reverse: bool
    status: Status


class BodyParams(Protocol):
    """The parameters that every law has."""

    @property
    def wheelbase(self) -> float:
        """Distance of the axles [m]."""

    @property
    def reference_offset(self) -> float | None:
        """Reference point ahead of the rear axle [m]; None is the law's default."""

    @property
    def max_steer(self) -> float:
        """Steering limit [rad]."""

    @property
    def search_distance(self) -> float | None:
        """How far from the last place the vehicle is looked for [m]; None is two wheelbases."""

    @property
    def lost_distance(self) -> float | None:
        """From where on the vehicle is lost [m]; None is ten wheelbases."""


class SearchParams(Protocol):
    """The parameters of the laws that search for a lookahead point."""

    @property
    def exact_lookahead(self) -> bool:
        """Whether the first crossing of the circle counts, instead of the paper's search."""

    @property
    def lookahead_tolerance(self) -> float:
        """Threshold of the search [m]."""

    @property
    def window_ahead(self) -> float:
        """Arc ahead of the vehicle that is searched [m]."""

    @property
    def grid_spacing(self) -> float:
        """Greatest distance of neighbours on the re-discretised path [m]."""


def check_body(params: BodyParams) -> None:
    """Settle the parameters that every law has."""
    config_in_range(params, "wheelbase", 1e-3, 1e3)
    if params.reference_offset is not None:
        config_in_range(params, "reference_offset", -1e3, 1e3)
    config_in_range(params, "max_steer", 1e-3, 1.57)
    if params.search_distance is not None:
        config_in_range(params, "search_distance", 0.0, 1e6)
    if params.lost_distance is not None:
        config_in_range(params, "lost_distance", 1e-3, 1e9)


def check_search(params: SearchParams) -> None:
    """Settle the parameters of a law that searches for a lookahead point."""
    config_in_range(params, "lookahead_gain", 0.0, 1e3)
    config_in_range(params, "min_lookahead", 0.0, 1e4)
    config_in_range(params, "lookahead_tolerance", 1e-9, 1e3)
    config_in_range(params, "window_ahead", 1e-3, 1e6)
    config_in_range(params, "grid_spacing", 1e-4, 1e3)


def find(path: PathView, at: Located, lookahead: float, params: SearchParams) -> Lookahead:
    """Find the lookahead point at distance `lookahead` [m] from a located vehicle."""
    if params.exact_lookahead:
        point, found = get_crossing(path, at.foot, at.position, lookahead)
        return Lookahead(0, point, found)
    nearest = at.foot.nearest_waypoint(path)
    waypoints = grid(path, window(path, nearest, params.window_ahead), params.grid_spacing)
    return get_lookahead_point(waypoints, at.position, lookahead, params.lookahead_tolerance)


def check_waypoint(path: PathView, waypoint: int | None) -> int | None:
    """Return a remembered waypoint, where it is one of `path`."""
    return None if waypoint is None else input_below("waypoint", waypoint, len(path))


def check_steer(field: str, steer: float, max_steer: float) -> float:
    """Return a remembered angle [rad], where it is within the limit."""
    return input_in_range(field, steer, -max_steer, max_steer)


def command(at: Located, steer: float, target: Point, status: Status) -> Command:
    """Make the command of the turned vehicle's angle, with the errors at the reference point."""
    if at.off_path:
        status = Status.OFF_PATH
    elif at.past_end:
        status = Status.END_OF_PATH
    return Command(
        steer=at.turn(steer),
        cross_track_error=at.foot.cross_track_error(),
        heading_error=wrap(at.vehicle.yaw - at.foot.path_yaw()),
        target=target,
        reverse=at.reverse,
        status=status,
    )


ParamsT = TypeVar("ParamsT", bound=BodyParams)
StateT = TypeVar("StateT", bound="DataclassInstance")


class LateralLaw(ABC, Generic[ParamsT, StateT]):
    """A steering law on a path: validated parameters that step a state."""

    def __init__(self, path: PathView, params: ParamsT, default_offset: float) -> None:
        wheelbase = params.wheelbase
        offset, search, lost = (
            params.reference_offset,
            params.search_distance,
            params.lost_distance,
        )
        self._path = path
        self._params = params
        self._follow = Follow(
            reference_offset=default_offset if offset is None else offset,
            rear_axle=0.0,
            search_distance=2.0 * wheelbase if search is None else search,
            lost_distance=10.0 * wheelbase if lost is None else lost,
            arrival_distance=0.05 * wheelbase,
            # 10 m for the wheelbase of a car, 3 m, to the last bit.
            opposite_distance=wheelbase * 10.0 / 3.0,
        )

    @property
    def path(self) -> PathView:
        """The path that is followed."""
        return self._path

    @property
    def params(self) -> ParamsT:
        """The parameters."""
        return self._params

    @property
    def reference_offset(self) -> float:
        """How far ahead of the rear axle the law's reference point lies [m].

        Where the path is driven backwards, how far behind it.
        """
        return self._follow.reference_offset

    @abstractmethod
    def initial_state(self) -> StateT:
        """Return the state before the first step."""

    @abstractmethod
    def check_state(self, state: StateT) -> StateT:
        """Return `state`, where it is one that this law could have on its path.

        Raises
        ------
        InputError
            Naming the field that is not.
        """

    def _locate(self, last: int | None, vehicle: VehicleState, dt: float) -> Located:
        """Where am I? The place of the reference point of a checked vehicle."""
        return self._follow.locate(self._path, last, vehicle, dt)

    def _limit(self, steer: float) -> tuple[float, Status]:
        """Bring an angle within the limit, and tell whether it had to be."""
        max_steer = self._params.max_steer
        if steer > max_steer:
            return max_steer, Status.SATURATED
        if steer < -max_steer:
            return -max_steer, Status.SATURATED
        return steer, Status.OK
