"""Preview POP in small signals about a straight.

On a straight its step is linear feedback of the errors and of what it remembers: c, the curvature
that its wheels were told, and a, the curvature that its own model drives by now. With b one period
back, the gains g from the cost-to-go, and E the decay of the model's lag over a period::

    c = b c - (g_e e + g_p ψ + g_a a + g_c b c + g_t t + g_s s)      δ = (L + K v²) c
    a = (1 - E) b c / (1 - E b)

Where it learns, t is how much more the vehicle turns than the model says, and s the angle of its
way to its heading: first-order filters of what was seen less what was foretold. Without a, c, t and
s, δ is a ratio of polynomials of b.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from numpy.polynomial import Polynomial

from popsteer.reference.lateral.cost_to_go import CostToGo, Travel
from popsteer.reference.math import decay
from popsteer.reference.vehicle.predict import steps

if TYPE_CHECKING:
    from popsteer._core import PreviewPopParams

__all__ = ["PreviewGains", "preview_gains", "preview_pop"]

_BACK = Polynomial([0.0, 1.0])  # b, one period back
_ONE = Polynomial([1.0])


class PreviewGains(NamedTuple):
    """How much less curvature is told for a unit of each; see the module."""

    error: float
    """Of the cross-track error [1/m²]."""
    heading: float
    """Of the heading error [1/m]."""
    driven: float
    """Of the curvature that the model drives [-]."""
    told: float
    """Of the curvature that the wheels were told [-]."""
    turn: float
    """Of what is learnt of the turning [-]."""
    slip: float
    """Of what is learnt of the slip [1/m]."""


class _Filter(NamedTuple):
    """What a sample adds to the curvature through what is learnt of it: gain / fade."""

    gain: float
    fade: Polynomial


def preview_pop(
    params: PreviewPopParams, speed: float, dt: float
) -> tuple[list[float], list[float], list[float]]:
    """Linearise the law about straight driving, within its neighbourhood and its limits.

    Parameters
    ----------
    params : PreviewPopParams
        Parameters of the law, with its reference point.
    speed : float
        Speed [m/s], positive.
    dt : float
        Control period [s].

    Returns
    -------
    tuple of three lists
        Weights of the cross-track errors, of the heading errors and of the angles, the latest
        first, as `popsteer.study.linear.LinearLaw` has them.

    Examples
    --------
    >>> from popsteer import PreviewPopParams
    >>> params = PreviewPopParams(slip_learning_time=0.0)
    >>> cross_track, heading, steer = preview_pop(params, 10.0, 0.05)
    >>> len(cross_track), len(heading), steer[0]
    (2, 2, 1.0)
    """
    gains = preview_gains(params, speed, dt)
    offset = params.reference_offset or 0.0
    length = params.wheelbase + params.understeer * speed * speed
    distance = speed * dt
    kept = decay(dt, params.steer_lag)
    swing = params.steer_lag * (1.0 - kept) * speed

    # Everything is multiplied by lag, turn.fade and slip.fade, by which something is divided.
    lag = 1.0 - kept * _BACK
    driven = (1.0 - kept) * _BACK  # a · lag, for a unit of c
    learns = speed >= params.min_speed
    turn = _filter(gains.turn / distance, params.turn_learning_time if learns else 0.0, dt)
    slip = _filter(gains.slip / distance, params.slip_learning_time if learns else 0.0, dt)
    foretold = _BACK * (distance * lag + swing * (driven - lag))  # turn · lag, for a unit of c
    change = 1.0 - _BACK
    aside = -offset * change - 0.5 * distance * (1.0 + _BACK)  # for a unit of ψ

    whole = lag * turn.fade * slip.fade
    cross_track = gains.error * whole + slip.gain * change * lag * turn.fade
    heading = (
        gains.heading * whole
        + turn.gain * change * lag * slip.fade
        + slip.gain * aside * lag * turn.fade
    )
    steer = (
        (1.0 - (1.0 - gains.told) * _BACK) * whole
        + gains.driven * driven * turn.fade * slip.fade
        - turn.gain * foretold * slip.fade
    )
    return (
        (length * cross_track).coef.tolist(),
        (length * heading).coef.tolist(),
        steer.coef.tolist(),
    )


def preview_gains(params: PreviewPopParams, speed: float, dt: float) -> PreviewGains:
    """Carry the cost back over the horizon, as the law does in each step.

    Parameters
    ----------
    params : PreviewPopParams
        Parameters of the law.
    speed : float
        Speed [m/s], positive.
    dt : float
        Control period [s].

    Returns
    -------
    PreviewGains
        The gains, on a straight.

    Examples
    --------
    >>> from popsteer import PreviewPopParams
    >>> gains = preview_gains(PreviewPopParams(), 10.0, 0.05)
    >>> gains.error > 0.0, abs(gains.turn - (gains.driven + gains.told)) < 1e-9
    (True, True)
    """
    offset = params.reference_offset or 0.0
    count, period = steps(params.horizon, dt)
    step = max(speed, params.min_speed) * period
    lag = params.steer_lag * speed
    kept = decay(step, lag)
    travel = Travel.over(step, lag, kept, offset)
    length = params.wheelbase + params.understeer * speed * speed
    move_cost = (params.steer_rate_cost * length / period) ** 2
    stage = CostToGo.stage(params.heading_cost, offset)

    def first(turn: float, drift: float) -> CostToGo:
        after = cost = stage
        for _ in range(count):
            cost = after.before(travel, turn, drift)
            after = cost.before_best_move(move_cost, stage)
        return cost

    cost = first(0.0, 0.0)
    share = dt / period / (move_cost + cost.cc)
    return PreviewGains(
        # The law lets an error count as far as a heading does, so not at all where that does not.
        error=share * cost.ec if cost.pc > 0.0 else 0.0,
        heading=share * cost.pc,
        driven=share * cost.ac,
        told=share * cost.cc,
        # A unit of what is learnt turns the path the other way, or carries the vehicle aside.
        turn=share * first(-step, 0.0).c,
        slip=share * first(0.0, step).c,
    )


def _filter(gain: float, time: float, dt: float) -> _Filter:
    """Learn within a time [s]; 0 for never."""
    if time <= 0.0:
        return _Filter(0.0, _ONE)
    share = min(dt / time, 1.0)
    return _Filter(gain * share, 1.0 - (1.0 - share) * _BACK)
