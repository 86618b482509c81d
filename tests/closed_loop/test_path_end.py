"""The last metres of a path, and those beyond it: as quiet as the rest."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

import popsteer
from popsteer import controllers, presets, sim, vehicles
from popsteer.lab.common.names import title_of
from popsteer.sim import Settings
from tests.closed_loop.paths import track
from tests.helpers import authors_data
from tests.pages.layout import line, table

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from popsteer.controllers import Controller
    from popsteer.sim.closed_loop import Pose

PLANT = "carla-identified"
CAR = vehicles.get(PLANT)
LAWS = ("pop", "pure-pursuit", "stanley", "pid", "preview-pop")
TO_THE_END = Settings(stop_distance=0.0, time_limit=300.0)


class Shortened:
    """A controller on a path without its last metres, driven along the whole of it."""

    def __init__(self, law: Controller) -> None:
        self.tracked_point = law.tracked_point
        self._law = law

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float, /) -> popsteer.Command:
        return self._law.step(x, y, yaw, speed, dt)


def courses(name: str) -> tuple[popsteer.Path, Pose | None]:
    if name == "authors":
        path = popsteer.Path.from_csv(authors_data() / "waypoints.csv")
        return path, (-183.797, 79.760, -1.574)
    return track(name), None


def controller(name: str, path: popsteer.Path, preset: str) -> Controller:
    make: Callable[..., Controller] = controllers.get(name).controller
    return make(path, CAR, presets.get(name, preset))


def shortened(path: popsteer.Path, length: float) -> popsteer.Path:
    kept = path.s <= path.length - length
    speed = None if path.speed is None else path.speed[kept]
    return popsteer.Path(np.column_stack((path.x, path.y))[kept], speed=speed)


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


def end_lines(course: str) -> list[str]:
    """Lines of the table of docs/edges.md."""
    path, start = courses(course)
    cut = 15.0
    lines = []
    for name in ("pop", "pure-pursuit"):
        for preset in ("default", "paper", "published-code"):
            arc, steer = angles_by_arc(controller(name, path, preset), path, start)
            whole = np.degrees(np.abs(steer[arc > path.length - 10.0]).max())
            law = Shortened(controller(name, shortened(path, cut), preset))
            arc, steer = angles_by_arc(law, path, start)
            past = f"{np.degrees(np.abs(steer[arc > path.length - cut]).max()):.1f}"
            if arc[-1] < path.length - 2.0:
                past = f"{past}, circles"
            lines.append(line(title_of(name), preset, f"{whole:.1f}", past))
    return lines


def in_the_last_over_rms_before(
    arc: NDArray[np.float64], steer: NDArray[np.float64], end: float
) -> float:
    """Largest angle in the last 10 m before `end` [m] and beyond, over the rms before."""
    last = arc > end - 10.0
    assert last.sum() > 10
    return float(np.abs(steer[last]).max() / np.sqrt(np.mean(steer[~last] ** 2)))


@pytest.mark.parametrize("course", ["authors", "racetrack", "slalom", "double-lane-change"])
@pytest.mark.parametrize("name", LAWS)
def test_angle_in_the_last_10_m_keeps_within_twice_its_rms(name: str, course: str) -> None:
    path, start = courses(course)
    arc, steer = angles_by_arc(controller(name, path, "default"), path, start)
    assert in_the_last_over_rms_before(arc, steer, path.length) <= 2.0


@pytest.mark.parametrize("course", ["authors", "racetrack"])
@pytest.mark.parametrize("name", LAWS)
def test_angle_past_the_end_keeps_within_twice_its_rms(name: str, course: str) -> None:
    path, start = courses(course)
    cut = 15.0
    law = controller(name, shortened(path, cut), "default")
    arc, steer = angles_by_arc(Shortened(law), path, start)
    assert arc[-1] > path.length - 0.5 * cut
    assert in_the_last_over_rms_before(arc, steer, path.length - cut) <= 2.0


def test_page_table_of_the_end_is_what_is_driven() -> None:
    assert table("edges.md", "end") == end_lines("racetrack")


@pytest.mark.parametrize("course", ["authors", "racetrack"])
def test_angle_of_the_published_pure_pursuit_swings_at_the_end(course: str) -> None:
    """The search stops at the last waypoint; its bearing runs through 90° as that is passed."""
    path, start = courses(course)
    arc, steer = angles_by_arc(controller("pure-pursuit", path, "published-code"), path, start)
    assert in_the_last_over_rms_before(arc, steer, path.length) > 5.0
    assert np.degrees(np.abs(steer[arc > path.length - 10.0]).max()) == pytest.approx(22.0, abs=0.5)
