"""Vehicle, adaptation, hand-over, another path, refused inputs: what all controllers do alike."""

from __future__ import annotations

import itertools
import math
import random
from math import nan
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import popsteer
from tests.parity.checks import adapting
from tests.parity.compare import Pair, make
from tests.parity.laws import LATERAL, Law
from tests.parity.strategies import ADAPTS, CALM_VEHICLES, SEEDS, XY, Shape

_EACH_LAW = [
    pytest.param(
        law,
        id=law.name,
        marks=pytest.mark.covers(
            f"{law.name}.set_path",
            f"{law.name}.step_or_hold",
            f"{law.name}.vehicle",
            f"{law.name}.adapt",
            f"{law.name}.estimate",
        ),
    )
    for law in LATERAL
]


@pytest.mark.parametrize("adapt", [None, {}], ids=["fixed", "adapting"])
@pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)
def test_law_whose_prediction_leaves_the_bounds_matches_reference_edges(
    law: Law, adapt: dict[str, Any] | None
) -> None:
    path = make("Path", [(-1e9, -1e9), (0.0, 0.0), (1e9, 1e9)])
    pair = make(law.name, path, make("Vehicle", dead_time=10.0), **adapting(adapt))
    if pair.within > 0.0:
        # A place on this path is known to the rounding of its coordinates, 1.2e-7 m.
        pair.within = 1e-8
    pair.call("reset", steer=1.2)
    for x, y in itertools.product((-1e9, 1e9), repeat=2):
        for yaw, speed in itertools.product((-1e6, 1e6, 0.1), (-1e4, 1e4)):
            assert pair.call("step", x, y, yaw, speed, 0.05) is not None
            assert pair.set_state(pair.get("state"))


@pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)
def test_law_of_a_vehicle_that_hardly_moves_matches_reference_edges(law: Law) -> None:
    path = make("Path", [(k * 1.0, 0.1 * k) for k in range(50)])
    pair = make(law.name, path, **adapting({"min_speed": 0.0}))
    for k, speed in enumerate((5e-324, 5e-324, 1e-320, 1e-300, 1e-9, -5e-324, 0.0, 3.0)):
        command = pair.call("step", 1.0, 0.1 * k, 0.0, speed, 0.05)
        assert command is not None
        assert math.isfinite(command.rust.steer)
        assert pair.set_state(pair.get("state"))


def _cusp(seed: int) -> tuple[XY, list[bool]]:
    """A bend forward, a bend back from its end, and one forward again."""
    rng = random.Random(seed)
    x, y, heading = 0.0, 0.0, rng.uniform(-3.0, 3.0)
    xy, reverse = [], []
    for section in range(3):
        curvature = rng.uniform(-0.15, 0.15)
        for _ in range(20):
            xy.append((x, y))
            reverse.append(section == 1)
            way = -0.5 if section == 1 else 0.5
            x, y = popsteer.paper.kinematic_bicycle(x, y, heading, way, 0.0, 0.0, 1.0, 1.0)[:2]
            heading += way * curvature
    return xy, reverse


def _drive(pair: Pair, car: dict[str, Any], seed: int, reverse_first: bool) -> None:
    """Follow the path with a vehicle that is another than the controller thinks; noise and all."""
    rng = random.Random(seed)
    gain, offset, slip = rng.uniform(0.7, 1.4), rng.uniform(-0.03, 0.03), rng.uniform(-0.05, 0.05)
    path = pair.rust.path
    (x, y), (x1, y1) = zip(path.x[:2], path.y[:2], strict=True)
    yaw = math.atan2(y1 - y, x1 - x) + (3.14 if reverse_first else 0.0)
    wheel, speed, backwards = 0.0, 0.0, reverse_first
    queue = [0.0] * round(car.get("dead_time", 0.0) / 0.05)
    for k in range(100):
        noise = [rng.gauss(0.0, 0.01) for _ in range(3)]
        pose = [x + noise[0], y + noise[1], yaw + 0.1 * noise[2]]
        if rng.random() < 0.05:
            pose[rng.randrange(3)] = nan
        elif rng.random() < 0.02:
            pose[0] += 40.0
        dt = 0.05 if rng.random() < 0.8 else rng.uniform(0.005, 0.1)
        answer = pair.call("step_or_hold", *pose, speed, dt, rng.choice((-1, 0, 1, 10)))
        assert answer is not None
        backwards = answer.rust.reverse
        queue.append(answer.rust.steer)
        wheel += 0.4 * (queue.pop(0) + offset - wheel)
        speed += 0.1 * ((-3.0 if backwards else 3.0) - speed)
        x, y, turned, _ = popsteer.paper.kinematic_bicycle(
            x, y, yaw + slip, speed, popsteer.paper.saturate(gain * wheel, -1.2, 1.2), 0.0, 3.0, dt
        )
        yaw = turned - slip
        if k % 10 == 9:
            state = pair.get("state")
            assert pair.set_state(state)
            pair.get("estimate")


@pytest.mark.parametrize("law", _EACH_LAW)
@given(
    vehicle=CALM_VEHICLES,
    adapt=ADAPTS,
    seed=SEEDS,
    way=st.sampled_from(["forward", "backward", "cusps"]),
    taken=st.floats(-0.25, 0.25),
)
def test_law_with_a_vehicle_matches_reference_random(
    law: Law, vehicle: dict[str, Any], adapt: Any, seed: int, way: str, taken: float
) -> None:
    if way == "cusps":
        xy, reverse = _cusp(seed)
    else:
        xy = Shape("smooth", count=40, seed=seed).build().xy
        reverse = [way == "backward"] * 40
    path = make("Path", xy, reverse=reverse)
    pair = make(law.name, path, make("Vehicle", **vehicle), **adapting(adapt))
    for attribute in ("vehicle", "vehicle_given", "adapt", "estimate", "tracked_point"):
        pair.get(attribute)
    pair.call("reset", steer=taken)
    pair.get("state")
    _drive(pair, vehicle, seed, reverse[0])
    pair.call("set_path", make("Path", Shape("collinear", count=40, seed=seed).build().xy))
    for k in range(5):
        pair.call("step", 1.0 + k, 0.3, 0.1, 5.0, 0.05)
        pair.get("state")


@pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)
def test_state_of_another_vehicle_matches_reference_edges(law: Law) -> None:
    path = make("Path", [(10.0 * k, 0.1 * k * k) for k in range(9)])

    def delayed(dead_time: float) -> Pair:
        return make(law.name, path, make("Vehicle", dead_time=dead_time), adapt=None)

    donor = delayed(0.2)
    for k in range(12):
        donor.call("step", 0.25 * k, 0.5, 0.1, 5.0, 0.05)
    state = donor.get("state")
    assert delayed(0.2).set_state(state)
    assert not delayed(0.3).set_state(state)
    bare = delayed(0.0)
    # Of a controller that models nothing, nothing is in flight; preview POP would have to know.
    assert bare.set_state(state) == (not law.reads_belief)
    bare.get("state")
    # The wheels of a state that knows nothing of them are at rest under its angle.
    plain = make(law.state_name, steer=0.1)
    assert delayed(0.3).set_state(plain)
    assert bare.set_state(plain)
    bare.get("state")
    assert not delayed(0.3).set_state(make(law.state_name, steer=nan))
    assert not delayed(0.3).set_state(make(law.state_name, longer_dead_time=0.1))
    for fields in (
        {"commands_in_flight": ((0.1, 0.1), (0.2, 0.2))},
        {"commands_in_flight": ((0.1, 0.1), (0.2, 0.3)), "longer_dead_time": 0.1},
        {"commands_in_flight": ((1.0, 0.3), (0.0, 0.0)), "wheel": 1.0},
    ):
        pair = delayed(0.3)
        assert pair.set_state(make(law.state_name, **{"wheel": 0.05, **fields}))
        pair.get("state")
        pair.call("step", 1.0, 0.5, 0.1, 5.0, 0.05)
        pair.get("state")
