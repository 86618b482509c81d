"""The fit of the heading: gain, understeer, offset, lag, dead time, rate limit and play, jointly.

The likeliest parameters under a wide prior around what was given (maximum a posteriori): what the
log does not show stays there, and none takes up the misfit of another. Structures are compared by
Schwarz's criterion, and those that explain the log as well widen the errors (Bayesian model
averaging; J. Hoeting et al., *Statistical Science* 14, 1999).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from popsteer.identification.arrays import huber
from popsteer.identification.chain import Chain, LagOf, kept
from popsteer.identification.whiten import (
    Error,
    Known,
    choose_theta,
    clipped_mean_square,
    influence,
    known,
    noise_score,
    rounding_score,
    spread,
    theta_of,
    whitened,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from popsteer._core import _Wheels
    from popsteer.identification.drive import PreparedLog

    Array = NDArray[np.float64]

Values = dict[str, float]

NUISANCES = ("load_shift", "front_slip", "tyre_lag")
"""What tyres do beyond what a vehicle keeps."""
NAMES = ("turning_wheelbase", "understeer", "steer_offset", "steer_lag", "dead_time", "load_shift")
"""What is always fitted, as `Chain.yaw` takes it; and what only if it makes the log likelier."""
GROWN = ("front_slip", "tyre_lag", "max_steer_rate", "steer_play")
LAGS: tuple[LagOf, ...] = ("wheels", "yaw rate", "tyres")
"""What the lag may be of; the vehicle's own chain is the first."""
# The lowest and the highest value of each, its scale, and the step of its derivative over that.
_BOUNDS = {
    "turning_wheelbase": (0.01, 100.0, 1.0, 1e-3),
    "understeer": (-0.1, 1.0, 1e-3, 1e-3),
    "steer_offset": (-0.5, 0.5, 0.01, 1e-3),
    "steer_lag": (0.0, 2.0, 0.1, 1e-3),
    "dead_time": (0.0, 1.5, 0.1, 1e-3),
    "load_shift": (-0.1, 0.1, 1e-4, 1e-3),
    "front_slip": (0.0, 0.1, 1e-3, 1e-2),
    "tyre_lag": (0.0, 1.0, 0.05, 1e-3),
    # Both bend the residuals: a short step would see a corner, not the slope.
    "max_steer_rate": (0.02, 20.0, 0.1, 0.3),
    "steer_play": (0.0, 0.2, 0.01, 0.1),
    "steer_scale": (0.02, 2.0, 1.0, 1e-2),
}
_ABSENT = {"max_steer_rate": 1e3, "steer_scale": 1.0}
_CORNERS = GROWN[2:]
_TYRES = {"front_slip": 0.005, "tyre_lag": 0.03}
"""Where the fit of what tyres do begins."""
_RATES = (0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0, 1.5)
_PLAYS = (0.005, 0.015, 0.04)
_DEAD_TIMES = (0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 0.8)
_LAGS = (0.03, 0.15)
_STARTS = [{"dead_time": delay, "steer_lag": lag} for delay in _DEAD_TIMES for lag in _LAGS]
TURNS = 3
"""How often the fit is made, with the noise that the last one showed."""
KEPT = 1.0
"""A limit of the rate is stated if the wheels kept it for this time in all [s]: were seen at it."""
RATIO, NARROWED = 1.5, 6
"""Around the best of a row, up to this many times as much and as little, so many values more are
tried: both bend the residuals, and a fit that starts farther off may stay at a corner."""
CLOSE = 100.0
"""A structure that is less likely by more than this [log-likelihood] is not followed up."""
SURE = 8.0
"""By how much play must raise the log-likelihood beyond the criterion, to be stated."""


@dataclass(frozen=True, eq=False)
class Fit:
    """What the heading says of the car."""

    values: Values
    names: list[str]
    known: Known
    """How well, in the order of `names`."""
    lag_of: LagOf
    theta: float
    noise: float
    """Standard deviation of the innovations of the heading [rad]."""
    yaw: Array
    """Simulated heading at the samples [rad]."""
    place: NDArray[np.complex128]
    """Simulated place of the no-slip point there, east + i north [m]."""
    wheels: _Wheels
    """The simulated wheels, without dead time and offset."""
    jacobian: Array
    """Of the weighted residuals, (K, P), and the roots of their weights, (K,)."""
    root: Array
    share: float
    """The share of the log-likelihood that counts, as residuals are correlated: the mean of the
    information over the sandwich's (A. Rotnitzky and N. Jewell, *Biometrika* 77, 1990)."""
    rate_seen: bool
    """Whether the wheels were seen against a limit of their rate."""
    play_seen: bool
    """Whether no structure without play explains the log nearly as well."""
    rounded: float
    """The step to which the commands were rounded [rad]; 0 where noise hides it."""
    candidates: tuple[Candidate, ...]
    """What explains the log, the likeliest first; it is that which was chosen."""

    @property
    def errors(self) -> Values:
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

    def scaled(self, error: float) -> Fit:
        """Widen the errors by that of the speed's scale: as its share, all lengths are off."""
        share = {"turning_wheelbase": 1.0, "understeer": -1.0}
        off = np.array([share.get(name, 0.0) * self.values[name] * error for name in self.names])
        wider = self.known.covariance + np.outer(off, off)
        return replace(self, known=self.known._replace(covariance=wider))

    def profile(self, name: str, points: Sequence[float], **along: float) -> list[float]:
        """Give the log-likelihood with a parameter at some values, below that of the estimate.

        The others are fitted anew, by one step of Gauss and Newton, from where those of `along` are
        in proportion to the parameter.
        """
        task, kept = self.candidates[0].task, [each != name for each in self.names]
        others = self.jacobian[:, kept]
        found = []
        for point in [self.values.get(name, _ABSENT.get(name, 0.0)), *points]:
            moved = {key: value * point for key, value in along.items()}
            left = self.root * task.residual({**self.values, **moved, name: point})
            left = left - others @ np.linalg.lstsq(others, left, rcond=1e-9)[0]
            found.append(-0.5 * self.share * float(left @ left))
        return [each - found[0] for each in found[1:]]


def fit(
    drive: PreparedLog,
    start: Mapping[str, float],
    fixed: Mapping[str, float],
    prior: Mapping[str, tuple[float, float]],
    progress: Callable[[float], object] | None = None,
) -> Fit:
    """Fit the chain to the heading of a drive, and give the likeliest structure.

    `start` is where to begin, with a turning wheelbase at least; `fixed` is what is not fitted,
    `prior` the mean and the deviation of what is believed before.
    """
    own = Task(drive, Chain(drive, LAGS[0]), dict(fixed), dict(prior))
    plain = own.solve(own.first(start))
    if drive.commands is not drive.recorded:  # were they rounded, or given in steps?
        stairs = replace(drive, commands=drive.recorded)
        stepped = Task(stairs, Chain(stairs, LAGS[0]), own.fixed, own.prior)
        stepped.length = own.length
        other = stepped.solve(plain)
        # As many parameters: what leaves less is likelier, even below the least noise.
        if stepped.left(other)[0] < own.left(plain)[0]:
            own, plain = stepped, other
    tried = [own.candidate(plain)]
    _grow(tried)
    if progress is not None:
        progress(0.5)
    # What the lag is of shows only once rate and play are no misfit any more, and they only then.
    starts = [plain] if len(tried) == 1 else [plain, dict(min(tried, key=_criterion).values)]
    starts[-1].pop("tyre_lag", None)
    drive = own.drive
    others = [Task(drive, Chain(drive, lag_of), own.fixed, own.prior) for lag_of in LAGS[1:]]
    tried += [each.candidate(each.solve(values)) for each in others for values in starts]
    if progress is not None:
        progress(0.7)
    best = _grow(tried)
    for name in [name for name in best.task.free(best.values) if name in GROWN]:
        less = {key: value for key, value in best.values.items() if key != name}
        tried.append(best.task.candidate(best.task.solve(less)))
    found = _chosen(tried)
    if found.play_seen and not drive.play:
        return fit(replace(drive, play=found.values["steer_play"]), start, fixed, prior)
    return found


def _grow(tried: list[Candidate]) -> Candidate:
    """Add what tyres do, a limit of the rate, and play, to the likeliest in turn; give that."""
    for name in (*GROWN, "max_steer_rate"):
        _, task, values = min(tried, key=_criterion)
        more = values if name in values else task.grown(values, name)
        if len(more) > len(values):
            tried.append(task.candidate(more))
    return min(tried, key=_criterion)


def refit(found: Fit, fixed: Mapping[str, float]) -> Fit:
    """Fit what explains the log once more, with other parameters fixed besides."""
    tried = []
    for near, old, values in found.candidates:
        if near < found.candidates[0].criterion + SURE:
            task = Task(old.drive, old.chain, {**old.fixed, **fixed}, old.prior)
            task.theta, task.noise, task.length = old.theta, old.noise, old.length
            tried.append(task.candidate(task.solve({**values, **fixed})))
    return replace(_chosen(tried), play_seen=found.play_seen)


def _chosen(tried: Sequence[Candidate]) -> Fit:
    """Report the likeliest; how far the others lie off widens its errors, each by its weight."""
    reference = min(tried, key=_criterion)
    reference.task.weigh(reference.values)
    share = reference.task.report(reference.values).share
    tried = sorted((each.against(reference.task, share) for each in tried), key=_criterion)
    best = tried[0]
    found = best.task.report(best.values)
    mine = found.values
    off = [[each.values.get(k, mine[k]) - mine[k] for k in found.names] for each in tried[1:]]
    weight = np.array([math.exp(best.criterion - each.criterion) for each in tried[1:]])
    shift = (
        np.array(off).reshape(len(weight), len(found.names))
        * np.sqrt(weight / (1.0 + weight.sum()))[:, None]
    )
    # As one more deviation: what they agree in, like the sum of lag and dead time, stays sure.
    wider = found.known.covariance + shift.T @ shift
    plain = [each.criterion for each in tried if "steer_play" not in each.values]
    return replace(
        found,
        known=found.known._replace(covariance=wider),
        candidates=tuple(tried),
        play_seen="steer_play" in mine and min(plain, default=math.inf) > best.criterion + SURE,
    )


_criterion = attrgetter("criterion")


class Candidate(NamedTuple):
    """One structure that was fitted."""

    criterion: float
    """Half of Schwarz's: the negative log-likelihood, and what parameters cost."""
    task: Task
    values: Values

    def against(self, other: Task, share: float) -> Candidate:
        """Judge it by the noise of another task, and by the share of the likelihood that counts."""
        self.task.theta, self.task.noise = other.theta, other.noise
        count = share * sum(part.stop - part.start - 1 for part in self.task.parts)
        price = 0.5 * len(self.task.free(self.values)) * math.log(count)
        price += float(self.task.chain.lag_of != LAGS[0])  # the vehicle's own chain of equal ones
        return self._replace(criterion=share * self.task.cost(self.values) + price)


class Task:
    """One structure of the chain, and what is to be found in it."""

    def __init__(
        self,
        drive: PreparedLog,
        chain: Chain,
        fixed: Values,
        prior: dict[str, tuple[float, float]],
    ) -> None:
        self.drive, self.chain, self.fixed, self.prior = drive, chain, fixed, prior
        self.parts = drive.parts()
        self.theta, self.noise, self.length = 0.9, 0.002, 2.7

    def error(self, values: Values) -> Array:
        """Give what the simulation leaves of the measured heading [rad]."""
        left: Array = self.drive.yaw - self.chain.yaw(**values)
        return left

    def residual(self, values: Values) -> Array:
        """Give the innovations of the heading, over their deviation."""
        return whitened(self.error(values), self.parts, self.theta) / self.noise

    def _beliefs(self, values: Values) -> Array:
        """Give how far the parameters are from what is believed before, in deviations."""
        prior = {k: each for k, each in self.prior.items() if k not in self.fixed}
        return np.array([(values.get(k, mean) - mean) / s for k, (mean, s) in prior.items()])

    def cost(self, values: Values) -> float:
        """Huber's loss of the residuals, and the square of the beliefs."""
        size = np.abs(self.residual(values))
        loss = float(np.sum(np.where(size < 2.0, 0.5 * size**2, 2.0 * size - 2.0)))
        return loss + 0.5 * float(np.sum(self._beliefs(values) ** 2))

    def criterion(self, values: Values) -> float:
        """Give half of Schwarz's criterion: the negative log-likelihood, and what parameters cost.

        Each structure has its own noise, none less than the log could have.
        """
        size, count = self.left(values)
        size = max(size, self.drive.least_noise["yaw"] ** 2)
        return 0.5 * (count * math.log(size) + len(self.free(values)) * math.log(count))

    def left(self, values: Values) -> tuple[float, int]:
        """Give the mean square of the innovations [rad²] with their own theta, and their number."""
        error = self.error(values)
        innovations = whitened(error, self.parts, self.choose_theta(error))
        return clipped_mean_square(innovations), len(innovations)

    def candidate(self, values: Values) -> Candidate:
        """Give a solution with its criterion."""
        return Candidate(self.criterion(values), self, values)

    def first(self, start: Mapping[str, float]) -> Values:
        """Choose where to begin: the best of a grid of dead times and lags."""
        self.length = start["turning_wheelbase"]
        base = {**dict.fromkeys(NAMES, 0.0), **start, **self.fixed}
        return min(({**base, **each, **self.fixed} for each in _STARTS), key=self.cost)

    def grown(self, values: Values, name: str) -> Values:
        """Fit with one of `GROWN` besides; as without it where that is no likelier."""
        if name == "tyre_lag" and self.chain.lag_of != LAGS[0]:
            return values  # all of the lag is behind the wheels
        if name in _TYRES:
            return self.solve({**values, name: _TYRES[name]})
        if name == "steer_play":
            return self._added(values, name, _PLAYS)
        # A limit that is not in the fit yet may be taken for lag.
        wheels = self.chain.wheels(min(values["steer_lag"], _LAGS[-1]))
        response = max(wheels.lag, self.drive.cell)
        fastest = float(np.max(np.abs(wheels.commands - wheels.angle))) / response
        rates = sorted((rate for rate in _RATES if rate < fastest), reverse=True)
        return self._added(values, name, rates)

    def _added(self, values: Values, name: str, trials: Sequence[float]) -> Values:
        """Fit with one more, from the best of a row of values; between them by its profile."""
        from scipy.optimize import minimize_scalar

        self.weigh(values)
        best, at, trial = self.cost(values), values, values
        others = self.free(values)
        for value in trials:
            begun = [{**trial, name: value}]
            if name == "max_steer_rate":  # what was lag until now may be all of the limit's
                grid = (self._scaled({**begun[0], **each}) for each in _STARTS)
                begun.append(min(grid, key=self.cost))
            trial = min((self.search(each, others, 1e-3) for each in begun), key=self.cost)
            cost = self.cost(trial)
            if cost < best:
                best, at = cost, trial
            elif cost > best + CLOSE:
                break
        if name not in at:
            return values
        found = [at]

        def profile(value: float) -> float:
            found.append(self.search({**found[-1], name: value}, others, 1e-3))
            return self.cost(found[-1])

        around = at[name] / RATIO, at[name] * RATIO
        minimize_scalar(profile, bounds=around, method="bounded", options={"maxiter": NARROWED})
        return self.solve(min(found, key=self.cost))

    def _scaled(self, values: Values) -> Values:
        """Give the values with the length by which the simulated heading turns as the measured."""
        _, slope = self.drive.explained(self.chain.yaw(**values))
        length = float(np.clip(values["turning_wheelbase"] / max(slope, 1e-3), 0.02, 90.0))
        return {**values, "turning_wheelbase": length}

    def solve(self, values: Values) -> Values:
        """Fit from there, with the noise that the fit itself shows."""
        names = self.free(values)
        for turn in range(TURNS):
            values = self.search(values, names, 1e-5 if turn == TURNS - 1 else 1e-3)
            if turn < TURNS - 1:
                self.weigh(values)
        return values

    def search(self, values: Values, names: list[str], tolerance: float) -> Values:
        """Fit some of the parameters, with the noise as it is."""
        from scipy.optimize import least_squares

        low, high, scale, _ = np.transpose([_BOUNDS[name] for name in names])

        def at(z: Array) -> Values:
            return {**values, **dict(zip(names, map(float, z), strict=True))}

        def residual(z: Array) -> Array:
            return np.concatenate((self.residual(at(z)), self._beliefs(at(z))))

        found = least_squares(
            residual,
            np.clip([values[name] for name in names], low + 1e-6 * scale, high),
            bounds=(low, high),
            x_scale=scale,
            diff_step=[1e-2 if name in _CORNERS else 1e-5 for name in names],
            loss="huber",
            f_scale=2.0,
            max_nfev=30,
            xtol=1e-5,
            ftol=tolerance,
        )
        return at(found.x)

    def weigh(self, values: Values) -> None:
        """Take noise and theta from what is left over."""
        error = self.error(values)
        self.theta = min(self.choose_theta(error), self.theta_of_noise(error))
        least = self.drive.least_noise["yaw"]
        self.noise = max(spread(whitened(error, self.parts, self.theta)), least)

    def choose_theta(self, error: Array) -> float:
        """Give the likeliest theta of what is left."""
        return choose_theta(error, self.parts, self.drive.least_noise["yaw"])

    def theta_of_noise(self, error: Array) -> float:
        """Give the theta of the signals' noise alone: unseen in residuals, it bounds the gain."""
        drift = self.drive.drift(error, self.length)
        steps = [slice(part.start, part.stop - 1) for part in self.parts]
        noise = np.concatenate([np.diff(error)[step] for step in steps])
        drifts = float(np.mean(np.concatenate([drift[step] for step in steps]) ** 2))
        return theta_of(drifts, max(0.5 * spread(noise) ** 2, self.drive.least_noise["yaw"] ** 2))

    def free(self, values: Values) -> list[str]:
        """Name what is fitted of these."""
        names = (*NAMES, *GROWN, "steer_scale")
        return [name for name in names if name in values and name not in self.fixed]

    def report(self, values: Values) -> Fit:
        """Set out what was found, with its standard errors."""
        names = self.free(values)
        residual = self.residual(values)
        columns = []
        for name in names:
            low, _, scale, share = _BOUNDS[name]
            step = share * scale
            if name == "max_steer_rate":
                step = 0.03 * values[name] / 0.3
            # Forwards at a bound, where there is no other side.
            lower = values[name] - step if values[name] - step >= low else values[name]
            above = self.residual({**values, name: values[name] + step})
            below = self.residual({**values, name: lower})
            columns.append((above - below) / (values[name] + step - lower))
        jacobian = np.array(columns).T
        root = huber(residual, 2.0)
        weighted = jacobian * root[:, None]
        # Innovations whose theta is not quite right are correlated as long as its powers last.
        longest = max(1.0, self.drive.usual_step / (1.0 - self.theta))
        memory = int(np.ceil(longest / self.drive.usual_step))
        error = self.error(values)
        theta = self.choose_theta(error)
        least = self.drive.least_noise["yaw"]
        sample = max(np.sqrt(theta) * spread(whitened(error, self.parts, theta)), least)
        added = influence(weighted * root[:, None], self.parts, self.theta)
        drift = self.drive.drift(error, self.length) / self.noise
        score = noise_score(added, self.parts, sample / self.noise, drift)
        rounded, rounding = rounding_score(self.drive, values, error, (sample, self.noise), added)
        # What the vehicle does not keep is believed to be as far as its prior says.
        nuisance = np.array([1.0 / self.prior[n][1] if n in NUISANCES else 0.0 for n in names])
        sure = known(weighted, residual * root, memory, score, nuisance, rounding)
        spent = float(np.sum((weighted @ sure.covariance) * weighted))
        lag, tyres = values["steer_lag"], values.get("tyre_lag", 0.0)
        wheels = self.chain.wheels(lag - tyres, values.get("max_steer_rate"))
        return Fit(
            values=values,
            names=names,
            known=sure,
            share=min(1.0, len(names) / max(spent, 1e-12)),
            lag_of="tyres" if tyres > 0.5 * lag else self.chain.lag_of,
            theta=self.theta,
            noise=self.noise,
            yaw=self.chain.yaw(**values),
            place=self.chain.place(**values),
            wheels=wheels,
            jacobian=weighted,
            root=root,
            rate_seen="max_steer_rate" in self.fixed or kept(wheels) >= KEPT,
            play_seen=False,
            rounded=rounded if np.any(np.diag(rounding) > np.diag(score)) else 0.0,
            candidates=(),
        )
