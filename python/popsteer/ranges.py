"""Refuse a number that is out of its range, by its name: every such refusal in Python is here."""

from __future__ import annotations

from popsteer.errors import ConfigError, InputError, count_in_range, in_range


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
