"""The tables of docs/theory.md, computed and driven.

What is driven is a `Chain`, apart from the library's own plants.
"""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

import popsteer
from popsteer import AdaptParams, controllers, presets, sim, vehicles
from popsteer.lab.common.experiment import controller
from popsteer.lab.stability import margins
from studies.carrot import carrot_offset, circle, driven_offset, preview_offset
from studies.chain import Chain
from studies.layout import line, track

if TYPE_CHECKING:
    from numpy.typing import NDArray


_SMALL = 5e-5  # change of the angle in a step that the grid of the candidates may cause [rad]
_ASTRAY = 0.3  # an angle that no stable loop comes to from the start below [rad]


def straight_path(length: float) -> popsteer.Path:
    x = np.arange(-20.0, length)
    return popsteer.Path(np.column_stack((x, np.zeros_like(x))))


def roll(
    law: controllers.Controller,
    car: popsteer.Vehicle,
    speed: float,
    pose: tuple[float, float, float],
    dt: float,
    steps: int,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Drive at constant speed; positions (x, y) and commanded angles at each control step."""
    chain = Chain(car, pose, speed, dt)
    places, commands = [], []
    for _ in range(steps):
        x, y, yaw = chain.pose
        places.append((x, y))
        commands.append(law.steer(x, y, yaw, speed, dt))
        chain.advance(commands[-1])
    return np.array(places), np.array(commands)


class Given(NamedTuple):
    """A controller by its name, its tuning, the vehicle that it is told, and how it adapts."""

    name: str
    params: controllers.Params
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

    def on(self, path: popsteer.Path) -> Any:
        return controller(self.name, path, self.vehicle, self.params, self.adapt)


def grows(
    given: Given, car: popsteer.Vehicle, speed: float, duration: float, dt: float = 0.05
) -> bool:
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
    car: popsteer.Vehicle,
    speed: float,
    guess: float,
    dt: float = 0.05,
    *,
    most: float | None = None,
) -> float:
    """Find by bisection the dead time to add at which a small disturbance no longer dies out."""

    def unstable(dead_time: float) -> bool:
        late = car.replace(dead_time=car.dead_time + dead_time)
        return grows(given, late, speed, 20.0 + 40.0 * guess, dt)

    low, high = 0.0, 2.0 * guess + 0.05 if most is None else most
    assert not unstable(low)
    assert unstable(high)
    while high - low > 0.002 * guess + 1e-4:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if unstable(middle) else (middle, high)
    return 0.5 * (low + high)


def driven_preview_offset(
    given: Given, car: popsteer.Vehicle, radius: float, speed: float
) -> float:
    """Drive preview POP a lap of a circle; its tracked point's offset to the inside, at last."""
    law = given.on(popsteer.Path(circle(radius), closed=True))
    steps = math.ceil(2.0 * math.pi * radius / speed / 0.05)
    places, _ = roll(law, car, speed, (0.0, 0.0, 0.0), 0.05, steps)
    turned = places[3 * steps // 4 :] - (0.0, radius)
    # The rear axle moves where it points, so what lies ahead of it is a little further out.
    return radius - float(np.hypot(np.hypot(*turned.T), law.tracked_point).mean())


CAR = vehicles.get("paper")
SPEEDS = (5.0, 10.0, 15.0, 20.0)


def margins_of(name: str) -> list[tuple[float, float]]:
    """Dead-time margin [ms] at each of `SPEEDS`, computed and driven."""
    given = Given(name, presets.get(name, "default"), CAR).in_small_signals()
    found = []
    for speed in SPEEDS:
        computed = margins(given.params, CAR, speed).dead_time
        driven = critical_dead_time(given, CAR, speed, computed)
        found.append((1e3 * computed, 1e3 * driven))
    return found


def margin_lines() -> list[str]:
    return [
        line(
            controllers.get(name).title,
            *(f"{each:.1f}" for pair in margins_of(name) for each in pair),
        )
        for name in controllers.names()
    ]


def carrot_lines() -> list[str]:
    lines = []
    for radius in (15.0, 30.0, 60.0, 120.0):
        cells = []
        for plant in ("kinematic-bicycle", "carla-identified"):
            speed = math.sqrt(2.0 * radius)
            driven, distance = driven_offset(radius, plant, speed)
            cells += [carrot_offset(distance, radius, vehicles.get(plant), speed), driven]
        lines.append(line(f"{radius:.0f}", *(f"{each:.2f}" for each in cells)))
    return lines


def _late(law: controllers.Controller, steps: int) -> Any:
    """Hold the commands of a controller back by some steps."""
    in_flight = [0.0] * steps

    def step(x: float, y: float, yaw: float, speed: float, dt: float, /) -> float:
        in_flight.append(law.steer(x, y, yaw, speed, dt))
        return in_flight.pop(0)

    return SimpleNamespace(step=step, path=law.path, tracked_point=law.tracked_point)


def late_line(name: str) -> str:
    """Errors of a controller whose commands come 0 to 300 ms late."""
    path = track("racetrack")
    given = Given(name, presets.get(name, "default"), vehicles.get("carla-identified"))
    cells = []
    for milliseconds in (0, 50, 100, 150, 200, 300):
        metrics = sim.run(_late(given.on(path), milliseconds // 50), path=path).metrics
        error = f"{metrics.settled_mean_abs_cross_track_error:.3f}"
        cells.append(error if metrics.finished else "off the road")
    return line(controllers.get(name).title, *cells)


def choice_lines() -> list[str]:
    lines = []
    for cost in (0.05, 0.25, 1.0):
        params = popsteer.PreviewPopParams(steer_rate_cost=cost)
        offsets = []
        for share in (1.0, 1.15, 0.85):
            believed = CAR.replace(turning_wheelbase=share * 3.0)
            given = Given("preview-pop", params, believed, adapt=None)
            offsets += [
                preview_offset(params, CAR, 50.0, 15.0, believed=believed, adapt=None),
                driven_preview_offset(given, CAR, 50.0, 15.0),
            ]
        dead_time = 1e3 * margins(params, CAR, 15.0).dead_time
        texts = [f"{offset:.3f}".replace("-", "−") for offset in offsets]
        lines.append(line(f"{cost:g}", f"{dead_time:.0f}", *texts))
    return lines
