"""The Rust core and its reference side by side: the same call to both, and what both answer.

Compared bit for bit, but for what `tolerances` lists.
"""

from __future__ import annotations

import copy
import dataclasses
import functools
import math
import struct
from typing import TYPE_CHECKING, Any

import numpy as np

import popsteer
from popsteer import PopsteerError, reference
from popsteer.reference.path.view import PathView
from popsteer.reference.vehicle.delay import InFlight
from tests.parity import plans
from tests.parity.tolerances import LOST, Refused, agree, amplified, tolerance

if TYPE_CHECKING:
    from collections.abc import Callable

_PATH = ("x", "y", "s", "speed", "length", "closed", "reverse")


class Apart(AssertionError):  # noqa: N818 - what it says of the two sides
    """Both sides answer, but not the same."""

    def __init__(self, text: str, ours: Any, theirs: Any) -> None:
        super().__init__(text)
        self.ours, self.theirs = ours, theirs


def shown(value: Any, like: Any) -> Any:
    """What the reference's value `like` shows, in numbers and texts, as `value` has it."""
    if isinstance(like, reference.TrackerState):
        return _plain(_remembered(value, like))
    if isinstance(like, PathView):
        return {name: _plain(getattr(value, name)) for name in _PATH}
    if dataclasses.is_dataclass(like):
        names = [field.name for field in dataclasses.fields(like)]
        return {name: _plain(getattr(value, name)) for name in names}
    if isinstance(like, (reference.CoupledLongitudinal, reference.SpeedPid)):
        return {"params": shown(value.params, like.params)}
    return _plain(value)


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, dict):
        return {name: _plain(entry) for name, entry in value.items()}
    if isinstance(value, (tuple, list)):
        return tuple(map(_plain, value))
    return value


def _remembered(state: Any, like: reference.TrackerState[Any]) -> dict[str, Any]:
    """What a state has of what the reference's tracker remembers."""
    tracked = ("waypoint", "steer", "held")
    in_flight = state.in_flight
    return {
        **(vars(like.law) if state is like else _own(state, like.law)),
        **{name: getattr(state, name) for name in tracked},
        "wheel": None if in_flight is None else in_flight.wheel,
        "commands": () if in_flight is None else in_flight.commands,
    }


def _own(state: popsteer.State, like: Any) -> dict[str, Any]:
    """What the core's controller remembers itself, by the names that its reference has."""
    law = state.law.as_dict()
    law.update(law.pop("buffer", {}))
    return {name: law[name] for name in vars(like)}


def bits(part: Any) -> Any:
    """The same, so that only equal bits compare equal: -0.0 is not 0.0."""
    if isinstance(part, float):
        return f"{part!r} = {struct.pack('<d', part).hex()}"
    if isinstance(part, tuple):
        return tuple(map(bits, part))
    if isinstance(part, dict):
        return {name: bits(entry) for name, entry in part.items()}
    return repr(part)


def outcome(call: Callable[..., Any], *args: Any, **kwargs: Any) -> tuple[Any, Refused | None]:
    """What a call returns, and how it was refused, where it was."""
    try:
        return call(*args, **kwargs), None
    except PopsteerError as error:
        return None, Refused((type(error), str(error), _plain(vars(error))))
    except Exception as error:  # noqa: BLE001 - whatever one side raises, the other has to
        return None, Refused((type(error), "", {}))


def same(
    name: str,
    rust: Callable[..., Any],
    twin: Callable[..., Any],
    *args: Any,
    within: float = 0.0,
    **kwargs: Any,
) -> Pair | None:
    """Call both with the same arguments, a `Pair` among them split; None where both refuse.

    Floats agree `within` so much, absolute or relative; 0 is bit for bit.
    """
    ours, our_refusal = outcome(
        rust, *map(_rust, args), **{field: _rust(value) for field, value in kwargs.items()}
    )
    theirs, their_refusal = outcome(
        twin, *map(_twin, args), **{field: _twin(value) for field, value in kwargs.items()}
    )
    what = f"{name}{args}{kwargs or ''}: Rust first, then reference"
    pair = None
    if our_refusal is None and their_refusal is None:
        pair = Pair(name, ours, theirs, within)
        within = pair.within
        here, there = shown(ours, theirs), shown(theirs, theirs)
    else:
        here, there = our_refusal or "an answer", their_refusal or "an answer"
    if within > 0.0:
        apart = agree(here, there, within, tied=plans.tied)
    else:
        apart = "" if bits(here) == bits(there) else f"{here}, {there}"
    if apart:
        raise Apart(f"{what}: {apart}", ours, theirs)
    return pair


def call(name: str, *args: Any, **kwargs: Any) -> Pair | None:
    """Make an object of popsteer and of its reference; a path of the waypoints as they stand."""
    ours = getattr(popsteer, name)
    if name == "Path":
        ours = functools.partial(ours, mend=False)
    return same(name, ours, getattr(reference, name), *args, **kwargs)


def make(name: str, *args: Any, **kwargs: Any) -> Pair:
    """Make an object on both sides, which neither may refuse."""
    pair = call(name, *args, **kwargs)
    assert pair is not None, f"{name}{args}{kwargs} was refused"
    return pair


def _rust(value: Any) -> Any:
    return value.rust if isinstance(value, Pair) else value


def _twin(value: Any) -> Any:
    return value.twin if isinstance(value, Pair) else value


class Pair:
    """One thing twice: of the Rust core, and of the reference.

    Numbers that it shows, and those of what its methods return, agree `within` so much.
    """

    def __init__(self, name: str, rust: Any, twin: Any, within: float = 0.0) -> None:
        self.name = name
        self.rust = rust
        self.twin = twin
        self.within = max(within, tolerance(rust))

    def __repr__(self) -> str:
        return repr(self.rust)

    def call(self, method: str, *args: Any, **kwargs: Any) -> Pair | None:
        """Call a method of both."""
        rust, twin = getattr(self.rust, method), getattr(self.twin, method)
        return same(f"{self.name}.{method}", rust, twin, *args, within=self.within, **kwargs)

    def get(self, attribute: str) -> Pair:
        """Read an attribute of both."""
        pair = same(
            f"{self.name}.{attribute}",
            lambda: getattr(self.rust, attribute),
            lambda: copy.deepcopy(getattr(self.twin, attribute)),
            within=self.within,
        )
        assert pair is not None
        return pair


class Controller(Pair):
    """A controller of popsteer, and the reference's tracker of the same.

    The core's neither estimates nor monitors its vehicle; `estimate` is what both believe of it.
    """

    def __init__(
        self, name: str, path: Pair, vehicle: Pair, params: Pair, estimate: dict[str, float]
    ) -> None:
        self.parts = (path, vehicle, params, estimate)
        law = getattr(reference, name)(vehicle.twin, params.twin)
        given = reference.Estimate(**estimate)
        twin = reference.Tracker(law, path.twin, given)
        super().__init__(name, self._made(name), twin)
        # Whether errors have grown so large, since it was reset, that nothing is left to compare.
        self._lost = False
        self._step: plans.Step | None = None
        follow = law.follow
        assert bits(self.rust.tracked_point) == bits(follow.base + follow.reference_offset)

    def _made(self, name: str) -> Any:
        path, vehicle, params, estimate = self.parts
        made = getattr(popsteer, name)(
            path.rust, vehicle.rust, params.rust, adapt=None, monitor=None
        )
        if estimate:
            estimator = made.state.estimator
            known = estimator.estimate.replace(**estimate)
            made.state = made.state.replace(estimator=estimator.replace(estimate=known))
        return made

    def anew(self) -> Controller:
        """The same before its first step."""
        return Controller(self.name, *self.parts)

    def reset(self) -> None:
        """Forget all steps, on both sides."""
        self.rust = self._made(self.name)
        self.twin.reset()
        self._lost = False

    def follow_rust(self) -> None:
        """Let the reference go on from the state of the Rust core."""
        state = self.rust.state
        law = self.twin.law.STATE(**_own(state, self.twin.state.law))
        if hasattr(law, "terms"):
            law.terms = list(law.terms)
        in_flight = state.in_flight
        self._share_acceleration()
        self.twin.state = reference.TrackerState(
            law,
            state.waypoint,
            state.steer,
            0.0 if state.answer is None else state.answer.vehicle.speed,
            None if in_flight is None else InFlight(in_flight.commands, in_flight.wheel),
        )

    def _share_acceleration(self) -> None:
        """Let both believe one acceleration, which a gap makes 0: part of Rust's state alone."""
        if self.rust.state.in_flight is not None:
            acceleration = self.rust.state.estimator.estimate.acceleration
            self.twin.estimate = dataclasses.replace(self.twin.estimate, acceleration=acceleration)

    def step(self, *inputs: Any) -> Pair | None:
        """Take a step; angle, errors, target and status agree."""
        return self._take("step", inputs)

    def steer(self, *inputs: Any) -> Pair | None:
        """Take a step that answers with the angle alone."""
        return self._take("steer", inputs)

    def _take(self, method: str, inputs: tuple[Any, ...]) -> Pair | None:
        if self.within == 0.0:
            return self.call(method, *inputs)
        if len(inputs) > 4:
            weight = amplified(self.rust, *inputs[3:5])
            if self._lost or weight > LOST:
                return self._go_on(method, inputs)
            # What goes on from such a step agrees as the step does.
            self.within = max(self.within, tolerance(self.rust) * weight)
        before = self.twin.state
        before = dataclasses.replace(before, law=copy.copy(before.law))
        self._step = plans.Step(self.rust.state, before, method, inputs)
        try:
            return self.call(method, *inputs)
        except Apart as apart:
            if apart.ours is None or apart.theirs is None:
                raise
            if plans.equally_near(self, self._step) or plans.turns_round(self):
                return Pair(self.name, apart.ours, apart.ours)
            if self._reaches_limit(apart):
                return Pair(self.name, apart.ours, apart.theirs, self.within)
            command = plans.check_cut_short(self, self._step, apart.theirs)
            if command is None:
                raise
            return Pair(self.name, command, command)

    def _reaches_limit(self, apart: Apart) -> bool:
        """Whether only what limits them differs, as the commands just reach a limit."""
        if not isinstance(apart.theirs, reference.Command) or self._step is None:
            return False
        ours, theirs = (shown(side, apart.theirs) for side in (apart.ours, apart.theirs))
        if (
            ours["status"] == theirs["status"]
            or (ours["status"] ^ theirs["status"]) & ~plans.LIMITS
        ):
            return False
        if agree({**ours, "status": 0}, {**theirs, "status": 0}, self.within):
            return False
        car, estimate = self.twin.law.vehicle, self.twin.estimate
        (*_, speed, dt), steer = self._step.inputs, ours["steer"]
        wheel = abs(steer + car.steer_offset + estimate.steer_offset)
        room = [car.max_steer - abs(steer), car.max_steer - wheel]
        if car.max_steer_rate is not None:
            room.append(car.max_steer_rate * dt - abs(steer - self._step.before.steer))
        if car.max_lateral_acceleration is not None and speed != 0.0:
            tightest = speed * speed * estimate.gain / car.max_lateral_acceleration
            room.append(math.atan(car.turning_length(speed) / tightest) - wheel)
        return bool(min(map(abs, room)) <= plans.PLANS)

    def _go_on(self, method: str, inputs: tuple[Any, ...]) -> Pair | None:
        """Take the step on both sides, and go on from the state of the Rust core."""
        ours, our_refusal = outcome(getattr(self.rust, method), *inputs)
        _, their_refusal = outcome(getattr(self.twin, method), *inputs)
        if our_refusal or their_refusal:
            assert not agree(our_refusal, their_refusal, self.within), f"{self.name}{inputs}"
            return None
        self._lost = True
        self.follow_rust()
        return Pair(self.name, ours, ours)

    def state(self) -> Pair:
        """What both remember, which agrees."""
        if self._lost:
            return Pair(f"{self.name}.state", self.rust.state, copy.deepcopy(self.twin.state))
        try:
            return self.get("state")
        except Apart:
            # A plan that was cut short may have the first move of the best plan, and others then.
            step, self._step = self._step, None
            if step is None or plans.check_cut_short(self, step) is None:
                raise
            return self.state()

    def restore(self, state: Pair) -> None:
        """Go on from a state, on both sides."""
        self.rust.state = state.rust
        self.twin.state = copy.deepcopy(state.twin)
        self._share_acceleration()
        # What goes on from a state agrees as the state does.
        self.within = max(self.within, state.within)
