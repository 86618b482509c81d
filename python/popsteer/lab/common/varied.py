"""Runs that differ: what can vary, what it is drawn from, and the plant and start of a draw.

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
from collections.abc import Mapping
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from popsteer._core import CarlaIdentified, KinematicBicycle, Noise, Path, Vehicle
from popsteer.errors import ConfigError
from popsteer.extras import require
from popsteer.ranges import check_known
from popsteer.sim import Plant, Pose, default_start

_ARGUMENTS = {"uniform": 2, "loguniform": 2, "normal": 2, "triangular": 3}
_FORMS = "a number, uniform(LOW,HIGH), loguniform(LOW,HIGH), normal(MEAN,DEVIATION) or \
triangular(LOW,MODE,HIGH)"
_EDGE = 2.0**-53  # the quantiles of 0 and 1 of the normal distribution are infinite


class Distribution(NamedTuple):
    """A distribution, by its name and its numbers."""

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
    >>> lag = distribution("steer_lag", "uniform(0.1, 0.3)")
    >>> lag.quantile(0.5), str(lag)
    (0.2, 'uniform(0.1,0.3)')
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
    first, last = numbers[0], numbers[-1]
    if kind in ("uniform", "loguniform") and not first < last:
        raise ConfigError(name, text, f"{kind}(LOW,HIGH) with LOW < HIGH")
    if kind == "loguniform" and not first > 0.0:
        raise ConfigError(name, text, "loguniform(LOW,HIGH) with LOW > 0")
    if kind == "normal" and not last >= 0.0:
        raise ConfigError(name, text, "normal(MEAN,DEVIATION) with a deviation of 0 or more")
    if kind == "triangular" and not (first <= numbers[1] <= last and first < last):
        raise ConfigError(name, text, "triangular(LOW,MODE,HIGH) in this order")
    return Distribution(kind, numbers)


_STEERING = ("dead_time", "steer_offset")  # what the closed loop adds to plants from elsewhere
_NOISE = {"noise_position": "position", "noise_yaw": "yaw", "noise_speed": "speed"}
START = ("start_offset", "start_yaw", "start_speed")
"""What can vary of the start."""


class Varied(NamedTuple):
    """The plant, start and noise of one run."""

    plant: Any
    start: Pose
    """Pose of its point at the start [m, m, rad]."""
    speed: float | None
    """Speed at the start [m/s]; None where it does not vary."""
    noise: Noise | None
    """Noise of pose and speed as the controller gets them; None where no noise varies."""


def varying(plant: Plant) -> tuple[str, ...]:
    """Name what can vary: fields of the vehicle, parameters of the plant, noise and start."""
    if isinstance(plant, CarlaIdentified | KinematicBicycle):
        known = (*plant.vehicle.as_dict(), *plant.as_dict())
        # The place of the pose's point is no property of the car, and a yes or no has no range.
        fixed = ("vehicle", "rear_axle", "no_slip_point", "steers_at_rest")
        return (*(name for name in known if name not in fixed), *_NOISE, *START)
    params: Any = getattr(plant, "params", None)
    return (*_STEERING, *(() if params is None else params.as_dict()), *_NOISE, *START)


def usual(vehicle: Vehicle, plant: Plant) -> dict[str, str]:
    """Give what varies where nothing else is asked for: by name, the texts of distributions."""
    turning = vehicle.wheelbase if vehicle.turning_wheelbase is None else vehicle.turning_wheelbase
    named = {
        "turning_wheelbase": f"uniform({0.95 * turning:.6g},{1.05 * turning:.6g})",
        "steer_lag": f"uniform({0.5 * vehicle.steer_lag:.6g},{1.5 * vehicle.steer_lag:.6g})",
        "dead_time": f"uniform({vehicle.dead_time:.6g},{vehicle.dead_time + 0.1:.6g})",
        "steer_offset": f"normal({vehicle.steer_offset:.6g},0.005)",
        "friction": "uniform(0.6,1.0)",
        "noise_position": "uniform(0.0,0.05)",
        "noise_yaw": "uniform(0.0,0.005)",
        "start_offset": f"uniform({-vehicle.wheelbase / 3.0:.6g},{vehicle.wheelbase / 3.0:.6g})",
        "start_yaw": "normal(0.0,0.05)",
    }
    if vehicle.steer_lag == 0.0:
        named["steer_lag"] = "uniform(0.0,0.1)"
    known = varying(plant)
    return {name: text for name, text in named.items() if name in known}


def draws(vary: Mapping[str, Distribution], runs: int, seed: int) -> dict[str, NDArray[np.float64]]:
    """Draw a Latin hypercube: each quantity's values, one a run, lie evenly over its quantiles.

    M. McKay, R. Beckman, W. Conover, *A Comparison of Three Methods for Selecting Values of Input
    Variables in the Analysis of Output from a Computer Code*, 1979.
    """
    if not vary:
        return {}
    require("a Latin hypercube", "lab", "scipy")
    from scipy.stats import qmc

    # One generator for all quantities: adding one changes the draws of the others.
    cube = qmc.LatinHypercube(len(vary), rng=np.random.default_rng(seed)).random(runs)
    return {
        name: np.array([each.quantile(share) for share in column.tolist()])
        for (name, each), column in zip(vary.items(), cube.T, strict=True)
    }


def run_seed(seed: int, run: int) -> int:
    """Give the seed of a run, 0 to 2**64 - 1: another for each, whatever else is driven."""
    return int(np.random.SeedSequence([seed, run]).generate_state(1, np.uint64)[0])


def varied(
    plant: Plant, path: Path, values: Mapping[str, float], offset: float | None = None
) -> Varied:
    """Make a run of a draw, `offset` [m] left of the path, else on it; ConfigError if it is bad."""
    known = varying(plant)
    for name in values:
        check_known("quantity that varies", name, known)
    moved = _moved(plant, {k: v for k, v in values.items() if k not in (*_NOISE, *START)})
    x, y, yaw = default_start(path, values.get("start_offset", offset or 0.0), moved.vehicle)
    seen = {field: values[name] for name, field in _NOISE.items() if name in values}
    return Varied(
        moved,
        (x, y, yaw + values.get("start_yaw", 0.0)),
        values.get("start_speed"),
        Noise(**seen) if seen else None,
    )


def _moved(plant: Any, values: Mapping[str, float]) -> Any:
    if not values:
        return plant
    core = isinstance(plant, CarlaIdentified | KinematicBicycle)
    fields = plant.vehicle.as_dict() if core else _STEERING
    own = {name: value for name, value in values.items() if name not in fields}
    of_vehicle = {name: value for name, value in values.items() if name in fields}
    if core:
        return plant.replace(vehicle=plant.vehicle.replace(**of_vehicle), **own)
    if own:
        plant = plant.with_params(plant.params.replace(**own))
    if of_vehicle:
        now = {name: getattr(plant.vehicle, name) for name in _STEERING}
        plant = plant.with_steering(**(now | of_vehicle))
    return plant
