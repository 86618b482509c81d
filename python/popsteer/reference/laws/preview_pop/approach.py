"""How preview POP approaches a path: no steeper than the vehicle can straighten before it.

For that the horizon is long enough, and the wheels turn at a rate that they keep.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from popsteer.reference.math import divide, sqrt, tan

if TYPE_CHECKING:
    from types import SimpleNamespace

    from popsteer.reference.vehicle import Vehicle

LAGS = 3.0
"""Least horizon in steering lags, for a vehicle with a `max_steer_rate`; added to `TURNS`."""
TURNS = 1.5
"""And in halves of the shortest time in which the vehicle can turn by the approach angle."""
WHEELBASE_TIME = 0.6
"""The horizon of a vehicle that needs longer than this for its wheelbase [s] is as much longer."""
MOST_HORIZONS = 2.0
"""Longest horizon, as a multiple of the parameter `horizon`."""
FULL_RATE = 0.5
"""Share of `min_speed` from which on wheels with a `max_steer_rate` turn at that rate."""
_LAGS_IN_HAND = 2.0
"""Reserve of an approach in steering lags: one to begin turning back, one to end it."""


class Straightening(NamedTuple):
    """What limits how soon an approaching vehicle is straight again, per distance travelled."""

    curvature: float  # the largest that the vehicle drives [1/m]
    rate: float  # how fast that changes [1/m²]
    lag: float  # the steering lag, as a distance [m]
    # The cross-track error per radian of heading at which the unlimited controller keeps its
    # heading [m]: close to the path it straightens sooner by itself.
    unlimited: float

    def steepest(self, approach_angle: float, error: float) -> float:
        """Return the steepest heading that is straightened before the path is reached [rad].

        Within `approach_angle`, for a path `error` away, the positive root of::

            angle² / (2 curvature) + angle (curvature / (2 rate) + 2 lag) = error

        with the distance in brackets at most `unlimited`, so that close to the path the unlimited
        controller remains what it is. The first term is the arc of the largest curvature; the
        second is the distance in which the wheels turn, and that of their lag. The curvature is at
        most the one that they reach while the vehicle turns by the approach angle.
        """
        reached = sqrt(approach_angle * self.rate)
        curvature = self.curvature if self.curvature < reached else reached
        turning = 0.5 * curvature / self.rate + _LAGS_IN_HAND * self.lag
        turning = self.unlimited if self.unlimited < turning else turning
        # Written so, no digits cancel.
        twice = 2.0 * error
        angle = divide(twice, turning + sqrt(turning * turning + twice / curvature))
        return angle if angle < approach_angle else approach_angle


class Approach(NamedTuple):
    """What a vehicle and the parameters of preview POP allow an approach."""

    vehicle: Vehicle
    params: SimpleNamespace  # resolved
    rate: float  # largest of the commanded angle [rad/s]: the lesser of parameter's and vehicle's
    rate_is_the_vehicles: bool  # whether the vehicle's `max_steer_rate` bounds it

    def horizon_at(self, pace: float) -> float:
        """Return the horizon at a speed [s].

        It is longer than the parameter if the vehicle needs longer than `WHEELBASE_TIME`, or
        its wheels longer to straighten it on its approach to the path.
        """
        vehicle = self.vehicle
        horizon: float = self.params.horizon
        usual = vehicle.wheelbase / WHEELBASE_TIME
        needed = horizon * (usual / pace) if pace < usual else horizon
        if self.rate_is_the_vehicles:
            # Half the time in which wheels that turn out and back at their rate turn the vehicle by
            # the approach angle.
            length = vehicle.turning_length(pace)
            turn = sqrt(self.params.approach_angle * length / (pace * self.rate))
            straight = LAGS * vehicle.steer_lag + TURNS * turn
            needed = straight if straight > needed else needed
        most = MOST_HORIZONS * horizon
        return needed if needed < most else most

    def rate_and_span(self, speed: float, dt: float) -> tuple[float, float]:
        """Return the planned rate of the wheels [rad/s], and their travel in a period `dt` [rad].

        Below `min_speed` the wheels turn in proportion to the distance travelled. Where the rate is
        the vehicle's `max_steer_rate`, they turn at the full rate down to `FULL_RATE` times
        `min_speed`, and in proportion to the distance below. The prediction assumes at least
        `min_speed`: it covers a distance sooner than the vehicle, so the planned rate is larger by
        the same factor.
        """
        rate = self.rate
        if speed >= self.params.min_speed:
            return rate, rate * dt
        slow = speed / self.params.min_speed
        if not self.rate_is_the_vehicles:
            return rate, rate * dt * slow
        if slow < FULL_RATE:
            return rate / FULL_RATE, rate * dt * (slow / FULL_RATE)
        return rate / slow, rate * dt

    def angle_at(self, error: float, straightening: Straightening) -> float:
        """Return the heading at which a path `error` [m] away is approached [rad].

        `approach_angle` for a vehicle without limits of its own: `steer_span_rate` is a choice and
        does not make the approach flatter.
        """
        approach_angle: float = self.params.approach_angle
        if self.rate_is_the_vehicles or self.vehicle.max_lateral_acceleration is not None:
            return straightening.steepest(approach_angle, abs(error))
        return approach_angle

    def widest(self, pace: float, length: float) -> float:
        """Return the largest curvature that the vehicle drives at a speed [1/m]."""
        steered = tan(self.vehicle.max_steer) / length
        most = self.vehicle.max_lateral_acceleration
        if most is not None and most / (pace * pace) < steered:
            return most / (pace * pace)
        return steered
