"""The Stanley law, the paper's Equation 3."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from popsteer.reference.error import config_in_range
from popsteer.reference.lateral import Command, check_body, check_waypoint, command
from popsteer.reference.lateral.tracker import Tracker, TrackerState
from popsteer.reference.math import atan, wrap
from popsteer.reference.path.locate import path_yaw_behind

if TYPE_CHECKING:
    from popsteer.reference.path.view import PathView
    from popsteer.reference.vehicle.actuator import Actuator
    from popsteer.reference.vehicle.state import VehicleState

__all__ = ["Stanley", "StanleyParams", "StanleyState"]


@dataclass(frozen=True, kw_only=True)
class StanleyParams:
    """Parameters of `Stanley`; the paper's Table 1 by default.

    Attributes
    ----------
    cross_track_gain : float
        Crosstrack error constant k_χ [1/s].
    speed_gain : float
        Velocity constant k_v.
    softening : float
        Softening constant k_s [m/s], which keeps the quotient finite at rest.
    heading_behind : bool
        Whether the path's heading is that of the segment behind the nearest waypoint, as in the
        published code, instead of that at the foot.
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
    >>> StanleyParams(softening=0.0)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: softening must be in [1e-09, 1e+06], got 0.0
    """

    cross_track_gain: float = 1.5
    speed_gain: float = 1.3
    softening: float = 1e-5
    heading_behind: bool = False
    wheelbase: float = 3.0
    reference_offset: float | None = None
    max_steer: float = 1.22
    search_distance: float | None = None
    lost_distance: float | None = None

    def __post_init__(self) -> None:
        config_in_range(self, "cross_track_gain", 0.0, 1e6)
        config_in_range(self, "speed_gain", 0.0, 1e6)
        config_in_range(self, "softening", 1e-9, 1e6)
        check_body(self)


@dataclass(frozen=True, kw_only=True)
class StanleyState(TrackerState):
    """What `Stanley` remembers.

    Examples
    --------
    >>> StanleyState().steer
    0.0
    """


class Stanley(Tracker[StanleyParams, StanleyState]):
    """Heading and cross-track error at the front axle: Equation 3.

    δ = -(ψ_e + atan(k_χ χ_e / (k_s + k_v v))), limited to ±δ_max. The signs are those of this
    package's errors, positive to the left; the paper's are the opposite.

    Parameters
    ----------
    path : Path
        The path to follow.
    params : StanleyParams, optional
        The parameters; the paper's without.
    actuator : Actuator, optional
        What lies between the commands and the wheels; nothing by default.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> law = Stanley(Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]))
    >>> round(law.steer(0.0, 0.5, 0.0, 5.0, 0.05), 6)  # left of the path: steer right
    -0.114876
    """

    def __init__(
        self,
        path: PathView,
        params: StanleyParams | None = None,
        *,
        actuator: Actuator | None = None,
    ) -> None:
        params = StanleyParams() if params is None else params
        super().__init__(path, params, params.wheelbase, actuator)

    def initial_state(self) -> StanleyState:
        """Return the state before the first step."""
        return StanleyState()

    def decide(self, vehicle: VehicleState, dt: float) -> Command:
        """Locate the vehicle on the path, aim, steer."""
        at = self._locate(self.state.waypoint, vehicle, dt)
        softened = self.params.softening + self.params.speed_gain * at.vehicle.forward_speed()
        pull = atan(self.params.cross_track_gain * at.foot.cross_track_error() / softened)
        if self.params.heading_behind:
            path_yaw = path_yaw_behind(self.path, at.foot.nearest_waypoint(self.path))
        else:
            path_yaw = at.foot.path_yaw()
        heading_error = wrap(at.vehicle.yaw - path_yaw)
        steer, status = self._limit(-(heading_error + pull))
        self._state = replace(self.state, waypoint=at.foot.segment)
        return command(at, steer, at.foot.point, status)

    def check_state(self, state: StanleyState) -> StanleyState:
        """Return `state`, where it is one that this law could have on its path."""
        return replace(state, waypoint=check_waypoint(self.path, state.waypoint))
