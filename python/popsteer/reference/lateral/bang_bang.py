"""Bang-bang: a fixed angle back towards the path, the floor to measure against."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from popsteer.reference.error import config_in_range
from popsteer.reference.lateral import Command, check_body, check_waypoint, command
from popsteer.reference.lateral.tracker import Tracker, TrackerState

if TYPE_CHECKING:
    from popsteer.reference.path.view import PathView
    from popsteer.reference.vehicle.actuator import Actuator
    from popsteer.reference.vehicle.state import VehicleState

__all__ = ["BangBang", "BangBangParams", "BangBangState"]


@dataclass(frozen=True, kw_only=True)
class BangBangParams:
    """Parameters of `BangBang`.

    Attributes
    ----------
    amplitude : float
        The angle that is switched [rad]; at most `max_steer` of it is used.
    deadband : float
        Cross-track errors up to this leave the wheels straight [m].
    wheelbase : float
        Distance of the axles [m].
    reference_offset : float or None
        Reference point ahead of the rear axle [m]; None is the front axle, `wheelbase`.
    max_steer : float
        Steering limit δ_max [rad].
    search_distance : float or None
        How far along the path from the last place the vehicle is looked for [m], beside what it
        travels in a step; None is two wheelbases.
    lost_distance : float or None
        Farther than this from its place the vehicle is lost, and looked for on the whole path
        [m]; None is ten wheelbases.

    Raises
    ------
    ConfigError
        Naming the parameter that is out of its range.

    Examples
    --------
    >>> BangBangParams(deadband=0.1).amplitude
    0.122
    """

    amplitude: float = 0.122
    deadband: float = 0.0
    wheelbase: float = 3.0
    reference_offset: float | None = None
    max_steer: float = 1.22
    search_distance: float | None = None
    lost_distance: float | None = None

    def __post_init__(self) -> None:
        config_in_range(self, "amplitude", 0.0, 1.57)
        config_in_range(self, "deadband", 0.0, 1e6)
        check_body(self)


@dataclass(frozen=True, kw_only=True)
class BangBangState(TrackerState):
    """What `BangBang` remembers.

    Examples
    --------
    >>> BangBangState().steer
    0.0
    """


class BangBang(Tracker[BangBangParams, BangBangState]):
    """A fixed angle back towards the path: -amplitude sign(χ_e) outside the deadband, 0 inside.

    Parameters
    ----------
    path : Path
        The path to follow.
    params : BangBangParams, optional
        The parameters.
    actuator : Actuator, optional
        What lies between the commands and the wheels; nothing by default.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> law = BangBang(Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]))
    >>> law.steer(0.0, 0.5, 0.0, 5.0, 0.05)  # left of the path: steer right
    -0.122
    """

    def __init__(
        self,
        path: PathView,
        params: BangBangParams | None = None,
        *,
        actuator: Actuator | None = None,
    ) -> None:
        params = BangBangParams() if params is None else params
        super().__init__(path, params, params.wheelbase, actuator)

    def initial_state(self) -> BangBangState:
        """Return the state before the first step."""
        return BangBangState()

    def decide(self, vehicle: VehicleState, dt: float) -> Command:
        """Locate the vehicle on the path, aim, steer."""
        at = self._locate(self.state.waypoint, vehicle, dt)
        error = at.foot.cross_track_error()
        if error > self.params.deadband:
            wanted = -self.params.amplitude
        elif error < -self.params.deadband:
            wanted = self.params.amplitude
        else:
            wanted = 0.0
        steer, status = self._limit(wanted)
        self._state = replace(self.state, waypoint=at.foot.segment)
        return command(at, steer, at.foot.point, status)

    def check_state(self, state: BangBangState) -> BangBangState:
        """Return `state`, where it is one that this law could have on its path."""
        return replace(state, waypoint=check_waypoint(self.path, state.waypoint))
