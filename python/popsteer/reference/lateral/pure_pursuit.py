"""Adaptive Pure-Pursuit, the paper's Equation 2."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import copysign
from typing import TYPE_CHECKING

from popsteer.reference.lateral import (
    Command,
    check_body,
    check_search,
    check_steer,
    check_waypoint,
    command,
    find,
)
from popsteer.reference.lateral.tracker import Tracker, TrackerState
from popsteer.reference.math import PI, acos, atan2, divide, sin
from popsteer.reference.path.view import get_distance
from popsteer.status import Status

if TYPE_CHECKING:
    from popsteer.reference.path.view import PathView
    from popsteer.reference.vehicle.actuator import Actuator
    from popsteer.reference.vehicle.state import VehicleState

__all__ = ["PurePursuit", "PurePursuitParams", "PurePursuitState"]


@dataclass(frozen=True, kw_only=True)
class PurePursuitParams:
    """Parameters of `PurePursuit`; the paper's Table 1, and the published code's least lookahead.

    Attributes
    ----------
    lookahead_gain : float
        Velocity constant k_v [s]: ld = max(ld_min, k_v v).
    min_lookahead : float
        Least lookahead ld_min [m]; the published code's 10 m, the paper's equation has 0.
    alpha_by_arccos : bool
        Whether α is taken as the published code does, acos(heading · line / ld), instead of as
        the angle between heading and line. The grid point lies up to ε inside the circle, so
        that reading never sees less than about √(2 ε / ld): the wheels chatter about straight
        ahead, and the path is tracked more tightly.
    exact_lookahead : bool
        Whether the lookahead point is the path's first crossing of the circle ahead of the
        vehicle, `get_crossing`, instead of what the paper's search finds; with it, a point behind
        the vehicle is turned to as one abeam.
    lookahead_tolerance : float
        Threshold ε of the paper's search [m].
    window_ahead : float
        Arc ahead of the vehicle that the paper's search looks at [m].
    grid_spacing : float
        Greatest distance of neighbours on the path as the paper's search re-discretises it [m].
    wheelbase : float
        Distance of the axles L [m].
    reference_offset : float or None
        Reference point ahead of the rear axle [m]; None is the rear axle, 0.
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
    >>> PurePursuitParams(wheelbase=2.5).wheelbase
    2.5
    """

    lookahead_gain: float = 0.9
    min_lookahead: float = 10.0
    alpha_by_arccos: bool = False
    exact_lookahead: bool = True
    lookahead_tolerance: float = 0.01
    window_ahead: float = 20.0
    grid_spacing: float = 0.01
    wheelbase: float = 3.0
    reference_offset: float | None = None
    max_steer: float = 1.22
    search_distance: float | None = None
    lost_distance: float | None = None

    def __post_init__(self) -> None:
        check_search(self)
        check_body(self)


@dataclass(frozen=True, kw_only=True)
class PurePursuitState(TrackerState):
    """What `PurePursuit` remembers beside what a `TrackerState` has.

    Attributes
    ----------
    previous_alpha : float
        The last bearing α [rad], which stands in where its arc cosine is not defined; 0 without
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

    Parameters
    ----------
    path : Path
        The path to follow.
    params : PurePursuitParams, optional
        The parameters.
    actuator : Actuator, optional
        What lies between the commands and the wheels; nothing by default.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> law = PurePursuit(Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]))
    >>> round(law.steer(0.0, 0.5, 0.0, 5.0, 0.05), 6)  # left of the path: steer right
    -0.029991
    """

    def __init__(
        self,
        path: PathView,
        params: PurePursuitParams | None = None,
        *,
        actuator: Actuator | None = None,
    ) -> None:
        params = PurePursuitParams() if params is None else params
        super().__init__(path, params, 0.0, actuator)

    def initial_state(self) -> PurePursuitState:
        """Return the state before the first step."""
        return PurePursuitState()

    def decide(self, vehicle: VehicleState, dt: float) -> Command:
        """Locate the vehicle on the path, aim, steer."""
        at = self._locate(self.state.waypoint, vehicle, dt)
        scheduled = self.params.lookahead_gain * at.vehicle.forward_speed()
        if scheduled > self.params.min_lookahead:
            lookahead = scheduled
        else:
            lookahead = self.params.min_lookahead
        # -0.0, a lookahead of nothing on the other side, becomes 0.0.
        lookahead = lookahead + 0.0
        target = find(self.path, at, lookahead, self.params)
        to = (target.point[0] - at.position[0], target.point[1] - at.position[1])
        cosine, sine = at.heading
        ahead = to[0] * cosine + to[1] * sine
        left = to[1] * cosine - to[0] * sine
        # atan2 is the equation's atan, and defined where the paper's lookahead vanishes at rest.
        alpha = self.state.previous_alpha
        if self.params.alpha_by_arccos:
            alpha = _alpha_by_arccos(ahead, left, lookahead, alpha)
            wanted = atan2(2.0 * self.params.wheelbase * sin(alpha), lookahead)
        else:
            # sin(alpha) is left / distance, with the distance on the other side.
            distance = get_distance(at.position, target.point)
            # Towards a point behind the circle would lead away from it, straight behind for good.
            behind = self.params.exact_lookahead and ahead < 0.0
            aside = copysign(distance, left) if behind else left
            wanted = atan2(2.0 * self.params.wheelbase * aside, lookahead * distance)
        steer, status = self._limit(wanted)
        self._state = replace(self.state, waypoint=at.foot.segment, previous_alpha=alpha)
        if not target.found:
            status = Status.LOOKAHEAD_LOST
        return command(at, steer, target.point, status)

    def check_state(self, state: PurePursuitState) -> PurePursuitState:
        """Return `state`, where it is one that this law could have on its path."""
        return replace(
            state,
            waypoint=check_waypoint(self.path, state.waypoint),
            previous_alpha=check_steer("previous_alpha", state.previous_alpha, PI),
        )


def _alpha_by_arccos(ahead: float, left: float, lookahead: float, previous: float) -> float:
    """Bearing α of a point `ahead` and to the `left` [m] as the published code takes it, signed.

    `previous` where the point lies outside the circle straight ahead, and the arc cosine is not
    defined.
    """
    cosine = divide(ahead, lookahead)
    if abs(cosine) <= 1.0:
        return copysign(acos(cosine), left)
    return previous
