"""POP: proximally optimal predictive control, the paper's Algorithm 1."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from popsteer.reference.error import config_count, config_in_range
from popsteer.reference.geometry import get_distance
from popsteer.reference.laws.law import Belief, Decision, Tracked, check_steer
from popsteer.reference.laws.search import SearchParams, find_lookahead
from popsteer.reference.math import PI, saturate
from popsteer.reference.tracker.state import TrackerState
from popsteer.reference.tracker.step import Tracker
from popsteer.reference.vehicle.bicycle import get_predicted_location
from popsteer.status import Status

if TYPE_CHECKING:
    from popsteer.reference.geometry import Point
    from popsteer.reference.path.follow import Located
    from popsteer.reference.vehicle import Vehicle

__all__ = ["Pop", "PopParams", "PopState"]

MAX_CANDIDATES = 100_001
"""The largest number of candidates."""


@dataclass(frozen=True, kw_only=True)
class PopParams(SearchParams):
    """Parameters of `Pop`; the paper's Table 1 by default.

    Attributes
    ----------
    lookahead_gain : float
        Velocity constant k_v [s]: ld = ld_min + k_v v.
    min_lookahead : float or None
        Lookahead at rest ld_min [m]; None is two wheelbases, the published code's 6 m at the
        paper's car. The paper gives none.
    steer_span : float
        Optimization range δ_nbd [rad]: candidates lie at most this far from the last angle.
    candidate_count : int
        Optimization resolution: the number of candidates, odd.
    exact_lookahead : bool
        Whether the lookahead point is the path's first crossing of the circle ahead of the
        vehicle, `get_crossing`, instead of what the paper's search finds.
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
    >>> PopParams(min_lookahead=5).min_lookahead
    5.0
    >>> PopParams(candidate_count=20)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: candidate_count must be odd and in [3, 100001], got 20
    """

    lookahead_gain: float = 0.2
    min_lookahead: float | None = None
    steer_span: float = 3.0 * (PI / 180.0)
    candidate_count: int = 21
    exact_lookahead: bool = True
    lookahead_tolerance: float | None = None
    window_ahead: float | None = None
    grid_spacing: float | None = None
    search_distance: float | None = None
    lost_distance: float | None = None

    def __post_init__(self) -> None:
        config_in_range(self, "steer_span", 1e-6, PI)
        config_count(self, "candidate_count", 3, MAX_CANDIDATES, odd=True)
        super().__post_init__()

    def _scaled(self, vehicle: Vehicle) -> dict[str, float]:
        """Return the defaults that scale with `vehicle`, by parameter."""
        return super()._scaled(vehicle) | {"min_lookahead": 2.0 * vehicle.wheelbase}


@dataclass(frozen=True, kw_only=True)
class PopState(TrackerState):
    """What `Pop` remembers beside what a `TrackerState` has.

    Attributes
    ----------
    previous_steer : float
        The last angle δ_prev [rad].

    Examples
    --------
    >>> PopState() == PopState(waypoint=None, steer=0.0, previous_steer=0.0)
    True
    """

    previous_steer: float = 0.0


class Pop(Tracker[PopParams, PopState]):
    """The POP controller: Algorithm 1.

    Of the angles in the neighbourhood of the last one, the angle whose predicted location lies
    closest to the lookahead point. With one-step point prediction the wheelbase does not enter;
    it only places the tracked point. The last angle is looked at first and wins ties, so a
    vehicle at rest, where every candidate predicts the same location, keeps its wheels still.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> controller = Pop(Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]))
    >>> round(controller.steer(0.0, 0.5, 0.0, 5.0, 0.05), 6)  # left of the path: steer right
    -0.05236
    >>> controller.state.waypoint
    0
    """

    TRACKED = Tracked.FRONT_AXLE
    PARAMS = PopParams
    STATE = PopState

    def decide(self, at: Located, belief: Belief) -> Decision:  # noqa: ARG002 - not needed here
        """Run Algorithm 1; the numbers are those of its lines."""
        speed = at.vehicle.forward_speed()
        previous_steer = at.mirror(self.state.previous_steer)
        # 2: ld = ld_min + k_v * v
        lookahead = self._resolved.min_lookahead + self._resolved.lookahead_gain * speed
        # 3: lp_i = get_lookahead_point_index(x, y, {w}, ld)
        # 4: lp = get_lookahead_point({w}, lp_i)
        target = find_lookahead(self.path, self._resolved, at, lookahead)
        # 1, 5 to 15: with the vehicle at the origin. Distances are the same there, and no digits
        # are lost far from it.
        lookahead_point = (target.point[0] - at.position[0], target.point[1] - at.position[1])
        steer = self._choose(lookahead_point, at.vehicle.yaw, speed, previous_steer, at.dt)
        # 16: delta_prev = delta
        self._state = replace(self.state, previous_steer=at.mirror(steer))
        status = Status.OK
        if abs(steer) >= self.vehicle.max_steer:
            status |= Status.SATURATED
        if not target.found:
            status |= Status.LOOKAHEAD_LOST
        return Decision(steer, target.point, status)

    def set_steer(self, state: PopState, steer: float) -> tuple[PopState, bool]:
        """Take note of the angle that the wheels were given: δ_prev."""
        return replace(state, previous_steer=steer), True

    def _choose(
        self, lookahead_point: Point, yaw: float, speed: float, previous_steer: float, dt: float
    ) -> float:
        """Optimize: lines 1 and 5 to 15 of Algorithm 1, with the vehicle at the origin."""
        x, y = 0.0, 0.0
        travel = speed * dt
        span = self.params.steer_span
        # The candidates' distances differ by about travel * span²; below the rounding of the
        # distances themselves their order is noise, and following it would wind the wheels up.
        lookahead_range = get_distance((x, y), lookahead_point)
        if travel * span * span <= 16.0 * sys.float_info.epsilon * lookahead_range:
            return previous_steer

        def get_distance_after(steer: float) -> float:
            # 9: V_pred = get_predicted_location(x, y, theta, v, delta_list[k])
            predicted = get_predicted_location(x, y, yaw, speed, steer, dt)
            # 11: dist = get_distance(V_pred, lp)
            return get_distance(predicted, lookahead_point)

        # 1: delta_list += delta_prev
        steer_list = [
            self._candidate(previous_steer, k) for k in range(self.params.candidate_count)
        ]
        # 6: delta = delta_prev
        steer = previous_steer
        # 5: min dist <- infinity; here the distance that delta_prev leads to, so that it wins ties
        min_distance = get_distance_after(steer)
        # 7: for k <- 1 to len(delta_list)
        for candidate in steer_list:
            # 9, 11: dist = get_distance(get_predicted_location(..., delta_list[k]), lp)
            distance = get_distance_after(candidate)
            # 13: if dist < min dist
            if distance < min_distance:
                # 14: delta = delta_list[k]
                steer = candidate
                # 15: min dist = dist
                min_distance = distance
        return steer

    def _candidate(self, previous_steer: float, k: int) -> float:
        """Return entry k of δ_list: evenly over δ_prev ± δ_nbd, within ±δ_max."""
        half = self.params.candidate_count // 2
        offset = self.params.steer_span * ((k - half) / half)
        max_steer = self.vehicle.max_steer
        return saturate(previous_steer + offset, -max_steer, max_steer)

    def check_law_state(self, state: PopState) -> PopState:
        """Return `state`, where what is remembered in it is what this controller could remember."""
        max_steer = self.vehicle.max_steer
        previous_steer = check_steer("previous_steer", state.previous_steer, max_steer)
        return replace(state, previous_steer=previous_steer)
