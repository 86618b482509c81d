"""Pure pursuit with the lookahead distance of others."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from popsteer.lab.opponents.observer import Opponent, Seen


@dataclass
class AutowareGains:
    """Autoware's node has a `velocity_ratio` of 2.4; distances are for a wheelbase of 2.79 m."""

    RANGES: ClassVar = {
        "velocity_ratio": (0.01, 10.0),
        "lateral_error_ratio": (0.0, 20.0),
        "curvature_ratio": (0.0, 500.0),
        "least": (0.1, 50.0),
        "most": (0.1, 100.0),
    }

    velocity_ratio: float = 0.15
    lateral_error_ratio: float = 3.6
    curvature_ratio: float = 120.0
    least: float = 4.35
    most: float = 15.0


class AutowarePurePursuit(Opponent):
    """Angle atan(2 G sin α / d) to a point at d = clamp(ratio v - 120 |κ| + 3.6 |e|).

    The last term counts from 0.5 m on. Parameters and law as autoware_pure_pursuit documents them;
    in this loop it also has the prediction of its dead time.
    """

    Params = AutowareGains
    params: AutowareGains

    def wheels(self, seen: Seen) -> float:
        """Give the angle of the wheels [rad]."""
        p, length = self.params, self.vehicle.wheelbase
        bend = float(self.observer.curvature(seen, np.array([0.0, 0.5 * length]))[0])
        beside = p.lateral_error_ratio * abs(seen.error) if abs(seen.error) >= 0.5 else 0.0
        distance = p.velocity_ratio * seen.speed - p.curvature_ratio * abs(bend) + beside
        scale = length / 2.79
        distance = min(max(distance, p.least * scale), p.most * scale)
        away, bearing = self.observer.towards(seen, distance)
        return math.atan(2.0 * seen.length * math.sin(bearing) / max(away, 0.1 * length))


@dataclass
class AccelerationGains:
    """The lookahead distance is `time` times the speed, at least `least` wheelbases."""

    RANGES: ClassVar = {"time": (0.05, 3.0), "least": (0.3, 10.0)}

    time: float = 0.2
    least: float = 1.5


class AccelerationPursuit(Opponent):
    """Acceleration a = 2 v² sin α / d towards a point at d, then the angle that gives it.

    S. Park, J. Deyst, J. How, *A New Nonlinear Guidance Logic for Trajectory Tracking*, 2004; with
    the steering by a model of the car's lateral acceleration, as J. Becker et al., *Model- and
    Acceleration-based Pursuit Controller for High-Performance Autonomous Racing*, 2023, have it.
    Here that model is the vehicle's understeer: δ = atan(G a / v²).
    """

    Params = AccelerationGains
    params: AccelerationGains

    def wheels(self, seen: Seen) -> float:
        """Give the angle of the wheels [rad]."""
        lag = self.vehicle.steer_lag + 0.5 * seen.dt
        distance = seen.speed * (self.params.time + lag)
        distance = max(distance, self.params.least * self.vehicle.wheelbase)
        away, bearing = self.observer.towards(seen, distance)
        least = 0.1 * self.vehicle.wheelbase
        acceleration = 2.0 * seen.speed**2 * math.sin(bearing) / max(away, least)
        return math.atan(seen.length * acceleration / seen.speed**2)
