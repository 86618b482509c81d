"""The Rust core and its reference side by side: the same call to both, compared bit for bit."""

from __future__ import annotations

import functools
import struct
import types
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

import popsteer
from popsteer import PopsteerError, Status, paper, reference

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


def bits(value: Any) -> Any:
    """Everything a value shows, so that only equal bits compare equal: -0.0 is not 0.0."""
    if isinstance(value, float):
        return f"{value!r} = {struct.pack('<d', value).hex()}"
    if value is None or isinstance(value, (bool, int, Status, str)):
        return repr(value)
    if isinstance(value, np.ndarray):
        return bits(value.tolist())
    if isinstance(value, (tuple, list)):
        return tuple(bits(entry) for entry in value)
    if isinstance(value, dict):
        return {name: bits(entry) for name, entry in value.items()}
    kind = type(value).__name__
    COMPARED.update(_qualified(kind))
    return kind, {field: bits(getattr(value, field)) for field in fields_of(kind)}


@dataclass(frozen=True)
class Outcome:
    """What a call came to."""

    value: Any
    shown: Any


def outcome(call: Callable[..., Any], *args: Any, **kwargs: Any) -> Outcome:
    try:
        value = call(*args, **kwargs)
    except PopsteerError as error:
        return Outcome(None, ("raises", type(error), str(error), bits(vars(error))))
    except Exception as error:  # noqa: BLE001 - whatever one side raises, the other has to
        return Outcome(None, ("raises", type(error)))
    return Outcome(value, bits(value))


def same(
    name: str,
    rust: Callable[..., Any],
    twin: Callable[..., Any],
    *args: Any,
    **kwargs: Any,
) -> Pair | None:
    """Call both with the same arguments, a `Pair` among them split; None where both refuse."""
    ours = outcome(
        rust, *map(_rust, args), **{field: _rust(value) for field, value in kwargs.items()}
    )
    theirs = outcome(
        twin, *map(_twin, args), **{field: _twin(value) for field, value in kwargs.items()}
    )
    assert ours.shown == theirs.shown, f"{name}{args}{kwargs or ''}: Rust first, then reference"
    COMPARED.add(name)
    refused = isinstance(ours.shown, tuple) and ours.shown[:1] == ("raises",)
    return None if refused else Pair(name, ours.value, theirs.value)


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
    """One thing twice: of the Rust core, and of the reference."""

    def __init__(self, name: str, rust: Any, twin: Any) -> None:
        self.name = name
        self.rust = rust
        self.twin = twin

    def __repr__(self) -> str:
        return repr(self.rust)

    def call(self, method: str, *args: Any, **kwargs: Any) -> Pair | None:
        """Call a method of both."""
        name = f"{self.name}.{method}"
        return same(name, getattr(self.rust, method), getattr(self.twin, method), *args, **kwargs)

    def get(self, attribute: str) -> Pair:
        """Read an attribute of both."""
        pair = same(
            f"{self.name}.{attribute}",
            functools.partial(getattr, self.rust, attribute),
            functools.partial(getattr, self.twin, attribute),
        )
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
        return done is not None
