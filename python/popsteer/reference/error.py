"""The checks behind every refusal; the classes they raise live in `popsteer.errors`."""

from __future__ import annotations

import operator
from math import inf

from popsteer import errors
from popsteer.ranges import check_in_range

__all__ = [
    "config_count",
    "config_in_range",
    "config_optional",
    "in_range",
    "input_below",
    "input_in_range",
    "input_within",
]


def in_range(value: float, low: float, high: float) -> bool:
    """Tell whether `value` is a number in [low, high]; False for NaN.

    Examples
    --------
    >>> in_range(1.0, 0.0, 1.0), in_range(float("nan"), 0.0, 1.0)
    (True, False)
    """
    return low <= value <= high


def _number(value: float) -> float:
    """Return `value` as a float; a whole number beyond all floats as an infinity."""
    try:
        return float(value)
    except OverflowError:
        return inf if value > 0 else -inf


def config_in_range(params: object, field: str, low: float, high: float) -> None:
    """Settle one field of new parameters: made a float, and found in [low, high].

    Raises `ConfigError`, naming the field, where its value is not.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> config_in_range(SimpleNamespace(kp=-1), "kp", 0.0, 1e6)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: kp must be in [0, 1e+06], got -1.0
    """
    value = _number(getattr(params, field))
    check_in_range(field, value, low, high)
    # Parameters are frozen; this runs inside their construction.
    object.__setattr__(params, field, value)


def config_optional(params: object, field: str, low: float, high: float) -> None:
    """Settle one field of new parameters that may be None: None, or as `config_in_range`.

    Raises `ConfigError`, naming the field, where its value is not.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> config_optional(SimpleNamespace(max_speed=None), "max_speed", 1e-3, 1e4)
    >>> config_optional(SimpleNamespace(max_speed=0), "max_speed", 1e-3, 1e4)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: max_speed must be in [0.001, 10000], got 0.0
    """
    if getattr(params, field) is not None:
        config_in_range(params, field, low, high)


def config_count(params: object, field: str, low: int, high: int, *, odd: bool = False) -> None:
    """Settle one field of new parameters: a whole number in [low, high], odd where that is asked.

    Raises `ConfigError`, naming the field, where its value is not.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> config_count(SimpleNamespace(candidate_count=20), "candidate_count", 3, 101, odd=True)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: candidate_count must be odd and in [3, 101], got 20
    """
    value = operator.index(getattr(params, field))
    if (odd and value % 2 == 0) or not low <= value <= high:
        wanted = errors.odd_in_range if odd else errors.count_in_range
        raise errors.ConfigError(field, value, wanted(low, high))
    object.__setattr__(params, field, value)


def input_in_range(field: str, value: float, low: float, high: float) -> float:
    """Return `value` as a float, where it lies in [low, high].

    Raises `InputError`, naming the argument, where it does not.

    Examples
    --------
    >>> input_in_range("dt", 0, 1e-6, 1e3)
    Traceback (most recent call last):
    popsteer.errors.InputError: dt must be in [1e-06, 1000], got 0.0
    """
    value = _number(value)
    check_in_range(field, value, low, high, error=errors.InputError)
    return value


def input_within(field: str, value: float, most: float) -> float:
    """Return `value` as a float, where it lies within `most` either way; as `input_in_range`."""
    return input_in_range(field, value, -most, most)


def input_below(field: str, value: int, count: int) -> int:
    """Return `value`, where it is an index below `count`.

    Raises `InputError`, naming the argument, where it is not.

    Examples
    --------
    >>> input_below("nearest", 3, 3)
    Traceback (most recent call last):
    popsteer.errors.InputError: nearest must be below 3, got 3
    """
    value = operator.index(value)
    if not 0 <= value < count:
        raise errors.InputError(field, value, errors.below(count))
    return value
