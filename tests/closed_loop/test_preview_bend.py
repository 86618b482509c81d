"""The offset that preview POP keeps in a bend, computed and driven."""

from __future__ import annotations

import pytest

import popsteer
from popsteer import AdaptParams, PreviewPopParams, Vehicle
from popsteer.errors import ConfigError
from popsteer.lab.stability import carrot_offset, margins, preview_offset
from popsteer.lab.stability.preview_bend import choice
from studies.rolling import Car, Given, driven_preview_offset

VEHICLE = Vehicle(max_lateral_acceleration=None)
CAR = Car.of(VEHICLE)
CONSTANT = AdaptParams(turn_time=0.0)


def _given(
    believed: dict[str, float],
    params: PreviewPopParams | None = None,
    adapt: AdaptParams = CONSTANT,
) -> Given:
    params = PreviewPopParams() if params is None else params
    return Given("preview-pop", params, VEHICLE.replace(**believed), adapt)


@pytest.mark.parametrize(
    ("believed", "changes"),
    [
        ({"turning_wheelbase": 2.55}, {}),
        ({"turning_wheelbase": 3.45}, {}),
        ({"turning_wheelbase": 2.7, "understeer": 4e-3}, {}),
        ({"turning_wheelbase": 3.45, "steer_lag": 0.2}, {}),
        ({"turning_wheelbase": 2.55}, {"heading_cost": 1.0, "steer_rate_cost": 1.0}),
        ({"turning_wheelbase": 3.45}, {"horizon": 2.5}),
    ],
    ids=str,
)
@pytest.mark.parametrize(("radius", "speed"), [(50.0, 15.0), (50.0, 4.0), (120.0, 15.0)])
def test_preview_offset_of_a_wrong_vehicle_is_the_one_that_is_driven(
    believed: dict[str, float], changes: dict[str, float], radius: float, speed: float
) -> None:
    params = PreviewPopParams().replace(**changes)
    given = _given(believed, params)
    computed = preview_offset(
        params, VEHICLE, radius, speed, believed=given.vehicle, adapt=given.adapt
    )
    driven = driven_preview_offset(given, CAR, radius, speed)
    assert driven == pytest.approx(computed, rel=0.05, abs=1e-3)
    assert abs(computed) > 1e-3


@pytest.mark.parametrize(
    ("believed", "adapt"),
    [({}, CONSTANT), ({"turning_wheelbase": 3.45}, AdaptParams())],
)
@pytest.mark.parametrize("speed", [4.0, 15.0])
def test_preview_offset_of_a_right_or_estimated_vehicle_is_none(
    believed: dict[str, float], adapt: AdaptParams, speed: float
) -> None:
    given = _given(believed, adapt=adapt)
    found = preview_offset(
        PreviewPopParams(), VEHICLE, 50.0, speed, believed=given.vehicle, adapt=adapt
    )
    assert found == 0.0
    # The weight of what the controller was told keeps a part of it for a while.
    assert driven_preview_offset(given, CAR, 50.0, speed) == pytest.approx(0.0, abs=4e-3)


def test_choice_varies_the_parameter_of_each_controller() -> None:
    pop = popsteer.PopParams()
    found = choice(pop, VEHICLE, (3.0, 9.0), radius=40.0, speed=12.0, dt=0.04)
    rope = pop.replace(lookahead_gain=0.0, min_lookahead=9.0)
    assert found.values == (3.0, 9.0)
    assert found.offsets[1] == carrot_offset(9.0, 40.0, VEHICLE, 12.0)
    assert found.dead_times[1] == margins(rope, VEHICLE, 12.0, 0.04).dead_time
    given = VEHICLE.replace(turning_wheelbase=2.7)
    found = choice(
        PreviewPopParams(),
        VEHICLE,
        (0.1, 1.0),
        radius=40.0,
        speed=12.0,
        dt=0.04,
        believed=given,
        adapt=None,
    )
    costly = PreviewPopParams(steer_rate_cost=1.0)
    offset = preview_offset(costly, VEHICLE, 40.0, 12.0, 0.04, believed=given, adapt=None)
    assert found.offsets[1] == offset != 0.0
    late = margins(costly, VEHICLE, 12.0, 0.04, believed=given, adapt=None).dead_time
    assert found.dead_times[1] == late


def test_preview_offset_of_bad_numbers_is_refused_by_name() -> None:
    with pytest.raises(ConfigError, match="radius must be in"):
        preview_offset(PreviewPopParams(), VEHICLE, 0.0, 15.0)
    with pytest.raises(ConfigError, match="speed must be in"):
        preview_offset(PreviewPopParams(), VEHICLE, 50.0, 0.0)
