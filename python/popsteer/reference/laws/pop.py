"""POP: proximally optimal predictive control, the paper's Algorithm 1."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING

from popsteer.reference.error import count, number, optional
from popsteer.reference.geometry import Point, get_distance
from popsteer.reference.laws.law import Belief, Decision, LateralLaw, Tracked
from popsteer.reference.laws.search import SearchParams, find_lookahead
from popsteer.reference.math import PI, divide, saturate
from popsteer.reference.vehicle.bicycle import get_predicted_location
from popsteer.status import Status

if TYPE_CHECKING:
    from popsteer.reference.path.follow import Located
    from popsteer.reference.path.view import PathView


@dataclass(frozen=True, kw_only=True)
class PopParams(SearchParams):
    """Parameters of `Pop`; the paper's Table 1 by default. See `popsteer.PopParams`.

    Examples
    --------
    >>> PopParams(candidate_count=20)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: candidate_count must be odd and in [3, 100001], got 20
    """

    lookahead_gain: float = number(0.2, 0.0, 1e3)  # k_v [s]: ld = ld_min + k_v v
    steer_span: float = number(3.0 * (PI / 180.0), 1e-6, PI)  # optimization range δ_nbd [rad]
    candidate_count: int = count(21, 3, 100_001, odd=True)  # optimization resolution
    # ld_min [m]
    min_lookahead: float | None = optional(0.0, 1e4, scaled=lambda car: 2.0 * car.wheelbase)


@dataclass
class PopState:
    """What `Pop` remembers."""

    previous_steer: float = 0.0
    """The last angle δ_prev [rad]."""


class Pop(LateralLaw[PopParams, PopState]):
    """The POP controller: Algorithm 1.

    Of the angles in the neighbourhood of the last one, the angle whose predicted location lies
    closest to the lookahead point. With one-step point prediction the wheelbase does not enter;
    it only places the tracked point. The last angle is looked at first and wins ties, so a
    vehicle at rest, where every candidate predicts the same location, keeps its wheels still.

    Examples
    --------
    >>> from popsteer.reference import Path, Tracker
    >>> tracker = Tracker(Pop(), Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]))
    >>> round(tracker.steer(0.0, 0.5, 0.0, 5.0, 0.05), 6)  # left of the path: steer right
    -0.05236
    """

    TRACKED = Tracked.FRONT_AXLE
    PARAMS = PopParams
    STATE = PopState

    def decide(self, path: PathView, state: PopState, at: Located, belief: Belief) -> Decision:  # noqa: ARG002 - not needed here
        """Run Algorithm 1; the numbers are those of its lines."""
        speed = at.vehicle.forward_speed()
        previous_steer = at.mirror(state.previous_steer)
        # 2: ld = ld_min + k_v * v
        lookahead = self._lookahead(at)
        # 3: lp_i = get_lookahead_point_index(x, y, {w}, ld)
        # 4: lp = get_lookahead_point({w}, lp_i)
        target = find_lookahead(path, self.resolved, at, lookahead)
        # 1, 5 to 15: with the vehicle at the origin. Distances are the same there, and no digits
        # are lost far from it.
        lookahead_point = (target.point[0] - at.position[0], target.point[1] - at.position[1])
        steer = self._choose(lookahead_point, at.vehicle.yaw, speed, previous_steer, at.dt)
        # 16: delta_prev = delta
        state.previous_steer = at.mirror(steer)
        status = Status.OK
        if abs(steer) >= self.vehicle.max_steer:
            status |= Status.SATURATED | Status.STEER_LIMIT
        if not target.found:
            status |= Status.LOOKAHEAD_LOST
        return Decision(steer, target.point, status)

    def pull(self, at: Located) -> float:
        """Return the bearing of the lookahead point for a vehicle along the path."""
        return divide(at.closest.cross_track_error(), self._lookahead(at))

    def _lookahead(self, at: Located) -> float:
        """Return ld [m]."""
        found = self.resolved
        return float(found.min_lookahead + found.lookahead_gain * at.vehicle.forward_speed())

    def set_steer(self, state: PopState, steer: float) -> None:
        """Note the angle that the wheels got: δ_prev."""
        state.previous_steer = steer

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
