"""What dead time and the age of a pose do, and what prediction makes of them: docs/edges.md."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from popsteer import AdaptParams, Path, Vehicle, controllers, presets, sim
from popsteer.lab.common.experiment import controller
from popsteer.sim import CarlaIdentified, KinematicBicycle, Metrics, Pose
from popsteer.sim.closed_loop import START_OFFSET
from studies.chain import Chain
from studies.layout import AUTHORS_START, course, line

if TYPE_CHECKING:
    from collections.abc import Iterable


NAMES = ("pop", "pure-pursuit", "stanley", "pid", "preview-pop")
RUNS = ("late", "predicted", "short", "long", "early", "later")


class DeadTimeRow(NamedTuple):
    """What each of the models of `run` did to a controller, by its name."""

    law: str
    runs: dict[str, Metrics]

    def ratio(self, model: str) -> float:
        """Mean error of a run over that without dead time; infinite where it did not finish."""
        found = self.runs[model]
        if not found.finished:
            return math.inf
        return found.mean_abs_cross_track_error / self.runs["prompt"].mean_abs_cross_track_error


def run(
    path: Path,
    names: Iterable[str] = NAMES,
    *,
    plant: CarlaIdentified | KinematicBicycle | None = None,
    start: Pose | None = None,
    start_at: Literal["pose", "front"] = "pose",
    preset: str = presets.REPRODUCTION,
    dead_time: float = 0.2,
    adapt: AdaptParams | Literal["auto"] | None = "auto",
) -> list[DeadTimeRow]:
    """Drive with and without dead time [s], and with a prediction through it, right and wrong.

    The plant's own dead time is replaced; the default is the one identified from the authors' run.
    By default they start as far beside the path as the paper's run did, no more than a wheelbase.
    """
    plant = CarlaIdentified() if plant is None else plant
    prompt = plant.vehicle.replace(dead_time=0.0)
    if start is None:
        aside = -min(START_OFFSET, prompt.wheelbase)
        start = sim.default_start(path, aside, prompt)
    real = prompt.replace(dead_time=dead_time)
    turning = real.turning_length(0.0)
    # The vehicle, and what the controller is given: no dead time, none given, and right or wrong.
    models = {
        "prompt": (prompt, prompt),
        "late": (real, prompt),
        "predicted": (real, real),
        "short": (real, real.replace(turning_wheelbase=0.85 * turning)),
        "long": (real, real.replace(turning_wheelbase=1.15 * turning)),
        "early": (real, real.replace(dead_time=dead_time - 0.05)),
        "later": (real, real.replace(dead_time=dead_time + 0.05)),
    }
    rows = []
    for name in names:
        params = presets.get(name, preset)
        found = {
            model: sim.run(
                controller(name, path, believed, params, adapt),
                plant.replace(vehicle=vehicle),
                start=start,
                start_at=start_at,
            ).metrics
            for model, (vehicle, believed) in models.items()
        }
        rows.append(DeadTimeRow(name, found))
    return rows


def dead_time_rows(name: str) -> list[DeadTimeRow]:
    """Drive a shipped track, or that of the paper's authors."""
    path, start = course(name)
    if start is None:
        return run(path)
    return run(path, start=AUTHORS_START, start_at="front")


def dead_time_lines(rows: Iterable[DeadTimeRow]) -> list[str]:
    """Mean errors [m]; in brackets over that without dead time."""
    return [
        line(
            controllers.get(row.law).title,
            f"{row.runs['prompt'].mean_abs_cross_track_error:.3f}",
            *(_cell(row, model) for model in RUNS),
        )
        for row in rows
    ]


def _cell(row: DeadTimeRow, model: str) -> str:
    found = row.runs[model]
    if not found.finished:
        return "off the road"
    return f"{found.mean_abs_cross_track_error:.3f} ({row.ratio(model):.2f})"


DT = 0.05
X = np.arange(0.0, 420.0)
SLALOM = Path(np.column_stack((X, 3.0 * np.sin(X / 12.0))))
CAR = Vehicle(wheelbase=2.7, rear_axle=-1.35, dead_time=0.15, max_steer=0.6, max_steer_rate=0.8)
START = (0.0, 0.5, math.atan2(3.0, 12.0))
AGES = [(0.0, False), (0.1, True), (0.1, False), (0.2, True), (0.2, False)]


def mean_error(
    kind: Any,
    car: Vehicle,
    age: float,
    *,
    given: bool,
    stale: int = 1,
    speed: float = 12.0,
) -> float:
    """Mean error after 5 s; poses are `age` [s] old, and each is repeated `stale` steps."""
    steering = kind(SLALOM, car)
    chain = Chain(car, START, speed, DT, substeps=20)
    late = round(age / DT)
    poses = [chain.pose] * (late + 1)
    errors = []
    point = steering.tracked_point
    for k in range(560 if speed < 10.0 else 480):
        older = k % stale
        seen = poses[max(len(poses) - 1 - late - older, 0)]
        report = {"pose_age": age + older * DT} if given else {}
        chain.advance(steering.step(*seen, speed, DT, **report).steer)
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
        for law in map(controllers.get, NAMES)
    ]
