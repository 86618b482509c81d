"""Refuse a number that is out of its range, by its name."""

from __future__ import annotations

import math

from popsteer.errors import ConfigError, in_range

__all__ = ["check_in_range"]


def check_in_range(field: str, value: float, low: float, high: float) -> None:
    """Refuse a number that is not finite or out of its range.

    Parameters
    ----------
    field : str
        Its name.
    value : float
        What it is.
    low, high : float
        Ends of the range; both belong to it.

    Raises
    ------
    ConfigError
        Naming the field and the value.

    Examples
    --------
    >>> check_in_range("radius", -1.0, 0.1, 1e3)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: radius must be in [0.1, 1000], got -1.0
    """
    if not (math.isfinite(value) and low <= value <= high):
        raise ConfigError(field, value, in_range(low, high))
