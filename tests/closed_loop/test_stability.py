"""The margins of `popsteer.lab.stability.runs` against cars that are driven to the edge."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import AdaptParams, Vehicle, controllers, presets, vehicles
from popsteer.lab.stability import margins
from studies.theory import (
    Given,
    critical_dead_time,
    grows,
    roll,
    straight_path,
)

CAR = vehicles.get("paper")  # has no limit of the lateral acceleration


def _given(name: str, vehicle: Vehicle, adapt: Any = "auto", **changes: Any) -> Given:
    params = presets.get(name, "default").replace(**changes)
    return Given(name, params, vehicle, adapt).in_small_signals()


@pytest.mark.parametrize("name", controllers.names())
@pytest.mark.parametrize("speed", [5.0, 10.0, 15.0, 20.0])
@pytest.mark.parametrize("lag", [0.1, 0.2])
def test_dead_time_margin_is_where_the_driven_loop_begins_to_grow(
    name: str, speed: float, lag: float
) -> None:
    vehicle = CAR.replace(steer_lag=lag)
    given = _given(name, vehicle)
    computed = margins(given.params, vehicle, speed).dead_time
    driven = critical_dead_time(given, vehicle, speed, computed)
    assert driven == pytest.approx(computed, rel=0.01, abs=3e-4)


@pytest.mark.parametrize("name", ["pure-pursuit", "stanley", "pop", "preview-pop"])
def test_dead_time_margin_without_lag_and_at_another_rate_is_that_of_the_driven_loop(
    name: str,
) -> None:
    vehicle = CAR.replace(wheelbase=2.5, steer_lag=0.0)
    given = _given(name, vehicle)
    computed = margins(given.params, vehicle, 12.0, dt=0.02).dead_time
    driven = critical_dead_time(given, vehicle, 12.0, computed, dt=0.02)
    assert driven == pytest.approx(computed, rel=0.01)


@pytest.mark.parametrize("name", controllers.names())
@pytest.mark.parametrize("dead_time", [0.04, 0.13])
@pytest.mark.parametrize("speed", [6.0, 12.0])
def test_dead_time_margin_of_a_controller_that_predicts_is_that_of_the_driven_loop(
    name: str, dead_time: float, speed: float
) -> None:
    vehicle = CAR.replace(dead_time=dead_time)
    given = _given(name, vehicle)
    computed = margins(given.params, vehicle, speed).dead_time
    # Far beyond its margin a controller that predicts may be stable once more.
    most = 1.5 * computed + 0.02
    driven = critical_dead_time(given, vehicle, speed, computed, most=most)
    assert driven == pytest.approx(computed, rel=0.01, abs=3e-4)


@pytest.mark.parametrize("name", controllers.names())
def test_dead_time_margin_shrinks_by_the_dead_time_that_nobody_tells(name: str) -> None:
    params = presets.get(name, "default")
    free = margins(params, CAR, 8.0).dead_time
    for share in (0.3, 0.77):
        late = CAR.replace(dead_time=share * free)
        found = margins(params, late, 8.0, believed=CAR).dead_time
        assert found == pytest.approx((1 - share) * free, abs=1e-4)
    assert not margins(params, CAR.replace(dead_time=1.01 * free), 8.0, believed=CAR).stable


@pytest.mark.parametrize(
    ("changes", "believed", "adapt"),
    [
        ({}, {}, None),
        ({}, {}, AdaptParams(slip_time=1.0)),
        ({}, {"wheelbase": 2.55, "steer_lag": 0.2}, "auto"),
        ({}, {"turning_wheelbase": 3.45, "steer_lag": 0.0}, None),
        ({"heading_cost": 1.0, "steer_rate_cost": 0.05}, {}, "auto"),
        ({"horizon": 2.0}, {}, "auto"),
    ],
    ids=str,
)
@pytest.mark.parametrize("speed", [4.0, 8.0, 16.0])
def test_dead_time_margin_of_another_preview_is_that_of_the_driven_loop(
    changes: dict[str, float], believed: dict[str, float], adapt: Any, speed: float
) -> None:
    given = _given("preview-pop", CAR.replace(**believed), adapt, **changes)
    computed = margins(given.params, CAR, speed, believed=given.vehicle).dead_time
    driven = critical_dead_time(given, CAR, speed, computed)
    assert driven == pytest.approx(computed, rel=0.01, abs=3e-4)


@pytest.mark.parametrize("name", controllers.names())
@pytest.mark.parametrize("point", [-1.0, 0.6])
def test_dead_time_margin_where_another_point_is_believed_is_that_of_the_driven_loop(
    name: str, point: float
) -> None:
    """It is told where it does not slip, and a dead time, neither of which is true."""
    given = _given(name, CAR.replace(no_slip_point=point, dead_time=0.06), None)
    computed = margins(given.params, CAR, 8.0, believed=given.vehicle).dead_time
    driven = critical_dead_time(given, CAR, 8.0, computed, most=1.5 * computed + 0.02)
    assert driven == pytest.approx(computed, rel=0.01, abs=3e-4)


@pytest.mark.parametrize("dead_time", [0.0, 0.13])
@pytest.mark.parametrize("speed", [5.0, 15.0])
def test_dead_time_margin_of_a_preview_that_adapts_is_hardly_less(
    dead_time: float, speed: float
) -> None:
    """A dead time that nobody told may be learnt in part, so there is no critical one to find."""
    vehicle = CAR.replace(dead_time=dead_time)
    given = _given("preview-pop", vehicle)._replace(adapt="auto")
    computed = margins(given.params, vehicle, speed).dead_time
    late = vehicle.replace(dead_time=vehicle.dead_time + 0.85 * computed)
    assert not grows(given, late, speed, 20.0 + 40.0 * computed)


@pytest.mark.parametrize("name", controllers.names())
@pytest.mark.parametrize("speed", [6.0, 12.0])
def test_gain_margin_is_by_how_much_more_a_car_may_turn_than_the_controller_is_told(
    name: str, speed: float
) -> None:
    vehicle = CAR.replace(steer_lag=0.2)
    given = _given(name, vehicle)
    gain = margins(given.params, vehicle, speed).gain
    for share, unstable in ((0.97, False), (1.03, True)):
        car = Vehicle(wheelbase=3.0 / (share * gain), steer_lag=0.2)
        assert grows(given, car, speed, 60.0) is unstable


@pytest.mark.parametrize("speed", [5.0, 15.0])
def test_pid_said_to_be_unstable_oscillates_between_its_limits(speed: float) -> None:
    vehicle = CAR.replace(steer_lag=0.0)
    printed = popsteer.PidParams(derivative_filter=0.0)
    found = margins(printed, vehicle, speed)
    # The filter keeps it stable up to (1 + 2 T / Δt) / k_D, 15 m/s.
    assert margins(popsteer.PidParams(), vehicle, speed).stable is (speed < 15.0)
    assert not found.stable
    assert np.isnan([found.gain, found.phase, found.dead_time]).all()
    law = popsteer.Pid(straight_path(speed * 30.0), vehicle, printed)
    _, angles = roll(law, vehicle, speed, (0.0, 1e-4, 0.0), 0.05, 400)
    assert np.ptp(angles[-50:]) > 1.0


@pytest.mark.parametrize("speed", [5.0, 10.0, 15.0, 20.0])
def test_pop_on_its_own_grid_stays_within_its_margin_and_leaves_the_road_beyond(
    speed: float,
) -> None:
    edge = margins(popsteer.PopParams(), CAR, speed).dead_time

    def excursion(dead_time: float) -> float:
        law = popsteer.Pop(straight_path(speed * 60.0 + 100.0), CAR)
        car = Vehicle(wheelbase=3.0, steer_lag=0.1, dead_time=dead_time)
        places, _ = roll(law, car, speed, (0.0, 0.3, 0.0), 0.05, 1200)
        return float(np.abs(places[-300:, 1]).max())

    assert excursion(0.9 * edge) < 0.06  # a step or three of 0.3 degrees to and fro
    assert excursion(1.1 * edge) > 3.0
