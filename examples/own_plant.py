"""A plant of your own in the closed loop: a car whose steering has backlash.

    python examples/own_plant.py

Any object with these names is a plant; `popsteer.sim.run` drives it, and puts the dead time around.
"""

from __future__ import annotations

import math

import popsteer
from popsteer import plants, sim


class LooseCar:
    """A bicycle whose wheels follow the command only when it leaves the gap of the gears."""

    name = "loose-car"
    vehicle = popsteer.Vehicle(wheelbase=2.7, steer_lag=0.1, dead_time=0.1, max_steer=0.6)
    reverses = False

    def __init__(self, gap: float) -> None:
        self.half = 0.5 * gap  # [rad]

    def reset(self, x: float, y: float, yaw: float, speed: float) -> None:
        self.x, self.y, self.yaw, self.speed = x, y, yaw, speed
        self.gear = self.wheel = 0.0

    def advance(
        self, steer: float, throttle: float, brake: float, dt: float, substeps: int, reverse: object
    ) -> plants.PlantState:
        assert not reverse  # noqa: S101 - see `reverses`
        turn = 0.0
        for _ in range(substeps):
            self.gear = max(steer - self.half, min(steer + self.half, self.gear))
            self.wheel += dt / 0.1 * (self.gear - self.wheel)
            self.speed = max(0.0, self.speed + dt * (4.0 * throttle - 8.0 * brake))
            turn = self.speed * math.tan(self.wheel) / 2.7
            self.yaw += dt * turn
            self.x += dt * self.speed * math.cos(self.yaw)
            self.y += dt * self.speed * math.sin(self.yaw)
        return plants.PlantState(self.x, self.y, self.yaw, self.speed, turn, self.wheel)


def main() -> None:
    """Drive S-bends with three sizes of the gap."""
    path = popsteer.Path([(0.5 * k, 10.0 * math.sin(0.5 * k / 20.0)) for k in range(500)])
    for degrees in (0.0, 1.0, 3.0):
        plant = LooseCar(math.radians(degrees))
        run = sim.run(popsteer.PreviewPop(path), plant, constant_speed=8.0)
        error = run.metrics.settled_max_abs_cross_track_error
        print(
            f"backlash of {degrees:.0f} degrees: {run.ending}, at most {error:.3f} m off after 5 s"
        )


if __name__ == "__main__":
    main()
