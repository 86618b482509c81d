"""The tables of docs/loop.md on replanning and on missing inputs.

A planner cuts local paths from a course many times a second, and a loop takes them in.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

import popsteer
from popsteer import controllers
from studies.cars_loop import CAR
from studies.chain import Chain
from studies.layout import line

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

SPEED = 8.0
"""Speed of the car, whose pose is measured at the centre [m/s]."""
DT = 0.05
"""Its control period [s]."""
SUBSTEP = 0.005
"""Step of the simulation [s]."""


@dataclass
class Course:
    """A course as fine waypoints, from which paths are cut."""

    xy: Floats

    def __post_init__(self) -> None:
        lengths = np.hypot(*np.diff(self.xy, axis=0).T)
        self.s = np.concatenate(([0.0], np.cumsum(lengths)))
        self.last = 0

    def points(self, s: Floats) -> Floats:
        """Points at these distances along the course, straight on beyond its ends."""
        inside = np.clip(s, 0.0, self.s[-1])
        at = np.column_stack([np.interp(inside, self.s, column) for column in self.xy.T])
        before, after = np.minimum(s, 0.0), np.maximum(s - inside, 0.0)
        for (a, b), beyond in ((self.xy[:2], before), (self.xy[-2:], after)):
            at += beyond[:, None] * ((b - a) / np.hypot(*(b - a)))
        return at

    def nearest(self, x: float, y: float) -> tuple[float, float, int]:
        """The distance along the course of a place, the signed distance to it [m], its waypoint.

        Looked for from the last waypoint on.
        """
        low, high = max(self.last - 100, 0), self.last + 400
        squares = np.sum((self.xy[low:high] - (x, y)) ** 2, axis=1)
        k = low + int(np.argmin(squares))
        (ax, ay), (bx, by) = self.xy[max(k - 1, 0)], self.xy[min(k + 1, len(self.xy) - 1)]
        along = math.hypot(bx - ax, by - ay)
        to = x - self.xy[k][0], y - self.xy[k][1]
        ahead = (to[0] * (bx - ax) + to[1] * (by - ay)) / along
        aside = ((bx - ax) * to[1] - (by - ay) * to[0]) / along
        return float(self.s[k] + ahead), float(aside), k

    def whole(self, spacing: float = 0.5, noise: float = 0.0, seed: int = 0) -> popsteer.Path:
        """The course as one path."""
        s = np.arange(0.0, self.s[-1], spacing)
        points = self.points(s)
        return popsteer.Path(points + np.random.default_rng(seed).normal(0.0, noise, points.shape))


@dataclass
class Planner:
    """Cuts paths of 60 points from a course, each with a phase of its own."""

    course: Course
    behind: float = 5.0
    """Where a path starts behind the vehicle [m]."""
    spacing: float = 0.5
    noise: float = 0.0
    """Standard deviation of each coordinate of each point of each path [m]."""
    seed: int = 0

    def __post_init__(self) -> None:
        self.random = np.random.default_rng(self.seed)

    def path(self, s: float, aside: float = 0.0) -> popsteer.Path:
        """The path for a vehicle at the distance `s` along the course, moved aside by so much."""
        first = s - self.behind - self.spacing * self.random.random()
        points = self.course.points(np.asarray(first + self.spacing * np.arange(60), dtype=float))
        if aside:
            along = np.gradient(points, axis=0)
            along /= np.hypot(*along.T)[:, None]
            points = points + aside * np.column_stack((-along[:, 1], along[:, 0]))
        return popsteer.Path(points + self.random.normal(0.0, self.noise, points.shape))


@dataclass
class Run:
    """What a drive came to: errors of the tracked point, angles and commands, one a step."""

    errors: Floats
    angles: Floats
    commands: list[Any]
    controller: Any
    dts: Floats

    @property
    def mean(self) -> float:
        """Mean error after 5 s [m]."""
        return float(np.abs(self.errors[np.cumsum(self.dts) > 5.0]).mean())

    @property
    def roughness(self) -> float:
        """Changes of the angle from step to step after 5 s, rms [rad]."""
        late = self.angles[np.cumsum(self.dts) > 5.0]
        return float(np.sqrt(np.mean(np.diff(late) ** 2)))


def drive(
    controller: controllers.Controller,
    steps: int = 500,
    *,
    course: Course,
    replan: Callable[[int, float], popsteer.Path | None] = lambda _k, _s: None,
    arrives: Callable[[int], bool] = lambda _k: True,
    dts: Iterator[float] | None = None,
    step: Callable[..., Any] | None = None,
) -> Run:
    """Drive the car on a course with paths from `replan(step, distance)` where it gives one.

    An input that does not arrive is not a number, for `step_or_hold`. `step` takes a controller, a
    pose with speed, and a dt; control periods are whole numbers of `SUBSTEP`.
    """
    course.last = 0
    car = controller.vehicle
    start, ahead = course.points(np.array([0.0, 0.1]))
    yaw = math.atan2(ahead[1] - start[1], ahead[0] - start[0])
    x, y = start[0] - car.rear_axle * math.cos(yaw), start[1] - car.rear_axle * math.sin(yaw)
    chain = Chain(car, (x, y, yaw), SPEED, SUBSTEP, substeps=1)
    errors: list[float] = []
    commands: list[Any] = []
    periods: list[float] = []
    point = controller.tracked_point
    for k in range(steps):
        dt = DT if dts is None else next(dts)
        if commands:
            for _ in range(round(dt / SUBSTEP)):
                chain.advance(commands[-1].steer)
        x, y, yaw = chain.pose
        s, _, course.last = course.nearest(x, y)
        path = replan(k, s)
        if path is not None:
            controller.set_path(path)
        seen = (x, y, yaw, SPEED) if arrives(k) else (math.nan, y, yaw, SPEED)
        command = controller.step_or_hold(*seen, dt) if step is None else step(controller, seen, dt)
        commands.append(command)
        _, aside, _ = course.nearest(x + point * math.cos(yaw), y + point * math.sin(yaw))
        errors.append(aside)
        periods.append(dt)
        if abs(aside) > 20.0:
            break
    angles = np.array([command.steer for command in commands])
    return Run(np.array(errors), angles, commands, controller, np.array(periods))


_X = np.arange(0.0, 320.0, 0.05)
COURSE = Course(np.column_stack((_X, 4.0 * np.sin(0.1 * _X))))
"""Bends to either side, a waypoint every 0.05 m: a sine of 4 m, 25 m in radius."""
STEPS = 400
RATES = (1, 5, 10, 20)


def make(name: str, path: popsteer.Path | None = None, car: popsteer.Vehicle = CAR) -> Any:
    """A controller, on the whole course unless on another path."""
    return controllers.get(name).controller(COURSE.whole() if path is None else path, car)


@cache
def whole(name: str, noise: float = 0.0) -> Run:
    """Drive on the whole course as one path."""
    return drive(make(name, COURSE.whole(noise=noise)), STEPS, course=COURSE)


def replanned(name: str, planner: Planner, hz: int, **options: Any) -> Run:
    """Drive on local paths that come so many times a second."""
    every = round(1.0 / DT) // hz

    def replan(k: int, s: float) -> popsteer.Path | None:
        return planner.path(s) if k % every == 0 else None

    controller = make(name, planner.path(-CAR.rear_axle))
    return drive(controller, STEPS, course=planner.course, replan=replan, **options)


@cache
def local(name: str, hz: int, behind: float, noise: float = 0.0) -> Run:
    """Drive on local paths that begin so far behind the vehicle."""
    return replanned(name, Planner(COURSE, behind=behind, noise=noise, seed=hz), hz)


def every_second(k: int) -> bool:
    """Tell whether an input arrives: every second one does."""
    return k % 2 == 0


def gaps(k: int) -> bool:
    """Tell the same with a gap every 2 s, of 1 to 9 inputs: up to 0.5 s from input to input."""
    return k % 40 >= (1, 5, 9, 3, 7)[k // 40 % 5]


def jitter() -> Iterator[float]:
    """Control periods of a half to one and a half of the usual one."""
    rng = random.Random(7)
    while True:
        yield SUBSTEP * rng.randint(5, 15)


def replanning_lines() -> list[str]:
    """Mean errors, and how much calmer the angle is on the whole course."""
    lines = []
    for name in controllers.names():
        ways = [(hz, behind) for hz in RATES for behind in (5.0, 0.3)]
        plain = max(local(name, *way).mean for way in ways)
        noisy = [local(name, *way, 0.02) for way in ways]
        rough = max(run.roughness for run in noisy) / whole(name, 0.02).roughness
        means = (whole(name).mean, plain, whole(name, 0.02).mean, max(run.mean for run in noisy))
        title = controllers.get(name).title
        lines.append(line(title, *(f"{mean:.3f}" for mean in means), f"{rough:.2f}"))
    return lines


def input_lines() -> list[str]:
    """Mean errors where inputs fail to come."""
    lines = []
    for name in controllers.names():
        runs = [whole(name)]
        runs += [drive(make(name), STEPS, course=COURSE, arrives=p) for p in (every_second, gaps)]
        runs.append(drive(make(name), STEPS, course=COURSE, dts=jitter()))
        lines.append(line(controllers.get(name).title, *(f"{run.mean:.3f}" for run in runs)))
    return lines
