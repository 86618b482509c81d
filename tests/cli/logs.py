"""A log on the disk, as a user has it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

import popsteer
from popsteer import sim

if TYPE_CHECKING:
    from pathlib import Path

CAR = popsteer.Vehicle(
    wheelbase=2.7, rear_axle=-1.35, steer_lag=0.1, dead_time=0.15, steer_offset=0.01
)


def drive(seconds: float = 40.0) -> dict[str, Any]:
    """Drive S-bends by Stanley, at speeds that change; the columns of the log."""
    x = 0.5 * np.arange(1600)
    waypoints = np.column_stack((x, 12.0 * np.sin(x / 22.0)))
    path = popsteer.Path(waypoints, speed=6.0 + 2.5 * np.sin(x / 60.0))
    plant = sim.KinematicBicycle(CAR)
    start = sim.default_start(path, vehicle=CAR)
    settings = sim.Settings(time_limit=seconds)
    run = sim.Simulation(path, plant, start=start, speed=6.0, settings=settings)
    stanley, pedals = popsteer.Stanley(path, CAR), popsteer.SpeedPid()
    random = np.random.default_rng(1)
    rows = []
    for k in range(round(seconds / 0.05)):
        noise = random.standard_normal(4) * (0.02, 0.02, 0.002, 0.02)
        pose = np.array(run.state) + noise
        x_, y_, yaw, speed = map(float, pose)
        steer = stanley.step(x_, y_, yaw, speed, 0.05).steer
        rows.append((0.05 * k, *pose, steer))
        run.step(steer, *pedals.step(float(pose[3]), run.reference_speed or 6.0, 0.05))
    names = ("t", "x", "y", "yaw", "speed", "steer")
    return dict(zip(names, np.array(rows).T, strict=True))


def write_csv(file: Path, columns: dict[str, Any]) -> Path:
    lines = [",".join(columns)]
    lines += [",".join(f"{v:.9g}" for v in row) for row in zip(*columns.values(), strict=True)]
    file.write_text("\n".join(lines) + "\n")
    return file
