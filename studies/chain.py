"""The chain from a command to the motion of a car, integrated by itself in plain Python."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import popsteer


class Chain:
    """A car at constant speed; `pose` is that of its point."""

    def __init__(
        self,
        car: popsteer.Vehicle,
        pose: tuple[float, float, float],
        speed: float,
        dt: float,
        substeps: int = 4,
    ) -> None:
        self.car, self.speed, self.dt, self.substeps = car, speed, dt, substeps
        self.no_slip = car.rear_axle if car.no_slip_point is None else car.no_slip_point
        x, y, self.yaw = pose
        self.x = x + self.no_slip * math.cos(self.yaw)
        self.y = y + self.no_slip * math.sin(self.yaw)
        self.wheel = max(-car.max_steer, min(car.steer_offset, car.max_steer))
        # How far the steering turns before the wheels turn back [rad], and where these are.
        self.backlash = 0.0
        self.road_wheel = self.wheel
        self.yaw_rate = 0.0
        # How many control periods a command is late, and how much longer in its last one.
        self.whole = math.floor(car.dead_time / dt + 1e-9)
        self.early = max(car.dead_time - self.whole * dt, 0.0)
        # The wheels are commanded straight until the first command arrives.
        self.commands = [0.0] * (self.whole + 1)

    @property
    def pose(self) -> tuple[float, float, float]:
        x = self.x - self.no_slip * math.cos(self.yaw)
        return x, self.y - self.no_slip * math.sin(self.yaw), self.yaw

    def advance(self, command: float) -> None:
        """Drive on for a control period."""
        self.commands.append(command)
        arriving = (self.commands[-2 - self.whole], self.commands[-1 - self.whole])
        for angle, duration in zip(arriving, (self.early, self.dt - self.early), strict=True):
            for _ in range(self.substeps if duration > 0.0 else 0):
                self._move(angle, duration / self.substeps)

    def _move(self, command: float, h: float) -> None:
        car = self.car
        target = max(-car.max_steer, min(command + car.steer_offset, car.max_steer))
        kept = math.exp(-h / car.steer_lag) if car.steer_lag > 0.0 else 0.0
        gap = self.wheel - target
        wheel, mean = target + gap * kept, target + gap * (1.0 - kept) * car.steer_lag / h
        if car.max_steer_rate is not None and abs(wheel - self.wheel) > car.max_steer_rate * h:
            wheel = self.wheel + math.copysign(car.max_steer_rate * h, target - self.wheel)
            mean = 0.5 * (self.wheel + wheel)
        self.wheel = wheel
        if self.backlash > 0.0:
            play = 0.5 * self.backlash
            mean = max(mean - play, min(self.road_wheel, mean + play))
        self.road_wheel = mean
        turning = car.wheelbase if car.turning_wheelbase is None else car.turning_wheelbase
        length = turning + car.understeer * self.speed * self.speed
        self.yaw_rate = self.speed * math.tan(mean) / length
        middle = self.yaw + 0.5 * self.yaw_rate * h
        self.x += self.speed * h * math.cos(middle)
        self.y += self.speed * h * math.sin(middle)
        self.yaw += self.yaw_rate * h
