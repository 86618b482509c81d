"""The fit of the heading: gain, understeer, steering offset, lag, dead time, rate limit."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from popsteer.identification.chain import Chain, LagOf, Wheels
from popsteer.identification.whiten import (
    Error,
    Known,
    choose_theta,
    clipped_mean_square,
    known,
    noise_score,
    spread,
    whitened,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from popsteer.identification.drive import PreparedLog

    Array = NDArray[np.float64]

NAMES = ("turning_wheelbase", "understeer", "steer_offset", "steer_lag", "dead_time", "load_shift")
"""What is fitted, as `Chain.yaw` takes it; `max_steer_rate` where it was reached."""
LAGS: tuple[LagOf, ...] = ("yaw rate", "wheels", "tyres")
# The lowest and the highest value of each, and its scale.
_BOUNDS = {
    "turning_wheelbase": (0.01, 100.0, 1.0),
    "understeer": (-0.1, 1.0, 1e-3),
    "steer_offset": (-0.5, 0.5, 0.01),
    "steer_lag": (0.0, 2.0, 0.1),
    "dead_time": (0.0, 1.5, 0.1),
    "load_shift": (-0.1, 0.1, 1e-4),
    "max_steer_rate": (0.02, 20.0, 0.1),
}
_STEP = {"max_steer_rate": 0.03}
_RATES = (0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0, 1.5)
_DEAD_TIMES = (0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 0.8)
_LAGS = (0.03, 0.15)
TURNS = 3
"""How often the fit is made, with the noise that the last one showed."""
REACHED = 2.0
"""By how much a limit of the rate must raise the log-likelihood to stay: as two standard deviations
do."""
KEPT, CLEARLY = 1.0, 1.5
"""A limit of the rate is known if the wheels kept it for this time in all [s], where commands asked
for this many times as much. Else anything that the model lacks would make a limit of the fastest
turns of a smooth drive."""
LONGEST = 0.1
"""A command that comes later than this after the last [s] is a step."""
CLEAR = 10.0
"""By how much another structure must raise the log-likelihood."""
CLOSE = 100.0
"""A structure that is less likely by more than this [log-likelihood] is not followed up."""


@dataclass(frozen=True, eq=False)
class Fit:
    """What the heading says of the car."""

    values: dict[str, float]
    names: list[str]
    known: Known
    """How well, in the order of `names`."""
    lag_of: LagOf
    theta: float
    noise: float
    """Standard deviation of the innovations of the heading [rad]."""
    yaw: Array
    """Simulated heading at the samples [rad]."""
    wheels: Wheels
    """The simulated wheels, without dead time and offset."""
    rate_known: bool
    """Whether a limit of their rate is more than something that mends the fit."""

    @property
    def errors(self) -> dict[str, float]:
        """The whole error of each parameter that was fitted: of noise, and of the model."""
        return dict(zip(self.names, self.known.errors(), strict=True))

    def error_of(self, **weights: float) -> float:
        """Give the whole error of a weighted sum of parameters."""
        return self.known.error(self._row(weights))

    def split(self, **weights: float) -> Error:
        """Give the two parts of the error of a weighted sum of parameters."""
        return self.known.split(self._row(weights))

    def _row(self, weights: Mapping[str, float]) -> Array:
        return np.array([weights.get(name, 0.0) for name in self.names])

    def doubted(self, others: Sequence[Mapping[str, float]]) -> Fit:
        """Widen the errors by how far others lie off, that explain the log as well."""
        mine = self.values
        off = np.array([[each.get(k, mine[k]) - mine[k] for k in self.names] for each in others])
        # As one more deviation: what they agree in, like the sum of lag and dead time, stays sure.
        wider = self.known.covariance + (off.T @ off) / max(len(others), 1)
        return replace(self, known=self.known._replace(covariance=wider))


def fit(
    drive: PreparedLog,
    start: Mapping[str, float],
    fixed: Mapping[str, float],
    progress: Callable[[float], object] | None = None,
) -> Fit:
    """Fit the chain to the heading of a drive, and give the likeliest of what the lag may be of.

    `start` is where to begin, with a turning wheelbase at least; `fixed` is what is not fitted. A
    limit of the rate is fitted where the log shows one.
    """
    tasks = [_Task(drive, Chain(drive, lag_of), dict(fixed)) for lag_of in LAGS]
    found = []
    for count, task in enumerate(tasks):
        values = task.solve(task.first(start))
        found.append((task.unlikelihood(values), values))
        if progress is not None:
            progress(0.5 * (count + 1) / len(tasks))
    least = min(at for at, _ in found)
    tried = list(found)
    for count, task in enumerate(tasks):
        at, values = found[count]
        if at < least + CLOSE:
            limited = task.limited(values)
            tried.append((task.unlikelihood(limited), limited))
            if tried[-1][0] < at - REACHED:
                found[count] = tried[-1]
        if progress is not None:
            progress(0.5 + 0.5 * (count + 1) / len(tasks))
    # The plainest first: another must be clearly likelier, or chance would choose.
    best = 0
    for count in range(1, len(tasks)):
        if found[count][0] < found[best][0] - CLEAR:
            best = count
    at, values = found[best]
    # What else explains the log as well may say something else of lag and dead time.
    return tasks[best].report(values).doubted([other for near, other in tried if near < at + CLEAR])


class _Task:
    """One structure of the chain, and what is to be found in it."""

    def __init__(self, drive: PreparedLog, chain: Chain, fixed: dict[str, float]) -> None:
        self.drive, self.chain, self.fixed = drive, chain, fixed
        self.parts = drive.parts()
        self.theta, self.noise = 0.9, 0.002

    def error(self, values: Mapping[str, float]) -> Array:
        """Give what the simulation leaves of the measured heading [rad]."""
        left: Array = self.drive.yaw - self.chain.yaw(**values)
        return left

    def residual(self, values: Mapping[str, float]) -> Array:
        return whitened(self.error(values), self.parts, self.theta) / self.noise

    def cost(self, values: Mapping[str, float]) -> float:
        """Huber's loss of the residuals."""
        size = np.abs(self.residual(values))
        return float(np.sum(np.where(size < 2.0, 0.5 * size**2, 2.0 * size - 2.0)))

    def unlikelihood(self, values: Mapping[str, float]) -> float:
        """Give what compares structures, each with its own noise: the negative log-likelihood."""
        error = self.error(values)
        innovations = whitened(error, self.parts, choose_theta(error, self.parts))
        return 0.5 * len(innovations) * float(np.log(max(clipped_mean_square(innovations), 1e-18)))

    def first(self, start: Mapping[str, float]) -> dict[str, float]:
        """Choose where to begin: the best of a grid of dead times and lags."""
        base = {"understeer": 0.0, "steer_offset": 0.0, "load_shift": 0.0, **start, **self.fixed}
        grid = [
            {**base, "dead_time": d, "steer_lag": lag, **self.fixed}
            for d in _DEAD_TIMES
            for lag in _LAGS
        ]
        return min(grid, key=self.cost)

    def limited(self, values: dict[str, float]) -> dict[str, float]:
        """Fit with a limit of the rate, from the best of a row of limits."""
        if "max_steer_rate" in self.fixed:
            return values
        self.weigh(values)
        wheels = self.chain.wheels(values["steer_lag"])
        response = max(wheels.lag, self.drive.cell)
        fastest = float(np.max(np.abs(wheels.commands - wheels.angle))) / response
        best, at = self.cost(values), values
        trial = values
        for rate in sorted((rate for rate in _RATES if rate < fastest), reverse=True):
            with_rate = {**trial, "max_steer_rate": rate}
            trial = self._search(with_rate, [n for n in self.free(with_rate) if n in NAMES], 1e-3)
            cost = self.cost(trial)
            if cost < best:
                best, at = cost, trial
            elif cost > best + CLOSE:
                break
        return self.solve(at) if "max_steer_rate" in at else values

    def _excites_rate(self, values: Mapping[str, float]) -> bool:
        """Say whether the wheels kept the limit, while the commands clearly asked for more."""
        rate = values.get("max_steer_rate")
        if rate is None or "max_steer_rate" in self.fixed:
            return rate is not None
        wheels = self.chain.wheels(values["steer_lag"], rate)
        times, changes = wheels.times, np.diff(wheels.commands)
        between = np.diff(times[1:][changes != 0.0])
        interval = min(float(np.median(between)) if len(between) else LONGEST, LONGEST)
        asked = np.concatenate(([False], np.abs(changes) > CLEARLY * rate * interval))
        # A stretch at the limit ends with the first command that the wheels reach.
        reached = wheels.turning[:-1] < 0.999 * np.diff(times)
        stretch = np.concatenate(([0], np.cumsum(reached)))
        kept = np.bincount(stretch, wheels.turning)
        return float(kept[np.bincount(stretch, asked) > 0].sum()) >= KEPT

    def solve(self, values: dict[str, float]) -> dict[str, float]:
        """Fit from there, with the noise that the fit itself shows."""
        names = self.free(values)
        for turn in range(TURNS):
            values = self._search(values, names, 1e-5 if turn == TURNS - 1 else 1e-3)
            if turn < TURNS - 1:
                self.weigh(values)
        return values

    def _search(
        self, values: dict[str, float], names: list[str], tolerance: float
    ) -> dict[str, float]:
        """Fit some of the parameters, with the noise as it is."""
        from scipy.optimize import least_squares

        low, high, scale = np.transpose([_BOUNDS[name] for name in names])
        found = least_squares(
            lambda z: self.residual({**values, **_named(names, z)}),
            np.clip([values[name] for name in names], low + 1e-6 * scale, high),
            bounds=(low, high),
            x_scale=scale,
            # The wheels' rate bends the residuals: a short step would see a corner, not the slope.
            diff_step=[1e-2 if name == "max_steer_rate" else 1e-5 for name in names],
            loss="huber",
            f_scale=2.0,
            max_nfev=30,
            xtol=1e-5,
            ftol=tolerance,
        )
        return {**values, **_named(names, found.x)}

    def weigh(self, values: Mapping[str, float]) -> None:
        """Take noise and theta from what is left over."""
        error = self.error(values)
        self.theta = min(choose_theta(error, self.parts), self._theta_of_speeds(error))
        self.noise = max(spread(whitened(error, self.parts, self.theta)), 1e-9)

    def _theta_of_speeds(self, error: Array) -> float:
        """Give the theta of the speeds' noise alone: unseen in residuals, it bounds the gain."""
        drift = self._drift(error)
        steps = [slice(part.start, part.stop - 1) for part in self.parts]
        noise = np.concatenate([np.diff(error)[step] for step in steps])
        share = float(np.mean(np.concatenate([drift[step] for step in steps]) ** 2))
        share /= max(0.5 * spread(noise) ** 2, 1e-18)
        return 1.0 + 0.5 * share - float(np.sqrt(share + 0.25 * share * share))

    def _drift(self, error: Array) -> Array:
        """Give how far the noise s of the speeds lets the heading drift: s dt yaw'/v a sample."""
        speed = np.maximum(np.abs(self.drive.sample_speed[1:]), 0.3 * self.drive.size)
        drift: Array = np.diff(self.drive.yaw - error) / speed * self.drive.speed_noise
        return drift

    def free(self, values: Mapping[str, float]) -> list[str]:
        return [
            name for name in (*NAMES, "max_steer_rate") if name in values and name not in self.fixed
        ]

    def report(self, values: dict[str, float]) -> Fit:
        """Set out what was found, with its standard errors."""
        names = self.free(values)
        residual = self.residual(values)
        columns = []
        for name in names:
            low, _, scale = _BOUNDS[name]
            step = _STEP.get(name, 1e-3 * scale)
            # Forwards at a bound, where there is no other side.
            lower = values[name] - step if values[name] - step >= low else values[name]
            above = self.residual({**values, name: values[name] + step})
            below = self.residual({**values, name: lower})
            columns.append((above - below) / (values[name] + step - lower))
        jacobian = np.array(columns).T
        weight = np.minimum(1.0, 2.0 / np.maximum(np.abs(residual), 1e-12))
        # Innovations whose theta is not quite right are correlated as long as its powers last.
        longest = max(1.0, self.drive.usual_step / (1.0 - self.theta))
        memory = int(np.ceil(longest / self.drive.usual_step))
        root = np.sqrt(weight)
        error = self.error(values)
        theta = choose_theta(error, self.parts)
        sample = np.sqrt(theta) * spread(whitened(error, self.parts, theta)) / self.noise
        score = noise_score(
            jacobian * weight[:, None],
            self.parts,
            self.theta,
            sample,
            self._drift(error) / self.noise,
        )
        return Fit(
            values=values,
            names=names,
            known=known(jacobian * root[:, None], residual * root, memory, score),
            lag_of=self.chain.lag_of,
            theta=self.theta,
            noise=self.noise,
            yaw=self.chain.yaw(**values),
            wheels=self.chain.wheels(values["steer_lag"], values.get("max_steer_rate")),
            rate_known=self._excites_rate(values),
        )


def _named(names: list[str], point: Array) -> dict[str, float]:
    return dict(zip(names, map(float, point), strict=True))
