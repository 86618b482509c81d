"""Every field of a value, each changed by itself: a field that is added is in it by itself."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from popsteer.errors import ConfigError

if TYPE_CHECKING:
    from collections.abc import Iterator

# Tried in turn, until the field takes one: factors and steps of a number, then plain ones.
_PLAIN = (0.37, 1.3, 0.013, 3.0, 5)


def _candidates(value: Any) -> Iterator[Any]:
    if isinstance(value, bool):
        yield not value
    elif isinstance(value, int):
        yield from (value + 1, value - 1, 7)
    elif isinstance(value, float):
        yield from (0.871 * value, 1.037 * value, value + 0.013, value - 0.013)
    yield from _PLAIN
    yield from (True, False, "other")


def changed(whole: Any, skip: tuple[str, ...] = ()) -> Iterator[tuple[str, Any]]:
    """Give each field's name, and the same value with another one in that field alone."""
    fields = whole.as_dict()
    for name, value in fields.items():
        if name not in skip:
            yield name, _other(whole, name, value)


def _other(whole: Any, name: str, value: Any) -> Any:
    for candidate in _candidates(value):
        try:
            found = whole.replace(**{name: candidate})
        except (ConfigError, TypeError, ValueError):
            continue
        if found.as_dict()[name] != value:
            return found
    raise AssertionError(f"{type(whole).__name__}.{name}: nothing else than {value!r} is taken")
