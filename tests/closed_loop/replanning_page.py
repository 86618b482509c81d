"""The tables of docs/loop.md on replanning and on missing inputs."""

from __future__ import annotations

import random
from functools import cache
from typing import TYPE_CHECKING, Any

import popsteer
from popsteer import controllers
from tests.closed_loop.replanning import CAR, DT, SUBSTEP, Course, Planner, Run, drive, s_bends

if TYPE_CHECKING:
    from collections.abc import Iterator

COURSE = Course(s_bends())
STEPS = 400
TRACKING = controllers.names()
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


def replanning_rows() -> list[list[str]]:
    """Mean errors, and how much calmer the angle is on the whole course."""
    rows = []
    for name in TRACKING:
        ways = [(hz, behind) for hz in RATES for behind in (5.0, 0.3)]
        plain = max(local(name, *way).mean for way in ways)
        noisy = [local(name, *way, 0.02) for way in ways]
        rough = max(run.roughness for run in noisy) / whole(name, 0.02).roughness
        means = (whole(name).mean, plain, whole(name, 0.02).mean, max(run.mean for run in noisy))
        rows.append(
            [controllers.get(name).title, *(f"{mean:.3f}" for mean in means), f"{rough:.2f}"]
        )
    return rows


def input_rows() -> list[list[str]]:
    """Mean errors where inputs fail to come."""
    rows = []
    for name in TRACKING:
        runs = [whole(name)]
        runs += [drive(make(name), STEPS, course=COURSE, arrives=p) for p in (every_second, gaps)]
        runs.append(drive(make(name), STEPS, course=COURSE, dts=jitter()))
        rows.append([controllers.get(name).title, *(f"{run.mean:.3f}" for run in runs)])
    return rows
