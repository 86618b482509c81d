"""The offset that preview POP keeps in a bend, computed and driven."""

from __future__ import annotations

import pytest

import popsteer
from popsteer.errors import ConfigError
from popsteer.study import Vehicle, carrot_offset, margins, preview_offset
from popsteer.study.preview_bend import choice
from tests.closed_loop.rolling import Car, driven_preview_offset

CAR = Car(3.0, 0.1, 0.0)


def _params(**changes: float) -> popsteer.PreviewPopParams:
    return Vehicle().fitted(popsteer.PreviewPopParams()).replace(**changes)


@pytest.mark.parametrize(
    "changes",
    [
        {"wheelbase": 2.55},
        {"wheelbase": 3.45},
        {"wheelbase": 2.7, "understeer": 4e-3},
        {"wheelbase": 3.45, "steer_lag": 0.2},
        {"wheelbase": 3.45, "reference_offset": 1.5},
        {"wheelbase": 2.55, "heading_cost": 1.0, "steer_rate_cost": 1.0},
        {"wheelbase": 3.45, "horizon": 2.5},
    ],
    ids=",".join,
)
@pytest.mark.parametrize(("radius", "speed"), [(50.0, 15.0), (50.0, 4.0), (120.0, 15.0)])
def test_preview_offset_of_a_wrong_model_is_the_one_that_is_driven(
    changes: dict[str, float], radius: float, speed: float
) -> None:
    params = _params(**changes)
    computed = preview_offset(params, Vehicle(), radius, speed)
    driven = driven_preview_offset(params, CAR, radius, speed)
    assert driven == pytest.approx(computed, rel=0.05, abs=1e-3)
    assert abs(computed) > 1e-3


@pytest.mark.parametrize("changes", [{}, {"wheelbase": 3.45, "turn_learning_time": 0.5}])
def test_preview_offset_of_a_right_or_learnt_model_is_none(changes: dict[str, float]) -> None:
    params = _params(**changes)
    assert preview_offset(params, Vehicle(), 50.0, 15.0) == 0.0
    assert driven_preview_offset(params, CAR, 50.0, 15.0) == pytest.approx(0.0, abs=1e-3)


def test_preview_offset_below_the_least_speed_is_not_learnt() -> None:
    params = _params(wheelbase=3.45, turn_learning_time=0.5)
    computed = preview_offset(params, Vehicle(), 50.0, 4.0)
    assert computed == preview_offset(params.replace(turn_learning_time=0.0), Vehicle(), 50.0, 4.0)
    driven = driven_preview_offset(params, CAR, 50.0, 4.0)
    assert driven == pytest.approx(computed, rel=0.05, abs=1e-3)


def test_choice_turns_the_parameter_of_each_law() -> None:
    vehicle = Vehicle()
    pop = vehicle.fitted(popsteer.PopParams())
    found = choice(pop, vehicle, (3.0, 9.0), radius=40.0, speed=12.0, dt=0.04)
    rope = pop.replace(lookahead_gain=0.0, min_lookahead=9.0)
    assert found.values == (3.0, 9.0)
    assert found.offsets[1] == carrot_offset(9.0, 40.0, vehicle, 12.0)
    assert found.dead_times[1] == margins(rope, vehicle, 12.0, 0.04).dead_time
    found = choice(_params(wheelbase=2.7), vehicle, (0.1, 1.0), radius=40.0, speed=12.0, dt=0.04)
    costly = _params(wheelbase=2.7, steer_rate_cost=1.0)
    assert found.offsets[1] == preview_offset(costly, vehicle, 40.0, 12.0, 0.04)
    assert found.dead_times[1] == margins(costly, vehicle, 12.0, 0.04).dead_time


def test_preview_offset_of_bad_numbers_is_refused_by_name() -> None:
    with pytest.raises(ConfigError, match="radius must be in"):
        preview_offset(_params(), Vehicle(), 0.0, 15.0)
    with pytest.raises(ConfigError, match="speed must be in"):
        preview_offset(_params(), Vehicle(), 50.0, 0.0)
