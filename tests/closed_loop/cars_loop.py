"""A car's loop: one car, driven through what a real loop has, by each controller.

The car is integrated by `Chain`, apart from popsteer.sim: 2.7 m between its axles, its pose at the
centre, slow wheels, a lag and a dead time. It drives S-bends of 25 m radius.
"""

from __future__ import annotations

import functools
import math
import random
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

import popsteer
from tests.closed_loop.chain import Chain

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy.typing as npt

    Curve = npt.NDArray[np.float64]

CAR = popsteer.Vehicle(
    wheelbase=2.7,
    rear_axle=-1.35,
    max_steer=0.6,
    max_steer_rate=0.4,
    steer_lag=0.15,
    dead_time=0.15,
)
RADIUS = 25.0
SUBSTEP = 1e-3
"""The longest step of the integration [s]: 50 in a control period of 50 ms."""

CONTROLLERS: dict[str, Callable[..., popsteer.PreviewPop]] = {
    "preview-pop": popsteer.PreviewPop,
    "pop": popsteer.Pop,
    "stanley": popsteer.Stanley,
    "pure-pursuit": popsteer.PurePursuit,
    "pid": popsteer.Pid,
}


WAVE = 100.0


@functools.cache
def course(length: float = 400.0, spacing: float = 0.5) -> Curve:
    """S-bends of a curvature that changes as a sine, from a straight of 10 m on."""
    fine = 0.01
    arc = np.arange(0.0, length, fine)
    curvature = np.where(arc < 10.0, 0.0, np.sin((arc - 10.0) * math.tau / WAVE) / RADIUS)
    yaw = np.cumsum(curvature * fine)
    xy = np.column_stack((np.cumsum(np.cos(yaw) * fine), np.cumsum(np.sin(yaw) * fine)))
    return np.vstack(((0.0, 0.0), xy))[:: round(spacing / fine)]


def recorded(noise: float = 0.05, spacing: float = 0.2, seed: int = 1) -> Curve:
    """The course as a drive with this noise [m] on each position recorded it."""
    xy = course(spacing=spacing)
    return xy + np.random.default_rng(seed).normal(0.0, noise, xy.shape)


def staircase(cell: float = 0.25) -> Curve:
    """The course as a planner on a grid gives it: from cell to cell, along x or along y."""
    cells = np.rint(course(spacing=0.02) / cell).astype(int)
    stairs = [tuple(cells[0])]
    for x, y in cells[1:]:
        if x != stairs[-1][0]:
            stairs.append((x, stairs[-1][1]))
        if y != stairs[-1][1]:
            stairs.append((x, y))
    return cell * np.array(stairs, dtype=float)


@dataclass(frozen=True)
class Loop:
    """What the loop is like."""

    speed: float = 8.0
    dt: float = 0.05
    seconds: float = 25.0
    waypoints: Callable[[], Curve] = course
    true: Callable[[], Curve] = course
    car: popsteer.Vehicle = CAR
    quantum: float = 0.0
    backlash: float = 0.0
    noise: tuple[float, float, float] = (0.0, 0.0, 0.0)
    standing: float = 0.0


class Outcome(NamedTuple):
    mean: float
    largest: float
    jitter: float


def drive(make, loop: Loop) -> Outcome:
    path = popsteer.Path(loop.waypoints())
    truth = popsteer.Path(loop.true())
    (x, y), (x1, y1) = loop.true()[:2]
    yaw = math.atan2(y1 - y, x1 - x)
    substeps = math.ceil(loop.dt / SUBSTEP - 1e-9)
    chain = Chain(
        loop.car, (x + 1.35 * math.cos(yaw), y + 1.35 * math.sin(yaw), yaw), 0.0, loop.dt, substeps
    )
    chain.backlash = loop.backlash
    controller = make(path, loop.car)
    rng = random.Random(7)
    errors = []
    steers = []
    arc = 0.0
    for k in range(round((loop.standing + loop.seconds) / loop.dt)):
        t = k * loop.dt
        chain.speed = loop.speed if t >= loop.standing else 0.0
        x, y, yaw = chain.pose
        sxy, syaw, sv = loop.noise
        steer = controller.steer(
            x + rng.gauss(0, sxy),
            y + rng.gauss(0, sxy),
            yaw + rng.gauss(0, syaw),
            chain.speed + rng.gauss(0, sv),
            loop.dt,
        )
        if t >= loop.standing + 5.0:
            errors.append(
                abs(
                    truth.project(
                        x - 1.35 * math.cos(yaw), y - 1.35 * math.sin(yaw)
                    ).cross_track_error
                )
            )
            steers.append(steer)
        if loop.quantum:
            steer = loop.quantum * round(steer / loop.quantum)
        chain.advance(steer)
    return Outcome(
        float(np.mean(errors)),
        max(errors),
        math.degrees(float(np.sqrt(np.mean(np.diff(steers) ** 2)))),
    )
