"""Residuals made white: what is left of a measured signal that a simulation explains in part.

The noise of a pose is independent from sample to sample; the errors of the simulation accumulate,
as a random walk. Their sum, differenced, is a moving average of first order (an IMA(1,1) process):

    e_k - e_{k-1} = w_k - theta w_{k-1}

whose innovations w are white. theta near 1: the pose's noise outweighs the model's error; 0: the
other way round. Least squares of w are the prediction error method (L. Ljung, *System
Identification*, 2nd ed., 1999, chapter 7), and their standard errors are the usual ones.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from popsteer.identification.arrays import recursion

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from popsteer.identification.drive import Array, PreparedLog

THETAS = (0.0, 0.3, 0.5, 0.65, 0.75, 0.8, 0.85, 0.9, 0.93, 0.95, 0.97, 0.98, 0.99, 0.995, 0.998)
"""What is tried for theta."""

_NOTHING = 1e-11
"""A direction with less of the information than this share of the greatest is not excited: 1e-5 of
a derivative are the errors of its differences."""
_GONE = 1e-9
"""Below it theta^k counts for nothing; numbers that are smaller still are slow to multiply."""
LEFT = 0.2
"""The share of the variance of rounding that a fit leaves in the heading: it takes up the rest."""
UNSURE = -1.0
"""Commands in steps were rounded unless the log-likelihood of that is below this."""


def whitened(error: Array, parts: Sequence[slice], theta: float) -> Array:
    """Give the innovations of an error, (N,) or (N, M) by samples, one part after the other."""
    steps = np.concatenate([np.diff(error[part], axis=0) for part in parts])
    firsts = _firsts(parts)
    kept = np.full(len(steps), theta)
    kept[firsts[:-1]] = 0.0
    white = recursion(kept, steps)
    # The first sample has noise too, which goes on as theta^k: what looks like it is taken out.
    powers = theta ** np.arange(1 if theta == 0.0 else int(np.ceil(np.log(_GONE) / np.log(theta))))
    for first, end in pairwise(firsts):
        head = white[first : min(end, first + len(powers))]
        start = powers[: len(head)] / np.linalg.norm(powers[: len(head)])
        head -= np.multiply.outer(start, start @ head)
    return white


def _firsts(parts: Sequence[slice]) -> list[int]:
    """Give where the steps of each part begin, and where the last ones end."""
    return [0, *np.cumsum([part.stop - part.start - 1 for part in parts]).tolist()]


def choose_theta(error: Array, parts: Sequence[slice], least: float = 0.0) -> float:
    """Give the theta with the least innovations, which is the likeliest.

    Of the parabola through the least of a row and its neighbours: errors would leap with the row.
    A sample's own noise has theta times the innovations' variance (J. Muth, *J. Amer. Statist.
    Assoc.* 55, 1960), and that of digits is known (B. Widrow and I. Kollár, *Quantization Noise*,
    2008), though digits that repeat look like no noise: theta is not below where it is `least`.
    """
    sizes = [clipped_mean_square(whitened(error, parts, theta)) for theta in THETAS]
    own = np.maximum.accumulate(np.multiply(THETAS, sizes))
    best = min(max(int(np.argmin(sizes)), 1), len(THETAS) - 2)
    left, lowest, right = sizes[best - 1 : best + 2]
    bend = max(left - 2.0 * lowest + right, 1e-300)
    off = min(max(0.5 * (left - right) / bend, -1.0), 1.0)
    likeliest = np.interp(best + off, range(len(THETAS)), THETAS)
    return float(max(likeliest, np.interp(least**2, own, THETAS)))


def theta_of(drift: float, sample: float) -> float:
    """Give the theta of what drifts by the variance `drift` a sample, with noise of `sample`."""
    share = drift / sample
    return 1.0 + 0.5 * share - math.sqrt(share + 0.25 * share * share)


def spread(values: Array) -> float:
    """Give the standard deviation of noise in which there are outliers."""
    return float(1.4826 * np.median(np.abs(values - np.median(values))))


def clipped_mean_square(values: Array) -> float:
    """Give the mean square, with each value clipped to three standard deviations."""
    deviation = spread(values)
    if deviation == 0.0:
        return float(np.mean(values**2))
    return float(np.mean(np.minimum(values**2, 9.0 * deviation**2)))


class Error(NamedTuple):
    """How far an estimate may be off; the two are independent."""

    noise: float
    """Standard error: how far new noise on the same drive would scatter the estimate."""
    model: float
    """What the residuals show beyond noise, and what else explains the log."""

    def wider(self, off: float) -> Error:
        """Give it with a further part of the model."""
        return Error(self.noise, math.hypot(self.model, off))


class Known(NamedTuple):
    """How well least squares know their parameters."""

    covariance: Array
    """Of the directions that were excited, (P, P)."""
    noise: Array
    """The part of it that noise alone makes, (P, P)."""
    unknown: Array
    """Directions that were not, (P, K), in the parameters over `scale`."""
    scale: Array
    """The length of each parameter's derivatives, (P,)."""

    def error(self, weights: Array) -> float:
        """Give the standard error of a weighted sum of the parameters; infinite if not excited."""
        scaled = weights / self.scale
        if np.any(np.abs(scaled @ self.unknown) > 1e-3 * np.linalg.norm(scaled)):
            return math.inf
        return math.sqrt(max(float(weights @ self.covariance @ weights), 0.0))

    def split(self, weights: Array) -> Error:
        """Give the two parts of the error of a weighted sum of the parameters."""
        total = self.error(weights)
        if total == math.inf:
            return Error(math.inf, math.inf)
        noise = math.sqrt(max(float(weights @ self.noise @ weights), 0.0))
        # What is no more than the digits of the difference is none.
        return Error(
            noise, total * math.sqrt(max(1.0 - (noise / max(total, 1e-300)) ** 2 - 1e-9, 0.0))
        )

    def errors(self) -> list[float]:
        """Give the standard error of each parameter."""
        return [self.error(row) for row in np.eye(len(self.covariance))]


def influence(jacobian: Array, parts: Sequence[slice], theta: float) -> list[Array]:
    """Give what each step of the error from sample to sample adds to J^T w, (K, P) for each part.

    w are the innovations, and `jacobian` theirs, (K, P).
    """
    # The transposed filter, backwards in time.
    pieces = np.split(jacobian, _firsts(parts)[1:-1])
    return [recursion(theta, piece[::-1])[::-1] for piece in pieces]


def noise_score(
    added: Sequence[Array], parts: Sequence[slice], sample: float, steps: Array
) -> Array:
    """Give the covariance of J^T w, (P, P), that noise alone makes of the innovations w.

    `added` is their `influence`. Each sample of the error has noise of its own, of the deviation
    `sample`; what is added from one to the next, of the deviations `steps`, stays.
    """
    total = np.zeros((added[0].shape[1],) * 2)
    for step, part in zip(added, parts, strict=True):
        ends = np.zeros((1, step.shape[1]))
        own = sample * np.diff(step, axis=0, prepend=ends, append=ends)
        stays = step * steps[part.start : part.stop - 1, None]
        total += own.T @ own + stays.T @ stays
    return total


def turned_by(drive: PreparedLog, values: Mapping[str, float]) -> tuple[NDArray[np.int64], Array]:
    """Give which recorded command turns the car at each step, and by how much for a radian of it.

    Commands are numbered by their value.
    """
    level = np.unique(drive.recorded, return_inverse=True)[1]
    delayed = drive.t[:-1] - values["dead_time"] - values["steer_lag"]
    level = level[np.clip(np.searchsorted(drive.times, delayed, side="right") - 1, 0, None)]
    length = values["turning_wheelbase"] + values["understeer"] * drive.sample_speed**2
    return level, (drive.sample_speed / np.maximum(length, 1e-3))[:-1] * np.diff(drive.t)


def rounding_score(
    drive: PreparedLog,
    values: Mapping[str, float],
    error: Array,
    noise: tuple[float, float],
    added: list[Array],
) -> tuple[float, Array]:
    """Give the step to which commands were rounded [rad], and the S that it makes of J^T w.

    An error in the variables that is one number for each recorded command, of q²/12: a car that
    turns by the same angle each time is misled the same way each time. Those of opposite commands
    may agree or oppose each other, twice the sum of both bounds either. Nothing was rounded where
    the heading keeps to commands that jump: then they are those of a program. `noise` is that of a
    sample and of the innovations, `added` their influence.
    """
    step, (sample, innovation) = drive.steer_step, noise
    level, turn = turned_by(drive, values)
    total, size = np.zeros((np.max(level) + 1, added[0].shape[1])), step * step / 12.0
    stretches = []
    for piece, part in zip(added, drive.parts(), strict=True):
        rows = slice(part.start, part.stop - 1)
        np.add.at(total, level[rows], piece * turn[rows, None] / innovation)
        # The heading's error over each stretch of one command, by how far a radian turns it.
        starts = np.flatnonzero(np.diff(level[rows], prepend=-1))
        stretches.append(np.add.reduceat((np.diff(error[part]), turn[rows]), starts, axis=1))
    off, gain = np.concatenate(stretches, axis=1) ** 2
    noise_alone = 2.0 * sample**2
    with_rounding = noise_alone + LEFT * size * gain
    more = np.log(with_rounding / noise_alone) - off / noise_alone + off / with_rounding
    shown = -0.5 * float(np.sum(more)) > UNSURE  # the likelihood ratio
    if shown or drive.commands is not drive.recorded:
        return step, 2.0 * size * total.T @ total
    return 0.0, 0.0 * total.T @ total


def known(
    jacobian: Array,
    residual: Array,
    memory: int,
    noise: Array | None = None,
    prior: Array | None = None,
    rounding: Array | None = None,
) -> Known:
    """Tell how well least squares know their parameters, where residuals are slightly correlated.

    The sandwich H^-1 S H^-1 with H = J^T J and Newey's and West's S over `memory` samples: right
    too where the model is not quite what the car is. `jacobian` is (K, P), `residual` (K,). No
    error is below that of `noise`, (P, P), the S of `noise_score`, or else of white residuals.
    `prior`, (P,), is the inverse deviation of what is believed before, 0 for nothing. `rounding`,
    (P, P), is the S of errors that stay for long, which neither of the two shows.
    """
    scale = np.linalg.norm(jacobian, axis=0)
    scale[scale == 0.0] = 1.0
    scaled, units = jacobian / scale, np.outer(scale, scale)
    before = np.zeros(len(scale)) if prior is None else (prior / scale) ** 2
    information, directions = np.linalg.eigh(scaled.T @ scaled + np.diag(before))
    excited = information > _NOTHING * max(float(information[-1]), 1e-300)
    inverse = (directions[:, excited] / information[excited]) @ directions[:, excited].T
    score = scaled * residual[:, None]
    middle = score.T @ score
    for lag in range(1, memory + 1):
        weight = 1.0 - lag / (memory + 1)
        cross = score[lag:].T @ score[:-lag]
        middle += weight * (cross + cross.T)
    found = inverse @ middle @ inverse
    # Newey and West do not see what is correlated for longer, and may be small by chance.
    if noise is None:
        least = inverse * float(np.mean(residual**2))
    else:
        least = inverse @ (noise / units) @ inverse
    grow = np.sqrt(np.maximum(1.0, np.diag(least) / np.maximum(np.diag(found), 1e-300)))
    found *= np.outer(grow, grow)
    if rounding is not None:
        found += inverse @ (rounding / units) @ inverse
    return Known(found / units, least / units, directions[:, ~excited], scale)
