"""The example that drives highway-env, as its user runs it, and with other controllers."""

from __future__ import annotations

import math
import re
import runpy
import subprocess
import sys
from itertools import product
from typing import TYPE_CHECKING, Any

import pytest

import popsteer
from tests.helpers import ROOT

if TYPE_CHECKING:
    from pathlib import Path

pytest.importorskip("highway_env", reason="highway-env is not installed")
pytest.importorskip("matplotlib", reason="matplotlib is not installed")

EXAMPLE = ROOT / "examples" / "highway_env.py"
LANE_WIDTH = 5.0  # m
CAR_LENGTH, CAR_WIDTH = 5.0, 2.0  # m


def _margin(path: popsteer.Path, poses: Any) -> float:
    """The distance that the outermost corner of the car had left to the edge of its lane."""
    offsets = []
    for x, y, yaw in poses.tolist():
        for ahead, left in product(
            (-CAR_LENGTH / 2, CAR_LENGTH / 2), (-CAR_WIDTH / 2, CAR_WIDTH / 2)
        ):
            corner_x = x + ahead * math.cos(yaw) - left * math.sin(yaw)
            corner_y = y + ahead * math.sin(yaw) + left * math.cos(yaw)
            offsets.append(abs(path.project(corner_x, corner_y).cross_track_error))
    return LANE_WIDTH / 2 - max(offsets)


def test_ten_laps_of_the_racetrack_stay_near_the_middle_of_the_lane(tmp_path: Path) -> None:
    ran = subprocess.run(
        [sys.executable, "-W", "error", str(EXAMPLE), "lap.png"],
        check=False,
        capture_output=True,
        text=True,
        timeout=600,
        cwd=tmp_path,
    )
    assert (ran.returncode, ran.stderr) == (0, "")
    found = re.fullmatch(
        r"(\d+) steps, never farther than ([\d.]+) m from the middle of the lane\n", ran.stdout
    )
    assert found
    assert int(found[1]) > 1800  # of 2 m; a lap has 377 m
    assert float(found[2]) < 0.25
    assert (tmp_path / "lap.png").stat().st_size > 10_000


@pytest.mark.parametrize(("law", "seed"), [(popsteer.PreviewPop, 0), (popsteer.Stanley, 1)])
def test_controller_drives_a_lap_of_the_racetrack_in_its_lane(law: Any, seed: int) -> None:
    path, poses = runpy.run_path(str(EXAMPLE))["drive"](law, laps=1.0, seed=seed)
    assert 2.0 * len(poses) >= path.length  # 2 m a step
    assert _margin(path, poses) > 0.5


def _far_sighted(path: popsteer.Path, car: popsteer.Vehicle) -> popsteer.PurePursuit:
    """It aims so far ahead that it cuts the bends."""
    return popsteer.PurePursuit(path, car, popsteer.PurePursuitParams(min_lookahead=40.0))


def test_controller_that_leaves_the_lane_does_not_go_unnoticed() -> None:
    path, poses = runpy.run_path(str(EXAMPLE))["drive"](_far_sighted, laps=1.0)
    assert _margin(path, poses) < 0.0
