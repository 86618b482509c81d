"""A car's loop: one car, driven by each controller through what a real loop has.

The car is integrated by `Chain`, apart from popsteer.sim: 2.7 m between its axles, its pose at the
centre, slow wheels, a lag and a dead time. All of that is told to the controllers.

    python -m studies.pages "cars loop"     # the table of docs/loop.md
"""

from __future__ import annotations

import functools
import math
import random
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import popsteer
from popsteer import controllers
from studies.chain import Chain
from studies.layout import line
from tests.trust.car import TOLD, bends

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy.typing as npt

    Curve = npt.NDArray[np.float64]

CAR = TOLD
NAMES = ("preview-pop", "pop", "stanley", "pure-pursuit", "pid")
CONTROLLERS: dict[str, Any] = {law.title: law.controller for law in map(controllers.get, NAMES)}
SUBSTEP = 1e-3
"""The longest step of the integration [s]: 50 in a control period of 50 ms."""
SETTLING = 5.0
"""How long after the start errors do not count [s]."""


def wide_bends() -> Curve:
    """Bends that turn as fast at 30 m/s as the others at 8 m/s."""
    return bends(length=975.0, stretch=3.75)


def straight() -> Curve:
    """A straight line."""
    return np.column_stack((np.arange(0.0, 260.0, 0.5), np.zeros(520)))


def recorded(seed: int = 1) -> Curve:
    """The bends as a drive recorded them: every 0.2 m, with 5 cm of noise on each position."""
    xy = bends(spacing=0.2)
    return xy + np.random.default_rng(seed).normal(0.0, 0.05, xy.shape)


def staircase(cell: float = 0.25) -> Curve:
    """The bends as a planner on a grid gives them: from cell to cell, along x or along y."""
    cells = np.rint(bends(spacing=0.02) / cell).astype(int)
    stairs = [tuple(cells[0])]
    for x, y in cells[1:]:
        if x != stairs[-1][0]:
            stairs.append((x, stairs[-1][1]))
        if y != stairs[-1][1]:
            stairs.append((x, y))
    return cell * np.array(stairs, dtype=float)


@dataclass(frozen=True)
class Loop:
    """What a loop is like; in SI units, and radians.

    The car goes along `course`, the controller is given the path of other `waypoints`. Commands are
    rounded to multiples of `quantum`; `noise` has the standard deviations of the measured position,
    heading and speed. It stands for a while before it drives off, and after the settling time the
    measured position jumps to the left.
    """

    speed: float = 8.0
    dt: float = 0.05
    seconds: float = 25.0
    course: Callable[[], Curve] = bends
    waypoints: Callable[[], Curve] | None = None
    car: popsteer.Vehicle = CAR
    quantum: float = 0.0
    backlash: float = 0.0
    noise: tuple[float, float, float] = (0.0, 0.0, 0.0)
    standing: float = 0.0
    jump: float = 0.0


NOISE = (0.05, 0.01, 0.05)
ROWS: dict[str, Loop] = {
    "as it is": Loop(),
    "5 Hz": Loop(dt=0.2),
    "10 Hz": Loop(dt=0.1),
    "50 Hz": Loop(dt=0.02),
    "100 Hz": Loop(dt=0.01),
    "commands quantised to 1°": Loop(quantum=math.radians(1.0)),
    "1° of backlash": Loop(backlash=math.radians(1.0)),
    "waypoints every 0.2 m with 5 cm of noise": Loop(waypoints=recorded),
    "a grid planner's staircase of 0.25 m": Loop(waypoints=staircase),
    "localisation noise of 5 cm, 0.01 rad, 0.05 m/s": Loop(noise=NOISE),
    "standing 20 s in that noise, then 5 m/s": Loop(standing=20.0, speed=5.0, noise=NOISE),
    "0.3 m/s": Loop(speed=0.3, seconds=40.0),
    "a lag of 0.5 s, given": Loop(car=CAR.replace(steer_lag=0.5)),
    "30 m/s, bends of 350 m": Loop(speed=30.0, course=wide_bends),
}
JUMP = Loop(course=straight, jump=1.0)


class Outcome(NamedTuple):
    """Error of the rear axle after the settling time [m]: mean, largest, and largest to the right.

    All errors are those against the course.
    """

    mean: float
    largest: float
    rightmost: float


@functools.cache
def drive(controller: Any, loop: Loop) -> Outcome:
    """Drive the loop with a controller on its defaults."""
    course = loop.course()
    truth = popsteer.Path(course)
    steering = controller(popsteer.Path((loop.waypoints or loop.course)()), loop.car)
    (x, y), (along, aside) = course[0], course[1] - course[0]
    yaw = math.atan2(aside, along)
    ahead = -loop.car.rear_axle
    start = (x + ahead * math.cos(yaw), y + ahead * math.sin(yaw), yaw)
    chain = Chain(loop.car, start, 0.0, loop.dt, math.ceil(loop.dt / SUBSTEP - 1e-9))
    chain.backlash = loop.backlash
    rng = random.Random(7)
    by_position, by_heading, by_speed = loop.noise
    errors = []
    first = loop.standing + SETTLING
    for k in range(round((loop.standing + loop.seconds) / loop.dt)):
        time = k * loop.dt
        chain.speed = loop.speed if time >= loop.standing else 0.0
        x, y, yaw = chain.pose
        jump = loop.jump if time >= first else 0.0
        if time >= first:
            rear = x - ahead * math.cos(yaw), y - ahead * math.sin(yaw)
            errors.append(truth.project(*rear).cross_track_error)
        command = steering.steer(
            x - jump * math.sin(yaw) + rng.gauss(0.0, by_position),
            y + jump * math.cos(yaw) + rng.gauss(0.0, by_position),
            yaw + rng.gauss(0.0, by_heading),
            chain.speed + rng.gauss(0.0, by_speed),
            loop.dt,
        )
        if loop.quantum > 0.0:
            command = loop.quantum * round(command / loop.quantum)
        chain.advance(command)
    return Outcome(float(np.mean(np.abs(errors))), max(map(abs, errors)), -min(errors))


def overshoot(controller: Any) -> float:
    """How far beyond its new place the car goes after the jump, in parts of the jump."""
    return drive(controller, JUMP).rightmost / JUMP.jump - 1.0


def loop_lines() -> list[str]:
    """Mean and largest error in each loop [m]; last, the overshoot after a jump."""
    lines = []
    for name, loop in ROWS.items():
        outcomes = [drive(controller, loop) for controller in CONTROLLERS.values()]
        lines.append(line(name, *(f"{each.mean:.3f} / {each.largest:.2f}" for each in outcomes)))
    over = [100.0 * overshoot(controller) for controller in CONTROLLERS.values()]
    last = "a localisation that jumps by 1 m: overshoot"
    return [*lines, line(last, *(f"{max(each, 0.0):.0f} %" for each in over))]
