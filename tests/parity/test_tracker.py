"""Actuator, hand-over, another path, refused inputs: what every law does alike."""

from __future__ import annotations

import dataclasses
import itertools
import random
from functools import partial
from math import inf, nan, nextafter
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.parity.compare import call, make, same
from tests.parity.laws import LATERAL, Law
from tests.parity.strategies import ACTUATORS, SEEDS, Shape

_FIELDS = ("dead_time", "lag", "max_rate", "wheelbase", "understeer", "learning_time")
_EACH_LAW = [
    pytest.param(
        law,
        id=law.name,
        marks=pytest.mark.covers(f"{law.name}.set_path", f"{law.name}.step_or_hold"),
    )
    for law in LATERAL
]


@pytest.mark.covers("Actuator", "Actuator.as_dict", "Actuator.replace")
def test_actuator_matches_reference_edges() -> None:
    make("Actuator")
    for field in _FIELDS:
        for value in (nan, inf, -inf, -1e300, 1e300, -nextafter(0.0, 1.0), [1.0]):
            assert call("Actuator", **{field: value}) is None
        made = make("Actuator", **{field: 0.01})
        same("Actuator.as_dict", made.rust.as_dict, partial(dataclasses.asdict, made.twin))
        replaced = partial(dataclasses.replace, made.twin)
        same("Actuator.replace", made.rust.replace, replaced, lag=0.2)


@pytest.mark.parametrize("learning_time", [0.0, 10.0])
@pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)
def test_law_whose_prediction_leaves_the_bounds_matches_reference_edges(
    law: Law, learning_time: float
) -> None:
    path = make("Path", [(-1e9, -1e9), (0.0, 0.0), (1e9, 1e9)])
    actuator = make("Actuator", dead_time=10.0, lag=0.1, learning_time=learning_time)
    pair = make(law.name, path, actuator=actuator)
    pair.call("reset", steer=1.2)
    for x, y in itertools.product((-1e9, 1e9), repeat=2):
        for yaw, speed in itertools.product((-1e6, 1e6, 0.1), (-1e4, 1e4)):
            assert pair.call("step", x, y, yaw, speed, 0.05) is not None
            pair.get("state")


@pytest.mark.parametrize("law", _EACH_LAW)
@given(actuator=ACTUATORS, seed=SEEDS, backwards=st.booleans(), taken=st.floats(-0.5, 0.5))
def test_law_through_an_actuator_matches_reference_random(
    law: Law, actuator: dict[str, Any] | None, seed: int, backwards: bool, taken: float
) -> None:
    rng = random.Random(seed)
    paths = []
    for kind in ("smooth", "collinear"):
        xy = Shape(kind, count=40, seed=seed).build().xy
        reverse = [backwards and k >= 20 for k in range(40)]
        paths.append(make("Path", xy, reverse=reverse))
    chain = None if actuator is None else make("Actuator", **actuator)
    pair = make(law.name, paths[0], actuator=chain)
    pair.get("actuator")
    pair.call("reset", steer=taken)
    for k in range(40):
        x, y = xy[k] if k >= 20 else (paths[0].rust.x[k], paths[0].rust.y[k])
        pose = [x + rng.gauss(0.0, 0.3), y + rng.gauss(0.0, 0.3), rng.uniform(-3.0, 3.0)]
        if rng.random() < 0.2:
            pose[rng.randrange(3)] = nan
        pair.call("step_or_hold", *pose, rng.uniform(-2.0, 9.0), 0.05, rng.choice((-1, 0, 1, 10)))
        pair.get("state")
        if k == 20:
            pair.call("set_path", paths[1])
    assert pair.set_state(pair.get("state"))
