"""The paper's longitudinal controller, coupled with the steering angle: Equation 7."""

from __future__ import annotations

from dataclasses import dataclass

from popsteer.reference.bounds import MAX_SPEED
from popsteer.reference.error import config_in_range, input_within
from popsteer.reference.math import PI
from popsteer.reference.speed.pedals import Pedals

__all__ = ["CoupledLongitudinal", "CoupledLongitudinalParams"]


@dataclass(frozen=True, kw_only=True)
class CoupledLongitudinalParams:
    """Parameters of `CoupledLongitudinal`; the paper's Table 2 by default.

    Attributes
    ----------
    cutoff : float
        Cutoff constant k_τ, 0 to 1: offset and aggressiveness of the command.
    steer_limit : float
        Steering limit δ_lim [rad].
    speed_limit : float
        Speed limit v_lim [m/s].

    Raises
    ------
    ConfigError
        Naming the parameter that is out of its range.

    Examples
    --------
    >>> CoupledLongitudinalParams(cutoff=2.0)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: cutoff must be in [0, 1], got 2.0
    """

    cutoff: float = 0.5
    steer_limit: float = 1.22
    speed_limit: float = 69.44

    def __post_init__(self) -> None:
        config_in_range(self, "cutoff", 0.0, 1.0)
        config_in_range(self, "steer_limit", 1e-3, 1.57)
        config_in_range(self, "speed_limit", 1e-3, MAX_SPEED)


class CoupledLongitudinal:
    """Full throttle from rest, less with speed and in bends: Equation 7.

    τ = k_τ + [(v_lim - v) / v_lim - |δ| / δ_lim] (1 - k_τ); throttle where τ is positive, brake
    where it is negative. The controller has no memory.

    Parameters
    ----------
    params : CoupledLongitudinalParams, optional
        The parameters; the paper's without.

    Examples
    --------
    >>> throttle, brake = CoupledLongitudinal().step(speed=34.72, steer=0.61)
    >>> throttle
    0.5
    """

    def __init__(self, params: CoupledLongitudinalParams | None = None) -> None:
        self._params = CoupledLongitudinalParams() if params is None else params

    @property
    def params(self) -> CoupledLongitudinalParams:
        """The parameters."""
        return self._params

    def step(self, speed: float, steer: float) -> Pedals:
        """Set the pedals.

        Parameters
        ----------
        speed : float
            Speed v [m/s].
        steer : float
            Commanded angle δ [rad].

        Returns
        -------
        Pedals
            Throttle and brake, each in 0 to 1.

        Raises
        ------
        InputError
            For a number that is not finite or beyond its bound.
        """
        cutoff = self._params.cutoff
        steer_limit = self._params.steer_limit
        speed_limit = self._params.speed_limit
        speed = input_within("speed", speed, MAX_SPEED)
        steer = input_within("steer", steer, PI)
        reserve = (speed_limit - speed) / speed_limit - abs(steer) / steer_limit
        return Pedals.from_command(cutoff + reserve * (1.0 - cutoff))
