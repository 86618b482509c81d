"""The judge of plans in 100 digits agrees with the reference."""

from __future__ import annotations

import itertools
from typing import Any

from popsteer.reference.laws.preview_pop import limited
from popsteer.reference.laws.preview_pop.horizon import MoveLimit
from tests.parity import plans
from tests.parity.checks import controller
from tests.parity.exact_plans import Planned, best, is_best
from tests.parity.laws import PREVIEW_POP
from tests.parity.strategies import Shape, Spot

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
