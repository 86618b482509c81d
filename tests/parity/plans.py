"""Plans of preview POP where both sides may decide otherwise, and how that is checked.

The Rust core searches for a plan within the limits by passes, the reference solves the quadratic
program by the textbook. Both find its one solution, but for two cases. In two more they are given
different problems: where a path that overlaps has two places equally near (`equally_near`), and
where it turns straight back, to the left or to the right (`turns_round`).

- A limit that the plan touches without being held back by it may count as reached or not.
- After 40 passes the Rust core takes the best plan so far, and says PLAN_CUT_SHORT.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

from popsteer import Status, reference
from popsteer.reference.laws import preview_pop
from popsteer.reference.laws.law import Belief
from popsteer.reference.laws.preview_pop import cost_to_go, limited
from popsteer.reference.laws.preview_pop.horizon import MoveLimit
from popsteer.reference.vehicle.delay import InFlight
from popsteer.reference.vehicle.state import VehicleState
from tests.parity import exact_plans
from tests.parity.exact_plans import Planned
from tests.parity.tolerances import agree

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tests.parity.laws import Law

LIMITS = Status.SATURATED | Status.STEER_LIMIT | Status.RATE_LIMIT | Status.LATERAL_LIMIT
"""What limits a command: rounding decides at a limit."""
PLANS = 1e-9
"""How near to the best a plan is that counts as the best, and an angle to its limit."""
_LAST: list[Planned] = []
_COSTS: list[tuple[Any, float]] = []
CUT_SHORT: list[Any] = []
"""Steps since the test began in which the Rust core's plan was cut short."""
TIED: set[tuple[int, int]] = set()
"""Limits that were reached by one side alone, since the test began."""


class Step(NamedTuple):
    """A step that was taken."""

    before: Any
    """The Rust core's state before it."""
    twin_before: Any
    """The reference's."""
    method: str
    inputs: tuple[Any, ...]


def forget() -> None:
    """What is remembered is of one test."""
    for remembered in (_LAST, _COSTS, CUT_SHORT, TIED):
        remembered.clear()


def last() -> Planned:
    """The reference's last plan."""
    return _LAST[0]


def _regulator(models: Any, stage: Any, move_cost: float) -> Any:
    _COSTS[:] = [(stage, move_cost)]
    return cost_to_go.regulator(models, stage, move_cost)


def _limited(horizon: Any, start: Any, limits: Any) -> Any:
    _LAST[:] = [Planned(horizon, start, limits, *costs) for costs in _COSTS]
    return limited.plan_within(horizon, start, limits)


vars(preview_pop).update(regulator=_regulator, plan_within=_limited)


def tied(field: str, ours: Any, theirs: Any) -> bool:
    """Whether two values of a field that is decided by limits stand for the same last plan."""
    if field == "reached_limits":
        return _same_plan(ours, theirs)
    return field == "status" and not (ours ^ theirs) & ~LIMITS and _touches()


def _same_plan(ours: int, theirs: int) -> bool:
    """Whether the limits that the last plan reached hold the best plan, on both sides."""
    if not _LAST:
        return False
    if (ours, theirs) not in TIED:
        loose = PLANS + exact_plans.rounding(_LAST[0])
        if not (_holds_best(ours, PLANS) and _holds_best(theirs, loose)):
            return False
        TIED.add((ours, theirs))
    return True


def _holds_best(code: int, within: float) -> bool:
    # A state keeps the limits of the next step on where the period is a step of the horizon.
    codes = [code, *(code << 3 | first for first in MoveLimit)]
    return any(exact_plans.is_best(_LAST[0], each, within) for each in codes)


def _touches() -> bool:
    """Whether the first move may count as at a limit or not, and the plan is the best both ways."""
    if not _LAST:
        return False
    later = exact_plans.best(_LAST[0]).reached[1:]
    code = sum(limit << 3 * k for k, limit in enumerate(later, 1))
    return sum(exact_plans.is_best(_LAST[0], code | first, PLANS) for first in MoveLimit) >= 2


def equally_near(pair: Any, step: Step) -> bool:
    """Whether the last step found places equally near, on two segments, on a path that overlaps.

    The reference then goes on from the state of the Rust core.
    """
    if pair.rust.state.waypoint == pair.twin.state.waypoint:
        return False
    pair.twin.state = step.twin_before
    both = _again(pair, step), pair.twin.step(*step.inputs)
    near, far = sorted(abs(command.predicted_cross_track_error) for command in both)
    if far - near > PLANS * max(1.0, far):
        return False
    pair.follow_rust()
    return True


def turns_round(pair: Any) -> bool:
    """Whether the path turns by π within the last plan, where rounding decides to which side.

    The reference then goes on from the state of the Rust core.
    """
    turns = [abs(model[1, 4]) for planned in _LAST for model in planned.horizon.models]
    if max(turns, default=0.0) < math.pi - PLANS:
        return False
    pair.follow_rust()
    return True


def check_cut_short(pair: Any, step: Step, theirs: Any = None) -> Any:
    """The command of a step whose plan was cut short; None where it was not.

    Its angle keeps the limits; all else agrees with `theirs`, where the reference's command is
    given. The reference goes on from the state of the Rust core.
    """
    rust = pair.rust
    command = _again(pair, step)
    if Status.PLAN_CUT_SHORT not in command.status:
        return None
    assert abs(command.steer) <= rust.vehicle.max_steer
    rate = rust.vehicle.max_steer_rate
    if rate is not None:
        assert abs(command.steer - step.before.steer) <= rate * step.inputs[4] * (1.0 + PLANS)
    if step.method != "steer" and theirs is not None:
        for field in ("cross_track_error", "heading_error", "target", "reverse"):
            apart = agree(getattr(command, field), getattr(theirs, field), PLANS, field)
            assert not apart, apart
    pair.follow_rust()
    CUT_SHORT.append(command)
    return command.steer if step.method == "steer" else command


def _again(pair: Any, step: Step) -> Any:
    """The Rust core's command of a step, by another controller."""
    again = pair.anew().rust
    again.state = step.before
    command = again.step(*step.inputs)
    assert again.state == pair.rust.state
    return command


def decided(
    law: Law, controller: Any, before: Any, after: Any, step: Sequence[float]
) -> tuple[Any, Any]:
    """Return the located vehicle and the decision of a step of `controller` between two states.

    The vehicle is the one predicted through the dead time, the decision the controller's own,
    before the limits of the vehicle.
    """
    path = reference.Path(
        list(zip(controller.path.x.tolist(), controller.path.y.tolist(), strict=True)),
        speed=None if controller.path.speed is None else controller.path.speed.tolist(),
        closed=controller.path.closed,
    )
    car = reference.Vehicle(**controller.vehicle.as_dict())
    params = getattr(reference, law.params_name)(**controller.params.as_dict())
    twin = getattr(reference, law.name)(car, params)
    x, y, yaw, speed, dt = step
    antenna = VehicleState(x, y, yaw, speed)
    vehicle = predicted = antenna.left(-car.antenna_offset(0.0))
    wheel, estimate = before.steer, reference.Estimate()
    if after.in_flight is not None:
        in_flight = InFlight(after.in_flight.commands, after.in_flight.wheel)
        wheel = in_flight.wheel
        # The slip is estimated after the prediction.
        estimate = _estimate(after, slip_of=before)
        if car.dead_time > 0.0:
            then, wheel = in_flight.predict(car, vehicle.ahead(car.no_slip), estimate)
            predicted = then.bounded().ahead(-car.no_slip).bounded()
        estimate = _estimate(after, slip_of=after)
    faster = 0.0 if before.answer is None else abs(before.answer.vehicle.speed)
    travelled = max(abs(speed), faster) * dt
    at = twin.follow.locate(path, before.waypoint, vehicle, dt, travelled)
    if car.dead_time > 0.0:
        at = twin.follow.offset(path, at, predicted, travelled)
    state = twin.STATE()
    # What a buffer holds stands in the law itself here.
    own = before.law.as_dict()
    own.update(own.pop("buffer", {}))
    for name in vars(state):
        value = own[name]
        setattr(state, name, list(value) if isinstance(value, tuple) and name == "terms" else value)
    offset = car.steer_offset + estimate.steer_offset
    twin.set_steer(state, car.at_wheels(before.steer + offset))
    return at, twin.decide(path, state, at, Belief(wheel, estimate))


def _estimate(state: Any, slip_of: Any) -> reference.Estimate:
    found, slipping = state.estimator.estimate, slip_of.estimator.estimate
    return reference.Estimate(
        gain=found.gain,
        steer_offset=found.steer_offset,
        slip=slipping.slip,
        slip_length=slipping.slip_length,
        acceleration=found.acceleration,
    )
