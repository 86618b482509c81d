"""The offsets in a bend of POP and preview POP: computed, and driven."""

from __future__ import annotations

import math

import numpy as np
import pytest

import popsteer
from popsteer import AdaptParams, PreviewPopParams, Vehicle, vehicles
from popsteer.errors import ConfigError
from popsteer.lab.stability import margins
from studies.carrot import carrot_curve, carrot_offset, choice, driven_offset, preview_offset
from studies.theory import Given, driven_preview_offset, roll

VEHICLE = Vehicle(max_lateral_acceleration=None)
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
    driven = driven_preview_offset(given, VEHICLE, radius, speed)
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
    assert driven_preview_offset(given, VEHICLE, 50.0, speed) == pytest.approx(0.0, abs=4e-3)


def test_choice_varies_the_parameter_of_each_controller() -> None:
    pop, car = popsteer.PopParams(), vehicles.get("paper")
    found = choice(pop, (3.0, 9.0))
    rope = pop.replace(lookahead_gain=0.0, min_lookahead=9.0)
    assert found.values == (3.0, 9.0)
    assert found.offsets[1] == carrot_offset(9.0, 50.0, car, 15.0)
    assert found.dead_times[1] == margins(rope, car, 15.0).dead_time
    given = car.replace(turning_wheelbase=2.7)
    found = choice(PreviewPopParams(), (0.1, 1.0), given)
    costly = PreviewPopParams(steer_rate_cost=1.0)
    offset = preview_offset(costly, car, 50.0, 15.0, believed=given, adapt=None)
    assert found.offsets[1] == offset != 0.0
    assert found.dead_times[1] == margins(costly, car, 15.0, believed=given).dead_time


def test_preview_offset_of_bad_numbers_is_refused_by_name() -> None:
    with pytest.raises(ConfigError, match="radius must be in"):
        preview_offset(PreviewPopParams(), VEHICLE, 0.0, 15.0)
    with pytest.raises(ConfigError, match="speed must be in"):
        preview_offset(PreviewPopParams(), VEHICLE, 50.0, 0.0)


@pytest.mark.parametrize(("distance", "radius"), [(6.0, 12.0), (8.0, 50.0), (11.0, 300.0)])
def test_carrot_offset_of_a_kinematic_bicycle_is_that_of_a_rope(
    distance: float, radius: float
) -> None:
    rope = radius - math.sqrt(radius**2 - distance**2)
    for wheelbase in (1.0, 2.7, 5.0):
        for rear_axle in (0.0, -1.5):
            vehicle = Vehicle(wheelbase=wheelbase, rear_axle=rear_axle)
            found = carrot_offset(distance, radius, vehicle)
            assert found == pytest.approx(rope, rel=1e-12)


def test_carrot_offset_on_a_wide_circle_is_the_small_angle_formula() -> None:
    vehicle = vehicles.get("carla-identified")
    turning = 3.553 + 2.9e-4 * 15.0**2
    formula = 9.0 * (4.5 - (turning - 1.06)) / 2000.0
    assert carrot_offset(9.0, 2000.0, vehicle, 15.0) == pytest.approx(formula, rel=1e-3)


@pytest.mark.parametrize(("wheelbase", "lag"), [(2.5, 0.0), (3.5, 0.1)])
@pytest.mark.parametrize("radius", [15.0, 40.0])
def test_carrot_offset_is_what_a_car_apart_from_the_library_drives(
    wheelbase: float, lag: float, radius: float
) -> None:
    angle = np.linspace(0.0, 2.0 * math.pi, round(30.0 * radius), endpoint=False)
    xy = radius * np.column_stack((np.sin(angle), 1.0 - np.cos(angle)))
    path = popsteer.Path(xy, closed=True)
    vehicle = Vehicle(wheelbase=wheelbase)
    pop = popsteer.Pop(path, vehicle, popsteer.PopParams(candidate_count=2001, min_lookahead=6.0))
    steps = int(3.0 * math.pi * radius / 5.0 / 0.05)
    places, _ = roll(pop, vehicle.replace(steer_lag=lag), 5.0, (0.0, 0.0, 0.0), 0.05, steps)
    # The rear axle is given; the front one is the wheelbase ahead along the tangent.
    rear = np.hypot(*(places[-40:] - [0.0, radius]).T)
    driven = radius - np.sqrt(rear**2 + wheelbase**2)
    assert driven.mean() == pytest.approx(carrot_offset(7.0, radius, Vehicle()), abs=0.01)


@pytest.mark.parametrize("plant", ["kinematic-bicycle", "carla-identified"])
@pytest.mark.parametrize("radius", [15.0, 30.0, 80.0])
def test_carrot_offset_is_what_pop_drives_on_the_plants(plant: str, radius: float) -> None:
    speed = math.sqrt(2.0 * radius)
    driven, distance = driven_offset(radius, plant, speed)
    computed = carrot_offset(distance, radius, vehicles.get(plant), speed)
    assert driven == pytest.approx(computed, abs=0.05)  # the candidates are 0.3 degrees apart


def test_carrot_curve_lies_below_the_rope_where_the_wheels_turn_the_car_less() -> None:
    curve = carrot_curve(vehicles.get("carla-identified"))
    assert (curve.computed < 0.5 * curve.rope).all()
    assert np.allclose(carrot_curve(vehicles.get("kinematic-bicycle")).computed, curve.rope)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((8.0, 8.0), "distance must be in"),
        ((8.0, math.nan), "radius must be in"),
        ((2.9, 2.95), "radius must be one that the vehicle can turn"),
    ],
)
def test_carrot_offset_of_what_cannot_be_driven_is_refused(
    arguments: tuple[float, float], message: str
) -> None:
    with pytest.raises(ConfigError, match=message):
        carrot_offset(*arguments, Vehicle())
