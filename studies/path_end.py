"""The angle on the last metres of a path, and past its end: a table of docs/edges.md."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

import popsteer
from popsteer import controllers, presets, sim, vehicles
from popsteer.sim import Settings
from studies.layout import course, line

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from popsteer.controllers import Controller
    from popsteer.sim import Pose

PLANT = "carla-identified"
CAR = vehicles.get(PLANT)
TO_THE_END = Settings(stop_distance=0.0, time_limit=300.0)
CUT = 15.0
"""How much shorter the controller's path is where it is driven past its end [m]."""


class Shortened:
    """A controller on a path without its last metres, driven along the whole of it."""

    def __init__(self, law: Controller) -> None:
        self.tracked_point = law.tracked_point
        self._law = law

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float, /) -> popsteer.Command:
        return self._law.step(x, y, yaw, speed, dt)


def controller(name: str, path: popsteer.Path, preset: str) -> Controller:
    """Make a controller of the plant's vehicle."""
    make: Callable[..., Controller] = controllers.get(name).controller
    return make(path, CAR, presets.get(name, preset))


def shortened(name: str, path: popsteer.Path, preset: str) -> Shortened:
    """Make a controller whose path ends `CUT` earlier."""
    kept = path.s <= path.length - CUT
    speed = None if path.speed is None else path.speed[kept]
    shorter = popsteer.Path(np.column_stack((path.x, path.y))[kept], speed=speed)
    return Shortened(controller(name, shorter, preset))


def angles_by_arc(
    law: Controller | Shortened, path: popsteer.Path, start: Pose | None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where on the path the front axle was at each step [m], and the angle commanded [rad]."""
    done = sim.run(law, PLANT, path=path, start=start, settings=TO_THE_END)
    records = done.records
    x = records["x"] + CAR.front_axle * np.cos(records["yaw"])
    y = records["y"] + CAR.front_axle * np.sin(records["yaw"])
    arc = np.array([path.project(*point).arc_length for point in zip(x, y, strict=True)])
    return arc, records["steer"]


def end_lines() -> list[str]:
    """A row for each preset of the controllers that look ahead."""
    path, start = course("racetrack")
    lines = []
    for name in ("pop", "pure-pursuit"):
        for preset in ("default", "paper", "published-code"):
            arc, steer = angles_by_arc(controller(name, path, preset), path, start)
            whole = np.degrees(np.abs(steer[arc > path.length - 10.0]).max())
            arc, steer = angles_by_arc(shortened(name, path, preset), path, start)
            past = f"{np.degrees(np.abs(steer[arc > path.length - CUT]).max()):.1f}"
            if arc[-1] < path.length - 2.0:
                past = f"{past}, circles"
            lines.append(line(controllers.get(name).title, preset, f"{whole:.1f}", past))
    return lines
