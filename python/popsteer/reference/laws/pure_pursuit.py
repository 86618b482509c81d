"""Adaptive Pure-Pursuit, the paper's Equation 2."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import copysign
from typing import TYPE_CHECKING

from popsteer.reference.geometry import get_distance
from popsteer.reference.laws.law import Belief, Decision, Tracked, check_steer, limit_steer
from popsteer.reference.laws.search import SearchParams, find_lookahead
from popsteer.reference.math import PI, acos, atan2, divide, sin
from popsteer.reference.tracker.state import TrackerState
from popsteer.reference.tracker.step import Tracker
from popsteer.status import Status

if TYPE_CHECKING:
    from popsteer.reference.path.follow import Located
    from popsteer.reference.vehicle import Vehicle

__all__ = ["PurePursuit", "PurePursuitParams", "PurePursuitState"]


@dataclass(frozen=True, kw_only=True)
class PurePursuitParams(SearchParams):
    """Parameters of `PurePursuit`; the paper's Table 1, and the published code's least lookahead.

    Attributes
    ----------
    lookahead_gain : float
        Velocity constant k_v [s]: ld = max(ld_min, k_v v).
    min_lookahead : float or None
        Least lookahead ld_min [m]; None is 10/3 wheelbases, the published code's 10 m at the
        paper's car. The paper's equation has 0.
    alpha_by_arccos : bool
        Whether α is taken as the published code does, acos(heading · line / ld), instead of as
        the angle between heading and line. The grid point lies up to ε inside the circle, so
        that reading never sees less than about √(2 ε / ld): the wheels chatter about straight
        ahead, and the path is tracked more tightly.
    exact_lookahead : bool
        Whether the lookahead point is the path's first crossing of the circle ahead of the
        vehicle, `get_crossing`, instead of what the paper's search finds; with it, a point behind
        the vehicle is turned to as one abeam.
    lookahead_tolerance : float or None
        Threshold ε of the paper's search [m]; None is 1/300 of the wheelbase.
    window_ahead : float or None
        Arc ahead of the vehicle that the paper's search looks at [m]; None is 20/3 wheelbases.
    grid_spacing : float or None
        Greatest distance of neighbours on the path as the paper's search re-discretises it [m];
        None is 1/300 of the wheelbase.
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
    >>> PurePursuitParams(min_lookahead=5).min_lookahead
    5.0
    """

    lookahead_gain: float = 0.9
    min_lookahead: float | None = None
    alpha_by_arccos: bool = False
    exact_lookahead: bool = True
    lookahead_tolerance: float | None = None
    window_ahead: float | None = None
    grid_spacing: float | None = None
    search_distance: float | None = None
    lost_distance: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()

    def _scaled(self, vehicle: Vehicle) -> dict[str, float]:
        """Return the defaults that scale with `vehicle`, by parameter."""
        return super()._scaled(vehicle) | {"min_lookahead": 10.0 / 3.0 * vehicle.wheelbase}


@dataclass(frozen=True, kw_only=True)
class PurePursuitState(TrackerState):
    """What `PurePursuit` remembers beside what a `TrackerState` has.

    Attributes
    ----------
    previous_alpha : float
        The last bearing α [rad], the substitute where its arc cosine is not defined; 0 without
        `alpha_by_arccos`.

    Examples
    --------
    >>> PurePursuitState().previous_alpha
    0.0
    """

    previous_alpha: float = 0.0


class PurePursuit(Tracker[PurePursuitParams, PurePursuitState]):
    """The circle from the rear axle through the lookahead point: Equation 2.

    δ = atan(2 L sin α / ld), limited to ±δ_max, with α the bearing of the lookahead point off
    the heading and ld = max(ld_min, k_v v).

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> controller = PurePursuit(Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]))
    >>> round(controller.steer(0.0, 0.5, 0.0, 5.0, 0.05), 6)  # left of the path: steer right
    -0.029991
    """

    TRACKED = Tracked.REAR_AXLE
    PARAMS = PurePursuitParams
    STATE = PurePursuitState

    def decide(self, at: Located, belief: Belief) -> Decision:  # noqa: ARG002 - not needed here
        """Decide the angle for a located vehicle."""
        wheelbase, params = self.vehicle.wheelbase, self._resolved
        scheduled = params.lookahead_gain * at.vehicle.forward_speed()
        lookahead = scheduled if scheduled > params.min_lookahead else params.min_lookahead
        # -0.0, a lookahead of nothing on the other side, becomes 0.0.
        lookahead = lookahead + 0.0
        target = find_lookahead(self.path, params, at, lookahead)
        to = (target.point[0] - at.position[0], target.point[1] - at.position[1])
        cosine, sine = at.heading
        ahead = to[0] * cosine + to[1] * sine
        left = to[1] * cosine - to[0] * sine
        # atan2 is the equation's atan, and defined where the paper's lookahead vanishes at rest.
        if params.alpha_by_arccos:
            alpha = _alpha_by_arccos(ahead, left, lookahead, self.state.previous_alpha)
            self._state = replace(self.state, previous_alpha=alpha)
            wanted = atan2(2.0 * wheelbase * sin(alpha), lookahead)
        else:
            # sin(alpha) is left / distance, with the distance on the other side.
            distance = get_distance(at.position, target.point)
            # Towards a point behind the circle would lead away from it, straight behind for good.
            behind = params.exact_lookahead and ahead < 0.0
            aside = copysign(distance, left) if behind else left
            wanted = atan2(2.0 * wheelbase * aside, lookahead * distance)
        steer, status = limit_steer(self.vehicle, wanted)
        if not target.found:
            status |= Status.LOOKAHEAD_LOST
        return Decision(steer, target.point, status)

    def check_law_state(self, state: PurePursuitState) -> PurePursuitState:
        """Return `state`, where what is remembered in it is what this controller could remember."""
        alpha = check_steer("previous_alpha", state.previous_alpha, PI)
        return replace(state, previous_alpha=alpha)


def _alpha_by_arccos(ahead: float, left: float, lookahead: float, previous: float) -> float:
    """Bearing α of a point `ahead` and to the `left` [m] as the published code takes it, signed.

    `previous` where the point lies outside the circle straight ahead, and the arc cosine is not
    defined.
    """
    cosine = divide(ahead, lookahead)
    if abs(cosine) <= 1.0:
        return copysign(acos(cosine), left)
    return previous
