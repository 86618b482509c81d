"""A controller of your own, driven and measured beside one of popsteer: bang-bang, the simplest.

    python examples/own_controller.py

It steers back towards the path by one fixed angle. On the car that the paper's authors drove it
limit-cycles, wider and wider, until it has left the road.
"""

from __future__ import annotations

import math

import popsteer
from popsteer import sim, tracks

PATH = popsteer.Path(tracks.get("racetrack").xy)


class BangBang:
    """``steer = -amplitude sign(cross_track_error)`` of the front axle."""

    name = "bang-bang"

    def __init__(self, path: popsteer.Path, vehicle: popsteer.Vehicle, amplitude: float) -> None:
        self.path, self.vehicle, self.amplitude = path, vehicle, amplitude
        self.tracked_point = vehicle.front_axle  # where the run measures its errors

    def step(self, x: float, y: float, yaw: float, _speed: float, _dt: float) -> float:
        """Answer the pose with the angle of the wheels."""
        ahead = self.vehicle.front_axle
        front = (x + ahead * math.cos(yaw), y + ahead * math.sin(yaw))
        error = self.path.project(*front).cross_track_error
        return -math.copysign(self.amplitude, error) if error else 0.0


def main() -> None:
    """Drive bang-bang and POP along the race track and say how far off they were."""
    car = popsteer.vehicles.get("carla-identified")
    for controller in (BangBang(PATH, car, amplitude=0.122), popsteer.Pop(PATH, car)):
        run = sim.run(controller)
        worst = run.metrics.max_abs_cross_track_error
        print(f"{run.law}: {run.ending} after {run.metrics.time:.1f} s, at most {worst:.2f} m off")


if __name__ == "__main__":
    main()
