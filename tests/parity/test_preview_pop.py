from __future__ import annotations

from math import inf, nan, nextafter, pi
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from tests.helpers import long_drives
from tests.parity.checks import (
    Rollout,
    check_bad_states,
    check_bad_steps,
    check_params,
    check_random,
    check_rollout,
    check_zeros,
)
from tests.parity.laws import PREVIEW_POP
from tests.parity.scenes import CASES, drives
from tests.parity.strategies import (
    ADAPTS,
    CALM_VEHICLES,
    SPOTS,
    VEHICLES,
    Shape,
    Spot,
    shapes,
)


@pytest.mark.covers(
    "PreviewPop", "PreviewPop.step", "PreviewPop.steer", "PreviewPop.state", "PreviewPop.reset"
)
@pytest.mark.parametrize("drive", CASES.values(), ids=CASES)
@pytest.mark.parametrize(
    ("params", "vehicle"),
    [
        ({}, {}),
        ({"heading_cost": 1.0}, {"steer_lag": 0.0, "dead_time": 0.3, "steer_offset": 0.02}),
        (
            {"horizon": 2.0, "smoothing_length": 0.0},
            {"rear_axle": -1.94, "no_slip_point": 0.0, "understeer": 0.002},
        ),
    ],
    ids=str,
)
def test_preview_pop_matches_reference_cases(
    drive: Rollout, params: dict[str, Any], vehicle: dict[str, Any]
) -> None:
    check_rollout(PREVIEW_POP, drive, params, most=5000, vehicle=vehicle)


@pytest.mark.covers(
    "PreviewPopParams",
    "PreviewPopState",
    "PreviewPop.step",
    "PreviewPop.steer",
    "PreviewPop.state",
)
def test_preview_pop_matches_reference_edges() -> None:
    check_params(PREVIEW_POP)
    check_bad_steps(PREVIEW_POP)
    check_zeros(PREVIEW_POP)
    bad = [{"previous_steer": value} for value in (nan, inf, -inf, 1.2200000000000002, -1.3)]
    # Its wheels are modelled always: what is in flight has to be what can be.
    in_flight: list[dict[str, Any]] = [
        *({"wheel": value} for value in (nan, inf, nextafter(pi / 2.0, 2.0), -2.0)),
        *({"wheel": 0.1, "commands_in_flight": ((value, 0.0),)} for value in (nan, -inf, 1.6)),
        *({"wheel": 0.1, "commands_in_flight": ((0.1, value),)} for value in (nan, -0.1, 1e-6)),
        {"wheel": 0.1, "commands_in_flight": ((0.0, 0.0),) * 197},
        # The first in the order of the check is the one named.
        {"wheel": nan, "previous_steer": nan, "waypoint": 99},
        {"wheel": 0.1, "commands_in_flight": ((nan, nan),) * 300, "previous_steer": nan},
        {"wheel": 0.1, "longer_dead_time": nan, "slip": nan},
        {"longer_dead_time": nan, "slip": nan},
    ]
    check_bad_states(PREVIEW_POP, good={"previous_steer": 0.5}, bad=[*bad, *in_flight])


@pytest.mark.covers(
    *("PreviewPop.params", "PreviewPop.path", "PreviewPop.vehicle", "PreviewPop.vehicle_given"),
    *(
        "PreviewPop.adapt",
        "PreviewPop.estimate",
        "PreviewPop.tracked_point",
        "PreviewPop.monitor",
        "Command.steer",
    ),
)
@given(
    shape=shapes(),
    params=PREVIEW_POP.params(),
    vehicle=st.none() | VEHICLES,
    adapt=ADAPTS,
    spots=st.lists(SPOTS, min_size=1, max_size=6),
)
# Limits close to rounding: at 10,000 m/s, where the first move must be 0, and where one follows
# from others.
@example(
    shape=Shape(count=3, closed=True),
    params={"steer_span_rate": None, "heading_cost": 0.0},
    vehicle=None,
    adapt="auto",
    spots=[*[Spot(speed=1.0, dt=0.125)] * 4, Spot(speed=1e4, dt=0.0625)],
)
@example(
    shape=Shape("noisy", 4, seed=1),
    params={"heading_cost": 0.0, "steer_rate_cost": 1e-05},
    vehicle=None,
    adapt="auto",
    spots=[Spot(speed=1.0, dt=0.125), Spot(speed=1e-160, dt=0.0625)],
)
@example(
    shape=Shape("noisy", 36, 0.875, seed=36),
    params={"steer_span_rate": None, "heading_cost": 40.0},
    vehicle=None,
    adapt=None,
    spots=[
        Spot(speed=0.5, dt=0.015625),
        Spot(along=1.0, speed=4.0, dt=0.03125),
        Spot(speed=1.0, dt=0.03125),
        Spot(along=1.0, speed=5.0, dt=0.03125),
        Spot(speed=0.5, dt=0.125),
        Spot(along=0.625, speed=12.0, dt=0.109375),
    ],
)
@example(
    shape=Shape(),
    params={},
    vehicle={"no_slip_point": None, "steer_offset": -0.5, "max_steer": 0.3125},
    adapt="auto",
    spots=[Spot(speed=1.0, dt=0.125), Spot(turned=pi, speed=1e4, dt=0.125)],
)
def test_preview_pop_matches_reference_random(
    shape: Shape,
    params: dict[str, Any],
    vehicle: dict[str, Any] | None,
    adapt: Any,
    spots: list[Spot],
) -> None:
    check_random(PREVIEW_POP, shape, params, spots, vehicle, adapt)


@pytest.mark.covers("PreviewPop.step", "PreviewPop.steer", "PreviewPop.state", "PreviewPop.reset")
@long_drives()
@given(drive=drives(), params=PREVIEW_POP.params(), vehicle=CALM_VEHICLES, adapt=ADAPTS)
def test_preview_pop_matches_reference_rollout(
    drive: Rollout, params: dict[str, Any], vehicle: dict[str, Any], adapt: Any
) -> None:
    check_rollout(PREVIEW_POP, drive, params, vehicle=vehicle, adapt=adapt)
