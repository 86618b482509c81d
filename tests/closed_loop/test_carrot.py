from __future__ import annotations

import math

import numpy as np
import pytest

import popsteer
from popsteer import Vehicle, vehicles
from popsteer.errors import ConfigError
from popsteer.lab.stability import carrot_offset, driven_offset
from popsteer.lab.stability.carrot import carrot_curve
from studies.rolling import Car, roll


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
    places, _ = roll(pop, Car(wheelbase, lag, 0.0), 5.0, (0.0, 0.0, 0.0), 0.05, steps)
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
    curve = carrot_curve("carla-identified")
    assert (curve.computed < 0.5 * curve.rope).all()
    assert np.allclose(carrot_curve("kinematic-bicycle").computed, curve.rope)


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
