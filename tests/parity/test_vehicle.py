"""The vehicle: values that both sides take and refuse alike."""

from __future__ import annotations

from math import inf, nan, nextafter
from typing import Any

from hypothesis import given

from tests.parity.checks import check_ranges
from tests.parity.compare import make
from tests.parity.strategies import SPEEDS, VEHICLE_OPTIONAL, VEHICLE_RANGES, VEHICLES


def test_vehicle_matches_reference_edges() -> None:
    check_ranges("Vehicle", VEHICLE_RANGES, VEHICLE_OPTIONAL)
    car = make("Vehicle", understeer=0.01)
    for speed in (nan, inf, -inf, nextafter(1e4, inf), -nextafter(1e4, inf), 10**400, None):
        assert car.call("turning_length", speed) is None


@given(vehicle=VEHICLES, speed=SPEEDS)
def test_vehicle_matches_reference_random(vehicle: dict[str, Any], speed: float) -> None:
    car = make("Vehicle", **vehicle)
    car.get("front_axle")
    car.call("turning_length", speed)
