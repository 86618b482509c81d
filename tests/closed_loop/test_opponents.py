"""Path trackers of others: their formulas, and what they have to keep."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

import popsteer
from popsteer import own, sim, tracks
from popsteer.lab import opponents
from popsteer.lab.opponents.lqr import cost_to_go, model, weights
from popsteer.lab.opponents.pure_pursuit import AutowareGains, AutowarePurePursuit
from tests.helpers import looped

if TYPE_CHECKING:
    from popsteer.lab.opponents import Seen

CAR = popsteer.Vehicle(
    wheelbase=2.7, rear_axle=-1.35, max_steer=0.6, max_steer_rate=0.8, steer_lag=0.1
)
NAMES = opponents.names()


def made(name: str, path: popsteer.Path, car: popsteer.Vehicle = CAR) -> Any:
    if name.endswith("Mpc"):
        pytest.importorskip("daqp")
    kind = own.load("controller", name)
    return kind(path, car, kind.Params())


def straight() -> popsteer.Path:
    return popsteer.Path([(float(x), 0.0) for x in range(0, 201, 2)])


@pytest.mark.parametrize("name", NAMES)
def test_opponents_follow_a_slalom_both_ways_within_the_limits_of_the_car(name: str) -> None:
    xy = tracks.get("slalom").xy
    allowed = 0.9 if "Autoware" in name else 0.03
    for reverse in (False, True):
        path = popsteer.Path(xy, reverse=[reverse] * len(xy))
        car = CAR.replace(max_lateral_acceleration=4.0)
        plant = sim.KinematicBicycle(car)
        start = sim.default_start(path, 0.0, car)
        run = sim.run(made(name, path, car), plant, path=path, start=start, constant_speed=6.0)
        assert run.metrics.finished, (name, run.ending)
        assert run.metrics.rear_axle_max_abs_cross_track_error < allowed, (name, reverse)
        rates = np.diff(run.records["steer"]) / run.dt
        assert np.abs(rates).max() <= CAR.max_steer_rate + 1e-9  # type: ignore[operator]
        lateral = run.records["speed"] ** 2 * np.tan(run.records["steer"]) / CAR.wheelbase
        assert np.abs(lateral[40:]).max() < 4.1


@looped("name", NAMES)
def test_mirrored_world_gives_the_mirrored_angle(name: str) -> None:
    xy = tracks.get("double-lane-change").xy[:120]
    pair = [made(name, popsteer.Path(xy * (1.0, side))) for side in (1.0, -1.0)]
    x, y = xy[10]
    for k in range(40):
        at = x + 0.4 * k
        left, right = (
            each.step(at, side * (y + 0.2), side * 0.03, 8.0, 0.05)
            for each, side in zip(pair, (1.0, -1.0), strict=True)
        )
        assert left == pytest.approx(-right, abs=1e-9)


def test_model_predictive_controller_is_the_regulator_where_no_limit_binds() -> None:
    pytest.importorskip("daqp")
    lqr, mpc = (
        kind(straight(), CAR, kind.Params(heading=3.0, change=10.0))
        for kind in (own.load("controller", NAMES[1]), own.load("controller", NAMES[0]))
    )
    for k in range(20):
        given = (20.0 + 0.4 * k, 0.01, 0.002, 8.0, 0.05)
        assert mpc.step(*given) == pytest.approx(lqr.step(*given), abs=1e-6)


def test_regulator_has_the_cost_of_its_riccati_equation_and_the_model_of_its_equations() -> None:
    a, b = model(8.0, 2.7, 0.1, 1.0, 0.05)
    q, r = weights(2.7, 3.0, 10.0)
    p = cost_to_go(a, b, q, r)
    assert np.allclose(p, solve_discrete_are(a, b, q, r), rtol=1e-9)
    assert np.allclose(p, p.T, rtol=1e-9)
    # The model over a period against a fine integration of its equations.
    e = psi = 0.0
    wheel, steer, speed, length, lag, fine = 0.02, 0.05, 8.0, 2.7, 0.1, 1e-5
    for _ in range(round(0.05 / fine)):
        e, psi = e + fine * speed * psi, psi + fine * speed * wheel / length
        wheel += fine * (steer - wheel) / lag
    found = a @ np.array([0.0, 0.0, 0.02, 0.05])
    assert found[1:3] == pytest.approx((psi, wheel), rel=1e-3)
    assert found[0] == pytest.approx(e, rel=0.2)  # its mean angle is taken as constant


def test_autowares_lookahead_distance_is_that_of_its_parameters() -> None:
    chased = AutowarePurePursuit(straight(), CAR.replace(wheelbase=2.79), AutowareGains())
    for speed, y, wanted in ((1.0, 0, 4.35), (3.0, 0.2, 7.2), (3.0, 0.8, 7.2 + 2.88), (9.0, 0, 15)):
        chased.reset()
        eye = chased.observer
        asked: list[float] = []

        def towards(seen: Seen, distance: float, asked: list[float] = asked) -> tuple[float, float]:
            asked.append(distance)
            return distance, 0.0

        eye.towards = towards  # type: ignore[method-assign]
        chased.step(20.0, y, 0.0, speed, 0.05)
        assert asked == pytest.approx([wanted], rel=1e-6)


def test_observer_knows_offset_and_dead_time() -> None:
    car = CAR.replace(dead_time=0.2, steer_offset=0.02)
    path = straight()
    run = sim.run(
        made(NAMES[1], path, car), sim.KinematicBicycle(car), path=path, constant_speed=8.0
    )
    assert run.records["steer"][-20:] == pytest.approx(-0.02, abs=1e-3)
    assert run.metrics.rear_axle_settled_max_abs_cross_track_error < 0.2
    assert math.isclose(float(run.records["rear_cross_track_error"][-1]), 0.0, abs_tol=0.01)
