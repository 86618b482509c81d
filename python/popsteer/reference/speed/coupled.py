"""The paper's longitudinal controller, coupled with the steering angle: Equation 7."""

from __future__ import annotations

from dataclasses import dataclass

from popsteer.reference.bounds import MAX_SPEED
from popsteer.reference.error import Checked, input_within, number
from popsteer.reference.math import PI
from popsteer.reference.speed.pedals import Pedals


@dataclass(frozen=True, kw_only=True)
class CoupledLongitudinalParams(Checked):
    """Parameters of `CoupledLongitudinal`; the paper's Table 2 by default.

    Examples
    --------
    >>> CoupledLongitudinalParams(cutoff=2.0)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: cutoff must be in [0, 1], got 2.0
    """

    cutoff: float = number(0.5, 0.0, 1.0)
    """Cutoff constant k_τ: offset and aggressiveness of the command."""
    steer_limit: float = number(1.22, 1e-3, 1.57)
    """Steering limit δ_lim [rad]."""
    speed_limit: float = number(69.44, 1e-3, MAX_SPEED)
    """Speed limit v_lim [m/s]."""


class CoupledLongitudinal:
    """Full throttle from rest, less with speed and in bends: Equation 7.

    τ = k_τ + [(v_lim - v) / v_lim - |δ| / δ_lim] (1 - k_τ); throttle where τ is positive, brake
    where it is negative. The controller has no memory.

    Examples
    --------
    >>> throttle, brake = CoupledLongitudinal().step(speed=34.72, steer=0.61)
    >>> throttle
    0.5
    """

    def __init__(self, params: CoupledLongitudinalParams | None = None) -> None:
        self.params = CoupledLongitudinalParams() if params is None else params

    def step(self, speed: float, steer: float) -> Pedals:
        """Set the pedals at the speed v [m/s] and the commanded angle δ [rad].

        Raises `InputError` for a number that is not finite or beyond its bound.
        """
        params = self.params
        speed = input_within("speed", speed, MAX_SPEED)
        steer = input_within("steer", steer, PI)
        slower = (params.speed_limit - speed) / params.speed_limit
        reserve = slower - abs(steer) / params.steer_limit
        return Pedals.from_command(params.cutoff + reserve * (1.0 - params.cutoff))
