"""The margins of `popsteer.study.stability` against cars that are driven to the edge."""

from __future__ import annotations

import numpy as np
import pytest

import popsteer
from popsteer import presets
from popsteer.study import LINEAR_LAWS, Vehicle, margins
from tests.closed_loop.rolling import (
    Car,
    critical_dead_time,
    grows,
    in_small_signals,
    roll,
    straight_path,
)


def _params(name: str, vehicle: Vehicle) -> popsteer.laws.Params:
    return in_small_signals(vehicle.fitted(presets.get(name, "default")))


@pytest.mark.parametrize("name", LINEAR_LAWS)
@pytest.mark.parametrize("speed", [5.0, 10.0, 15.0, 20.0])
@pytest.mark.parametrize("lag", [0.1, 0.2])
def test_dead_time_margin_is_where_the_driven_loop_begins_to_grow(
    name: str, speed: float, lag: float
) -> None:
    vehicle = Vehicle(lag=lag)
    params = _params(name, vehicle)
    predicted = margins(params, vehicle, speed).dead_time
    driven = critical_dead_time(name, params, Car(3.0, lag, 0.0), speed, predicted)
    assert driven == pytest.approx(predicted, rel=0.01, abs=3e-4)


@pytest.mark.parametrize("name", ["pure-pursuit", "stanley", "pop", "preview-pop"])
def test_dead_time_margin_without_lag_and_at_another_rate_is_that_of_the_driven_loop(
    name: str,
) -> None:
    vehicle = Vehicle(wheelbase=2.5, lag=0.0)
    params = _params(name, vehicle)
    predicted = margins(params, vehicle, 12.0, dt=0.02).dead_time
    driven = critical_dead_time(name, params, Car(2.5, 0.0, 0.0), 12.0, predicted, dt=0.02)
    assert driven == pytest.approx(predicted, rel=0.01)


@pytest.mark.parametrize("name", LINEAR_LAWS)
def test_dead_time_margin_shrinks_by_the_dead_time_that_there_is(name: str) -> None:
    params = _params(name, Vehicle())
    free = margins(params, Vehicle(), 8.0).dead_time
    for share in (0.3, 0.77):
        late = Vehicle(dead_time=share * free)
        assert margins(params, late, 8.0).dead_time == pytest.approx((1 - share) * free, abs=1e-4)
    assert not margins(params, Vehicle(dead_time=1.01 * free), 8.0).stable


@pytest.mark.parametrize(
    "changes",
    [
        {"turn_learning_time": 0.5},
        {"slip_learning_time": 1.0},
        {"wheelbase": 2.55, "steer_lag": 0.2},
        {"wheelbase": 3.45, "steer_lag": 0.0, "turn_learning_time": 0.5},
        {"heading_cost": 1.0, "steer_rate_cost": 0.05},
        {"horizon": 2.0},
    ],
    ids=",".join,
)
@pytest.mark.parametrize("speed", [4.0, 8.0, 16.0])
def test_dead_time_margin_of_another_preview_is_that_of_the_driven_loop(
    changes: dict[str, float], speed: float
) -> None:
    vehicle = Vehicle()
    params = _params("preview-pop", vehicle).replace(**changes)
    predicted = margins(params, vehicle, speed).dead_time
    driven = critical_dead_time("preview-pop", params, Car(3.0, 0.1, 0.0), speed, predicted)
    assert driven == pytest.approx(predicted, rel=0.01, abs=3e-4)


@pytest.mark.parametrize("name", LINEAR_LAWS)
@pytest.mark.parametrize("speed", [6.0, 12.0])
def test_gain_margin_is_by_how_much_more_a_car_may_turn_than_the_law_is_told(
    name: str, speed: float
) -> None:
    vehicle = Vehicle(lag=0.2)
    params = _params(name, vehicle)
    gain = margins(params, vehicle, speed).gain
    for share, unstable in ((0.97, False), (1.03, True)):
        car = Car(3.0 / (share * gain), 0.2, 0.0)
        assert grows(name, params, car, speed, 60.0) is unstable


@pytest.mark.parametrize("speed", [5.0, 15.0])
def test_pid_said_to_be_unstable_swings_from_rim_to_rim(speed: float) -> None:
    vehicle = Vehicle(lag=0.0)
    params = vehicle.fitted(popsteer.PidParams())
    found = margins(params, vehicle, speed)
    assert not found.stable
    assert np.isnan([found.gain, found.phase, found.dead_time]).all()
    law = popsteer.Pid(straight_path(speed * 30.0), params)
    _, angles = roll(law, Car(3.0, 0.0, 0.0), speed, (0.0, 1e-4, 0.0), 0.05, 400)
    assert np.ptp(angles[-50:]) > 1.0


@pytest.mark.parametrize("speed", [5.0, 10.0, 15.0, 20.0])
def test_pop_on_its_own_grid_stays_within_its_margin_and_leaves_the_road_beyond(
    speed: float,
) -> None:
    vehicle = Vehicle()
    params = vehicle.fitted(popsteer.PopParams())
    edge = margins(params, vehicle, speed).dead_time

    def excursion(dead_time: float) -> float:
        law = popsteer.Pop(straight_path(speed * 60.0 + 100.0), params)
        car = Car(3.0, 0.1, dead_time)
        places, _ = roll(law, car, speed, (0.0, 0.3, 0.0), 0.05, 1200)
        return float(np.abs(places[-300:, 1]).max())

    assert excursion(0.9 * edge) < 0.06  # a step or three of 0.3 degrees to and fro
    assert excursion(1.1 * edge) > 3.0
