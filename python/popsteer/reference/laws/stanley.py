"""The Stanley controller, the paper's Equation 3."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from popsteer.reference.error import number, optional
from popsteer.reference.laws.law import Belief, Decision, LateralLaw, Params, Tracked, limit_steer
from popsteer.reference.math import atan, wrap
from popsteer.reference.path.preview import Preview
from popsteer.reference.path.projection import path_yaw_behind

if TYPE_CHECKING:
    from popsteer.reference.path.follow import Located
    from popsteer.reference.path.view import PathView


@dataclass(frozen=True, kw_only=True)
class StanleyParams(Params):
    """Parameters of `Stanley`; the paper's Table 1 by default. See `popsteer.StanleyParams`."""

    cross_track_gain: float = number(1.5, 0.0, 1e6)  # k_χ [1/s]
    speed_gain: float = number(1.3, 0.0, 1e6)  # k_v
    # k_s [m/s]
    softening: float | None = optional(1e-9, 1e6, scaled=lambda car: 1.0 / 3.0 * car.wheelbase)
    heading_behind: bool = False  # the path's heading behind the nearest waypoint
    # of the path's heading [m]
    smoothing_length: float | None = optional(0.0, 1e4, scaled=lambda car: car.wheelbase)


@dataclass
class StanleyState:
    """What `Stanley` remembers: nothing."""


class Stanley(LateralLaw[StanleyParams, StanleyState]):
    """Heading and cross-track error at the front axle: Equation 3.

    δ = -(ψ_e + atan(k_χ χ_e / (k_s + k_v v))), limited to ±δ_max. The signs are those of this
    package's errors, positive to the left; the paper's are the opposite.

    Examples
    --------
    >>> from popsteer.reference import Path, Tracker
    >>> tracker = Tracker(Stanley(), Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]))
    >>> round(tracker.steer(0.0, 0.5, 0.0, 5.0, 0.05), 6)  # left of the path: steer right
    -0.099669
    """

    TRACKED = Tracked.FRONT_AXLE
    PARAMS = StanleyParams
    STATE = StanleyState

    def pull(self, at: Located) -> float:
        """Return the second term of the equation."""
        params = self.resolved
        speed = params.softening + params.speed_gain * at.vehicle.forward_speed()
        return atan(params.cross_track_gain * at.closest.cross_track_error() / speed)

    def decide(self, path: PathView, state: StanleyState, at: Located, belief: Belief) -> Decision:  # noqa: ARG002 - not needed here
        """Decide the angle for a located vehicle."""
        params, pull = self.resolved, self.pull(at)
        if params.heading_behind:
            path_yaw = path_yaw_behind(path, at.closest.nearest_waypoint(path))
        elif params.smoothing_length > 0.0:
            arc_length = at.closest.arc_length(path)
            path_yaw = Preview.yaw_at(path, params.smoothing_length, at.closest.segment, arc_length)
        else:
            path_yaw = at.closest.path_yaw()
        heading_error = wrap(at.vehicle.yaw - path_yaw)
        steer, status = limit_steer(self.vehicle, -(heading_error + pull))
        return Decision(steer, at.closest.point, status)
