"""Estimates what the vehicle's parameters do not say, from its motion. All controllers share it.

- Turning gain and steering offset by recursive least squares with exponential forgetting. The
  model of the turn y in one period is gain (a + steer_offset b): a is the turn that the vehicle's
  parameters predict, b its derivative by the steering offset. It is linear in the parameters
  θ = (gain, gain steer_offset), with φ = (a, b) for its regressors::

      y = φᵀ θ,    M = λ M + φ φᵀ,    m = λ m + φ y,    (M + W) θ = m + W θ₀

  as in Åström and Wittenmark, *Adaptive Control*, section 2.2, written with the information matrix
  M. The prior θ₀ = (1, 0) has the weights W and is not forgotten.
- Dead time by a normalised gradient step. If the given dead time is too short by t, the measured
  turn differs from the expected one by -t da/dt; that difference and da/dt give t.
- Slip, the angle from the heading to the direction of motion, by normalised least mean squares
  from the measured positions.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from popsteer.reference.bounds import MAX_COORDINATE, MAX_SPEED, MAX_YAW
from popsteer.reference.error import input_in_range, input_within
from popsteer.reference.math import cos, exp, saturate, sin, wrap
from popsteer.reference.vehicle.estimate import Corrections
from popsteer.reference.vehicle.state import VehicleState

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from popsteer.reference.vehicle import Vehicle
    from popsteer.reference.vehicle.estimate import AdaptParams
    from popsteer.reference.vehicle.wheels import WheelIntegrals

__all__ = ["Estimator"]

ACCELERATION_TIME = 0.1
"""Time constant of the estimated acceleration [s]."""
PRIOR = np.diag([1e-4, 0.1])
"""W: weights of the gain 1, that of the vehicle's parameters [rad²], and of its steering offset.

Larger values make the estimate slower and steadier. 1e-4 weighs as much as one measured turn of
0.6°, 0.1 as much as three periods with b = 0.18.
"""
CHANGE_PRIOR = 1e-2
"""Weight of the vehicle's given dead time [rad²/s²]. Larger values make the estimate slower."""
MIN_GAIN, MAX_GAIN = 0.4, 2.5
"""Bounds of the gain: one beyond them would mean that the parameters are another vehicle's."""
MAX_STEER_OFFSET = 0.15
"""Bound of the estimated steering offset [rad]."""
MAX_SLIP = 0.15
"""Bound of the estimated slip [rad]."""
SLIP_SPLIT = 0.03
"""Curvature times wheelbase at which a slip sample updates `slip` and `slip_length` equally.

Below it a bend is treated as straight.
"""
LEAST_TRAVEL = 1e-9
"""Shortest distance from which a slip is estimated [m].

Over a shorter one, the path's turn divided by the distance could overflow. The slowest vehicle at
its default `min_speed` travels more in the shortest period.
"""
MAX_ACCELERATION = 20.0
"""Bound of the estimated acceleration, in wheelbases [1/s²]."""
MAX_SUM = 1e100
"""Bound of the sums, which no valid input reaches."""
MAX_TURN = 1e30
"""Bound of a turn, which no valid input reaches; squares of its changes keep to `MAX_SUM`."""


@dataclass(frozen=True)
class Estimator:
    """The estimator's state: sums with exponential forgetting, and the estimates they give.

    The symbols are those of the module.

    Attributes
    ----------
    last_measured : VehicleState or None
        State of the no-slip point when it was last measured; None if the motion since then must
        not be used.
    information : array, shape (2, 2)
        M: forgotten sums of a² [rad²], a b [rad] and b².
    moment : array, shape (2,)
        m: forgotten sums of a y [rad²] and b y [rad].
    turn : float
        a of the last period [rad].
    change : float
        Sum of the squared rates of change of a [rad²/s²].
    estimate : Corrections
        The present estimates.

    Examples
    --------
    10 s of a vehicle that turns although its wheels are straight:

    >>> from popsteer.reference import AdaptParams, Vehicle
    >>> from popsteer.reference.vehicle.wheels import WheelIntegrals
    >>> estimator = Estimator(last_measured=VehicleState(0.0, 0.0, 0.0, 10.0))
    >>> now = VehicleState(1.0, 0.0, 0.01, 10.0)
    >>> for _ in range(100):
    ...     estimator = estimator.observe_turn(
    ...         AdaptParams(), Vehicle(), now, WheelIntegrals(turn=0.0, slope=0.1), dt=0.1
    ...     )
    >>> round(estimator.estimate.steer_offset, 2)  # 0.01 rad a metre, times the wheelbase
    0.03
    """

    last_measured: VehicleState | None = None
    information: NDArray[np.float64] = field(default_factory=lambda: np.zeros((2, 2)))
    moment: NDArray[np.float64] = field(default_factory=lambda: np.zeros(2))
    turn: float = 0.0
    change: float = 0.0
    estimate: Corrections = field(default_factory=Corrections)

    def observe_turn(
        self,
        params: AdaptParams,
        vehicle: Vehicle,
        now: VehicleState,
        reached: WheelIntegrals,
        dt: float,
    ) -> Estimator:
        """Update gain, steering offset, dead time and acceleration from the last `dt` [s].

        `now` is the state of the no-slip point, `reached` what the wheels did in that time.
        """
        before = self.last_measured
        if before is None:
            return replace(self, turn=0.0)
        speed = 0.5 * (before.speed + now.speed)
        regressors = speed / vehicle.turning_length(speed) * np.array(reached)
        acceleration = _acceleration(vehicle, self.estimate, before, now, dt)
        after = self
        if params.turn_time > 0.0:
            measured = wrap(now.yaw - before.yaw)
            after = self._fit_turning(params.turn_time, vehicle, regressors, measured, dt)
        estimate = replace(after.estimate, acceleration=acceleration)
        return replace(after, turn=float(regressors[0]), estimate=estimate)

    def _fit_turning(
        self,
        time: float,
        vehicle: Vehicle,
        regressors: NDArray[np.float64],
        measured: float,
        dt: float,
    ) -> Estimator:
        """Update gain, steering offset and dead time from one `measured` turn y; φ = `regressors`.

        A measured turn counts as at most 2 (|a| + MAX_STEER_OFFSET |b|) away from the estimated
        one, so a jump of the localisation changes little.
        """
        turn, by_offset = float(regressors[0]), float(regressors[1])

        def expected(estimate: Corrections) -> float:
            return estimate.gain * (turn + estimate.steer_offset * by_offset)

        most = 2.0 * (abs(turn) + MAX_STEER_OFFSET * abs(by_offset))
        before = expected(self.estimate)
        measured = before + saturate(measured - before, -most, most)
        kept = exp(-dt / time)
        after = replace(
            self,
            information=kept * self.information + np.outer(regressors, regressors),
            moment=kept * self.moment + regressors * measured,
        )
        estimate = self.estimate
        fitted = after.fitted_gain()
        if fitted is not None:
            # Without a dead time nothing is predicted, and feedback corrects a wrong gain. There
            # an estimate, which a wrong `steer_lag` disturbs, would only cost gain margin.
            gain = fitted if vehicle.dead_time > 0.0 else 1.0
            # The best offset for this gain, which may be 1 or clamped: the second equation.
            (_, moment), (_, (ab, bb)) = after.moment.tolist(), (after.information + PRIOR).tolist()
            offset = (moment - ab * gain) / bb / gain
            offset = saturate(offset, -MAX_STEER_OFFSET, MAX_STEER_OFFSET)
            estimate = replace(estimate, gain=gain, steer_offset=offset)

        change = (self.turn - turn) / dt
        most_longer = _most_longer(vehicle)
        residual = measured - expected(estimate)
        most = abs(change) * most_longer
        changes = self.change * kept + change * change
        correction = saturate(residual, -most, most) * change / (changes + CHANGE_PRIOR)
        correction = saturate(correction, -dt, dt)
        longer = saturate(estimate.longer_dead_time + correction, -most_longer, most_longer)
        estimate = replace(estimate, longer_dead_time=longer)
        return replace(after, change=changes, estimate=estimate)

    def fitted_gain(self) -> float | None:
        """Return the gain of the least squares; None where rounding leaves no equations."""
        normal = self.information + PRIOR
        if not normal[0, 0] * normal[1, 1] - normal[0, 1] * normal[0, 1] > 0.0:
            return None
        parameters = np.linalg.solve(normal, self.moment + PRIOR @ np.array([1.0, 0.0]))
        return saturate(float(parameters[0]), MIN_GAIN, MAX_GAIN)

    def known(self) -> Corrections:
        """Return the present estimates, with the fitted gain also where controllers use 1."""
        gain = self.fitted_gain()
        return self.estimate if gain is None else replace(self.estimate, gain=gain)

    def observe_slip(
        self,
        params: AdaptParams,
        vehicle: Vehicle,
        now: VehicleState,
        curvature: Callable[[float], float],
        dt: float,
    ) -> Estimator:
        """Update the slip from the motion of the no-slip point in the last `dt` [s].

        `curvature` gives the path's mean curvature [1/m] over a distance travelled [m]. Its sign is
        that of the steering angle: where the path is driven backwards, opposite to the path's own.
        The vehicle's curvature would not do: the vehicle steers by the measured position, so its
        curvature is correlated with the noise of the sample.
        """
        before = self.last_measured
        if before is None or not params.slip_time > 0.0:
            return self
        pace = 5.0 / 3.0 * vehicle.wheelbase if params.min_speed is None else params.min_speed
        speed = 0.5 * (before.speed + now.speed)
        travel = speed * dt
        if abs(speed) < pace or abs(travel) < LEAST_TRAVEL:
            return self
        direction = before.yaw + 0.5 * wrap(now.yaw - before.yaw)
        aside = (now.y - before.y) * cos(direction) - (now.x - before.x) * sin(direction)
        bend = curvature(travel)
        sample = saturate(aside / travel, -4.0 * MAX_SLIP, 4.0 * MAX_SLIP)
        split = SLIP_SPLIT / vehicle.wheelbase
        estimate = self.estimate
        missed = sample - (estimate.slip + estimate.slip_length * bend)
        share = dt / params.slip_time if dt < params.slip_time else 1.0
        step = share * missed / (split * split + bend * bend)
        slip = saturate(estimate.slip + step * (split * split), -MAX_SLIP, MAX_SLIP)
        slip_length = saturate(
            estimate.slip_length + step * bend, -vehicle.wheelbase, vehicle.wheelbase
        )
        return replace(self, estimate=replace(estimate, slip=slip, slip_length=slip_length))

    def checked(self, vehicle: Vehicle) -> Estimator:
        """Return the estimator, as floats, if it is one that `vehicle` could have.

        Raises
        ------
        InputError
            Naming the field that is not.
        """
        last_measured = self.last_measured
        if last_measured is not None:
            most = 2.0 * MAX_COORDINATE
            last_measured = VehicleState(
                x=input_within("last_measured", last_measured.x, most),
                y=input_within("last_measured", last_measured.y, most),
                yaw=input_within("last_measured", last_measured.yaw, MAX_YAW),
                speed=input_within("last_measured", last_measured.speed, MAX_SPEED),
            )
        (aa, ab), (_, bb) = self.information.tolist()
        ay, by = self.moment.tolist()
        aa = input_in_range("turn_turn", aa, 0.0, MAX_SUM)
        ab = input_within("turn_offset", ab, MAX_SUM)
        bb = input_in_range("offset_offset", bb, 0.0, MAX_SUM)
        ay = input_within("turn_measured", ay, MAX_SUM)
        by = input_within("offset_measured", by, MAX_SUM)
        change = input_in_range("change", self.change, 0.0, MAX_SUM)
        turn = input_within("turn", self.turn, MAX_TURN)
        estimate = self.estimate
        gain = input_in_range("gain", estimate.gain, MIN_GAIN, MAX_GAIN)
        others = {
            field: input_within(field, getattr(estimate, field), most)
            for field, most in (
                ("steer_offset", MAX_STEER_OFFSET),
                ("longer_dead_time", _most_longer(vehicle)),
                ("slip", MAX_SLIP),
                ("slip_length", vehicle.wheelbase),
                ("acceleration", MAX_ACCELERATION * vehicle.wheelbase),
            )
        }
        estimate = Corrections(gain=gain, **others)
        sums = np.array([[aa, ab], [ab, bb]]), np.array([ay, by])
        return Estimator(last_measured, *sums, turn=turn, change=change, estimate=estimate)


def _most_longer(vehicle: Vehicle) -> float:
    """Return how far an estimated dead time may be from the vehicle's [s]."""
    return 0.5 * vehicle.dead_time


def _acceleration(
    vehicle: Vehicle, estimate: Corrections, before: VehicleState, now: VehicleState, dt: float
) -> float:
    """Return the estimated acceleration after a period [m/s²]: the measured one, low-passed."""
    most = MAX_ACCELERATION * vehicle.wheelbase
    gained = (now.speed - before.speed) / dt - estimate.acceleration
    weight = 1.0 - exp(-dt / ACCELERATION_TIME)
    return saturate(estimate.acceleration + weight * gained, -most, most)
