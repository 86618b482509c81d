"""How preview POP approaches a path: no steeper than the vehicle can straighten before it."""

from __future__ import annotations

from typing import NamedTuple

from popsteer.reference.math import divide, sqrt

__all__ = ["Straightening"]

_LAGS_IN_HAND = 2.0
"""Reserve of an approach in steering lags: one to begin turning back, one to end it."""


class Straightening(NamedTuple):
    """What limits how soon an approaching vehicle is straight again, per distance travelled."""

    curvature: float
    """The largest curvature that the vehicle drives [1/m]."""
    rate: float
    """How fast that changes [1/m²]."""
    lag: float
    """The steering lag, as a distance [m]."""
    unlimited: float
    """The cross-track error per radian of heading at which the unlimited controller keeps its
    heading [m]: close to the path it straightens sooner by itself."""

    def steepest(self, approach_angle: float, error: float) -> float:
        """Return the steepest heading that is straightened before the path is reached [rad].

        Within `approach_angle`, for a path `error` away, the positive root of::

            angle² / (2 curvature) + angle (curvature / (2 rate) + 2 lag) = error

        with the distance in brackets at most `unlimited`, so that close to the path the unlimited
        controller remains what it is. The first term is the arc of the largest curvature; the
        second is the distance in which the wheels turn, and that of their lag. The curvature is at
        most the one that they reach while the vehicle turns by the approach angle.

        Examples
        --------
        >>> fast = Straightening(curvature=0.0064, rate=0.006, lag=3.75, unlimited=8.2)
        >>> round(fast.steepest(0.25, 1.0), 4), fast.steepest(0.25, 20.0)
        (0.0729, 0.25)
        """
        reached = sqrt(approach_angle * self.rate)
        curvature = self.curvature if self.curvature < reached else reached
        turning = 0.5 * curvature / self.rate + _LAGS_IN_HAND * self.lag
        turning = self.unlimited if self.unlimited < turning else turning
        # Written so, no digits cancel.
        twice = 2.0 * error
        angle = divide(twice, turning + sqrt(turning * turning + twice / curvature))
        return angle if angle < approach_angle else approach_angle
