"""The tables of docs/theory.md, computed and driven."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import popsteer
from popsteer import controllers, presets, sim, vehicles
from popsteer.lab.stability import carrot_offset, driven_offset, margins, preview_offset
from studies.layout import line, track
from studies.rolling import Car, Given, critical_dead_time, driven_preview_offset

if TYPE_CHECKING:
    from popsteer.sim import OwnSimpleController

CAR = vehicles.get("paper")
SPEEDS = (5.0, 10.0, 15.0, 20.0)


def margins_of(name: str) -> list[tuple[float, float]]:
    """Dead-time margin [ms] at each of `SPEEDS`, computed and driven."""
    given = Given(name, presets.get(name, "default"), CAR).in_small_signals()
    found = []
    for speed in SPEEDS:
        computed = margins(given.params, CAR, speed).dead_time
        driven = critical_dead_time(given, Car.of(CAR), speed, computed)
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


class _Late:
    """A controller whose commands are held back by some steps."""

    def __init__(self, law: controllers.Controller, steps: int) -> None:
        self.path = law.path
        self.tracked_point = law.tracked_point
        self._law = law
        self._in_flight = [0.0] * steps

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float, /) -> float:
        self._in_flight.append(self._law.steer(x, y, yaw, speed, dt))
        return self._in_flight.pop(0)


def late_line(name: str) -> str:
    """Errors of a controller whose commands come 0 to 300 ms late."""
    path = track("racetrack")
    given = Given(name, presets.get(name, "default"), vehicles.get("carla-identified"))
    cells = []
    for milliseconds in (0, 50, 100, 150, 200, 300):
        late: OwnSimpleController = _Late(given.on(path), milliseconds // 50)
        metrics = sim.run(late, path=path).metrics
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
                driven_preview_offset(given, Car.of(CAR), 50.0, 15.0),
            ]
        dead_time = 1e3 * margins(params, CAR, 15.0).dead_time
        texts = [f"{offset:.3f}".replace("-", "−") for offset in offsets]
        lines.append(line(f"{cost:g}", f"{dead_time:.0f}", *texts))
    return lines
