"""The core without the standard library: it builds, cannot panic, and steers the same."""

from __future__ import annotations

import math
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

import popsteer

ROOT = Path(__file__).parents[2]
PROGRAM = ROOT / "tests" / "no_std"
TARGET = ROOT / "target" / "no_std"


def build(*features: str) -> subprocess.CompletedProcess[str]:
    cargo = shutil.which("cargo")
    if cargo is None:
        pytest.skip("cargo is not on the path")
    chosen = ["--features", ",".join(features)] if features else []
    return subprocess.run(
        [cargo, "build", "--release", "--locked", *chosen],
        cwd=PROGRAM,
        env=os.environ | {"CARGO_TARGET_DIR": str(TARGET)},
        capture_output=True,
        text=True,
        check=False,
    )


DELAYED: dict[str, Any] = {
    "wheelbase": 2.7,
    "rear_axle": -1.35,
    "no_slip_point": -1.2,
    "turning_wheelbase": 2.8,
    "understeer": 0.002,
    "steer_offset": 0.01,
    "steer_lag": 0.1,
    "dead_time": 0.15,
    "max_steer": 0.6,
    "max_steer_rate": 0.5,
    "max_lateral_acceleration": 4.0,
}
"""The vehicle of the program's second drive."""


def drive(controller: popsteer.Pop | popsteer.PreviewPop) -> list[float]:
    vehicle = (0.0, 0.5, 0.3, 10.0)
    angles = []
    for _ in range(1000):
        angles.append(controller.steer(*vehicle, 0.05))
        vehicle = popsteer.paper.kinematic_bicycle(*vehicle, angles[-1], 0.0, 3.0, 0.05)
    return angles


def test_no_std_program_links_without_a_panic_and_steers_as_the_binding() -> None:
    built = build()
    assert built.returncode == 0, built.stderr
    program = TARGET / "release" / "popsteer-no-std"
    printed = subprocess.run([program], capture_output=True, text=True, check=True).stdout
    angles = [float(line) for line in printed.split()]

    path = popsteer.Path([(float(k), 8.0 * math.sin(k / 25.0)) for k in range(600)])
    late = popsteer.Vehicle(**DELAYED)
    for controller in (popsteer.Pop(path), popsteer.PreviewPop(path, late)):
        expected = drive(controller)
        driven, angles = angles[:1000], angles[1000:]
        assert max(abs(a - b) for a, b in zip(driven, expected, strict=True)) <= 1e-12
        assert max(expected) - min(expected) > 0.05
    assert not angles


def test_no_std_program_with_a_planted_panic_does_not_link() -> None:
    built = build("planted-panic")
    assert built.returncode != 0
    assert "the_core_can_panic" in built.stderr
