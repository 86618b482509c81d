"""Preview POP in small signals about a straight.

On a straight its step is linear feedback of the errors and of what it remembers: c, the curvature
that its wheels are commanded, a, the curvature that they have come to by its own model, and s, the
slip that it estimates. With b one period back, the gains g from the cost-to-go, and E the decay of
the model's lag over a period::

    c = b c - (g_e e + g_p (ψ + s) + g_a a + g_c b c)      δ = (L + K v²) c
    a = (1 - E) b c / (1 - E b)

Without a and c, δ is a ratio of polynomials of b.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.polynomial import Polynomial

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from popsteer._core import PreviewPopParams, Vehicle

_BACK = Polynomial([0.0, 1.0])  # b, one period back
_MAX_STEPS = 20  # of the prediction


class PreviewGains(NamedTuple):
    """How much less curvature is commanded for a unit of each; see the module."""

    error: float
    """Of the cross-track error [1/m²]."""
    heading: float
    """Of the heading error, and of the slip that is estimated: the direction of motion [1/m]."""
    driven: float
    """Of the curvature that the wheels have come to [-]."""
    commanded: float
    """Of the curvature that was commanded [-]."""


def decay(time: float, time_constant: float) -> float:
    """Give what remains after `time` of what fades with a time constant; 0 where that is 0."""
    return math.exp(-time / time_constant) if time_constant > 0.0 else 0.0


def preview_pop(
    params: PreviewPopParams, vehicle: Vehicle, speed: float, dt: float
) -> tuple[list[float], list[float], list[float], list[float]]:
    """Linearise the controller about straight driving, within its neighbourhood and its limits.

    Gives weights of the cross-track errors, of the heading errors, of the angles and of the slip,
    the latest first, as `popsteer.lab.stability.linear.Weights` has them. Speed in [m/s], period in
    [s].
    """
    gains = preview_gains(params, vehicle, speed, dt)
    length = vehicle.turning_length(speed)
    kept = decay(dt, vehicle.steer_lag)
    # Everything is multiplied by lag, by which a is divided.
    lag = 1.0 - kept * _BACK
    driven = (1.0 - kept) * _BACK  # a · lag, for a unit of c
    steer = (1.0 - (1.0 - gains.commanded) * _BACK) * lag + gains.driven * driven
    scaled = [length * gain * lag for gain in (gains.error, gains.heading)]
    cross_track, heading = (each.coef.tolist() for each in scaled)
    return cross_track, heading, steer.coef.tolist(), heading


def preview_gains(
    params: PreviewPopParams, vehicle: Vehicle, speed: float, dt: float
) -> PreviewGains:
    """Carry the cost back over the horizon on a straight, as the controller does in each step.

    Speed in [m/s], period in [s].
    """
    params = params.resolved(vehicle)
    heading_cost, rate_cost, pace = map(
        float,
        (params.heading_cost or 0.0, params.steer_rate_cost or 0.0, params.min_speed or 0.0),
    )
    count = int(min(max(params.horizon / dt + 1e-6, 1.0), _MAX_STEPS))
    period = max(params.horizon / count, dt)
    step = max(speed, pace) * period
    move_cost = (rate_cost * vehicle.turning_length(speed) / period) ** 2
    lag = vehicle.steer_lag * speed
    gains = _first_gains(_straight(step, lag), heading_cost, move_cost, count)
    error, heading, driven, commanded = (dt / period * gains).tolist()
    return PreviewGains(
        # An error counts as far as a heading does, so not at all where that does not.
        error=error if heading > 0.0 else 0.0,
        heading=heading,
        driven=driven,
        commanded=commanded,
    )


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
