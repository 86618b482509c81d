"""POP's own loop over a horizon, with the bicycle: what it brings, and where it fails."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import Pop, PopParams, sim, tracks
from tests.helpers import ROOT, authors_data

START = (-183.8, 78.7, -1.574)
PLANT = "carla-identified"
PAGE = (ROOT / "docs" / "preview_pop.md").read_text(encoding="utf-8")


def _driven(path: popsteer.Path, params: PopParams, start: tuple[float, float, float]) -> sim.Run:
    return sim.run(Pop(path, params), path=path, start=start)


def _cells(run: sim.Run) -> list[str]:
    metrics = run.metrics
    if not metrics.finished:
        return ["off the road"] * 4
    if metrics.settled_max_abs_cross_track_error > 3.0:
        # Chaotic: the next machine's rounding swings otherwise.
        return ["swings"] * 4
    return [
        f"{metrics.mean_abs_cross_track_error:.3f}",
        f"{metrics.settled_mean_abs_cross_track_error:.4f}",
        f"{metrics.settled_max_abs_cross_track_error:.3f}",
        f"{metrics.rms_steer_rate:.3f}",
    ]


def test_page_table_of_horizons_is_driven() -> None:
    path = popsteer.Path.from_csv(authors_data() / "waypoints.csv")
    table = PAGE.partition("<!-- table: horizon -->\n")[2].partition("\n\n")[0].splitlines()[2:]
    assert len(table) > 8
    for line in table:
        words, *cells = (cell.strip() for cell in line.strip("|").split("|"))
        found = re.findall(r"`(\w+)=([\d.]+)`", words)
        changes: dict[str, Any] = {name: float(value) for name, value in found}
        params = sim.fitted(PopParams(**changes), PLANT)
        share = re.search(r"wheelbase of the model ([+−]\d+) %", words)
        if share is not None:
            percent = float(share.group(1).replace("−", "-"))
            params = params.replace(wheelbase=params.wheelbase * (1.0 + 0.01 * percent))
        lag = re.search(r"lag of the model ([\d.]+) s", words)
        if lag is not None:
            params = params.replace(steer_lag=float(lag.group(1)))
        assert cells == _cells(_driven(path, params, START)), words


@pytest.mark.parametrize("plant", ["carla-identified", "kinematic-bicycle"])
def test_pop_over_a_horizon_errs_less_than_half_of_one_step(plant: str) -> None:
    track = tracks.get("racetrack")
    path = popsteer.Path(track.xy, speed=track.speed)
    errors = []
    for horizon in (None, 0.8):
        params = sim.fitted(PopParams(horizon=horizon), plant)
        metrics = sim.run(Pop(path, params), path=path, plant=plant).metrics
        assert metrics.finished
        errors.append(metrics.settled_mean_abs_cross_track_error)
    assert errors[1] < 0.5 * errors[0]


def test_pop_over_a_horizon_too_short_does_not_come_back_from_a_right_angle() -> None:
    path = popsteer.Path([(float(x), 0.0) for x in range(300)])

    def largest(horizon: float) -> float:
        law = Pop(path, PopParams(horizon=horizon, wheelbase=3.0))
        x, y, yaw, largest = 5.0, 0.0, 0.5 * math.pi, 0.0
        for k in range(400):
            steer = law.steer(x, y, yaw, 5.0, 0.05)
            x, y, yaw, _ = popsteer.kinematic_bicycle(x, y, yaw, 5.0, steer, 0.0, 3.0, 0.05)
            largest = max(largest, abs(y)) if k > 200 else largest
        return largest

    assert largest(0.8) < 0.05
    assert largest(0.1) > 1.0


def _nearest(steer: float, target: tuple[float, float], params: PopParams, speed: float) -> float:
    """How near the front axle comes to a target over the horizon, by plain integration."""
    dt, length = 1e-4, params.wheelbase + params.understeer * speed * speed
    x, y, yaw, wheel, least, front = -3.0, 0.0, 0.0, 0.0, math.inf, params.reference_offset or 3.0
    assert params.horizon is not None
    for k in range(1, round(params.horizon / dt) + 1):
        wheel += (steer - wheel) * (1.0 - math.exp(-dt / params.steer_lag))
        yaw += dt * speed * math.tan(wheel) / length
        x, y = x + dt * speed * math.cos(yaw), y + dt * speed * math.sin(yaw)
        if k % 500 == 0:  # the ends of the steps of the prediction
            at = (x + front * math.cos(yaw), y + front * math.sin(yaw))
            least = min(least, math.dist(at, target))
    return least


@pytest.mark.parametrize("aside", [-0.8, -0.4, 0.05, 0.3, 0.6])
def test_pop_over_a_horizon_takes_the_candidate_that_an_integration_finds_nearest(
    aside: float,
) -> None:
    params = PopParams(
        horizon=0.8, understeer=0.002, steer_lag=0.2, steer_span=0.3, reference_offset=3.0
    )
    path = popsteer.Path([(-50.0, aside), (50.0, aside)])
    command = Pop(path, params).step(-3.0, 0.0, 0.0, 8.0, 0.05)
    candidates = 0.03 * np.arange(-10, 11)
    distances = [_nearest(steer, command.target, params, 8.0) for steer in candidates]
    chosen = _nearest(command.steer, command.target, params, 8.0)
    # The prediction's steps are coarser than the integration's: to within a part of a candidate.
    assert chosen <= min(distances) + 0.02
    assert np.isclose(candidates, command.steer).any()
    assert command.steer * aside >= 0.0
