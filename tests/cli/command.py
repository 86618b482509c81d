"""The command, as a process of its own and in this one."""

from __future__ import annotations

import os
import subprocess
import sysconfig
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pytest

import popsteer
from popsteer import sim
from popsteer.cli import main

if TYPE_CHECKING:
    from collections.abc import Mapping


class Outcome(NamedTuple):
    status: int
    out: str
    err: str


def script() -> str:
    """The installed command."""
    return str(Path(sysconfig.get_path("scripts")) / "popsteer")


def run(*arguments: str, environment: Mapping[str, str] | None = None) -> Outcome:
    """Run the installed command."""
    done = subprocess.run(
        [script(), *arguments],
        capture_output=True,
        encoding="utf-8",
        env={**os.environ, **(environment or {})},
        check=False,
    )
    return Outcome(done.returncode, done.stdout, done.stderr)


def call(capsys: pytest.CaptureFixture[str], *arguments: str) -> Outcome:
    """Run the command in this process, which is faster."""
    with pytest.raises(SystemExit) as exit_:
        main(arguments)
    captured = capsys.readouterr()
    assert isinstance(exit_.value.code, int)
    return Outcome(exit_.value.code, captured.out, captured.err)


def read_terminal(reading: int) -> bytes:
    """Read all that is sent to a terminal, until its other end is closed."""
    sent = b""
    while True:
        try:
            part = os.read(reading, 65536)
        except OSError:  # Linux says so where the other end is closed
            return sent
        if not part:
            return sent
        sent += part


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
