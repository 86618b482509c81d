"""Whole lives of a controller.

Steps, resets, hand-overs, jumps, other paths, other vehicles, states saved, pickled, restored and
made up, and bad input at any point, with any vehicle, adapting or not, in an order that hypothesis
chooses; whatever comes, its answers are sound, and its state is one that it takes back.
"""

from __future__ import annotations

import math
import pickle
from dataclasses import replace
from typing import Any, ClassVar

import pytest
from hypothesis import Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)

import popsteer
from popsteer import InputError
from tests.helpers import long_drives, placed
from tests.parity.checks import BAD_STEPS, HELD_DTS, NAN, adapting
from tests.parity.compare import bits
from tests.parity.laws import LATERAL, Law
from tests.parity.strategies import (
    ADAPTS,
    CALM_SPOTS,
    CALM_VEHICLES,
    SPOTS,
    VEHICLES,
    Shape,
    Spot,
    Waypoints,
    fitted,
    shapes,
)

# What a plain loop of the reference visits in one step at most.
MOST_GRID_POINTS = 150
SHAPES = shapes(most=20)
CARS = st.none() | CALM_VEHICLES | VEHICLES
# Bad poses, and where among x, y and yaw.
BAD_POSES = [(place, value) for place, value in BAD_STEPS if place < 3]
BAD_HOLDS = [*BAD_STEPS, *((4, dt) for dt in HELD_DTS)]
# What the controllers remember, by its place, besides their places on the path.
MADE_UP = (
    *("steer", "handover.offset", "handover.remaining", "in_flight.wheel", "estimator.change"),
    *(f"estimator.estimate.{name}" for name in ("gain", "steer_offset", "longer_dead_time")),
    *(f"estimator.estimate.{name}" for name in ("slip", "slip_length", "acceleration")),
    *("law.previous_steer", "law.previous_error", "law.previous_alpha"),
)


def _edited(state: Any, place: str, value: float) -> Any:
    """The state with another value at a place, where it has that place."""
    name, _, rest = place.partition(".")
    inner = getattr(state, name, None)
    if not rest:
        return state.replace(**{name: value}) if name in state.as_dict() else state
    return state if inner is None else state.replace(**{name: _edited(inner, rest, value)})


class Life(RuleBasedStateMachine):
    """One controller; `law` is set by the class that is run."""

    law: ClassVar[Law]

    def __init__(self) -> None:
        super().__init__()
        self.saved: Any = None
        self.there = (0.0, 0.0, 0.0, 5.0)
        self.angle = 0.0

    @initialize(shape=SHAPES, vehicle=CARS, adapt=ADAPTS, data=st.data())
    def construct(
        self, shape: Shape, vehicle: dict[str, Any] | None, adapt: Any, data: st.DataObject
    ) -> None:
        self.vehicle = vehicle
        self.adapt = adapt
        self._put_on(shape.build(), data.draw(self.law.params(), label="params"))

    def _put_on(self, path: Waypoints, params: dict[str, Any]) -> None:
        self.path = path
        self.params = params
        if self.law.searches:
            wheelbase = (self.vehicle or {}).get("wheelbase", 3.0)
            params = fitted(params, path, MOST_GRID_POINTS, wheelbase)
        made = popsteer.Path(path.xy, speed=path.speed, closed=path.closed, mend=False)
        car = None if self.vehicle is None else popsteer.Vehicle(**self.vehicle)
        tuning = getattr(popsteer, self.law.params_name)(**params)
        self.made = getattr(popsteer, self.law.name)(made, car, tuning, **adapting(self.adapt))
        self.max_steer = self.made.vehicle.max_steer

    def _made_anew(self) -> Any:
        parts = (self.made.path, self.made.vehicle, self.made.params)
        return type(self.made)(*parts, adapt=self.made.adapt)

    def _call(self, method: str, *inputs: Any, **options: Any) -> Any:
        """What a method answers; None where the input is refused, and the state is as before."""
        before = self.made.state
        try:
            return self._ask(method, *inputs, **options)
        except InputError:
            assert self._bits() == bits(before.as_dict())
            return None

    def _ask(self, method: str, *inputs: Any, **options: Any) -> Any:
        return getattr(self.made, method)(*inputs, **options)

    def _bits(self) -> Any:
        return bits(self.made.state.as_dict())

    def _take(self, state: Any) -> bool:
        """Restore a state; False where it is refused, and the controller's is as before."""
        before = self.made.state
        try:
            self.made.state = state
        except InputError:
            assert self._bits() == bits(before.as_dict())
            return False
        return True

    def _is_on_path(self, state: Any) -> bool:
        """Whether the path has the place that a state remembers."""
        return state.place is None or state.place.segment < len(self.path.xy)

    def _check_command(self, given: Any) -> None:
        assert given is not None
        assert abs(given.steer) <= self.max_steer
        assert math.isfinite(given.cross_track_error)
        assert math.isfinite(given.predicted_cross_track_error)
        assert abs(given.heading_error) <= math.pi
        assert abs(given.predicted_heading_error) <= math.pi
        assert all(map(math.isfinite, given.target))
        self.angle = given.steer

    @rule(spot=SPOTS)
    def step(self, spot: Spot) -> None:
        inputs = spot.at(self.path)
        self.there = inputs[:4]
        self._check_command(self._call("step", *inputs))

    @rule(spot=SPOTS)
    def steer_as_step(self, spot: Spot) -> None:
        inputs = spot.at(self.path)
        self.there = inputs[:4]
        before = self.made.state
        angle = self._call("steer", *inputs)
        after = self._bits()
        assert self._take(before)
        self._check_command(self._call("step", *inputs))
        assert bits(angle) == bits(self.angle)
        assert self._bits() == after

    @rule(steps=st.integers(1, 5), acceleration=st.floats(-8.0, 8.0))
    def drive_on(self, steps: int, acceleration: float) -> None:
        wheelbase = self.made.vehicle.wheelbase
        for _ in range(steps):
            x, y, yaw, speed = popsteer.paper.kinematic_bicycle(
                *self.there, self.angle, acceleration, wheelbase, 0.05
            )
            bounds = ((x, 1e9), (y, 1e9), (yaw, 1e6), (speed, 1e4))
            if any(abs(value) > bound for value, bound in bounds):
                break
            self.there = (x, y, yaw, speed)
            self._check_command(self._call("step", *self.there, 0.05))
            estimate = self.made.estimate.as_dict().values()
            assert all(map(math.isfinite, estimate))

    @rule(
        spot=CALM_SPOTS, bad=st.sampled_from(BAD_STEPS), method=st.sampled_from(["step", "steer"])
    )
    def refuse_bad_step(self, spot: Spot, bad: tuple[int, float], method: str) -> None:
        place, value = bad
        inputs = list(spot.at(self.path))
        inputs[place] = value
        assert self._call(method, *inputs) is None

    @rule(spot=SPOTS, dt=st.sampled_from(HELD_DTS), method=st.sampled_from(["step", "steer"]))
    def step_in_no_time(self, spot: Spot, dt: float, method: str) -> None:
        before = self.made.state
        answer = self._call(method, *spot.at(self.path)[:4], dt)
        if method == "step":
            self._check_command(answer)
            lost = before.held + 1 > 10
            wanted = popsteer.Status.INPUT_LOST if lost else popsteer.Status.INPUT_HELD
            assert answer.status == wanted
            answer = answer.steer
        assert bits(answer) == bits(before.steer)
        assert self._bits() == bits(before.replace(held=before.held + 1).as_dict())

    @rule(spot=SPOTS, bad=st.none() | st.sampled_from(BAD_HOLDS), limit=st.integers(-1, 2))
    def step_or_hold(self, spot: Spot, bad: tuple[int, float] | None, limit: int) -> None:
        inputs = list(spot.at(self.path))
        if bad is not None:
            inputs[bad[0]] = bad[1]
        held, angle = self.made.state.held, self.made.state.steer
        command = self._call("step_or_hold", *inputs, limit)
        self._check_command(command)
        if bad is None:
            self.there = spot.at(self.path)[:4]
            assert self.made.state.held == 0
        else:
            assert bits(command.steer) == bits(angle)
            lost = held + 1 > max(0, limit)
            wanted = popsteer.Status.INPUT_LOST if lost else popsteer.Status.INPUT_HELD
            assert command.status == wanted

    @rule(angle=st.floats(-2.0, 2.0) | st.sampled_from([NAN, 1e308, -0.0]))
    def take_over(self, angle: float) -> None:
        before = self._bits()
        self._call("reset", steer=angle)
        if abs(angle) <= self.max_steer:
            assert bits(self.made.state.steer) == bits(angle)
        else:
            assert self._bits() == before

    @rule(shape=SHAPES, turns=st.lists(st.booleans(), min_size=40, max_size=40))
    def set_path(self, shape: Shape, turns: list[bool]) -> None:
        """Go on along another path, driven backwards in places, from the present angle."""
        self.path = shape.build()
        reverse = turns[: len(self.path.xy)] if len(self.path.xy) <= len(turns) else None
        path = popsteer.Path(
            self.path.xy, speed=None, closed=self.path.closed, reverse=reverse, mend=False
        )
        angle = self.made.state.steer
        self._call("set_path", path)
        assert self._is_on_path(self.made.state)
        assert bits(self.made.state.steer) == bits(angle)

    @rule(first=st.integers(0, 5))
    def cut_path(self, first: int) -> None:
        """Go on along the rest of the path, or all of it, which changes nothing."""
        here = self.made.path
        xy = [(float(x), float(y)) for x, y in zip(here.x, here.y, strict=True)]
        if first and (here.closed or len(xy) - first < 2):
            return
        flags = None if here.reverse is None else [bool(flag) for flag in here.reverse[first:]]
        before = self.made.state
        self.path = replace(self.path, xy=xy[first:], speed=None)
        path = popsteer.Path(
            self.path.xy, speed=None, closed=here.closed, reverse=flags, mend=False
        )
        self._call("set_path", path)
        after = self.made.state
        assert self._is_on_path(after)
        if not first:
            assert self._bits() == bits(before.as_dict())
        # Of a hand-over that has begun less than all of its time remains.
        now, then = (each.handover.remaining if each.handover else 0.0 for each in (after, before))
        assert now in (0.0, 1.0, then, min(then, 1.0 - 1e-6))

    @rule()
    def reset(self) -> None:
        self._call("reset")
        assert self._bits() == bits(self._made_anew().state.as_dict())

    @rule(spot=SPOTS)
    def relocalise(self, spot: Spot) -> None:
        x, y, yaw, _, _ = spot.at(self.path)
        self._call("relocalise", x, y, yaw)
        assert 0 <= self.made.state.place.segment < len(self.path.xy)

    @rule(spot=CALM_SPOTS, bad=st.sampled_from(BAD_POSES))
    def refuse_bad_relocalise(self, spot: Spot, bad: tuple[int, float]) -> None:
        pose = list(spot.at(self.path)[:3])
        pose[bad[0]] = bad[1]
        assert self._call("relocalise", *pose) is None

    @rule()
    def save(self) -> None:
        self.saved = self.made.state

    @precondition(lambda self: self.saved is not None)
    @rule()
    def restore(self) -> None:
        taken = self._take(self.saved)
        # The one thing in which another path can make it wrong.
        assert taken == self._is_on_path(self.saved)
        if taken:
            assert self._bits() == bits(self.saved.as_dict())

    @rule()
    def pickle_all(self) -> None:
        """Go on with a controller made of what was pickled of the last."""
        before, kind = self._bits(), type(self.made)
        state, path, vehicle, params, adapt = (
            pickle.loads(pickle.dumps(getattr(self.made, part)))
            for part in ("state", "path", "vehicle", "params", "adapt")
        )
        self.made = kind(path, vehicle, params, adapt=adapt)
        assert self._take(state)
        assert self._bits() == before

    @rule(shape=SHAPES)
    def swap_path(self, shape: Shape) -> None:
        """Go on along another path, from the old state where that has its waypoint."""
        state = self.made.state
        self._put_on(shape.build(), self.params)
        assert self._take(state) == self._is_on_path(state)

    @rule(vehicle=CARS, adapt=ADAPTS)
    def swap_vehicle(self, vehicle: dict[str, Any] | None, adapt: Any) -> None:
        """Go on with another vehicle, from the old state where that could be one of it."""
        state = self.made.state
        self.vehicle, self.adapt = vehicle, adapt
        self._put_on(self.path, self.params)
        if self._take(state):
            assert self.made.state.place == state.place
        # Whether it is one of this vehicle too is another question.
        self.saved = None

    @rule(
        place=st.builds(placed, st.integers(0, 30), st.booleans()),
        value=st.floats(-2.0, 2.0) | st.sampled_from([NAN, 1e308]),
        part=st.none() | st.sampled_from(MADE_UP),
    )
    def restore_made_up(self, place: popsteer.State, value: float, part: str | None) -> None:
        state = self._made_anew().state.replace(place=place)
        if part is not None:
            state = _edited(state, part, value)
        if not self._take(state):
            assert not self._is_on_path(state) or part is not None

    @invariant()
    def state_is_accepted(self) -> None:
        """Whatever happened, the state is one that the controller takes back."""
        if hasattr(self, "made"):
            before = self._bits()
            assert self._take(self.made.state)
            assert self._bits() == before


@pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)
def test_life_of_a_controller_in_any_order_stays_sound(law: Law) -> None:
    machine = type(f"{law.name}Life", (Life,), {"law": law})
    run_state_machine_as_test(machine, settings=settings(long_drives(), stateful_step_count=50))


def test_life_with_a_state_changed_by_a_refused_step_is_found() -> None:
    """The machine sees the fault that it is there for."""

    class FaultyLife(Life):
        law = LATERAL[0]

        def _ask(self, method: str, *inputs: Any, **options: Any) -> Any:
            try:
                return super()._ask(method, *inputs, **options)
            except InputError:
                self.made.reset()
                raise

    # Finding it is enough; making it small is not this test's work.
    effort = settings(max_examples=100, phases=[Phase.generate])
    with pytest.raises(AssertionError):
        run_state_machine_as_test(FaultyLife, settings=effort)
