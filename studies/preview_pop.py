"""The tables of docs/preview_pop.md: the authors' waypoints, a vehicle that is wrong, noise."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from popsteer import AdaptParams, Path, Pop, PreviewPop, Vehicle, sim, vehicles
from popsteer.lab.opponents.mpc import Mpc, Weights
from popsteer.sim import CarlaIdentified, Noise, OwnSimpleController
from popsteer.sim.geometry import object_of
from studies.layout import course, line

if TYPE_CHECKING:
    from collections.abc import Iterator


START = (-183.797, 79.760, -1.574)
CAR = vehicles.get("carla-identified")
NOISE = Noise(position=0.1, yaw=0.005)
NO_TURN, NO_SLIP = AdaptParams(turn_time=0.0), AdaptParams(slip_time=0.0)


class Misinformed:
    """The controller, given a wrong heading [rad], or the pose of a point `ahead` [m]."""

    def __init__(self, law: PreviewPop, yaw: float = 0.0, ahead: float = 0.0) -> None:
        self.law, self.yaw, self.ahead = law, yaw, ahead
        self.path = law.path
        self.tracked_point = ahead  # the errors are those of the point that it is given

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float, /) -> float:
        x += self.ahead * math.cos(yaw)
        y += self.ahead * math.sin(yaw)
        return self.law.steer(x, y, yaw + self.yaw, speed, dt)


def _row(name: str, law: OwnSimpleController, noise: Noise | None = None, **settings: Any) -> str:
    seeds = range(8 if noise else 1)
    runs = [sim.run(law, start=START, noise=noise, seed=seed, **settings).metrics for seed in seeds]

    def mean(metric: str) -> float:
        return float(np.mean([getattr(run, metric) for run in runs]))

    return line(
        name,
        f"{mean('mean_abs_cross_track_error'):.3f}",
        f"{mean('settled_mean_abs_cross_track_error'):.4f}",
        f"{mean('settled_max_abs_cross_track_error'):.3f}",
        f"{mean('rms_steer_rate'):.{2 if noise else 3}f}",
    )


def preview_lines() -> Iterator[str]:
    """Yield a row for each run."""
    path, _ = course("authors")

    def law(vehicle: Vehicle = CAR, adapt: Any = "auto") -> PreviewPop:
        return PreviewPop(path, vehicle, adapt=adapt)

    yield _row("POP", Pop(path, CAR))
    yield _row("MPC", Mpc(path, CAR, Weights()))
    yield _row("preview POP", law())
    yield _row("not adapting", law(adapt=None))
    yield _row("not estimating the turning, `turn_time=0`", law(adapt=NO_TURN))
    yield _row("not estimating the slip, `slip_time=0`", law(adapt=NO_SLIP))
    for wrong_by, factor in (("small", 0.85), ("large", 1.15)):
        given = CAR.replace(turning_wheelbase=factor * 3.553)
        yield _row(f"`turning_wheelbase` given 15 % too {wrong_by}", law(given))
    for lag, instead in ((0.05, " instead of 0.1 s"), (0.2, ""), (0.0, "")):
        yield _row(f"`steer_lag` given as {lag:g} s{instead}", law(CAR.replace(steer_lag=lag)))
    plant = CarlaIdentified(CAR.replace(steer_offset=math.radians(1.0)))
    yield _row("1° of steering offset, not given", law(), plant=plant)
    yield _row("... not adapting", law(adapt=None), plant=plant)
    yield _row("noise", law(), NOISE)
    yield _row("... not adapting", law(adapt=None), NOISE)
    yield _row("noise, `turn_time=0.5`", law(adapt=AdaptParams(turn_time=0.5)), NOISE)
    for name, wrong in (
        ("heading 0.01 rad wrong", {"yaw": 0.01}),
        ("pose of a point 1.4 m ahead of the vehicle's", {"ahead": 1.4}),
    ):
        yield _row(name, Misinformed(law(), **wrong))
        yield _row("... not adapting", Misinformed(law(adapt=None), **wrong))


def slip_lines() -> Iterator[str]:
    """Yield a row for each plant: the error after 5 s [m], not estimating the slip, and so."""
    path, _ = course("authors")
    angles = np.linspace(0.0, math.tau, 315, endpoint=False)
    circle = Path(50.0 * np.column_stack((np.cos(angles), np.sin(angles))), closed=True)
    cases: tuple[tuple[str, Path, str, float | None, int], ...] = (
        ("carla-identified", path, "", None, 10),
        ("carla-identified", path, ", 200 substeps a period", None, 200),
        ("commonroad-mb-2", path, "", 10.0, 10),
        ("commonroad-mb-2", path, "", 14.0, 10),
        ("commonroad-std-2", circle, ", circle", 10.0, 10),
        ("mujoco-car", circle, ", circle", 8.0, 10),
    )
    for plant, way, note, speed, substeps in cases:
        car = sim.vehicle_of(object_of(plant))
        start = START if speed is None else sim.default_start(way, 1.0, car)
        errors = [
            sim.run(
                PreviewPop(way, car, adapt=adapt),
                plant,
                start=start,
                constant_speed=speed,
                settings=sim.Settings(substeps=substeps),
            ).metrics.settled_mean_abs_cross_track_error
            for adapt in (NO_SLIP, AdaptParams())
        ]
        at = "" if speed is None else f", {speed:g} m/s"
        yield line(f"`{plant}`{note}{at}", *(f"{each:.4f}" for each in errors))
