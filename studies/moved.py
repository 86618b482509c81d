"""What moves in the studies of speed: a car of its own, and popsteer's plants on a slope."""

from __future__ import annotations

import math
from collections import deque
from typing import Any, Protocol

from popsteer import Path, Vehicle, sim
from popsteer.sim.geometry import pose_of

PERIOD, STEP = 0.05, 0.005
"""Of the control and of the car's motion [s]."""
GRAVITY = 9.806_65


class Moved(Protocol):
    """A vehicle that steers, pulls and brakes as commanded."""

    vehicle: Vehicle
    stands: bool
    """Whether it can."""

    @property
    def state(self) -> tuple[float, float, float, float]:
        """Pose of its point and speed, [m, m, rad, m/s]."""

    def advance(self, steer: float, acceleration: float, *, reverse: bool) -> None:
        """Move on by `PERIOD`; the acceleration is that of a `SpeedCommand`."""


def along(grade: float) -> float:
    """Acceleration by gravity on a slope [m/s²], negative uphill."""
    return -GRAVITY * grade / math.hypot(1.0, grade)


class OwnCar:
    """A bicycle of its own, on a slope towards +x.

    Its wheels have a dead time, a lag, a limit of their rate and play; its drive has a lag, its
    brakes act against the motion and hold at rest, and gravity moves it if nothing holds it.
    """

    stands = True

    def __init__(
        self, vehicle: Vehicle, speed: float = 0.0, grade: float = 0.0, play: float = 0.0
    ) -> None:
        self.vehicle, self.speed, self.play = vehicle, speed, play
        self.slope = along(grade)
        self.flight = deque([0.0] * round(vehicle.dead_time / STEP))
        self.x = self.y = self.yaw = self.wheel = self.road_wheel = self.pull = 0.0

    @property
    def state(self) -> tuple[float, float, float, float]:
        return self.x, self.y, self.yaw, self.speed

    def advance(self, steer: float, acceleration: float, *, reverse: bool) -> None:
        car = self.vehicle
        gear = -1.0 if reverse else 1.0
        rate = car.max_steer_rate or math.inf
        brakes = car.brake_deceleration or 6.0
        for _ in range(round(PERIOD / STEP)):
            self.flight.append(steer)
            turn = (self.flight.popleft() - self.wheel) / max(car.steer_lag, STEP)
            self.wheel += STEP * max(-rate, min(rate, turn))
            half = 0.5 * self.play
            self.road_wheel = max(self.wheel - half, min(self.road_wheel, self.wheel + half))
            self.pull += STEP / max(car.drive_lag, STEP) * (max(acceleration, -brakes) - self.pull)
            push = gear * max(self.pull, 0.0) + self.slope * math.cos(self.yaw)
            free = self.speed + STEP * push
            held = max(abs(free) + STEP * min(self.pull, 0.0), 0.0)
            self.speed = math.copysign(held, free)
            self.x += STEP * self.speed * math.cos(self.yaw)
            self.y += STEP * self.speed * math.sin(self.yaw)
            self.yaw += STEP * self.speed * math.tan(self.road_wheel) / car.wheelbase


class Shipped:
    """A plant of popsteer with its rear axle on the first waypoint, driven by its pedals.

    A slope is a throttle or a brake that is always on.
    """

    def __init__(self, plant: Any, path: Path, speed: float = 0.0, grade: float = 0.0) -> None:
        self.vehicle = sim.vehicle_of(plant)
        self.stands = sim.plant_name(plant) != "commonroad-mb-2"
        self.pedals = sim.PedalMap.of(plant)
        x, y = path.x[:2].tolist(), path.y[:2].tolist()
        yaw = math.atan2(y[1] - y[0], x[1] - x[0])
        start = pose_of((x[0], y[0], yaw), "rear", self.vehicle)
        settings = sim.Settings(dt=PERIOD, stop_distance=0.0, time_limit=300.0)
        self.run = sim.Simulation(path, plant, start=start, speed=speed, settings=settings)
        push = along(grade)
        self.always = max(push, 0.0) / self.pedals.drive, max(-push, 0.0) / self.pedals.braking

    @property
    def state(self) -> tuple[float, float, float, float]:
        return self.run.state

    def advance(self, steer: float, acceleration: float, *, reverse: bool) -> None:
        speed = self.run.state[3]
        pedals = self.pedals(acceleration, -speed if reverse else speed)
        throttle, brake = (min(a + b, 1.0) for a, b in zip(pedals, self.always, strict=True))
        self.run.step(steer, throttle, brake, reverse)
