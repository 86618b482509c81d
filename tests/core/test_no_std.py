"""The core without the standard library: it builds, cannot panic, and steers the same."""

from __future__ import annotations

import math
import os
import shutil
import subprocess
from pathlib import Path

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
        env=os.environ | {"CARGO_TARGET_DIR": str(TARGET / ("-".join(features) or "plain"))},
        capture_output=True,
        text=True,
        check=False,
    )


def test_no_std_program_links_without_a_panic_and_steers_as_the_binding() -> None:
    built = build()
    assert built.returncode == 0, built.stderr
    program = TARGET / "plain" / "release" / "popsteer-no-std"
    printed = subprocess.run([program], capture_output=True, text=True, check=True).stdout
    angles = [float(line) for line in printed.split()]

    path = popsteer.Path([(float(k), 8.0 * math.sin(k / 25.0)) for k in range(600)])
    pop = popsteer.Pop(path)
    vehicle = (0.0, 0.5, 0.3, 10.0)
    expected = []
    for _ in range(1000):
        expected.append(pop.steer(*vehicle, 0.05))
        vehicle = popsteer.kinematic_bicycle(*vehicle, expected[-1], 0.0, 3.0, 0.05)
    assert len(angles) == len(expected)
    assert max(abs(a - b) for a, b in zip(angles, expected, strict=True)) <= 1e-12
    assert max(expected) - min(expected) > 0.05


def test_no_std_program_with_a_planted_panic_does_not_link() -> None:
    built = build("planted-panic")
    assert built.returncode != 0
    assert "the_core_can_panic" in built.stderr
