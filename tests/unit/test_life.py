"""Whole lives of a controller, in Rust and in the reference side by side.

Steps, resets, hand-overs, jumps, other paths, other vehicles, states saved, pickled, restored and
made up, and bad input at any point, with any vehicle, adapting or not, in an order that hypothesis
chooses; whatever comes, both answer with the same bits.
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
from tests.helpers import long_drives
from tests.parity.checks import BAD_STEPS, NAN, controller
from tests.parity.compare import Pair, bits, make
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
    shapes,
)

# What a plain loop of the reference visits in one step at most.
MOST_GRID_POINTS = 150
SHAPES = shapes(most=20)
CARS = st.none() | CALM_VEHICLES | VEHICLES
# Bad poses, and where among x, y and yaw.
BAD_POSES = [(place, value) for place, value in BAD_STEPS if place < 3]
# What each law remembers itself, and what all of them do beside their places.
REMEMBERED = {
    "Pop": "previous_steer",
    "PreviewPop": "previous_steer",
    "Pid": "previous_error",
    "PurePursuit": "previous_alpha",
}
MADE_UP = (
    *("measured_waypoint", "steer", "handover_offset", "handover_remaining", "wheel", "gain"),
    *("steer_offset", "longer_dead_time", "slip", "slip_length", "acceleration", "change"),
)


class Life(RuleBasedStateMachine):
    """One controller and its twin; `law` is set by the class that is run."""

    law: ClassVar[Law]

    def __init__(self) -> None:
        super().__init__()
        self.saved: Pair | None = None
        self.before: Any = None
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
        self.pair = controller(self.law, path, params, MOST_GRID_POINTS, self.vehicle, self.adapt)
        self.max_steer = self.pair.rust.vehicle.max_steer

    def _made_anew(self) -> Pair:
        path, vehicle, params = (self.pair.get(part) for part in ("path", "vehicle", "params"))
        return make(self.law.name, path, vehicle, params, adapt=self.pair.get("adapt"))

    def _is_on_path(self, state: Pair) -> bool:
        """Whether the path has the places that a state remembers."""
        places = (state.rust.waypoint, state.rust.measured_waypoint)
        return all(place is None or place < len(self.path.xy) for place in places)

    def _check_command(self, command: Pair | None) -> None:
        assert command is not None
        given = command.rust
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
        self._check_command(self.pair.call("step", *inputs))

    @rule(spot=SPOTS)
    def steer_as_step(self, spot: Spot) -> None:
        inputs = spot.at(self.path)
        self.there = inputs[:4]
        before = self.pair.get("state")
        angle = self.pair.call("steer", *inputs)
        after = self.pair.get("state")
        assert angle is not None
        assert self.pair.set_state(before)
        command = self.pair.call("step", *inputs)
        self._check_command(command)
        assert bits(angle.rust) == bits(self.angle)
        assert bits(self.pair.get("state").rust) == bits(after.rust)

    @rule(steps=st.integers(1, 5), acceleration=st.floats(-8.0, 8.0))
    def drive_on(self, steps: int, acceleration: float) -> None:
        wheelbase = self.pair.rust.vehicle.wheelbase
        for _ in range(steps):
            x, y, yaw, speed = popsteer.paper.kinematic_bicycle(
                *self.there, self.angle, acceleration, wheelbase, 0.05
            )
            bounds = ((x, 1e9), (y, 1e9), (yaw, 1e6), (speed, 1e4))
            if any(abs(value) > bound for value, bound in bounds):
                break
            self.there = (x, y, yaw, speed)
            self._check_command(self.pair.call("step", *self.there, 0.05))
            self.pair.get("estimate")

    @rule(
        spot=CALM_SPOTS, bad=st.sampled_from(BAD_STEPS), method=st.sampled_from(["step", "steer"])
    )
    def refuse_bad_step(self, spot: Spot, bad: tuple[int, float], method: str) -> None:
        place, value = bad
        inputs = list(spot.at(self.path))
        inputs[place] = value
        before = bits(self.pair.get("state").rust)
        assert self.pair.call(method, *inputs) is None
        assert bits(self.pair.get("state").rust) == before

    @rule(spot=SPOTS, bad=st.none() | st.sampled_from(BAD_STEPS), limit=st.integers(-1, 2))
    def step_or_hold(self, spot: Spot, bad: tuple[int, float] | None, limit: int) -> None:
        inputs = list(spot.at(self.path))
        if bad is not None:
            inputs[bad[0]] = bad[1]
        held, angle = self.pair.rust.state.held, self.pair.rust.state.steer
        command = self.pair.call("step_or_hold", *inputs, limit)
        self._check_command(command)
        assert command is not None
        if bad is None:
            self.there = spot.at(self.path)[:4]
            assert self.pair.rust.state.held == 0
        else:
            assert bits(command.rust.steer) == bits(angle)
            lost = held + 1 > max(0, limit)
            wanted = popsteer.Status.INPUT_LOST if lost else popsteer.Status.INPUT_HELD
            assert command.rust.status == wanted

    @rule(angle=st.floats(-2.0, 2.0) | st.sampled_from([NAN, 1e308, -0.0]))
    def take_over(self, angle: float) -> None:
        before = bits(self.pair.get("state").rust)
        self.pair.call("reset", steer=angle)
        after = self.pair.get("state").rust
        if abs(angle) <= self.max_steer:
            assert bits(after.steer) == bits(angle)
        else:
            assert bits(after) == before

    @rule(shape=SHAPES, turns=st.lists(st.booleans(), min_size=40, max_size=40))
    def set_path(self, shape: Shape, turns: list[bool]) -> None:
        """Go on along another path, driven backwards in places, from the present angle."""
        self.path = shape.build()
        reverse = turns[: len(self.path.xy)] if len(self.path.xy) <= len(turns) else None
        path = make("Path", self.path.xy, speed=None, closed=self.path.closed, reverse=reverse)
        angle = self.pair.rust.state.steer
        self.pair.call("set_path", path)
        state = self.pair.get("state").rust
        assert self._is_on_path(self.pair.get("state"))
        assert bits(state.steer) == bits(angle)

    @rule(first=st.integers(0, 5))
    def cut_path(self, first: int) -> None:
        """Go on along the rest of the path, or all of it, which changes nothing."""
        here = self.pair.rust.path
        xy = [(float(x), float(y)) for x, y in zip(here.x, here.y, strict=True)]
        if first and (here.closed or len(xy) - first < 2):
            return
        flags = None if here.reverse is None else [bool(flag) for flag in here.reverse[first:]]
        before = self.pair.rust.state
        self.path = replace(self.path, xy=xy[first:], speed=None)
        path = make("Path", self.path.xy, speed=None, closed=here.closed, reverse=flags)
        self.pair.call("set_path", path)
        after = self.pair.get("state")
        assert self._is_on_path(after)
        if not first:
            assert bits(after.rust) == bits(before)
        # Of a hand-over that has begun less than all of its time remains.
        remaining = min(before.handover_remaining, 1.0 - 1e-6)
        assert after.rust.handover_remaining in (0.0, 1.0, before.handover_remaining, remaining)

    @rule()
    def reset(self) -> None:
        self.pair.call("reset")
        first = self._made_anew().get("state")
        assert bits(self.pair.get("state").rust) == bits(first.rust)

    @rule(spot=SPOTS)
    def relocalise(self, spot: Spot) -> None:
        x, y, yaw, _, _ = spot.at(self.path)
        self.pair.call("relocalise", x, y, yaw)
        assert 0 <= self.pair.get("state").rust.waypoint < len(self.path.xy)

    @rule(spot=CALM_SPOTS, bad=st.sampled_from(BAD_POSES))
    def refuse_bad_relocalise(self, spot: Spot, bad: tuple[int, float]) -> None:
        pose = list(spot.at(self.path)[:3])
        pose[bad[0]] = bad[1]
        before = bits(self.pair.get("state").rust)
        assert self.pair.call("relocalise", *pose) is None
        assert bits(self.pair.get("state").rust) == before

    @rule()
    def save(self) -> None:
        self.saved = self.pair.get("state")

    @precondition(lambda self: self.saved is not None)
    @rule()
    def restore(self) -> None:
        assert self.saved is not None
        taken = self.pair.set_state(self.saved)
        # The one thing in which another path can make it wrong.
        assert taken == self._is_on_path(self.saved)
        if taken:
            assert bits(self.pair.get("state").rust) == bits(self.saved.rust)

    @rule()
    def pickle_all(self) -> None:
        """Go on with a controller made of what was pickled of the last."""
        state, path, vehicle, params, adapt = (
            Pair(part, *(pickle.loads(pickle.dumps(side)) for side in (shown.rust, shown.twin)))
            for part in ("state", "path", "vehicle", "params", "adapt")
            for shown in (self.pair.get(part),)
        )
        assert bits(state.rust) == bits(self.pair.rust.state)
        self.pair = make(self.law.name, path, vehicle, params, adapt=adapt)
        assert self.pair.set_state(state)

    @rule(shape=SHAPES)
    def swap_path(self, shape: Shape) -> None:
        """Go on along another path, from the old state where that has its waypoint."""
        state = self.pair.get("state")
        self._put_on(shape.build(), self.params)
        assert self.pair.set_state(state) == self._is_on_path(state)

    @rule(vehicle=CARS, adapt=ADAPTS)
    def swap_vehicle(self, vehicle: dict[str, Any] | None, adapt: Any) -> None:
        """Go on with another vehicle, from the old state where that could be one of it."""
        state = self.pair.get("state")
        self.vehicle, self.adapt = vehicle, adapt
        self._put_on(self.path, self.params)
        before = bits(self.pair.get("state").rust)
        if self.pair.set_state(state):
            assert bits(self.pair.get("state").rust.waypoint) == bits(state.rust.waypoint)
        else:
            assert bits(self.pair.get("state").rust) == before
        # Whether it is one of this vehicle too is another question.
        self.saved = None

    @rule(
        waypoint=st.integers(0, 30),
        value=st.floats(-2.0, 2.0) | st.sampled_from([NAN, 1e308]),
        part=st.none() | st.sampled_from(MADE_UP),
    )
    def restore_made_up(self, waypoint: int, value: float, part: str | None) -> None:
        field = REMEMBERED.get(self.law.name)
        fields: dict[str, Any] = {"waypoint": waypoint}
        if part == "measured_waypoint":
            fields[part] = 30 - waypoint
        elif part is not None:
            fields[part] = value
        elif field is not None:
            fields[field] = value
        before = bits(self.pair.get("state").rust)
        state = make(self.law.state_name, **fields)
        if not self.pair.set_state(state):
            assert not self._is_on_path(state) or value in fields.values()
            assert bits(self.pair.get("state").rust) == before

    @invariant()
    def state_is_shown_alike_and_accepted(self) -> None:
        """Whatever happened, the state is one that the controller takes back."""
        if hasattr(self, "pair"):
            assert self.pair.set_state(self.pair.get("state"))


@pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)
def test_life_of_a_controller_in_any_order_matches_reference_and_stays_sound(law: Law) -> None:
    machine = type(f"{law.name}Life", (Life,), {"law": law})
    run_state_machine_as_test(machine, settings=settings(long_drives(), stateful_step_count=50))


def test_life_with_a_state_changed_by_a_refused_step_is_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The machine sees the fault that it is there for."""
    law = LATERAL[0]
    machine = type("FaultyLife", (Life,), {"law": law})
    step = popsteer.reference.Pop.step

    def faulty(self: Any, *inputs: float) -> Any:
        try:
            return step(self, *inputs)
        except InputError:
            self.reset()
            raise

    monkeypatch.setattr(popsteer.reference.Pop, "step", faulty)
    # Finding it is enough; making it small is not this test's work.
    effort = settings(max_examples=100, phases=[Phase.generate])
    with pytest.raises(AssertionError):
        run_state_machine_as_test(machine, settings=effort)
