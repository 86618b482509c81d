"""Adaptive Pure-Pursuit, the paper's Equation 2."""

from __future__ import annotations

from dataclasses import dataclass
from math import copysign
from typing import TYPE_CHECKING

from popsteer.reference.error import number, optional
from popsteer.reference.geometry import get_distance
from popsteer.reference.laws.law import Belief, Decision, LateralLaw, Tracked, limit_steer
from popsteer.reference.laws.search import SearchParams, find_lookahead
from popsteer.reference.math import acos, atan2, divide, sin
from popsteer.status import Status

if TYPE_CHECKING:
    from popsteer.reference.path.follow import Located
    from popsteer.reference.path.view import PathView


@dataclass(frozen=True, kw_only=True)
class PurePursuitParams(SearchParams):
    """Parameters of `PurePursuit`; the paper's Table 1, and the published code's least lookahead.

    See `popsteer.PurePursuitParams`.
    """

    lookahead_gain: float = number(0.9, 0.0, 1e3)  # k_v [s]: ld = max(ld_min, k_v v)
    # ld_min [m]
    min_lookahead: float | None = optional(0.0, 1e4, scaled=lambda car: 10.0 / 3.0 * car.wheelbase)
    alpha_by_arccos: bool = False  # α as the published code takes it


@dataclass
class PurePursuitState:
    """What `PurePursuit` remembers."""

    previous_alpha: float = 0.0
    """The last bearing α [rad], the substitute where its arc cosine is not defined; 0 without
    `alpha_by_arccos`."""


class PurePursuit(LateralLaw[PurePursuitParams, PurePursuitState]):
    """The circle from the rear axle through the lookahead point: Equation 2.

    δ = atan(2 L sin α / ld), limited to ±δ_max, with α the bearing of the lookahead point off
    the heading and ld = max(ld_min, k_v v).

    Examples
    --------
    >>> from popsteer.reference import Path, Tracker
    >>> tracker = Tracker(PurePursuit(), Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]))
    >>> round(tracker.steer(0.0, 0.5, 0.0, 5.0, 0.05), 6)  # left of the path: steer right
    -0.029991
    """

    TRACKED = Tracked.REAR_AXLE
    PARAMS = PurePursuitParams
    STATE = PurePursuitState

    def decide(
        self,
        path: PathView,
        state: PurePursuitState,
        at: Located,
        belief: Belief,  # noqa: ARG002 - not needed here
    ) -> Decision:
        """Decide the angle for a located vehicle."""
        wheelbase, params = self.vehicle.wheelbase, self.resolved
        scheduled = params.lookahead_gain * at.vehicle.forward_speed()
        lookahead = scheduled if scheduled > params.min_lookahead else params.min_lookahead
        # -0.0, a lookahead of nothing on the other side, becomes 0.0.
        lookahead = lookahead + 0.0
        target = find_lookahead(path, params, at, lookahead)
        to = (target.point[0] - at.position[0], target.point[1] - at.position[1])
        cosine, sine = at.heading
        ahead = to[0] * cosine + to[1] * sine
        left = to[1] * cosine - to[0] * sine
        # atan2 is the equation's atan, and defined where the paper's lookahead vanishes at rest.
        if params.alpha_by_arccos:
            alpha = _alpha_by_arccos(ahead, left, lookahead, state.previous_alpha)
            state.previous_alpha = alpha
            wanted = atan2(2.0 * wheelbase * sin(alpha), lookahead)
        else:
            # sin(alpha) is left / distance, with the distance on the other side.
            distance = get_distance(at.position, target.point)
            # Towards a point behind the circle would lead away from it, straight behind for good.
            behind = params.exact_lookahead and ahead < 0.0
            aside = copysign(distance, left) if behind else left
            # A substitute nearer than the lookahead has a circle of its own.
            nearer = params.exact_lookahead and not target.found and distance < lookahead
            reach = distance if nearer else lookahead
            wanted = atan2(2.0 * wheelbase * aside, reach * distance)
        steer, status = limit_steer(self.vehicle, wanted)
        if not target.found:
            status |= Status.LOOKAHEAD_LOST
        return Decision(steer, target.point, status)


def _alpha_by_arccos(ahead: float, left: float, lookahead: float, previous: float) -> float:
    """Bearing α of a point `ahead` and to the `left` [m] as the published code takes it, signed.

    acos(heading · line / ld), and `previous` where the point lies outside the circle straight
    ahead, and the arc cosine is not defined.
    """
    cosine = divide(ahead, lookahead)
    if abs(cosine) <= 1.0:
        return copysign(acos(cosine), left)
    return previous
