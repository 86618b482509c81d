"""The chain from command to motion in plain Python, apart from the library's plants and equations.

wheel' = clip((command(t - dead_time) + steer_offset - wheel) / steer_lag, ± max_steer_rate)
|wheel| <= max_steer
yaw'   = speed tan(wheel) / (turning_wheelbase + understeer speed²)
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeVar, cast

import numpy as np

import popsteer
from popsteer import laws

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from popsteer.laws import Params

_P = TypeVar("_P", bound="Params")
_SMALL = 5e-5  # change of the angle in a step that the grid of the candidates may cause [rad]
_ASTRAY = 0.3  # an angle that no stable loop comes to from the start below [rad]


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
        self.x, self.y = (
            x + self.no_slip * math.cos(self.yaw),
            y + self.no_slip * math.sin(self.yaw),
        )
        self.wheel = max(-car.max_steer, min(car.steer_offset, car.max_steer))
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
        turning = car.wheelbase if car.turning_wheelbase is None else car.turning_wheelbase
        length = turning + car.understeer * self.speed * self.speed
        self.yaw_rate = self.speed * math.tan(mean) / length
        middle = self.yaw + 0.5 * self.yaw_rate * h
        self.x += self.speed * h * math.cos(middle)
        self.y += self.speed * h * math.sin(middle)
        self.yaw += self.yaw_rate * h


def straight_path(length: float) -> popsteer.Path:
    x = np.arange(-20.0, length)
    return popsteer.Path(np.column_stack((x, np.zeros_like(x))))


def in_small_signals(params: _P) -> _P:
    """Parameters with which a controller answers small signals in proportion, and growing ones."""
    if isinstance(params, popsteer.PopParams):
        return cast("_P", params.replace(candidate_count=20_001))
    return params


def unaware(car: popsteer.Vehicle) -> popsteer.Vehicle:
    """A car as a controller knows it that does not predict through its dead time.

    The lateral acceleration is free: else a loop that grows settles to a swing, at high speed a
    small one.
    """
    return car.replace(dead_time=0.0, max_lateral_acceleration=None)


def roll(
    controller: laws.Controller,
    car: popsteer.Vehicle,
    speed: float,
    pose: tuple[float, float, float],
    dt: float,
    steps: int,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Drive at constant speed; positions (x, y) and commanded angles at each control step."""
    chain = Chain(car, pose, speed, dt)
    places, angles = [], []
    for _ in range(steps):
        x, y, yaw = chain.pose
        places.append((x, y))
        angles.append(controller.steer(x, y, yaw, speed, dt))
        chain.advance(angles[-1])
    return np.array(places), np.array(angles)


def grows(
    name: str,
    params: Params,
    car: popsteer.Vehicle,
    speed: float,
    duration: float,
    dt: float = 0.05,
    *,
    known: popsteer.Vehicle | None = None,
) -> bool:
    """Whether a small disturbance is still growing after a while; `known` is what is believed."""
    steps = math.ceil(duration / dt)
    known = unaware(car) if known is None else known
    # The registry pairs each controller with its parameters; the type checker cannot see that.
    controller = laws.get(name).controller(
        straight_path(speed * duration + 100.0),
        known,
        params,  # type: ignore[arg-type]
    )
    _, angles = roll(controller, car, speed, (0.0, 0.02, 0.0), dt, steps)
    if np.abs(angles).max() > _ASTRAY:
        return True
    moves = np.abs(np.diff(angles))
    early = moves[steps // 3 : 2 * steps // 3].max()
    late = moves[2 * steps // 3 :].max()
    return bool(late > early and late > _SMALL)


def critical_dead_time(
    name: str,
    params: Params,
    car: popsteer.Vehicle,
    speed: float,
    guess: float,
    dt: float = 0.05,
    *,
    known: popsteer.Vehicle | None = None,
) -> float:
    """Find by bisection the dead time at which a small disturbance no longer dies out."""

    def unstable(dead_time: float) -> bool:
        late = car.replace(dead_time=dead_time)
        return grows(name, params, late, speed, 20.0 + 40.0 * guess, dt, known=known)

    low, high = 0.0, 2.0 * guess + 0.05
    assert not unstable(low)
    assert unstable(high)
    while high - low > 0.002 * guess + 1e-4:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if unstable(middle) else (middle, high)
    return 0.5 * (low + high)


def circle(radius: float, spacing: float = 0.5) -> popsteer.Path:
    """Once round to the left, from the origin along x."""
    count = round(2.0 * math.pi * radius / spacing)
    angle = np.arange(count) * (2.0 * math.pi / count)
    xy = radius * np.column_stack((np.sin(angle), 1.0 - np.cos(angle)))
    return popsteer.Path(xy, closed=True)


def driven_preview_offset(
    controller: popsteer.PreviewPop, car: popsteer.Vehicle, radius: float, speed: float
) -> float:
    """Drive preview POP a lap of its `circle`; the offset that it keeps to the inside, at last."""
    steps = math.ceil(2.0 * math.pi * radius / speed / 0.05)
    places, _ = roll(controller, car, speed, (0.0, 0.0, 0.0), 0.05, steps)
    turned = places[3 * steps // 4 :] - (0.0, radius)
    # The rear axle moves where it points, so what lies ahead of it is a little further out.
    ahead = controller.tracked_point
    return radius - float(np.hypot(np.hypot(*turned.T), ahead).mean())
