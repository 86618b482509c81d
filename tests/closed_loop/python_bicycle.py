"""A plant written in Python, to be compared with the core's."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from popsteer import plants, sim
from popsteer.errors import PlantLimit

if TYPE_CHECKING:
    import popsteer


class Bicycle:
    """The core's kinematic bicycle, whose wheels turn at once, with its pose at the rear axle."""

    name, reverses = "python-bicycle", True

    def __init__(self, last_x: float = math.inf, vehicle: popsteer.Vehicle | None = None) -> None:
        self.params, self.last_x = sim.KinematicBicycle(), last_x
        self.vehicle = self.params.vehicle if vehicle is None else vehicle
        self.state = (math.nan,) * 4

    def reset(self, x: float, y: float, yaw: float, speed: float, /) -> None:
        self.state = x, y, yaw, speed

    def advance(
        self,
        steer: float,
        throttle: float,
        brake: float,
        dt: float,
        substeps: int,
        reverse: bool,
        /,
    ) -> plants.PlantState:
        p, curvature = self.params, math.tan(steer) / self.vehicle.wheelbase
        gear = -1.0 if reverse else 1.0
        x, y, yaw, speed = self.state
        for _ in range(substeps):
            yaw_rate, travel = speed * curvature, speed * dt
            heading = yaw + 0.5 * (travel * curvature)
            x, y = x + travel * math.cos(heading), y + travel * math.sin(heading)
            yaw += travel * curvature
            along = gear * speed
            braking = math.copysign(p.braking * brake, along)
            after = along + (p.drive * throttle - braking - p.drag * along) * dt
            speed = gear * (min(after, 0.0) if along < 0.0 else max(after, 0.0))
        self.state = x, y, yaw, speed
        if self.state[0] > self.last_x:
            raise PlantLimit("the end of the world")
        return plants.PlantState(*self.state, yaw_rate, steer)
