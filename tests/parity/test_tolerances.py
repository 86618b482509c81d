"""The table of tolerances lets nothing through: faults planted in the reference are seen."""

from __future__ import annotations

import itertools
import math
import random
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import Status
from popsteer.reference.laws import preview_pop
from popsteer.reference.laws.preview_pop import limited
from popsteer.reference.laws.preview_pop.horizon import MoveLimit
from popsteer.reference.vehicle import bicycle, delay
from tests.parity import plans
from tests.parity.checks import Rollout, check_rollout, controller
from tests.parity.compare import Apart, Pair
from tests.parity.exact_plans import Planned, best, is_best
from tests.parity.laws import POP, PREVIEW_POP, STANLEY, Law
from tests.parity.strategies import Shape, Spot, Waypoints
from tests.parity.tolerances import TABLE, agree, tolerance

if TYPE_CHECKING:
    from collections.abc import Callable

CAR: dict[str, Any] = {
    "dead_time": 0.2,
    "steer_lag": 0.2,
    "max_steer_rate": 0.8,
    "max_lateral_acceleration": 3.0,
    "understeer": 0.001,
}
DRIVE = Rollout(Shape("smooth", 100, seed=3), Spot(0.0, 1.5), steps=200, seed=1)


@pytest.mark.parametrize(
    ("ours", "theirs"),
    [
        (1.0, 1.0 + 2e-9),
        (0.0, 2e-9),
        (1e6, 1e6 + 2e-3),
        (math.nan, 1.0),
        (1.0, math.inf),
        (-math.inf, math.inf),
        (1, 2),
        (1, 1.0),
        (0.0, None),
        (True, False),
        (Status.OK, Status.SATURATED),
        ((1.0, 2.0), (1.0,)),
        ({"a": (1.0, "x")}, {"a": (1.0, "y")}),
        ({"a": 1.0}, {"b": 1.0}),
    ],
    ids=str,
)
def test_agree_names_what_differs(ours: Any, theirs: Any) -> None:
    assert agree(ours, theirs, 1e-9)
    assert agree(theirs, ours, 1e-9)
    assert not agree(ours, ours, 1e-9)


def test_table_ends_with_bits_for_all_else() -> None:
    assert [line.within for line in TABLE] == [1e-9, 0.0]
    path = popsteer.Path([(0.0, 0.0), (9.0, 0.0)])
    assert tolerance(path) == tolerance(popsteer.Pop(path)) == 0.0
    assert tolerance(popsteer.PreviewPop(path, adapt=None)) == 1e-9


def test_zeros_of_other_signs_differ_where_bits_are_compared() -> None:
    with pytest.raises(Apart):
        Pair("x", complex(0.0, 0.0), complex(-0.0, 0.0)).get("real")


def _of(name: str, change: Callable[..., Any]) -> tuple[Any, str, Callable[..., Any]]:
    """A function of the reference's controller whose answer is changed."""
    plain = getattr(preview_pop, name)
    return preview_pop, name, lambda *args: change(plain(*args), *args)


def _with(array: Any, place: Any, change: Callable[[Any], Any]) -> Any:
    changed = np.array(array)
    changed[place] = change(changed[place])
    return changed


def _negative_gains(best: Any, *_: Any) -> Any:
    return best._replace(gains=best.gains * [1.0, 1.0, -1.0, 1.0, 1.0])


PLANTED: dict[str, tuple[Law, Any]] = {
    "turn of the path of the other sign": (
        PREVIEW_POP,
        _of("transition", lambda a, *_: _with(a, (1, 4), lambda turn: -turn)),
    ),
    "lag in the wrong place": (
        PREVIEW_POP,
        _of("transition", lambda a, *_: _with(a, (2, [2, 3]), lambda pair: pair[::-1])),
    ),
    "model off by 1e-6": (
        PREVIEW_POP,
        _of("transition", lambda a, *_: _with(a, (0, 3), lambda x: x * (1.0 + 1e-6))),
    ),
    "stage cost off by 1e-6": (
        PREVIEW_POP,
        _of("stage", lambda q, *_: _with(q, (1, 1), lambda x: x * (1.0 + 1e-6))),
    ),
    "feedback of a wrong sign within the limits": (PREVIEW_POP, _of("regulator", _negative_gains)),
    "limit of the moves off by 1e-6": (
        PREVIEW_POP,
        (
            preview_pop,
            "plan_within",
            lambda horizon, start, limits: limited.plan_within(
                horizon, start, limits._replace(later=limits.later * (1.0 + 1e-6))
            ),
        ),
    ),
    "no limit ever released": (
        PREVIEW_POP,
        (limited, "least_norm", lambda rows, room, _: _never_released(rows, room)),
    ),
    "longer steps of a prediction": (STANLEY, (bicycle, "STEP", 0.06)),
    "commands in flight joined too early": (POP, (delay, "RESOLUTION", 2)),
}


def _never_released(rows: Any, room: Any) -> tuple[Any, list[int]]:
    """Hold each exceeded limit for ever."""
    held: list[int] = []
    x = np.zeros(rows.shape[1])
    while np.max(excess := rows @ x - room) > 1e-9 and len(held) < rows.shape[1]:
        held.append(int(np.argmax(excess)))
        x = np.linalg.lstsq(rows[held], room[held])[0]
    return x, held


@pytest.mark.parametrize("fault", PLANTED)
def test_fault_planted_in_the_reference_is_seen(
    fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    law, planted = PLANTED[fault]
    monkeypatch.setattr(*planted)
    with pytest.raises(AssertionError, match="Rust first, then reference"):
        check_rollout(law, DRIVE, {}, vehicle=CAR)


def test_drive_without_a_fault_agrees() -> None:
    for law in (PREVIEW_POP, STANLEY, POP):
        check_rollout(law, DRIVE, {}, vehicle=CAR)


def test_limits_that_hold_another_plan_differ() -> None:
    path = Waypoints([(float(k), 0.0) for k in range(60)], None, closed=False)
    pair = controller(PREVIEW_POP, path, {}, vehicle={"max_steer_rate": 0.2})
    pair.step(5.0, 1.0, 0.0, 10.0, 0.05)
    state = pair.state()
    law = state.rust.law
    assert law.reached_limits != 0
    rng = random.Random(1)
    for _ in range(20):
        code = sum(rng.choice(list(MoveLimit)) << 3 * k for k in range(19))
        pair.twin.state.law.reached_limits = code
        pair.rust.state = state.rust.replace(law=law.replace(reached_limits=code ^ 1))
        with pytest.raises(Apart, match="reached_limits"):
            pair.get("state")


SHAPE = Shape("smooth", 60, seed=3)


def _planned(spot: Spot, **params: Any) -> Planned:
    """What the reference plans at the second of two steps."""
    path = SHAPE.build()
    car = {"max_steer_rate": 0.5, "steer_lag": 0.2}
    pair = controller(PREVIEW_POP, path, params, vehicle=car)
    for _ in range(2):
        pair.twin.step(*spot.at(path))
    return plans.last()


def test_best_plan_is_the_references() -> None:
    asides = ((0.02, 0.0), (0.6, 0.1), (-2.5, -0.4), (30.0, 2.0))
    speeds = ((0.5, 3.0), (6.0, 0.0), (25.0, 3.0), (1e4, 0.0))
    for (aside, turned), (speed, heading_cost) in itertools.product(asides, speeds):
        planned = _planned(Spot(0.3, aside, turned, speed), heading_cost=heading_cost)
        exact, plan = best(planned), limited.plan_within(*planned[:3])
        assert abs(exact.curvature - plan.curvature) < 1e-12
        assert exact.reached == list(plan.reached)
        code = sum(limit << 3 * k for k, limit in enumerate(plan.reached))
        assert is_best(planned, code, 1e-9)
        for k, limit in enumerate(plan.reached[:3]):
            other = MoveLimit((limit + 2) % len(MoveLimit))
            assert not is_best(planned, code ^ (limit ^ other) << 3 * k, 1e-9)
