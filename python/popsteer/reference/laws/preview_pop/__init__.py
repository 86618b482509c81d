"""Preview POP: of the angles near the last one, the one with the least predicted cost.

`PreviewPop._choose` predicts, and takes the first move of the best plan within the limits. Angles
in this file are those of the wheels. A command is such an angle less the steering offset; the
tracker converts.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from popsteer.reference.error import number, optional
from popsteer.reference.laws.law import Belief, Decision, LateralLaw, Params, Tracked, limit_steer
from popsteer.reference.laws.preview_pop.approach import FULL_RATE, Approach, Straightening
from popsteer.reference.laws.preview_pop.cost_to_go import COMMANDED, regulator, stage, transition
from popsteer.reference.laws.preview_pop.horizon import Horizon, MoveLimit, PlanLimits
from popsteer.reference.laws.preview_pop.limited import plan_within
from popsteer.reference.math import PI, atan, decay, divide, saturate, tan, wrap
from popsteer.reference.path.preview import Preview
from popsteer.reference.vehicle.bicycle import steps
from popsteer.status import Status

if TYPE_CHECKING:
    from collections.abc import Sequence

    from popsteer.reference.laws.preview_pop.horizon import Array
    from popsteer.reference.path.follow import Located
    from popsteer.reference.path.view import PathView
    from popsteer.reference.vehicle import Vehicle

__all__ = ["PreviewPop", "PreviewPopParams", "PreviewPopState"]

BRAKING = 1.0 / 6.0
"""A vehicle that brakes by more than this share of its comfortable braking slows for what is
ahead."""
FARTHEST = 4
"""How many horizons ahead sharp bends are looked for."""


def _span_rate(car: Vehicle) -> float:
    return 60.0 * (PI / 180.0) if car.max_steer_rate is None else car.max_steer_rate


def _min_speed(car: Vehicle) -> float:
    gentle = car.max_steer_rate is None and not car.steers_at_rest
    return car.wheelbase / (0.6 if gentle else 3.0)


@dataclass(frozen=True, kw_only=True)
class PreviewPopParams(Params):
    """Parameters of `PreviewPop`. See `popsteer.PreviewPopParams`.

    Examples
    --------
    >>> PreviewPopParams(heading_cost=-1)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: heading_cost must be in [0, 1000], got -1.0
    """

    # δ_nbd over the control period [rad/s]
    steer_span_rate: float | None = optional(1e-3, 1e6, scaled=_span_rate)
    horizon: float = number(1.0, 0.05, 100.0)  # of the prediction [s]
    # of 1 rad in cross-track error [m/rad], and of 1 rad/s [m s/rad]
    heading_cost: float | None = optional(0.0, 1e3, scaled=lambda car: car.wheelbase)
    steer_rate_cost: float | None = optional(1e-5, 1e3, scaled=lambda car: car.wheelbase / 12.0)
    approach_angle: float = number(0.25, 1e-3, 0.5 * PI)  # of a path far off [rad]
    # least speed of the prediction [m/s]
    min_speed: float | None = optional(1e-4, 1e4, scaled=_min_speed)
    # of the path's heading [m]
    smoothing_length: float | None = optional(
        0.0, 1e3, scaled=lambda car: (0.2 if car.steers_at_rest else 2.0 / 3.0) * car.wheelbase
    )


@dataclass
class PreviewPopState:
    """What `PreviewPop` remembers."""

    previous_steer: float = 0.0
    """The last angle δ_prev [rad]: that of the wheels, the command plus the steering offset."""
    reached_limits: int = 0
    """The limits that the last plan reached, three bits a step. The core's search for the next plan
    starts from them; the plan here does not need them."""


class Prediction(NamedTuple):
    """The prediction of one control step, for the mirrored vehicle: one that drives forward."""

    horizon: Horizon
    path_yaw: float  # beside the vehicle [rad]
    length: float  # turning length over the estimated gain [m]: angle = atan(curvature * length)
    period: float  # of a step of the horizon [s]
    pace: float  # that is predicted with [m/s]: the vehicle's, but at least `min_speed`
    lag: float  # the steering lag, as a distance [m]
    ahead: Status  # TOO_FAST before a bend that is too sharp for the speed


class Neighbourhood(NamedTuple):
    """The angles that can be commanded in this control period."""

    low: float  # the smallest [rad]
    high: float  # the largest [rad]
    share: float  # control period as a share of a step of the horizon, at most 1


class PreviewPop(LateralLaw[PreviewPopParams, PreviewPopState]):
    """Preview POP.

    Of the angles in the neighbourhood of the last one, the angle with the least cost over a
    horizon. The cost of a step is e² + (heading_cost ψ)² + (steer_rate_cost rate)²: cross-track
    error e, heading error ψ, and the rate of the commanded angle, linearised about straight wheels.
    A linear bicycle with steering lag predicts them along the curvature of the path ahead. The
    moves after the first one are assumed optimal; their cost is the cost-to-go. The cost of an
    angle is then a parabola, and its minimum is the best angle. There is no list of candidates; the
    controller is this closed form. Where that plan breaks a limit of the wheels' rate or angle or
    of the lateral acceleration, at any step, the best plan that keeps them takes its place
    (`plan_within`).

    Examples
    --------
    >>> from popsteer.reference import Path, Tracker
    >>> tracker = Tracker(PreviewPop(), Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]))
    >>> tracker.steer(0.0, 0.5, 0.0, 5.0, 0.05) < 0.0  # left of the path: steer right
    True
    """

    TRACKED = Tracked.NO_SLIP_POINT
    READS_BELIEF = True
    PARAMS = PreviewPopParams
    STATE = PreviewPopState

    def decide(
        self, path: PathView, state: PreviewPopState, at: Located, belief: Belief
    ) -> Decision:
        """Decide the angle for a located vehicle."""
        wanted, planned = self._choose(path, state, at, belief)
        steer, status = limit_steer(self.vehicle, wanted)
        state.previous_steer = at.mirror(steer)
        return Decision(steer, at.closest.point, planned | status)

    def set_steer(self, state: PreviewPopState, steer: float) -> None:
        """Note the angle; the next neighbourhood is its own."""
        state.previous_steer = steer

    @property
    def _approach(self) -> Approach:
        span_rate, rate = self.resolved.steer_span_rate, self.vehicle.max_steer_rate
        least = span_rate if rate is None or span_rate < rate else rate
        is_the_vehicles = rate is not None and rate <= span_rate
        return Approach(self.vehicle, self.resolved, least, is_the_vehicles)

    def _choose(
        self, path: PathView, state: PreviewPopState, at: Located, belief: Belief
    ) -> tuple[float, Status]:
        """Find the best angle in the neighbourhood, of the mirrored vehicle."""
        prediction = self._predict(path, at, belief)
        previous_steer = at.mirror(state.previous_steer)
        rate, span = self._approach.rate_and_span(at.vehicle.forward_speed(), at.dt)
        if span <= 0.0:
            return previous_steer, prediction.ahead  # at rest the wheels do not turn
        share = at.dt / prediction.period
        around = Neighbourhood(previous_steer - span, previous_steer + span, share)
        tangent = tan(previous_steer)
        start = self._start(prediction, rate, tangent, at, belief)
        # At a constant rate of the angle, its tangent changes faster at large angles. A plan at the
        # vehicle's own rate does not count on that: on their way back to straight the wheels lose
        # it, and would be late.
        slope = 1.0 if self._approach.rate_is_the_vehicles else 1.0 + tangent * tangent
        later = rate * prediction.period * slope / prediction.length
        curvatures = self._curvatures(at, belief, prediction.length)
        limits = PlanLimits((-later, later), later, *curvatures)
        return self._best_within(prediction, start, limits, around, state, at)

    def _predict(self, path: PathView, at: Located, belief: Belief) -> Prediction:
        """Set the planning problem up: the model over a step of travel, its cost, the path."""
        vehicle, estimate, params = self.vehicle, belief.estimate, self.resolved
        speed = at.vehicle.forward_speed()
        pace = speed if speed > params.min_speed else params.min_speed
        length = vehicle.turning_length(speed) / estimate.gain
        longer, ahead = self._sharp_bend_ahead(path, at, pace, length, estimate.acceleration)
        count, period = steps(self._approach.horizon_at(pace) * longer, at.dt)
        # The model runs over distance: that of a step, and that travelled in the lag.
        step, lag = pace * period, vehicle.steer_lag * speed
        # A slip of `slip_length` times the curvature acts as if the tracked point lay
        # `slip_length` ahead of the no-slip point; behind it in the mirrored vehicle.
        offset = at.mirror(estimate.slip_length)
        move_cost = params.steer_rate_cost * length / period
        path_yaw, turns = self._turns(path, at, step, count)
        models = [transition(step, lag, decay(step, lag), offset, turn) for turn in turns]
        best = regulator(models, stage(params.heading_cost, offset), move_cost * move_cost)
        return Prediction(Horizon(models, best), path_yaw, length, period, pace, lag, ahead)

    def _turns(
        self, path: PathView, at: Located, step: float, count: int
    ) -> tuple[float, Sequence[float]]:
        """Return the path's heading here, and its turns over the next steps of `step` [m]."""
        arc, smoothing = at.closest.arc_length(path), self.resolved.smoothing_length
        preview = Preview(path, smoothing, at.closest.segment, arc, count * step)
        return preview.turns(arc, step, count)

    def _sharp_bend_ahead(
        self, path: PathView, at: Located, pace: float, length: float, acceleration: float
    ) -> tuple[float, Status]:
        """Return how many times as far as usual to look ahead: past a bend sharper than allowed.

        At a speed that the vehicle can no longer leave before it, so that it turns in early.
        Besides, whether it is too fast for such a bend, also where it brakes.
        """
        braking, limit = self.vehicle.comfort_braking, self.vehicle.max_lateral_acceleration
        if limit is None:
            return 1.0, Status.OK
        stretch = pace * self.resolved.horizon
        _, halves = self._turns(path, at, 0.5 * stretch, 2 * FARTHEST)
        slowest = self.resolved.min_speed * self.resolved.min_speed
        speed = at.vehicle.forward_speed()
        squared, driven = pace * pace, speed * speed - 0.5 * braking * stretch
        longer, ahead = 1.0, Status.OK
        # In a chicane, whose halves turn to either side, the sharper one counts.
        for stretches, (first, second) in enumerate(zip(halves[::2], halves[1::2], strict=True)):
            turn = first + second
            asked = 2.0 * max(abs(first), abs(second)) if first * second < 0.0 else abs(turn)
            if asked * driven > stretch * limit:
                ahead = Status.TOO_FAST
            if abs(turn) > stretch * self._approach.widest(sqrt(squared), length):
                longer = float(min(stretches + 2, FARTHEST))
                break
            squared -= 2.0 * braking * stretch
            if squared < slowest:
                squared = slowest
            driven -= 2.0 * braking * stretch
        if acceleration < -BRAKING * braking:
            longer = 1.0  # it slows for the bend
        return longer, ahead

    def _start(
        self, prediction: Prediction, rate: float, tangent: float, at: Located, belief: Belief
    ) -> Array:
        """Return the state that the plan starts from.

        A large error counts as the one whose pull is that of the approach angle, or of the steepest
        heading that the vehicle can still straighten before the path.
        """
        length, pace, estimate = prediction.length, prediction.pace, belief.estimate
        by_error, by_heading = prediction.horizon.best.cost[COMMANDED, :2].tolist()
        error = at.closest.cross_track_error()
        straightening = Straightening(
            curvature=self._approach.widest(pace, length),
            rate=rate / (length * pace),
            lag=prediction.lag,
            unlimited=divide(by_heading, by_error),
        )
        pull = self._approach.angle_at(error, straightening) * by_heading
        largest = divide(pull if pull > 0.0 else 0.0, abs(by_error))
        # That of the direction in which the vehicle moves.
        heading_error = wrap(at.vehicle.yaw + estimate.slip - prediction.path_yaw)
        wheel = self.vehicle.at_wheels(belief.wheel + estimate.steer_offset)
        driven, commanded = tan(at.mirror(wheel)) / length, tangent / length
        error = saturate(error, -largest, largest)
        return np.array([error, heading_error, driven, commanded, 1.0])

    def _best_within(
        self,
        prediction: Prediction,
        start: Array,
        limits: PlanLimits,
        around: Neighbourhood,
        state: PreviewPopState,
        at: Located,
    ) -> tuple[float, Status]:
        """Return the angle of the best plan within `limits` and the neighbourhood."""
        vehicle, pace, length = self.vehicle, at.vehicle.speed, prediction.length
        (low, high, share), commanded = around, float(start[COMMANDED])

        def move_to(angle: float) -> float:
            return (tan(angle) / length - commanded) / share

        # An angle beyond `max_steer` is excluded by the limits of the curvature already.
        first = (
            move_to(low) if low > -vehicle.max_steer else -inf,
            move_to(high) if high < vehicle.max_steer else inf,
        )
        plan = plan_within(prediction.horizon, start, limits._replace(first=first))
        kept = plan.reached[1:] if share > 0.5 else plan.reached
        state.reached_limits = sum(limit << 3 * k for k, limit in enumerate(kept))
        # A move that ends at a limit of the curvature is commanded at once: with only a share of it
        # in each control period, the wheels would get there too late.
        reached = plan.reached[0]
        made = 1.0 if reached.of_curvature() else share
        angle = atan((commanded + (plan.curvature - commanded) * made) * length)
        # SATURATED means that the vehicle limits the angle. Arriving at a limit of the curvature
        # counts; being held back by `steer_span_rate`, which is a choice, does not.
        arrives = low - 1e-10 <= angle <= high + 1e-10
        fast = at.vehicle.forward_speed() >= FULL_RATE * self.resolved.min_speed
        rate_is_the_vehicles = self._approach.rate_is_the_vehicles and fast
        status = prediction.ahead
        if reached.of_curvature() and (arrives or rate_is_the_vehicles):
            most, steered = vehicle.max_lateral_acceleration, tan(vehicle.max_steer) / length
            is_lateral = most is not None and most <= steered * (pace * pace)
            limit = Status.LATERAL_LIMIT if is_lateral else Status.STEER_LIMIT
            status |= Status.SATURATED | limit
        elif reached is not MoveLimit.NOTHING and rate_is_the_vehicles:
            status |= Status.SATURATED | Status.RATE_LIMIT
        return saturate(angle, low, high), status

    def _curvatures(self, at: Located, belief: Belief, length: float) -> tuple[float, float]:
        """Return the least and the greatest curvature that may be commanded [1/m].

        The wheels keep `max_steer`, and so does the command, their angle less the steering offset;
        both keep `max_lateral_acceleration`.
        """
        vehicle = self.vehicle
        offset = at.mirror(vehicle.steer_offset + belief.estimate.steer_offset)
        low = tan(vehicle.at_wheels(offset - vehicle.max_steer)) / length
        high = tan(vehicle.at_wheels(offset + vehicle.max_steer)) / length
        most = vehicle.max_lateral_acceleration
        if most is None:
            return low, high
        speed = at.vehicle.speed
        widest = divide(most, speed * speed)
        return saturate(low, -widest, widest), saturate(high, -widest, widest)
