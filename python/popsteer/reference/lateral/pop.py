"""POP: proximally optimal predictive control, the paper's Algorithm 1."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from popsteer.reference.error import config_in_range, config_odd
from popsteer.reference.lateral import (
    Command,
    check_body,
    check_search,
    check_steer,
    check_waypoint,
    command,
    find,
)
from popsteer.reference.lateral.rollout import Model, Rollout
from popsteer.reference.lateral.tracker import Tracker, TrackerState
from popsteer.reference.math import PI, saturate
from popsteer.reference.path.view import get_distance
from popsteer.reference.vehicle.predict import get_predicted_location
from popsteer.status import Status

if TYPE_CHECKING:
    from collections.abc import Callable

    from popsteer.reference.path.view import PathView, Point
    from popsteer.reference.vehicle.actuator import Actuator
    from popsteer.reference.vehicle.state import VehicleState

__all__ = ["Pop", "PopParams", "PopState"]

MAX_CANDIDATES = 100_001
"""The largest number of candidates."""


@dataclass(frozen=True, kw_only=True)
class PopParams:
    """Parameters of `Pop`; the paper's Table 1 by default.

    Attributes
    ----------
    lookahead_gain : float
        Velocity constant k_v [s]: ld = ld_min + k_v v.
    min_lookahead : float
        Lookahead at rest ld_min [m]; the published code's 6 m, the paper gives none.
    steer_span : float
        Optimization range δ_nbd [rad]: candidates lie at most this far from the last angle.
    candidate_count : int
        Optimization resolution: the number of candidates, odd.
    exact_lookahead : bool
        Whether the lookahead point is the path's first crossing of the circle ahead of the
        vehicle, `get_crossing`, instead of what the paper's search finds.
    lookahead_tolerance : float
        Threshold ε of the paper's search [m].
    window_ahead : float
        Arc ahead of the vehicle that the paper's search looks at [m].
    grid_spacing : float
        Greatest distance of neighbours on the path as the paper's search re-discretises it [m].
    horizon : float or None
        How long a prediction by the kinematic bicycle with steering lag looks ahead [s]; None for
        the paper's, a point over one step. The vehicle should come about as far as the lookahead
        in it: where it does not, the law swings.
    understeer : float
        With a horizon, the understeer of the bicycle [s²/m]:
        yaw rate = v tan δ / (wheelbase + understeer v²).
    steer_lag : float
        With a horizon, the time constant with which the wheels follow their command [s].
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
    >>> PopParams(min_lookahead=5).min_lookahead
    5.0
    >>> PopParams(candidate_count=20)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: candidate_count must be odd and in [3, 100001], got 20
    """

    lookahead_gain: float = 0.2
    min_lookahead: float = 6.0
    steer_span: float = 3.0 * (PI / 180.0)
    candidate_count: int = 21
    exact_lookahead: bool = True
    lookahead_tolerance: float = 0.01
    window_ahead: float = 20.0
    grid_spacing: float = 0.01
    horizon: float | None = None
    understeer: float = 0.0
    steer_lag: float = 0.1
    wheelbase: float = 3.0
    reference_offset: float | None = None
    max_steer: float = 1.22
    search_distance: float | None = None
    lost_distance: float | None = None

    def __post_init__(self) -> None:
        check_search(self)
        config_in_range(self, "steer_span", 1e-6, PI)
        config_odd(self, "candidate_count", 3, MAX_CANDIDATES)
        check_body(self)
        if self.horizon is not None:
            config_in_range(self, "horizon", 1e-3, 100.0)
        config_in_range(self, "understeer", 0.0, 1e3)
        config_in_range(self, "steer_lag", 0.0, 10.0)


@dataclass(frozen=True, kw_only=True)
class PopState(TrackerState):
    """What `Pop` remembers beside what a `TrackerState` has.

    Attributes
    ----------
    previous_steer : float
        The last angle δ_prev [rad].
    model_steer : float
        With a horizon, the angle of the wheels by the model [rad].

    Examples
    --------
    >>> PopState() == PopState(waypoint=None, steer=0.0, previous_steer=0.0)
    True
    """

    previous_steer: float = 0.0
    model_steer: float = 0.0


class Pop(Tracker[PopParams, PopState]):
    """The POP controller: Algorithm 1.

    Of the angles in the neighbourhood of the last one, the angle whose predicted location lies
    closest to the lookahead point. With one-step point prediction the wheelbase does not enter;
    it only places the reference point. The last angle is looked at first and wins ties, so a
    vehicle at rest, where every candidate predicts the same location, keeps its wheels still.

    With a `horizon` the location is predicted by a bicycle with steering lag, under each candidate
    held over it, and what counts is the place on the way that lies closest to the lookahead point.

    Parameters
    ----------
    path : Path
        The path to follow.
    params : PopParams, optional
        The parameters; the paper's without.
    actuator : Actuator, optional
        What lies between the commands and the wheels; nothing by default.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> pop = Pop(Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]))
    >>> round(pop.steer(0.0, 0.5, 0.0, 5.0, 0.05), 6)  # left of the path: steer right
    -0.05236
    >>> pop.state.waypoint
    0
    """

    def __init__(
        self,
        path: PathView,
        params: PopParams | None = None,
        *,
        actuator: Actuator | None = None,
    ) -> None:
        params = PopParams() if params is None else params
        super().__init__(path, params, params.wheelbase, actuator)
        self._model: Model | None = None
        if params.horizon is not None:
            self._model = Model(
                params.horizon,
                params.wheelbase,
                params.understeer,
                params.steer_lag,
                self.reference_offset,
            )

    def initial_state(self) -> PopState:
        """Return the state before the first step."""
        return PopState()

    def decide(self, vehicle: VehicleState, dt: float) -> Command:
        """Run Algorithm 1; the numbers are those of its lines."""
        at = self._locate(self.state.waypoint, vehicle, dt)
        speed = at.vehicle.forward_speed()
        previous_steer = at.turn(self.state.previous_steer)
        # 2: ld = ld_min + k_v * v
        lookahead = self.params.min_lookahead + self.params.lookahead_gain * speed
        # 3: lp_i = get_lookahead_point_index(x, y, {w}, ld)
        # 4: lp = get_lookahead_point({w}, lp_i)
        target = find(self.path, at, lookahead, self.params)
        # 1, 5 to 15: with the vehicle at the origin. Distances are the same there, and no digits
        # are lost far from it.
        lookahead_point = (target.point[0] - at.position[0], target.point[1] - at.position[1])
        wheel = at.turn(self.state.model_steer)
        if self._model is None:
            steer = self._choose(lookahead_point, at.vehicle.yaw, speed, previous_steer, at.dt)
        else:
            rollout = self._model.rollout(at.vehicle.yaw, speed, wheel, at.dt)
            steer = self._choose_over_horizon(lookahead_point, rollout, previous_steer)
            wheel, _ = self._limit(self._model.follow(wheel, steer, at.dt))
        # 16: delta_prev = delta
        self._state = replace(
            self.state,
            waypoint=at.foot.segment,
            previous_steer=at.turn(steer),
            model_steer=at.turn(wheel),
        )
        if not target.found:
            status = Status.LOOKAHEAD_LOST
        elif abs(steer) >= self.params.max_steer:
            status = Status.SATURATED
        else:
            status = Status.OK
        return command(at, steer, target.point, status)

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

        return self._choose_nearest(previous_steer, get_distance_after)

    def _choose_over_horizon(
        self, lookahead_point: Point, rollout: Rollout, previous_steer: float
    ) -> float:
        """Optimize the way over the horizon, instead of the location after a step."""
        lookahead_range = get_distance((0.0, 0.0), lookahead_point)
        spread = rollout.spread(self.params.steer_span)
        if spread <= 16.0 * sys.float_info.epsilon * lookahead_range:
            return previous_steer
        return self._choose_nearest(
            previous_steer, lambda steer: rollout.get_least_distance(steer, lookahead_point)
        )

    def _choose_nearest(self, previous_steer: float, predict: Callable[[float], float]) -> float:
        """Return the candidate predicted closest; the last angle where none is closer."""
        # 1: delta_list += delta_prev
        steer_list = [
            self._candidate(previous_steer, k) for k in range(self.params.candidate_count)
        ]
        # 6: delta = delta_prev
        steer = previous_steer
        # 5: min dist <- infinity; here the distance that delta_prev leads to, so that it wins ties
        min_distance = predict(steer)
        # 7: for k <- 1 to len(delta_list)
        for candidate in steer_list:
            # 9, 11: dist = get_distance(get_predicted_location(..., delta_list[k]), lp)
            distance = predict(candidate)
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
        max_steer = self.params.max_steer
        return saturate(previous_steer + offset, -max_steer, max_steer)

    def check_state(self, state: PopState) -> PopState:
        """Return `state`, where it is one that this law could have on its path."""
        return replace(
            state,
            waypoint=check_waypoint(self.path, state.waypoint),
            previous_steer=check_steer(
                "previous_steer", state.previous_steer, self.params.max_steer
            ),
            model_steer=check_steer("model_steer", state.model_steer, self.params.max_steer),
        )
