"""The example that drives highway-env, as its user runs it."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest

from tests.helpers import ROOT

pytest.importorskip("highway_env", reason="highway-env is not installed")


def _run(*arguments: str) -> subprocess.CompletedProcess[str]:
    program = [sys.executable, "-W", "error", str(ROOT / "examples" / "highway_env.py")]
    return subprocess.run(
        [*program, *arguments], check=False, capture_output=True, text=True, timeout=600
    )


@pytest.mark.parametrize(("controller", "seed"), [("preview-pop", "0"), ("stanley", "1")])
def test_controller_drives_a_lap_of_the_racetrack_in_its_lane(controller: str, seed: str) -> None:
    ran = _run("--controller", controller, "--laps", "1", "--seed", seed)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert ran.stdout.endswith("the lane was kept\n")
    found = re.search(r"outermost corner was ([\d.]+) m inside", ran.stdout)
    assert found
    assert float(found[1]) > 0.5


def test_controller_that_leaves_the_lane_is_said_to() -> None:
    ran = _run("--controller", "bang-bang", "--laps", "1")
    assert ran.returncode == 1
    assert ran.stdout.endswith("the lane was LEFT\n")
