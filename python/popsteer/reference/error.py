"""The checks behind every refusal; the classes they raise live in `popsteer.errors`."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from collections.abc import Set as AbstractSet
from dataclasses import field, fields
from math import inf, ldexp
from typing import TYPE_CHECKING, Any

from popsteer import errors
from popsteer.ranges import check_in_range

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable


def as_float(value: float) -> float:
    """Return `value` as a float; a whole number beyond all floats as an infinity."""
    try:
        return ldexp(value, 0)  # not float(), which reads text, too
    except OverflowError:
        return inf if value > 0 else -inf


def as_numbers(name: str, values: Iterable[float]) -> Iterable[float]:
    """Return `values`; raises `TypeError` for text, and for what has no order."""
    if isinstance(values, (str, bytes, bytearray, AbstractSet, Mapping)):
        raise TypeError(f"{name} must be numbers in their order, not {type(values).__name__}")
    return values


class Checked:
    """A frozen dataclass whose fields made by `number`, `optional` and `count` are checked.

    Raises `ConfigError`, naming the field, where a value is out of its range.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> @dataclass(frozen=True)
    ... class Gains(Checked):
    ...     kp: float = number(0.25, 0.0, 1e6)
    >>> Gains(kp=-1)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: kp must be in [0, 1e+06], got -1.0
    """

    def __post_init__(self) -> None:
        for each in fields(self):  # type: ignore[arg-type] # of the dataclass derived from this
            settled = each.metadata.get("settled")
            if settled is not None:
                # Parameters are frozen; this runs inside their construction.
                object.__setattr__(self, each.name, settled(each.name, getattr(self, each.name)))


def number(default: float, low: float, high: float) -> Any:  # noqa: ANN401 - what dataclasses.field gives
    """Declare a field: a float in [low, high]."""

    def settled(name: str, value: float) -> float:
        value = as_float(value)
        check_in_range(name, value, low, high)
        return value

    return field(default=default, metadata={"settled": settled, "range": (low, high)})


def optional(
    low: float,
    high: float,
    default: float | None = None,
    scaled: Callable[[Any], float] | None = None,
) -> Any:  # noqa: ANN401 - what dataclasses.field gives
    """Declare a field: None, or a float in [low, high]; `scaled` says of a vehicle what None is."""
    settled = number(0.0, low, high).metadata["settled"]

    def unless_none(name: str, value: float | None) -> float | None:
        return None if value is None else settled(name, value)

    metadata = {"settled": unless_none, "range": (low, high), "scaled": scaled}
    return field(default=default, metadata=metadata)


def count(default: int, low: int, high: int, *, odd: bool = False) -> Any:  # noqa: ANN401 - what dataclasses.field gives
    """Declare a field: a whole number in [low, high], odd where that is asked."""
    wanted: Callable[[int, int], str] = errors.odd_in_range if odd else errors.count_in_range

    def settled(name: str, value: int) -> int:
        value = operator.index(value)
        if (odd and value % 2 == 0) or not low <= value <= high:
            raise errors.ConfigError(name, value, wanted(low, high))
        return value

    return field(default=default, metadata={"settled": settled, "range": (low, high)})


def input_in_range(name: str, value: float, low: float, high: float) -> float:
    """Return `value` as a float, where it lies in [low, high].

    Raises `InputError`, naming the argument, where it does not.
    """
    value = as_float(value)
    check_in_range(name, value, low, high, error=errors.InputError)
    return value


def input_within(name: str, value: float, most: float) -> float:
    """Return `value` as a float, where it lies within `most` either way; as `input_in_range`."""
    return input_in_range(name, value, -most, most)


def input_below(name: str, value: int, count: int) -> int:
    """Return `value`, where it is an index below `count`.

    Raises `InputError`, naming the argument, where it is not.
    """
    value = operator.index(value)
    if not 0 <= value < count:
        raise errors.InputError(name, value, errors.below(count))
    return value
