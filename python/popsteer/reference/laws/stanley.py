"""The Stanley controller, the paper's Equation 3."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from popsteer.reference.error import config_in_range, config_optional
from popsteer.reference.laws.law import Belief, Decision, Params, Tracked, limit_steer
from popsteer.reference.math import atan, wrap
from popsteer.reference.path.preview import Preview
from popsteer.reference.path.projection import path_yaw_behind
from popsteer.reference.tracker.state import TrackerState
from popsteer.reference.tracker.step import Tracker

if TYPE_CHECKING:
    from popsteer.reference.path.follow import Located
    from popsteer.reference.vehicle import Vehicle

__all__ = ["Stanley", "StanleyParams", "StanleyState"]


@dataclass(frozen=True, kw_only=True)
class StanleyParams(Params):
    """Parameters of `Stanley`; the paper's Table 1 by default.

    Attributes
    ----------
    cross_track_gain : float
        Crosstrack error constant k_χ [1/s].
    speed_gain : float
        Velocity constant k_v.
    softening : float or None
        Softening constant k_s [m/s], which keeps the quotient finite at rest; None is 1e-5 at the
        paper's wheelbase, in proportion at others.
    heading_behind : bool
        Whether the path's heading is that of the segment behind the nearest waypoint, as in the
        published code, instead of that at the projection.
    smoothing_length : float or None
        Length of path over which its heading is taken [m]; None is a wheelbase. More: less of the
        waypoints' noise is steered, and bends shorter than this are cut. 0, or `heading_behind`:
        the heading of one segment, as printed.
    search_distance : float or None
        Arc of the path that is searched on each side of the last projection [m], in addition to the
        distance travelled in a step; None is two wheelbases.
    lost_distance : float or None
        Distance from the path beyond which the vehicle is lost and is searched for on the whole
        path [m]; None is ten wheelbases.

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
    softening: float | None = None
    heading_behind: bool = False
    smoothing_length: float | None = None
    search_distance: float | None = None
    lost_distance: float | None = None

    def __post_init__(self) -> None:
        config_in_range(self, "cross_track_gain", 0.0, 1e6)
        config_in_range(self, "speed_gain", 0.0, 1e6)
        config_optional(self, "softening", 1e-9, 1e6)
        config_optional(self, "smoothing_length", 0.0, 1e4)
        super().__post_init__()

    def _scaled(self, vehicle: Vehicle) -> dict[str, float]:
        """Return the defaults that scale with `vehicle`, by parameter."""
        return super()._scaled(vehicle) | {
            "softening": 1e-5 / 3.0 * vehicle.wheelbase,
            "smoothing_length": vehicle.wheelbase,
        }


@dataclass(frozen=True, kw_only=True)
class StanleyState(TrackerState):
    """What `Stanley` remembers: what a `TrackerState` has.

    Examples
    --------
    >>> StanleyState().steer
    0.0
    """


class Stanley(Tracker[StanleyParams, StanleyState]):
    """Heading and cross-track error at the front axle: Equation 3.

    δ = -(ψ_e + atan(k_χ χ_e / (k_s + k_v v))), limited to ±δ_max. The signs are those of this
    package's errors, positive to the left; the paper's are the opposite.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> controller = Stanley(Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]))
    >>> round(controller.steer(0.0, 0.5, 0.0, 5.0, 0.05), 6)  # left of the path: steer right
    -0.114876
    """

    TRACKED = Tracked.FRONT_AXLE
    PARAMS = StanleyParams
    STATE = StanleyState

    def decide(self, at: Located, belief: Belief) -> Decision:  # noqa: ARG002 - not needed here
        """Decide the angle for a located vehicle."""
        params = self._resolved
        speed = params.softening + params.speed_gain * at.vehicle.forward_speed()
        pull = atan(params.cross_track_gain * at.closest.cross_track_error() / speed)
        if params.heading_behind:
            path_yaw = path_yaw_behind(self.path, at.closest.nearest_waypoint(self.path))
        elif params.smoothing_length > 0.0:
            arc_length = at.closest.arc_length(self.path)
            smoothing = params.smoothing_length
            path_yaw = Preview.yaw_at(self.path, smoothing, at.closest.segment, arc_length)
        else:
            path_yaw = at.closest.path_yaw()
        heading_error = wrap(at.vehicle.yaw - path_yaw)
        steer, status = limit_steer(self.vehicle, -(heading_error + pull))
        return Decision(steer, at.closest.point, status)
