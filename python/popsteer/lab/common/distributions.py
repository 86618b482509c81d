"""Distributions by name: what a quantity that varies is drawn from.

=============================  ===============================================================
text                           what is drawn
=============================  ===============================================================
``0.1``                        that number, always
``uniform(low, high)``         every number between the two alike
``loguniform(low, high)``      every factor alike; both are positive
``normal(mean, deviation)``    the normal distribution
``triangular(low, mode, high)``  most often near the mode, never beyond the ends
=============================  ===============================================================

Each is given by its quantiles, so that a Latin hypercube can be drawn from it.
"""

from __future__ import annotations

import math
import re
from statistics import NormalDist
from typing import NamedTuple

from popsteer.errors import ConfigError

_ARGUMENTS = {"uniform": 2, "loguniform": 2, "normal": 2, "triangular": 3}
_FORMS = "a number, uniform(LOW,HIGH), loguniform(LOW,HIGH), normal(MEAN,DEVIATION) or \
triangular(LOW,MODE,HIGH)"
_EDGE = 2.0**-53  # the quantiles of 0 and 1 of the normal distribution are infinite


class Distribution(NamedTuple):
    """A distribution, by its name and its numbers.

    Examples
    --------
    >>> lag = distribution("steer_lag", "uniform(0.1, 0.3)")
    >>> lag.quantile(0.5)
    0.2
    >>> str(lag)
    'uniform(0.1,0.3)'
    """

    name: str
    """One of the names above; "constant" for a number."""
    arguments: tuple[float, ...]
    """The numbers in its brackets."""

    @property
    def is_constant(self) -> bool:
        """Whether it is a number, and so always draws the same."""
        return self.name == "constant"

    @property
    def bounds(self) -> tuple[float, float]:
        """The least and the greatest number that is drawn; infinite for the normal distribution."""
        if self.name == "normal":
            return -math.inf, math.inf
        return self.arguments[0], self.arguments[-1]

    def quantile(self, share: float) -> float:
        """Give the number below which a share of the draws lies, 0 to 1."""
        first = self.arguments[0]
        if self.is_constant:
            return first
        last = self.arguments[-1]
        if self.name == "normal":
            inside = min(max(share, _EDGE), 1.0 - _EDGE)
            return first + last * NormalDist().inv_cdf(inside)
        if self.name == "loguniform":
            return math.exp(math.log(first) + share * (math.log(last) - math.log(first)))
        if self.name == "triangular":
            mode = self.arguments[1]
            rising = (mode - first) / (last - first)
            if share < rising:
                return first + math.sqrt(share * (last - first) * (mode - first))
            return last - math.sqrt((1.0 - share) * (last - first) * (last - mode))
        return first + share * (last - first)

    def __str__(self) -> str:
        if self.is_constant:
            return repr(self.arguments[0])
        return f"{self.name}({','.join(map(repr, self.arguments))})"


def distribution(name: str, text: str | float) -> Distribution:
    """Read a distribution, written as the table above has it.

    `name` is what varies, for messages. Raises ConfigError where the text says nothing that is
    known, or its numbers do not make a distribution.

    Examples
    --------
    >>> distribution("steer_lag", 0.1).quantile(0.9)
    0.1
    >>> distribution("steer_lag", "uniform(0.3, 0.1)")
    Traceback (most recent call last):
    popsteer.errors.ConfigError: steer_lag must be uniform(LOW,HIGH) with LOW < HIGH, \
got 'uniform(0.3, 0.1)'
    """
    found = re.fullmatch(r"\s*([a-z]+)\s*\(([^()]*)\)\s*", str(text))
    kind, inside = found.groups() if found else ("constant", str(text))
    try:
        numbers = tuple(float(part) for part in inside.split(","))
    except ValueError:
        raise ConfigError(name, text, _FORMS) from None
    if len(numbers) != _ARGUMENTS.get(kind, 1 if found is None else -1):
        raise ConfigError(name, text, _FORMS)
    if not all(map(math.isfinite, numbers)):
        raise ConfigError(name, text, "of finite numbers")
    if kind in ("uniform", "loguniform") and not numbers[0] < numbers[1]:
        raise ConfigError(name, text, f"{kind}(LOW,HIGH) with LOW < HIGH")
    if kind == "loguniform" and not numbers[0] > 0.0:
        raise ConfigError(name, text, "loguniform(LOW,HIGH) with LOW > 0")
    if kind == "normal" and not numbers[1] >= 0.0:
        raise ConfigError(name, text, "normal(MEAN,DEVIATION) with a deviation of 0 or more")
    if kind == "triangular" and not (
        numbers[0] <= numbers[1] <= numbers[2] and numbers[0] < numbers[2]
    ):
        raise ConfigError(name, text, "triangular(LOW,MODE,HIGH) in this order")
    return Distribution(kind, numbers)
