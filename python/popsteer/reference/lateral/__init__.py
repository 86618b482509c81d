"""The steering laws, one a file, all behind `LateralLaw`.

A law is its validated parameters; what it remembers between steps is a state of its own, a
small frozen value that can be copied, compared and restored.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

from popsteer.reference.error import config_in_range, input_below, input_in_range
from popsteer.reference.math import wrap
from popsteer.reference.path.locate import Projection, locate, project
from popsteer.reference.path.lookahead import Lookahead, get_lookahead_point
from popsteer.reference.path.relocalise import relocalise
from popsteer.reference.path.resample import grid, window
from popsteer.reference.vehicle.state import VehicleState, checked_dt
from popsteer.status import Status

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

    from popsteer.reference.path.view import PathView, Point

__all__ = ["Command", "LateralLaw", "Located"]


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


class SearchParams(Protocol):
    """The parameters of the laws that search for a lookahead point."""

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


def check_search(params: SearchParams) -> None:
    """Settle the parameters of a law that searches for a lookahead point."""
    config_in_range(params, "lookahead_gain", 0.0, 1e3)
    config_in_range(params, "min_lookahead", 0.0, 1e4)
    config_in_range(params, "lookahead_tolerance", 1e-9, 1e3)
    config_in_range(params, "window_ahead", 1e-3, 1e6)
    config_in_range(params, "grid_spacing", 1e-4, 1e3)


def find(path: PathView, at: Located, lookahead: float, params: SearchParams) -> Lookahead:
    """Find the point at distance `lookahead` [m] in the window around a located vehicle."""
    waypoints = grid(path, window(path, at.nearest, params.window_ahead), params.grid_spacing)
    return get_lookahead_point(waypoints, at.position, lookahead, params.lookahead_tolerance)


def check_waypoint(path: PathView, waypoint: int | None) -> int | None:
    """Return a remembered waypoint, where it is one of `path`."""
    return None if waypoint is None else input_below("waypoint", waypoint, len(path))


def check_steer(field: str, steer: float, max_steer: float) -> float:
    """Return a remembered angle [rad], where it is within the limit."""
    return input_in_range(field, steer, -max_steer, max_steer)


@dataclass(frozen=True)
class Located:
    """A checked input, and where on the path it is.

    Attributes
    ----------
    position : tuple of float
        The law's reference point [m].
    nearest : int
        The waypoint nearest to it.
    vehicle : VehicleState
        Pose of the rear axle, and speed.
    dt : float
        Control period [s].
    """

    position: Point
    nearest: int
    vehicle: VehicleState
    dt: float

    def heading_error(self, projection: Projection) -> float:
        """Yaw less direction of the path at a projection [rad], in [-π, π]."""
        return wrap(self.vehicle.yaw - projection.path_yaw)

    def command(
        self, projection: Projection, steer: float, target: Point, status: Status
    ) -> Command:
        """Make the command with the errors at the reference point."""
        return Command(
            steer=steer,
            cross_track_error=projection.cross_track_error,
            heading_error=self.heading_error(projection),
            target=target,
            status=status,
        )


ParamsT = TypeVar("ParamsT", bound=BodyParams)
StateT = TypeVar("StateT", bound="DataclassInstance")


class LateralLaw(ABC, Generic[ParamsT, StateT]):
    """A steering law on a path: validated parameters that step a state."""

    def __init__(self, path: PathView, params: ParamsT, default_offset: float) -> None:
        offset = params.reference_offset
        self._path = path
        self._params = params
        self._reference_offset = default_offset if offset is None else offset
        self._state = self.initial_state()

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
        """How far ahead of the rear axle the law's reference point lies [m]."""
        return self._reference_offset

    @property
    def state(self) -> StateT:
        """What the law remembers; may be set to a state saved before.

        Raises
        ------
        InputError
            Where it is no state that this law could have; the state is then unchanged.
        """
        return self._state

    @state.setter
    def state(self, state: StateT) -> None:
        self._state = self.check_state(state)

    def reset(self) -> None:
        """Forget everything: the state before the first step."""
        self._state = self.initial_state()

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

    @abstractmethod
    def step(self, x: float, y: float, yaw: float, speed: float, dt: float) -> Command:
        """Locate the vehicle on the path, aim, steer: one control step.

        Parameters
        ----------
        x, y : float
            Position of the middle of the rear axle [m].
        yaw : float
            Heading [rad]; need not be wrapped.
        speed : float
            Forward speed [m/s]; negative while rolling backwards.
        dt : float
            Control period [s].

        Returns
        -------
        Command
            The angle, the errors, the point aimed at, and how the step went.

        Raises
        ------
        InputError
            Naming the first argument that is not finite or beyond its bound; the state is then
            unchanged.
        """

    def steer(self, x: float, y: float, yaw: float, speed: float, dt: float, /) -> float:
        """Return the angle of `step` alone [rad]; same arguments, same state afterwards."""
        return self.step(x, y, yaw, speed, dt).steer

    def relocalise(self, x: float, y: float, yaw: float) -> None:
        """Find the vehicle's place on the path anew, after a jump.

        Puts the remembered waypoint to `relocalise` of the law's reference point; the next step
        goes on from there. The rest of the state stays.

        Parameters
        ----------
        x, y : float
            Position of the middle of the rear axle [m].
        yaw : float
            Heading [rad]; tells branches apart that cross or lie alongside.

        Raises
        ------
        InputError
            Naming the first argument that is not finite or beyond its bound; the state is then
            unchanged.
        """
        vehicle = VehicleState(x, y, yaw, speed=0.0).checked()
        position = vehicle.point_ahead(self._reference_offset)
        waypoint = relocalise(self._path, position, vehicle.yaw)
        self._state = replace(self._state, waypoint=waypoint)

    def _locate(
        self, last: int | None, x: float, y: float, yaw: float, speed: float, dt: float
    ) -> Located:
        """Where am I? The reference point of a checked vehicle, and the waypoint nearest to it."""
        vehicle = VehicleState(x, y, yaw, speed).checked()
        dt = checked_dt(dt)
        position = vehicle.point_ahead(self._reference_offset)
        return Located(position, locate(self._path, last, position), vehicle, dt)

    def _project(self, at: Located) -> Projection:
        """Project a located vehicle onto the path."""
        return project(self._path, at.nearest, at.position)

    def _limit(self, steer: float) -> tuple[float, Status]:
        """Bring an angle within the limit, and tell whether it had to be."""
        max_steer = self._params.max_steer
        if steer > max_steer:
            return max_steer, Status.SATURATED
        if steer < -max_steer:
            return -max_steer, Status.SATURATED
        return steer, Status.OK
