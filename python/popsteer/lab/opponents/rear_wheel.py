"""Feedback at the rear axle, after Samson."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from popsteer.lab.opponents.observer import Opponent, Seen


@dataclass
class Gains:
    """The error decays over L / `decay`, damped by `damping`, of which 1 is critical."""

    RANGES: ClassVar = {"decay": (0.05, 5.0), "damping": (0.1, 5.0), "preview": (0.0, 1.0)}

    decay: float = 0.75
    damping: float = 1.0
    preview: float = 0.0
    """How far ahead the curvature is taken [s], besides the lag of the wheels."""


class RearWheelFeedback(Opponent):
    """Rate ω = v κ cos ψ / (1 - κ e) - 2 ζ k v ψ - k² v e sin ψ / ψ, angle atan(G ω / v).

    C. Samson, *Path following and time-varying feedback stabilization of a wheeled mobile robot*,
    1992; the form is of B. Paden et al., *A Survey of Motion Planning and Control Techniques for
    Self-Driving Urban Vehicles*, 2016. κ is the curvature where the wheels will have turned.
    """

    Params = Gains
    params: Gains

    def wheels(self, seen: Seen) -> float:
        """Give the angle of the wheels [rad]."""
        k = self.params.decay / self.vehicle.wheelbase
        ahead = seen.speed * (self.vehicle.steer_lag + 0.5 * seen.dt + self.params.preview)
        bend = self.observer.bend(seen, ahead)
        heading = seen.heading + seen.slope * bend
        denominator = max(1.0 - bend * seen.error, 0.2)
        sinc = float(np.sinc(heading / math.pi))
        turning = bend * math.cos(heading) / denominator
        turning -= 2.0 * self.params.damping * k * heading + k * k * seen.error * sinc
        return math.atan(seen.length * turning)
