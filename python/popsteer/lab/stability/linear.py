"""Controllers in small signals about straight driving at one speed.

A controller sees e and ψ, the offset and the heading error of its tracked point, and commands
δ = -(C_e(z) e + C_ψ(z) ψ) / D(z), where D is 1 unless it remembers what it commanded.
`popsteer.lab.stability.loop` closes the loop with a vehicle.

On a straight a step of preview POP is linear feedback of the errors and of what it remembers: c,
the curvature that its wheels are commanded, a, the curvature that they have come to by its own
model. With b one period back, the gains g from the cost-to-go, and E the decay of the
model's lag over a period::

    c = b c - (g_e e + g_p ψ + g_a a + g_c b c)      δ = (L + K v²) c
    a = (1 - E) b c / (1 - E b)

Without a and c, δ is a ratio of polynomials of b.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from popsteer import controllers
from popsteer._core import (
    PidParams,
    PopParams,
    PreviewPopParams,
    PurePursuitParams,
    StanleyParams,
    Vehicle,
)
from popsteer.controllers import Params
from popsteer.errors import ConfigError
from popsteer.ranges import check_in_range

_Weights = tuple[list[float], ...]
"""Those of `LinearLaw`, in its order; what is left out is its default."""


_BACK = Polynomial([0.0, 1.0])  # b, one period back


class LinearLaw(NamedTuple):
    """A controller in small signals: the point that it tracks, and weights, the latest first.

    Σ steer[i] δ(k - i) = -Σ (cross_track[i] e(k - i) + heading[i] ψ(k - i))
    """

    tracked_point: float
    """Where e is measured, ahead of the pose's point [m]."""
    cross_track: NDArray[np.float64]
    """Of the cross-track errors [rad/m]."""
    heading: NDArray[np.float64]
    """Of the heading errors [-]."""
    steer: NDArray[np.float64] = np.ones(1)
    """Of the angles [-]; of the latest it is 1."""


def no_slip(vehicle: Vehicle) -> float:
    """Give where the point lies that moves where the vehicle looks, ahead of the pose's [m]."""
    return vehicle.rear_axle if vehicle.no_slip_point is None else vehicle.no_slip_point


def lookahead(params: Params, vehicle: Vehicle, speed: float) -> float | None:
    """Give a controller's lookahead distance [m] at a speed [m/s]; None where it has none."""
    found: Any = params.resolved(vehicle)
    if isinstance(params, PopParams):
        return float(found.min_lookahead + found.lookahead_gain * speed)
    if isinstance(params, PurePursuitParams):
        return float(max(found.min_lookahead, found.lookahead_gain * speed))
    return None


def _pop(params: PopParams, vehicle: Vehicle, speed: float, _dt: float) -> _Weights:
    """δ = β - ψ with the bearing β = -asin(e / ld) of the lookahead point."""
    return [1.0 / _positive_lookahead(params, vehicle, speed)], [1.0]


def _pure_pursuit(
    params: PurePursuitParams, vehicle: Vehicle, speed: float, _dt: float
) -> _Weights:
    """δ = atan(2 L sin α / ld) with α = β - ψ."""
    distance = _positive_lookahead(params, vehicle, speed)
    gain = 2.0 * vehicle.wheelbase / distance
    return [gain / distance], [gain]


def _stanley(params: StanleyParams, vehicle: Vehicle, speed: float, _dt: float) -> _Weights:
    """δ = -(ψ + atan(k e / (k_s + k_v v)))."""
    found: Any = params.resolved(vehicle)
    return [found.cross_track_gain / (found.softening + found.speed_gain * speed)], [1.0]


def _pid(params: PidParams, vehicle: Vehicle, _speed: float, dt: float) -> _Weights:
    """δ = -(k_P e + k_I Σ e Δt + k_D r), the sum over the buffer, (T + Δt) r = T b r + (1 - b) e.

    Multiplied by 1 - kept b, by which the filter of the derivative divides.
    """
    found: Any = params.resolved(vehicle)
    term = found.ki * (dt if params.integral_with_dt else 1.0)
    summed = Polynomial([found.kp + term, *[term] * (params.buffer_length - 1)])
    held = found.derivative_filter + dt
    lag = 1.0 - found.derivative_filter / held * _BACK
    weights = summed * lag + found.kd / held * (1.0 - _BACK)
    return weights.coef.tolist(), [0.0], lag.coef.tolist()


def linearised(params: Params, vehicle: Vehicle, speed: float, dt: float) -> LinearLaw:
    """Linearise a controller about straight driving on the path.

    Speed in [m/s], period in [s]. POP is taken without its grid of candidates and within the span
    that it may move in one step, pure pursuit without `alpha_by_arccos`, whose bearing has no slope
    at zero; both with the lookahead point inside the window that is searched. Preview POP is taken
    within its limits. The gain and the steering offset that a controller estimates are taken as
    constants. Raises ConfigError where the controller has no lookahead, or a number is out of its
    range.
    """
    check_in_range("speed", speed, 1e-3, 1e3)
    check_in_range("dt", dt, 1e-3, 1.0)
    axle = controllers.get(controllers.name_of(type(params))).axle
    known = {"front": vehicle.front_axle, "rear": vehicle.rear_axle}
    weights = _LINEAR[type(params)](params, vehicle, speed, dt)
    return LinearLaw(known.get(axle, no_slip(vehicle)), *map(np.array, weights))


def _positive_lookahead(
    params: PopParams | PurePursuitParams, vehicle: Vehicle, speed: float
) -> float:
    distance = lookahead(params, vehicle, speed)
    if not distance:
        raise ConfigError("lookahead", distance, "positive")
    return distance


_MAX_STEPS = 20  # of the prediction


class PreviewGains(NamedTuple):
    """How much less curvature is commanded for a unit of each; see the module."""

    error: float
    """Of the cross-track error [1/m²]."""
    heading: float
    """Of the heading error [1/m]."""
    driven: float
    """Of the curvature that the wheels have come to [-]."""
    commanded: float
    """Of the curvature that was commanded [-]."""


def decay(time: float, time_constant: float) -> float:
    """Give what remains after `time` of what fades with a time constant; 0 where that is 0."""
    return math.exp(-time / time_constant) if time_constant > 0.0 else 0.0


def _preview_pop(params: PreviewPopParams, vehicle: Vehicle, speed: float, dt: float) -> _Weights:
    """Within its neighbourhood and its limits; the module has the formulas."""
    gains = preview_gains(params, vehicle, speed, dt)
    length = vehicle.turning_length(speed)
    kept = decay(dt, vehicle.steer_lag)
    # Everything is multiplied by lag, by which a is divided.
    lag = 1.0 - kept * _BACK
    driven = (1.0 - kept) * _BACK  # a · lag, for a unit of c
    steer = (1.0 - (1.0 - gains.commanded) * _BACK) * lag + gains.driven * driven
    scaled = [length * gain * lag for gain in (gains.error, gains.heading)]
    cross_track, heading = (each.coef.tolist() for each in scaled)
    return cross_track, heading, steer.coef.tolist()


_LINEAR: dict[type[Any], Callable[[Any, Vehicle, float, float], _Weights]] = {
    PopParams: _pop,
    PurePursuitParams: _pure_pursuit,
    StanleyParams: _stanley,
    PidParams: _pid,
    PreviewPopParams: _preview_pop,
}


def preview_gains(
    params: PreviewPopParams, vehicle: Vehicle, speed: float, dt: float
) -> PreviewGains:
    """Carry the cost back over the horizon on a straight; speed in [m/s], period in [s]."""
    found: Any = params.resolved(vehicle)
    pace = max(speed, found.min_speed)
    horizon = _horizon(found, vehicle, pace)
    count = int(min(max(horizon / dt + 1e-6, 1.0), _MAX_STEPS))
    period = max(horizon / count, dt)
    step = pace * period
    move_cost = (found.steer_rate_cost * vehicle.turning_length(speed) / period) ** 2
    lag = vehicle.steer_lag * speed
    gains = _first_gains(_straight(step, lag), found.heading_cost, move_cost, count)
    error, heading, *others = (dt / period * gains).tolist()
    # An error counts as far as a heading does, so not at all where that does not.
    return PreviewGains(error if heading > 0.0 else 0.0, heading, *others)


def _horizon(found: Any, vehicle: Vehicle, pace: float) -> float:
    """Return how long preview POP looks ahead at a speed [s]: see its `horizon`."""
    needed = found.horizon * max(1.0, vehicle.wheelbase / (0.6 * pace))
    rate = vehicle.max_steer_rate
    if rate is not None and rate <= found.steer_span_rate:
        turn = math.sqrt(found.approach_angle * vehicle.turning_length(pace) / (pace * rate))
        needed = max(needed, 3.0 * vehicle.steer_lag + 1.5 * turn)
    return float(min(needed, 2.0 * found.horizon))


def _straight(step: float, lag: float) -> NDArray[np.float64]:
    """Return A of a step [m] of z = (e, ψ, a, c) along a straight, with a lag [m], exactly.

    e' = ψ, ψ' = a, a' = (c - a) / lag, each by the distance travelled.
    """
    kept = decay(step, lag)
    by_driven = lag * (1.0 - kept)
    by_commanded = step - by_driven
    lagging = lag * by_commanded
    return np.array(
        [
            [1.0, step, lagging, 0.5 * step * step - lagging],
            [0.0, 1.0, by_driven, by_commanded],
            [0.0, 0.0, kept, 1.0 - kept],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def _first_gains(
    model: NDArray[np.float64], heading_cost: float, move_cost: float, count: int
) -> NDArray[np.float64]:
    """Return K of the first of `count` steps: the Riccati recursion, from the last one back.

    S = Aᵀ P A,  K = Bᵀ S / (R + Bᵀ S B),  P = Q + S - S B K, from P = Q, where B moves c.
    """
    stage = np.diag([1.0, heading_cost**2, 0.0, 0.0])
    after, gain = stage, np.zeros(4)
    for _ in range(count):
        cost = model.T @ after @ model
        gain = cost[3] / (move_cost + cost[3, 3])
        after = stage + cost - np.outer(cost[3], gain)
    return gain
