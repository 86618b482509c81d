"""Planned speeds beside those of trajectory-planning-helpers."""

from __future__ import annotations

import math
import sys
import types
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from popsteer import Path, planning, tracks
from popsteer.planning import SpeedLimits, speeds_along
from tests.planned import closed_spline, spacing_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

TOP, SIDE, DRIVING, BRAKING = 25.0, 4.0, 2.0, 3.0


@pytest.fixture(scope="module")
def theirs() -> Any:
    """Their solver, without the optimiser that the package imports beside it."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setitem(sys.modules, "quadprog", types.ModuleType("quadprog"))
        planners = pytest.importorskip("trajectory_planning_helpers")
        return planners.calc_vel_profile.calc_vel_profile


def _their_speeds(
    solve: Any,
    bends: NDArray[np.float64],
    spacing: NDArray[np.float64],
    closed: bool,
    exponent: float,
    driving: float,
) -> NDArray[np.float64]:
    """An ellipse of what the tyres hold, and a drive that is weaker."""
    found: NDArray[np.float64] = solve(
        ax_max_machines=np.array([[0.0, driving], [2.0 * TOP, driving]]),
        kappa=bends,
        el_lengths=spacing,
        closed=closed,
        drag_coeff=0.0,
        m_veh=1000.0,
        ggv=np.array([[0.0, BRAKING, SIDE], [2.0 * TOP, BRAKING, SIDE]]),
        v_max=TOP,
        dyn_model_exp=exponent,
        v_start=1.0,
        v_end=1.0,
    )
    return found


def _time(speed: NDArray[np.float64], spacing: NDArray[np.float64]) -> float:
    after = np.roll(speed, -1)[: spacing.size]
    return float((2.0 * spacing / (speed[: spacing.size] + after)).sum())


def _compare(solve: Any, path: Path, exponent: float, driving: float) -> float:
    bends, spacing = planning.curvature(path), spacing_of(path)
    limits = SpeedLimits(
        max_speed=TOP,
        max_lateral_acceleration=SIDE,
        max_acceleration=driving,
        max_deceleration=BRAKING,
        longitudinal_grip=BRAKING,
        exponent=exponent,
    )
    ours = speeds_along(bends, spacing, limits, closed=path.closed, start_speed=1.0, end_speed=1.0)
    other = _their_speeds(solve, bends, spacing, path.closed, exponent, driving)
    assert math.isfinite(other.sum())
    return _time(ours, spacing) / _time(other, spacing)


@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.0])
@pytest.mark.parametrize("driving", [DRIVING, BRAKING])
def test_plan_takes_as_long_as_theirs(theirs: Any, exponent: float, driving: float) -> None:
    ratios = {}
    for name in tracks.names():
        track = tracks.get(name)
        ratios[name] = _compare(theirs, Path(track.xy, closed=track.closed), exponent, driving)
    for seed in range(20):
        path = Path(closed_spline(seed, count=500), closed=True)
        ratios[f"spline {seed}"] = _compare(theirs, path, exponent, driving)
    print({name: round(ratio, 4) for name, ratio in ratios.items()})  # noqa: T201 - with pytest -s
    assert all(abs(ratio - 1.0) <= 0.01 for ratio in ratios.values()), ratios
