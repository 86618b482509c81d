"""A bicycle with lag and dead time, apart from the library's own plants and equations."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

import popsteer
from popsteer import AdaptParams, controllers

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from popsteer.controllers import Params

_SUBSTEPS = 4
_SMALL = 5e-5  # change of the angle in a step that the grid of the candidates may cause [rad]
_ASTRAY = 0.3  # an angle that no stable loop comes to from the start below [rad]


class Car(NamedTuple):
    """A kinematic bicycle about the middle of its rear axle."""

    wheelbase: float
    lag: float
    dead_time: float

    @classmethod
    def of(cls, vehicle: popsteer.Vehicle) -> Car:
        return cls(vehicle.turning_length(0.0), vehicle.steer_lag, vehicle.dead_time)


def straight_path(length: float) -> popsteer.Path:
    x = np.arange(-20.0, length)
    return popsteer.Path(np.column_stack((x, np.zeros_like(x))))


def roll(
    law: controllers.Controller,
    car: Car,
    speed: float,
    pose: tuple[float, float, float],
    dt: float,
    steps: int,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Drive at constant speed; positions (x, y) and commanded angles at each control step."""
    x, y, yaw = pose
    yaw_rate = 0.0
    whole = math.floor(car.dead_time / dt + 1e-9)
    early = max(car.dead_time - whole * dt, 0.0)
    # The wheels stand straight until the first command arrives.
    commands = [0.0] * (whole + 1)
    places = []
    for _ in range(steps):
        places.append((x, y))
        commands.append(law.steer(x, y, yaw, speed, dt))
        for angle, duration in ((commands[-2 - whole], early), (commands[-1 - whole], dt - early)):
            target = speed * math.tan(angle) / car.wheelbase
            h = duration / _SUBSTEPS
            for _ in range(_SUBSTEPS if duration > 0.0 else 0):
                left = math.exp(-h / car.lag) if car.lag > 0.0 else 0.0
                turned = target * h + (yaw_rate - target) * car.lag * (1.0 - left)
                middle = yaw + 0.5 * turned
                x += speed * h * math.cos(middle)
                y += speed * h * math.sin(middle)
                yaw += turned
                yaw_rate = target + (yaw_rate - target) * left
    return np.array(places), np.array(commands[whole + 1 :])


class Given(NamedTuple):
    """A controller by its name, its tuning, the vehicle that it is told, and how it adapts."""

    name: str
    params: Params
    vehicle: popsteer.Vehicle
    adapt: AdaptParams | Literal["auto"] | None = "auto"

    def in_small_signals(self) -> Given:
        """The same, as it answers small signals in proportion.

        With many candidates, without a limit within which a loop that grows would oscillate on, and
        with what is estimated of the turning taken as constant.
        """
        params: Any = self.params
        if isinstance(params, popsteer.PopParams):
            params = params.replace(candidate_count=20_001)
        vehicle = self.vehicle.replace(max_lateral_acceleration=None)
        adapt = AdaptParams() if self.adapt == "auto" else self.adapt
        adapt = None if adapt is None else adapt.replace(turn_time=0.0)
        return self._replace(params=params, vehicle=vehicle, adapt=adapt)

    def on(self, path: popsteer.Path) -> controllers.Controller:
        make: Callable[..., controllers.Controller] = controllers.get(self.name).controller
        return make(path, self.vehicle, self.params, adapt=self.adapt)


def grows(given: Given, car: Car, speed: float, duration: float, dt: float = 0.05) -> bool:
    """Whether a small disturbance is still growing after a while."""
    steps = math.ceil(duration / dt)
    law = given.on(straight_path(speed * duration + 100.0))
    _, angles = roll(law, car, speed, (0.0, 0.02, 0.0), dt, steps)
    if np.abs(angles).max() > _ASTRAY:
        return True
    moves = np.abs(np.diff(angles))
    early = moves[steps // 3 : 2 * steps // 3].max()
    late = moves[2 * steps // 3 :].max()
    return bool(late > early and late > _SMALL)


def critical_dead_time(
    given: Given,
    car: Car,
    speed: float,
    guess: float,
    dt: float = 0.05,
    *,
    most: float | None = None,
) -> float:
    """Find by bisection the dead time to add at which a small disturbance no longer dies out."""

    def unstable(dead_time: float) -> bool:
        late = car._replace(dead_time=car.dead_time + dead_time)
        return grows(given, late, speed, 20.0 + 40.0 * guess, dt)

    low, high = 0.0, 2.0 * guess + 0.05 if most is None else most
    assert not unstable(low)
    assert unstable(high)
    while high - low > 0.002 * guess + 1e-4:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if unstable(middle) else (middle, high)
    return 0.5 * (low + high)


def driven_preview_offset(given: Given, car: Car, radius: float, speed: float) -> float:
    """Drive preview POP a lap of a circle; its tracked point's offset to the inside, at last."""
    count = round(2.0 * math.pi * radius / 0.5)
    angle = np.arange(count) * (2.0 * math.pi / count)
    xy = radius * np.column_stack((np.sin(angle), 1.0 - np.cos(angle)))
    law = given.on(popsteer.Path(xy, closed=True))
    steps = math.ceil(2.0 * math.pi * radius / speed / 0.05)
    places, _ = roll(law, car, speed, (0.0, 0.0, 0.0), 0.05, steps)
    turned = places[3 * steps // 4 :] - (0.0, radius)
    # The rear axle moves where it points, so what lies ahead of it is a little further out.
    return radius - float(np.hypot(np.hypot(*turned.T), law.tracked_point).mean())
