"""What is estimated of a vehicle."""

from __future__ import annotations

from dataclasses import dataclass

from popsteer.reference.bounds import MAX_SPEED
from popsteer.reference.math import saturate


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """What the motion of a vehicle has shown, as corrections to its parameters.

    The core finds them while it drives; here they are given, and stay.
    """

    gain: float = 1.0
    """Ratio of the measured turning to that of the vehicle's parameters."""
    steer_offset: float = 0.0
    """Angle of the wheels at the command 0, beyond the vehicle's own offset [rad]."""
    slip: float = 0.0
    """Direction of the no-slip point's motion less the heading, on a straight [rad]."""
    slip_length: float = 0.0
    """Change of the slip per curvature [m]."""
    acceleration: float = 0.0
    """Acceleration [m/s²]."""

    def speed_after(self, speed: float, time: float) -> float:
        """Return the speed after `time` [s] at the estimated acceleration; braking stops at 0."""
        following = speed + self.acceleration * time
        if speed >= 0.0:
            return saturate(following, 0.0, MAX_SPEED)
        return saturate(following, -MAX_SPEED, 0.0)
