"""What the age of a pose costs, given or not: a table of docs/edges.md."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import popsteer
from popsteer import controllers
from studies.chain import Chain
from studies.layout import line

DT = 0.05
X = np.arange(0.0, 420.0)
SLALOM = popsteer.Path(np.column_stack((X, 3.0 * np.sin(X / 12.0))))
CAR = popsteer.Vehicle(
    wheelbase=2.7, rear_axle=-1.35, dead_time=0.15, max_steer=0.6, max_steer_rate=0.8
)
START = (0.0, 0.5, math.atan2(3.0, 12.0))
AGES = [(0.0, False), (0.1, True), (0.1, False), (0.2, True), (0.2, False)]
SHOWN = [controllers.get(name) for name in ("pop", "pure-pursuit", "stanley", "pid", "preview-pop")]


def mean_error(
    kind: Any,
    car: popsteer.Vehicle,
    age: float,
    *,
    given: bool,
    stale: int = 1,
    speed: float = 12.0,
) -> float:
    """Mean error of the tracked point after 5 s, with poses that are `age` [s] old.

    A localisation that gives a pose each `stale` steps gives the same one, ever older, in between.
    """
    controller = kind(SLALOM, car)
    chain = Chain(car, START, speed, DT, substeps=20)
    late = round(age / DT)
    poses = [chain.pose] * (late + 1)
    errors = []
    point = controller.tracked_point
    for k in range(560 if speed < 10.0 else 480):
        older = k % stale
        seen = poses[max(len(poses) - 1 - late - older, 0)]
        report = {"pose_age": age + older * DT} if given else {}
        chain.advance(controller.step(*seen, speed, DT, **report).steer)
        poses.append(chain.pose)
        x, y, yaw = chain.pose
        closest = SLALOM.project(x + point * math.cos(yaw), y + point * math.sin(yaw))
        if k * DT > 5.0:
            errors.append(abs(closest.cross_track_error))
    return float(np.mean(errors))


def age_lines() -> list[str]:
    """A row for each controller."""
    return [
        line(
            law.title,
            *(f"{mean_error(law.controller, CAR, age, given=given):.3f}" for age, given in AGES),
        )
        for law in SHOWN
    ]
