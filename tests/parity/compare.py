"""The Rust core and its reference side by side: the same call to both, and what both answer.

Compared bit for bit, but for what `tolerances` lists.
"""

from __future__ import annotations

import functools
import math
import struct
import types
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

import popsteer
from popsteer import PopsteerError, Status, paper, reference
from tests.parity import plans
from tests.parity.tolerances import LOST, Refused, agree, amplified, tolerance

if TYPE_CHECKING:
    from collections.abc import Callable

COMPARED: set[str] = set()
"""Public names compared since the test began; the `covers` marks are held against it."""


@functools.cache
def fields_of(kind: str) -> tuple[str, ...]:
    """Names of the attributes that a class of the Rust core shows."""
    members = vars(getattr(popsteer, kind))
    return tuple(
        sorted(name for name in members if isinstance(members[name], types.GetSetDescriptorType))
    )


@functools.cache
def _qualified(kind: str) -> frozenset[str]:
    return frozenset(f"{kind}.{field}" for field in fields_of(kind))


def shown(value: Any) -> Any:
    """Everything that a value shows, in numbers, texts and their collections."""
    if value is None or isinstance(value, (bool, int, float, Status, str)):
        return value
    if isinstance(value, np.ndarray):
        return shown(value.tolist())
    if isinstance(value, (tuple, list)):
        return tuple(shown(entry) for entry in value)
    if isinstance(value, dict):
        return {name: shown(entry) for name, entry in value.items()}
    kind = type(value).__name__
    COMPARED.update(_qualified(kind))
    return kind, {field: shown(getattr(value, field)) for field in fields_of(kind)}


def bits(value: Any) -> Any:
    """The same, so that only equal bits compare equal: -0.0 is not 0.0."""
    return _bits(shown(value))


def _bits(part: Any) -> Any:
    if isinstance(part, float):
        return f"{part!r} = {struct.pack('<d', part).hex()}"
    if isinstance(part, tuple):
        return tuple(_bits(entry) for entry in part)
    if isinstance(part, dict):
        return {name: _bits(entry) for name, entry in part.items()}
    return repr(part)


@dataclass(frozen=True)
class Outcome:
    """What a call came to."""

    value: Any
    shown: Any


class Apart(AssertionError):  # noqa: N818 - what it says of the two sides
    """Both sides answer, but not the same."""

    def __init__(self, text: str, ours: Any, theirs: Any) -> None:
        super().__init__(text)
        self.ours, self.theirs = ours, theirs


def outcome(call: Callable[..., Any], *args: Any, **kwargs: Any) -> Outcome:
    try:
        value = call(*args, **kwargs)
    except PopsteerError as error:
        refused = ("raises", type(error), str(error), shown(vars(error)))
        return Outcome(None, Refused(refused))
    except Exception as error:  # noqa: BLE001 - whatever one side raises, the other has to
        return Outcome(None, ("raises", type(error)))
    return Outcome(value, shown(value))


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
    given = [*args, *kwargs.values()]
    within = max([within, *(each.within for each in given if isinstance(each, Pair))])
    ours = outcome(
        rust, *map(_rust, args), **{field: _rust(value) for field, value in kwargs.items()}
    )
    theirs = outcome(
        twin, *map(_twin, args), **{field: _twin(value) for field, value in kwargs.items()}
    )
    pair = Pair(name, ours.value, theirs.value, within)
    what = f"{name}{args}{kwargs or ''}: Rust first, then reference"
    if pair.within > 0.0:
        apart = agree(ours.shown, theirs.shown, pair.within, tied=plans.tied)
    else:
        apart = "" if _bits(ours.shown) == _bits(theirs.shown) else f"{ours.shown}, {theirs.shown}"
    if apart:
        raise Apart(f"{what}: {apart}", ours.value, theirs.value)
    COMPARED.add(name)
    refused = isinstance(ours.shown, tuple) and ours.shown[:1] == ("raises",)
    return None if refused else pair


def call(name: str, *args: Any, **kwargs: Any) -> Pair | None:
    """Call a function, or make an object, of popsteer and of its reference."""
    home = paper if name in paper.__all__ else popsteer
    return same(name, getattr(home, name), getattr(reference, name), *args, **kwargs)


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
        self._step: Any = None
        # Whether errors have grown so large, since it was reset, that nothing is left to compare.
        self._lost = False

    def __repr__(self) -> str:
        return repr(self.rust)

    def call(self, method: str, *args: Any, **kwargs: Any) -> Pair | None:
        """Call a method of both."""
        name = f"{self.name}.{method}"
        rust, twin = getattr(self.rust, method), getattr(self.twin, method)
        steps = method in ("step", "steer", "step_or_hold")
        if steps and self.within > 0.0 and hasattr(self.rust, "vehicle") and len(args) > 4:
            weight = amplified(self.rust, *args[3:5])
            if self._lost or weight > LOST:
                return self._go_on(name, method, args, kwargs)
            # What goes on from such a step agrees as the step does.
            self.within = max(self.within, tolerance(self.rust) * weight)
        self._lost = self._lost and method != "reset"
        before = self.rust.state if steps and self.within > 0.0 else None
        plans_ahead = self.name == "PreviewPop" and steps
        self._step = (before, method, args, kwargs) if plans_ahead else None
        try:
            return same(name, rust, twin, *args, within=self.within, **kwargs)
        except Apart as apart:
            if apart.ours is None:
                raise
            if (
                steps
                and self.within > 0.0
                and (plans.equally_near(self) or plans.turns_round(self))
            ):
                return Pair(name, apart.ours, apart.ours)
            if before is not None and self._reaches_limit(before, apart, args):
                return Pair(name, apart.ours, apart.theirs, self.within)
            if self._step is None:
                raise
            command = plans.check_cut_short(self, self._step, apart.theirs)
            if command is None:
                raise
            return Pair(name, command, command)

    def _reaches_limit(self, before: Any, apart: Apart, args: Any) -> bool:
        """Whether the commands agree but for SATURATED, and just reach a limit of the wheels."""
        if not isinstance(apart.ours, popsteer.Command):
            return False
        (_, ours), (_, theirs) = shown(apart.ours), shown(apart.theirs)
        if ours["status"] ^ theirs["status"] != Status.SATURATED:
            return False
        if agree({**ours, "status": 0}, {**theirs, "status": 0}, self.within):
            return False
        car, estimate, steer = self.twin.vehicle, self.twin.estimate, ours["steer"]
        wheel, speed = abs(steer + estimate.steer_offset), args[3]
        room = [car.max_steer - abs(steer), car.max_steer - wheel]
        if car.max_steer_rate is not None:
            room.append(car.max_steer_rate * args[4] - abs(steer - before.steer))
        if car.max_lateral_acceleration is not None and speed != 0.0:
            tightest = speed * speed * estimate.gain / car.max_lateral_acceleration
            room.append(math.atan(car.turning_length(speed) / tightest) - wheel)
        return bool(min(map(abs, room)) <= plans.PLANS)

    def _go_on(self, name: str, method: str, args: Any, kwargs: Any) -> Pair | None:
        """Call a method of both, and go on from the state of the Rust core."""
        ours = outcome(getattr(self.rust, method), *args, **kwargs)
        theirs = outcome(getattr(self.twin, method), *args, **kwargs)
        if ours.value is None or theirs.value is None:
            assert not agree(ours.shown, theirs.shown, self.within), f"{name}{args}"
            return None
        self._lost = True
        state = self.rust.state
        self.twin.state = getattr(reference, type(state).__name__)(**state.as_dict())
        return Pair(name, ours.value, ours.value)

    def get(self, attribute: str) -> Pair:
        """Read an attribute of both."""
        if self._lost:
            ours, theirs = getattr(self.rust, attribute), getattr(self.twin, attribute)
            return Pair(f"{self.name}.{attribute}", ours, theirs, self.within)
        try:
            pair = same(
                f"{self.name}.{attribute}",
                functools.partial(getattr, self.rust, attribute),
                functools.partial(getattr, self.twin, attribute),
                within=self.within,
            )
        except Apart:
            # A plan that was cut short may have the first move of the best plan, and others then.
            step, self._step = self._step, None
            if attribute != "state" or step is None or plans.check_cut_short(self, step) is None:
                raise
            return self.get(attribute)
        assert pair is not None
        return pair

    def set_state(self, state: Pair) -> bool:
        """Restore a state on both; False where both refuse it."""
        done = same(
            f"{self.name}.state",
            lambda value: setattr(self.rust, "state", value),
            lambda value: setattr(self.twin, "state", value),
            state,
        )
        # What goes on from a state agrees as the state does.
        self.within = max(self.within, state.within)
        return done is not None
