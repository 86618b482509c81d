"""The vehicle and how a controller adapts to it: values that both sides take and refuse alike."""

from __future__ import annotations

from math import inf, nan, nextafter
from typing import Any

import pytest
from hypothesis import given

from popsteer import Status
from tests.parity.checks import check_copy, check_ranges
from tests.parity.compare import call, make
from tests.parity.strategies import (
    ADAPT_OPTIONAL,
    ADAPT_RANGES,
    MONITOR_OPTIONAL,
    MONITOR_RANGES,
    SPEEDS,
    VEHICLE_OPTIONAL,
    VEHICLE_RANGES,
    VEHICLES,
    some,
)

ANSWERS: dict[str, dict[str, Any]] = {
    "Command": {
        "steer": 0.1,
        "cross_track_error": -0.0,
        "heading_error": 0.2,
        "predicted_cross_track_error": 0.3,
        "predicted_heading_error": -0.1,
        "target": (1.0, -2.0),
        "reverse": True,
        "reference_speed": -1.5,
        "distance_to_stop": inf,
        "status": Status.SATURATED,
    },
    "Projection": {
        "segment": 3,
        "fraction": 0.5,
        "point": (1.0, 2.0),
        "arc_length": 3.5,
        "cross_track_error": -0.25,
        "path_yaw": 0.1,
    },
    "Lookahead": {"index": 4, "point": (1.0, 2.0), "found": False},
    "SpeedCommand": {
        "acceleration": -0.0,
        "reference_speed": 3.0,
        "distance_to_stop": inf,
        "reverse": True,
        "standing": False,
    },
}
"""What answers consist of."""


@pytest.mark.covers("Vehicle", "AdaptParams", "MonitorParams")
def test_vehicle_matches_reference_edges() -> None:
    check_ranges("Vehicle", VEHICLE_RANGES, VEHICLE_OPTIONAL)
    check_ranges("AdaptParams", ADAPT_RANGES, ADAPT_OPTIONAL)
    check_ranges("MonitorParams", MONITOR_RANGES, MONITOR_OPTIONAL)
    car = make("Vehicle", understeer=0.01)
    for speed in (nan, inf, -inf, nextafter(1e4, inf), -nextafter(1e4, inf), 10**400, None):
        assert car.call("turning_length", speed) is None


@pytest.mark.covers("Vehicle.as_dict", "Vehicle.replace", "Vehicle.front_axle")
@pytest.mark.covers("Vehicle.turning_length")
@given(vehicle=VEHICLES, changes=VEHICLES, speed=SPEEDS)
def test_vehicle_matches_reference_random(
    vehicle: dict[str, Any], changes: dict[str, Any], speed: float
) -> None:
    check_copy("Vehicle", vehicle, changes)
    car = make("Vehicle", **vehicle)
    car.get("front_axle")
    car.call("turning_length", speed)
    assert (car.rust == make("Vehicle", **changes).rust) == (
        car.twin == make("Vehicle", **changes).twin
    )
    assert hash(car.rust) == hash(make("Vehicle", **vehicle).rust)


@pytest.mark.covers("AdaptParams.as_dict", "AdaptParams.replace")
@given(adapt=some(ADAPT_RANGES, ADAPT_OPTIONAL), changes=some(ADAPT_RANGES, ADAPT_OPTIONAL))
def test_adapt_params_matches_reference_random(
    adapt: dict[str, Any], changes: dict[str, Any]
) -> None:
    check_copy("AdaptParams", adapt, changes)


@pytest.mark.covers("MonitorParams.as_dict", "MonitorParams.replace")
@given(
    monitor=some(MONITOR_RANGES, MONITOR_OPTIONAL), changes=some(MONITOR_RANGES, MONITOR_OPTIONAL)
)
def test_monitor_params_matches_reference_random(
    monitor: dict[str, Any], changes: dict[str, Any]
) -> None:
    check_copy("MonitorParams", monitor, changes)


@pytest.mark.covers("Estimate", "Estimate.as_dict")
def test_estimate_matches_reference_cases() -> None:
    check_copy("Estimate", {}, None)
    check_copy("Estimate", {"gain": 0.5, "dead_time": -0.0, "slip_length": 1.0}, None)
    assert call("Estimate", 1.0) is None
    assert call("Estimate", no_such_field=1.0) is None


@pytest.mark.parametrize(
    ("name", "fields"),
    [
        pytest.param(name, fields, id=name, marks=pytest.mark.covers(name))
        for name, fields in ANSWERS.items()
    ],
)
def test_answer_made_anew_matches_reference(name: str, fields: dict[str, Any]) -> None:
    make(name, **fields)
    for missing in fields:
        assert call(name, **{field: fields[field] for field in fields if field != missing}) is None
