"""Refuse a number that is out of its range, by its name: every such refusal in Python is here."""

from __future__ import annotations

from typing import TYPE_CHECKING

from popsteer.errors import ConfigError, InputError, count_in_range, in_range

if TYPE_CHECKING:
    from collections.abc import Iterable


def check_in_range(
    field: str,
    value: float,
    low: float,
    high: float,
    *,
    above: bool = False,
    error: type[ConfigError | InputError] = ConfigError,
) -> None:
    """Refuse a number that is out of its range, whose ends belong to it; NaN is out of every range.

    Where `above`, `low` itself is refused, too. Raises `error`, naming the field and the value.

    Examples
    --------
    >>> check_in_range("radius", -1.0, 0.1, 1e3)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: radius must be in [0.1, 1000], got -1.0
    """
    if not (low <= value <= high) or (above and value == low):
        wanted = f"in ({low:g}, {high:g}]" if above else in_range(low, high)
        raise error(field, value, wanted)


def check_count(field: str, value: int, low: int, high: int) -> None:
    """Refuse a whole number that is out of its range; as `check_in_range`.

    Examples
    --------
    >>> check_count("runs", 0, 1, 1000)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: runs must be a count in [1, 1000], got 0
    """
    if not low <= value <= high:
        raise ConfigError(field, value, count_in_range(low, high))


def check_known(what: str, name: object, known: Iterable[str]) -> None:
    """Refuse a name that is not among the known ones; `what` is named."""
    if name not in tuple(known):  # a tuple compares, where a dict would hash and fail on a list
        raise ConfigError.unknown(what, name, known)
