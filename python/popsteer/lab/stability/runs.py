"""How far the steering loop of a controller is from instability, at each speed."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from popsteer import controllers, presets
from popsteer._core import PopParams, PurePursuitParams, Vehicle
from popsteer.controllers import Params
from popsteer.lab.stability.linear import linearised
from popsteer.lab.stability.loop import Loop, crossings

_SPEEDS = (2.0, 5.0, 10.0, 15.0, 20.0, 25.0)  # that are looked at by default [m/s]

_LONGEST = 20.0  # dead time beyond which the margin counts as infinite [s]


class Margins(NamedTuple):
    """Margins of a loop: how far one quantity may change before the loop becomes unstable.

    All three are NaN where the loop is not stable to begin with.
    """

    stable: bool
    """Whether the loop is stable as it is."""
    gain: float
    """Gain margin: the least factor above 1 on the steering; infinite where there is none."""
    phase: float
    """Phase that the loop may lag more [rad]; infinite where its gain never falls through 1."""
    dead_time: float
    """Dead time that may be added [s]."""


@dataclass(frozen=True)
class Stability:
    """Margins of several controllers on one vehicle over a range of speeds.

    Examples
    --------
    >>> result = run(["pop"], Vehicle(), [10.0])
    >>> result.margins["pop"][0].stable
    True
    """

    params: Mapping[str, Params]
    """Tuning of the controllers by name, in the order to show them."""
    margins: Mapping[str, list[Margins]]
    """The margins of each controller at each of the speeds."""
    vehicle: Vehicle
    """The vehicle as it is."""
    believed: Vehicle
    """The vehicle that the controllers are given."""
    speeds: tuple[float, ...]
    """The speeds [m/s]."""
    dt: float
    """Control period [s]."""
    preset: str
    """Where the tuning comes from."""


def margins(
    params: Params,
    vehicle: Vehicle,
    speed: float,
    dt: float = 0.05,
    *,
    believed: Vehicle | None = None,
    frequencies: int = 3000,
) -> Margins:
    """Measure how far a loop is from instability.

    Broken at the steering command, a stable loop with the gain L becomes unstable at the least
    factor k > 1 with k L = -1 (gain margin), at the least phase φ with L exp(-jφ) = -1 (phase
    margin), and at the least added dead time with which a pole leaves the unit circle. The first
    two are read from the frequency response of the sampled loop, the last is found by bisection on
    its stability, so that the holding of the command counts as it is.

    Parameters
    ----------
    params : PopParams or PurePursuitParams or StanleyParams or PidParams or PreviewPopParams
        Tuning of the controller.
    vehicle : Vehicle
        The vehicle as it is.
    speed : float
        Speed [m/s], positive.
    dt : float, default 0.05
        Control period [s].
    believed : Vehicle, optional
        The vehicle that the controller is given; `vehicle` by default. A controller that is given a
        dead time predicts through it.
    frequencies : int, default 3000
        How finely the frequency response is looked at.

    Returns
    -------
    Margins
        The margins, in small signals about straight driving.

    Raises
    ------
    ConfigError
        A number is out of its range, or the controller has no lookahead.

    Examples
    --------
    >>> from popsteer import PopParams
    >>> found = margins(PopParams(), Vehicle(), 10.0)
    >>> found.stable, 0.15 < found.dead_time < 0.25
    (True, True)

    A dead time that the controller is not given:

    >>> late = Vehicle(dead_time=0.25)
    >>> margins(PopParams(), late, 10.0, believed=Vehicle()).stable
    False
    >>> margins(PopParams(), late, 10.0).stable
    True
    """
    believed = vehicle if believed is None else believed
    law = linearised(params, believed, speed, dt)
    loop = Loop(law, vehicle, speed, dt, believed=believed, frequencies=frequencies)
    if not loop.is_stable():
        return Margins(stable=False, gain=math.nan, phase=math.nan, dead_time=math.nan)
    response = loop.gain()
    gains, phases = crossings(loop.angles / dt, response, np.unwrap(np.angle(response)))
    lags = [(phase + math.pi) % math.tau for _, phase in gains]
    delay = min((lag / at for lag, (at, _) in zip(lags, gains, strict=True)), default=_LONGEST)
    sizes = [size for _, size in phases]
    sizes.append(-float(response[-1].real))  # real at half the control rate
    return Margins(
        stable=True,
        gain=min((1.0 / size for size in sizes if 0.0 < size < 1.0), default=math.inf),
        phase=min(lags, default=math.inf),
        dead_time=_dead_time_margin(loop, vehicle.dead_time, delay, dt),
    )


def run(
    names: Iterable[str] | Mapping[str, Params] = controllers.names(),
    vehicle: Vehicle | None = None,
    speeds: Iterable[float] | None = None,
    *,
    believed: Vehicle | None = None,
    preset: str = "default",
    dt: float = 0.05,
) -> Stability:
    """Measure the margins of several controllers at several speeds.

    Parameters
    ----------
    names : iterable of str, or mapping of str to parameters
        The controllers; all of popsteer by default. A mapping gives each its tuning, and
        `preset` then only says what that is called.
    vehicle : Vehicle, optional
        The vehicle as it is; ``Vehicle()`` by default.
    speeds : iterable of float, optional
        Speeds [m/s], positive; by default 2 to 25 m/s, as far as the vehicle's top speed.
    believed : Vehicle, optional
        The vehicle that the controllers are given; `vehicle` by default.
    preset : str, default "default"
        Where the tuning comes from; see `popsteer.presets`.
    dt : float, default 0.05
        Control period [s].

    Returns
    -------
    Stability
        The margins.

    Raises
    ------
    ConfigError
        A controller or the preset is not known, or a number is out of its range.

    Examples
    --------
    >>> result = run(["stanley", "pop"], Vehicle(steer_lag=0.1), [5.0, 20.0])
    >>> [margins.stable for margins in result.margins["stanley"]]
    [True, True]
    """
    vehicle = Vehicle() if vehicle is None else vehicle
    believed = vehicle if believed is None else believed
    if not isinstance(names, Mapping):
        names = {name: presets.get(name, preset) for name in names}
    if speeds is None:
        top = min(_SPEEDS[-1], math.inf if vehicle.max_speed is None else vehicle.max_speed)
        speeds = (*(speed for speed in _SPEEDS if speed < top), top)
    speeds = tuple(speeds)
    found = {
        name: [margins(params, vehicle, speed, dt, believed=believed) for speed in speeds]
        for name, params in names.items()
    }
    return Stability(dict(names), found, vehicle, believed, speeds, dt, preset)


def dead_time_map(
    params: PopParams | PurePursuitParams,
    vehicle: Vehicle,
    speeds: Iterable[float],
    distances: Iterable[float],
    dt: float = 0.05,
    *,
    believed: Vehicle | None = None,
) -> NDArray[np.float64]:
    """Find the dead-time margin of a controller over speeds [m/s] and lookahead distances [m].

    `distances` replace the lookahead of `params`; the other arguments and the errors are those of
    `margins`. Gives the dead time that may be added [s], a row for each distance and a column for
    each speed; NaN where the loop is unstable without.

    Examples
    --------
    >>> from popsteer import PopParams
    >>> found = dead_time_map(PopParams(), Vehicle(), [10.0], [4.0, 8.0])
    >>> found.shape, bool(found[0, 0] < found[1, 0])
    ((2, 1), True)
    """
    speeds = tuple(speeds)
    how: Any = {"believed": believed, "frequencies": 800}
    fixed = (params.replace(lookahead_gain=0.0, min_lookahead=each) for each in distances)
    return np.array(
        [[margins(each, vehicle, v, dt, **how).dead_time for v in speeds] for each in fixed]
    )


def _dead_time_margin(loop: Loop, dead_time: float, guess: float, dt: float) -> float:
    """Find the least dead time to add that makes a stable loop unstable, from a guess of it."""
    # With the phase at the crossing alone: near, except where the crossing is fast.
    low, high = 0.8 * guess, 1.2 * guess + 0.1 * dt
    if guess >= _LONGEST or not loop.is_stable(dead_time + low):
        low, high = 0.0, 0.25 * dt
    while loop.is_stable(dead_time + high):
        low, high = high, high + max(0.25 * dt, 0.05 * high)
        if high > _LONGEST:
            return math.inf
    while high - low > 1e-5:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if loop.is_stable(dead_time + middle) else (low, middle)
    return low
