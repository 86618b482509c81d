"""What the drive does: its delay, lag and gains, drag, by what was commanded and the speed.

    a'     = (acceleration(t - drive_delay) - a) / drive_lag
    speed' = a - drag speed - air_drag speed |speed| - gravity times the slope

The acceleration is ``drive`` throttle - ``braking`` brake, or ``gain`` times the one commanded; to
a commanded speed, the speed itself responds, with ``gain`` of it. All but delay and lag is linear,
and solved for at each of them (variable projection; G. Golub and V. Pereyra, 1973).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from popsteer._core import _Wheels
from popsteer.identification.arrays import huber, middles, summed
from popsteer.identification.drive import RESOLVED, REST, SEEN, noise_of, prepare
from popsteer.identification.signals import LONGEST
from popsteer.identification.whiten import choose_theta, influence, known, spread, whitened
from popsteer.logs import Log

if TYPE_CHECKING:
    from popsteer.identification.drive import Array

_DELAYS = np.arange(0.0, 1.01, 0.05)
_LAGS = (0.01, 0.05, 0.1, 0.2, 0.4, 0.8)
_STEP = 0.004
"""Of the derivatives by delay and lag [s]."""
_GRAVITY = 9.80665
_SLOPE_TIME = 0.5
"""Time over which the slope is taken [s]."""
_PRIOR = {"drag": 1.0, "air_drag": 0.02, "rolling": 0.2}
"""How large these are believed to be, about 0: what the drive does not show stays there."""
SURE = {"drive_delay": 0.02, "drive_lag": 0.03, "drag": 0.03, "air_drag": 0.003}
"""Largest standard errors of what is stated [s, s, 1/s, 1/m]; of a gain, a share of it."""
SURE_GAIN = 0.05
ASKED = "drive three stops and starts, with steps of throttle and brake that are held for 2 s"


@dataclass(frozen=True)
class Drive:
    """What is known of the drive.

    Attributes
    ----------
    values, errors : dict of str to float
        ``drive_delay``, ``drive_lag`` [s]; of pedals ``drive``, ``braking`` [m/s²], of other
        commands ``gain``; ``drag`` [1/s], ``air_drag`` [1/m]; and the standard errors of those that
        the log shows.
    unknown : dict of str to str
        Why the others are not known, and within which range they lie.
    residual : float
        Standard deviation of what is left of the speed from row to row [m/s].
    """

    values: dict[str, float] = field(default_factory=dict)
    errors: dict[str, float] = field(default_factory=dict)
    unknown: dict[str, str] = field(default_factory=dict)
    residual: float = 0.0

    @property
    def pedals(self) -> dict[str, float]:
        """What a map of pedals says: both gains and drag, if both pedals are known."""
        if not {"drive", "braking"} <= self.errors.keys():
            return {}
        names = ("drive", "braking", "drag", "air_drag")
        return {n: max(self.values[n], 0.0) for n in names if n in self.errors}


class _Task:
    """The commands of a log as columns, and the speed that they are to explain."""

    def __init__(self, log: Log, size: float) -> None:
        ready = prepare(log, size)
        self.t, self.speed = ready.t, ready.sample_speed
        self.names, self.direct, signals = _commands(log)
        slowest = max(REST * size, SEEN * ready.speed_noise)
        if not self.direct:  # a brake that holds the car moves nothing, however short the rest
            ready = replace(ready, moving=ready.moving & (np.abs(self.speed) > slowest))
        self.parts = ready.parts()
        # Commands at rest are those of the drive that follows, in its gear.
        drives = np.append(np.flatnonzero(ready.moving), len(log) - 1)
        following = drives[np.searchsorted(drives, np.arange(len(log)))]
        self.gear = np.where(self.speed[following] < 0.0, -1.0, 1.0)
        # A car that stands as the log begins was commanded nothing before.
        stands = abs(self.speed[0]) < slowest and not self.direct
        self.given_at = np.concatenate((self.t[:1] - 1.0, self.t)) if stands else self.t
        self.signals = [np.concatenate(([0.0], each)) if stands else each for each in signals]
        step, mean = np.diff(self.t), middles(self.speed)
        rise, self.per_rise = _rise(log, self.speed)
        self.heights = noise_of(np.asarray(log.signals["z"])) if "z" in log.signals else 0.0
        self.period = log.period
        self.by_slope = -_GRAVITY * summed(np.clip(rise * self.per_rise, -0.5, 0.5)[1:] * step)
        self.nuisance = ["drag", "air_drag", "rolling"] if not self.direct else []
        self.columns = [-mean * step, -mean * np.abs(mean) * step, -self.gear[1:] * step]
        self.theta = 0.9
        self.noise = max(ready.speed_noise, RESOLVED["speed"])

    def model(self, delay: float, lag: float) -> Array:
        """Give what each parameter of 1 adds to the speed from the start on, (N, P)."""
        found = []
        for values in self.signals:
            wheels = _Wheels(self.given_at, values, lag, None)
            given = self.t - delay
            added = wheels.at(given) if self.direct else wheels.integral(given)
            found.append(self.gear[1:] * np.diff(added) if not self.direct else np.diff(added))
        found += self.columns if self.nuisance else []
        return summed(np.stack(found, axis=1))

    def solve(self, delay: float, lag: float) -> tuple[Array, Array]:
        """Give the linear parameters that explain the speed best, and the residuals."""
        names = [*self.names, *self.nuisance]
        columns = whitened(self.model(delay, lag), self.parts, self.theta) / self.noise
        wanted = whitened(self.speed - self.by_slope, self.parts, self.theta) / self.noise
        belief = np.diag(_belief(names))
        rows = np.vstack((columns, belief)), np.concatenate((wanted, np.zeros(len(names))))
        root = np.ones(len(rows[1]))
        for _ in range(3):
            linear = np.linalg.lstsq(rows[0] * root[:, None], rows[1] * root, rcond=1e-12)[0]
            left = rows[1] - rows[0] @ linear
            root = huber(left, 3.0)
        weighted: Array = left * root
        return np.asarray(linear), weighted

    def weigh(self, delay: float, lag: float) -> None:
        """Take noise and theta from what is left over."""
        linear, _ = self.solve(delay, lag)
        error = self.speed - self.by_slope - self.model(delay, lag) @ linear
        self.theta = choose_theta(error, self.parts)
        left = spread(whitened(error, self.parts, self.theta))
        self.noise = max(left, RESOLVED["speed"] * float(np.max(np.abs(self.speed))))

    def of_heights(self, jacobian: Array) -> Array:
        """Give the covariance of J^T w that the noise of the heights makes through the slope."""
        added = np.zeros((len(self.t), jacobian.shape[1]))
        for part, piece in zip(
            self.parts, influence(jacobian, self.parts, self.theta), strict=True
        ):
            added[part.start + 1 : part.stop] = piece
        steps = np.diff(self.t, prepend=self.t[0]) * self.per_rise * _GRAVITY / self.noise
        moved = self.heights * _smoothed(added * steps[:, None], self.period, 1)
        return moved.T @ moved


def fit_drive(log: Log, size: float = 1.0) -> Drive | None:
    """Find out what the drive does; None where the log has no commands of it."""
    from scipy.optimize import least_squares

    if not _commands(log)[0]:
        return None
    task = _Task(_liveliest(log), size)
    if sum(part.stop - part.start for part in task.parts) < 50:
        return Drive(unknown={"drive_delay": f"the car hardly drives: {ASKED}"})
    grid = [(delay, lag) for delay in _DELAYS for lag in _LAGS]
    best = min(grid, key=lambda at: float(np.sum(task.solve(*at)[1] ** 2)))
    for _ in range(2):
        task.weigh(*best)
        found = least_squares(
            lambda at: task.solve(*at)[1],
            np.clip(best, (0.0, 1e-3), (1.5, 3.0)),
            bounds=((0.0, 1e-3), (1.5, 3.0)),
            x_scale=(0.1, 0.1),
            diff_step=1e-3,
            max_nfev=30,
        )
        best = float(found.x[0]), float(found.x[1])
    linear, left = task.solve(*best)
    return _stated(task, best, linear, left)


def _belief(names: list[str]) -> Array:
    """Give the inverse deviations of what is believed of parameters, 0 of nothing."""
    return np.array([1.0 / _PRIOR[name] if name in _PRIOR else 0.0 for name in names])


def _stated(task: _Task, best: tuple[float, float], linear: Array, left: Array) -> Drive:
    """State what the log shows, and say why not of the rest."""
    names = ["drive_delay", "drive_lag", *task.names, *task.nuisance]
    columns = whitened(task.model(*best), task.parts, task.theta) / task.noise
    count, own = len(columns), linear[: len(names) - 2]
    direct = []
    for k, least in enumerate((0.0, 1e-3)):
        ends = np.array([best, best])
        ends[:, k] = best[k] + _STEP, max(best[k] - _STEP, least)
        change = (task.model(*ends[0]) - task.model(*ends[1])) @ own / (ends[0, k] - ends[1, k])
        direct.append(-whitened(change, task.parts, task.theta) / task.noise)
    jacobian = np.column_stack([*direct, -columns])
    memory = int(np.ceil(1.0 / float(np.median(np.diff(task.t)))))
    noise = jacobian.T @ jacobian + task.of_heights(jacobian)
    sure = known(jacobian, left[:count], memory, noise, _belief(names))
    values = dict(zip(names, [*best, *map(float, own)], strict=True))
    errors = dict(zip(names, sure.errors(), strict=True))
    values.pop("rolling", None)
    shown, unknown = {}, {}
    for name, value in values.items():
        if errors[name] <= SURE.get(name, SURE_GAIN * abs(value)):
            shown[name] = errors[name]
        else:
            low, high = value - 2.0 * errors[name], value + 2.0 * errors[name]
            unknown[name] = f"{name} lies between {max(low, 0.0):.3g} and {high:.3g}: {ASKED}"
    return Drive(values, shown, unknown, task.noise)


def _commands(log: Log) -> tuple[list[str], bool, list[Array]]:
    """Give the gains to be found, whether the speed itself is commanded, and the commands."""
    signals = {key: np.asarray(values) for key, values in log.signals.items()}
    signals = {key: values for key, values in signals.items() if np.ptp(values) > 0.0}
    if "throttle" in signals or "brake" in signals:
        pedals = [("drive", "throttle", 1.0), ("braking", "brake", -1.0)]
        there = [(gain, sign * signals[key]) for gain, key, sign in pedals if key in signals]
        return [gain for gain, _ in there], False, [values for _, values in there]
    for key, direct in (("acceleration_command", False), ("speed_command", True)):
        if key in signals:
            return ["gain"], direct, [signals[key]]
    return [], False, []


def _liveliest(log: Log) -> Log:
    """Give the part of a long log, without a break in its rows, in which most is commanded."""
    if log.duration <= LONGEST:
        return log
    done = sum(summed(np.abs(np.diff(each))) for each in _commands(log)[2])
    ends = np.searchsorted(log.t, log.t + LONGEST)
    first = int(np.argmax(np.asarray(done)[ends - 1] - done))
    rows = slice(first, int(ends[first]))
    columns = [values[rows] for values in log.as_dict().values()]
    signals = {name: np.asarray(values)[rows] for name, values in log.signals.items()}
    return Log(*columns, name=log.name, signals=signals)


def _smoothed(values: Array, period: float, order: int) -> Array:
    """Give a signal, or its rate of order 1, smoothed over `_SLOPE_TIME`."""
    from scipy.ndimage import gaussian_filter1d

    width = max(_SLOPE_TIME / period, 1.0)
    found: Array = gaussian_filter1d(values, width, axis=0, order=order) / period**order
    return found


def _rise(log: Log, speed: Array) -> tuple[Array, Array]:
    """Give the rate at which the car climbs, 0 without heights, and the slope for 1 m/s of it."""
    rise = _smoothed(np.asarray(log.signals.get("z", np.zeros(len(log)))), log.period, 1)
    way = _smoothed(speed, log.period, 0)
    drives = np.abs(way) > 0.3
    return rise, np.divide(1.0, way, out=np.zeros_like(way), where=drives)
