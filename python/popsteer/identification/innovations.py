"""Whether a vehicle explains a log: a test of its innovations, and what the drive excited."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from popsteer.identification.arrays import stretches, summed
from popsteer.identification.whiten import spread, turned_by, whitened

if TYPE_CHECKING:
    from popsteer.identification.drive import Array, PreparedLog
    from popsteer.identification.fit import Fit

RISK = 1e-3
"""How often a test may find something in white noise."""
NOTABLE = 1.3
"""A band with less than this times the noise is none that matters: noise is seldom quite white."""
CORRELATED = 0.05
"""Nor does a smaller correlation."""
LONGEST = 2.0
"""Up to which lag what is left is compared with the turning before it [s]."""


class Octave(NamedTuple):
    """The power of the innovations in an octave, over that of white noise."""

    low: float
    """Its ends [Hz]."""
    high: float
    power: float
    most: float
    """What noise alone does not reach."""


def unexplained(found: Fit, drive: PreparedLog) -> tuple[tuple[str, ...], tuple[Octave, ...]]:
    """Say what the innovations have that the noise of the signals has not, and give their octaves.

    They are those of the signals' own noise, not of what the fit leaves, so that a misfit is not
    taken for noise. Their power in each octave against white noise (a chi-squared distribution),
    and their correlation with the turning before them (L. Ljung, *System Identification*, 2nd ed.,
    1999, chapter 16).
    """
    task = found.candidates[0].task
    error = drive.yaw - found.yaw
    theta = task.theta_of_noise(error)
    white = whitened(error, task.parts, theta)
    sample = _sample_noise(error, drive)
    white = np.clip(white * math.sqrt(theta) / sample, -4.0, 4.0)
    if found.rounded:
        known = _rounding(found, drive, theta) * theta / sample**2
        white = np.fft.irfft(np.fft.rfft(white) / np.sqrt(1.0 + known), len(white))
    octaves, said = _octaves(white, drive.usual_step), []
    loud = max(octaves, key=lambda each: each.power / each.most, default=None)
    if loud is not None and loud.power > loud.most:
        said.append(
            f"between {loud.low:.2g} and {loud.high:.2g} Hz it leaves"
            f" {math.sqrt(loud.power):.1f} times the noise"
        )
    turning = whitened(found.yaw, task.parts, theta)
    correlation, lag = _most_correlated(white, turning, drive.usual_step)
    if correlation > max(CORRELATED, math.sqrt(-2.0 * math.log(RISK) / len(white))) and (
        float(np.std(white)) > 0.5
    ):
        said.append(
            f"{100.0 * correlation**2:.2g} % of what it leaves goes with how the car turned"
            f" {lag:.2g} s before"
        )
    return tuple(said), tuple(octaves)


def _rounding(found: Fit, drive: PreparedLog, theta: float) -> Array:
    """Give the power that rounded commands leave in the innovations, frequency by frequency.

    Each recorded command is off by a number of its own, as `rounding_score` has it.
    """
    level, turn = turned_by(drive, found.values)
    total = np.zeros(1)
    for each in np.unique(level):
        error = whitened(summed(turn * (level == each)), drive.parts(), theta)
        total = total + np.abs(np.fft.rfft(error)) ** 2 / len(error)
    return total * found.rounded**2 / 12.0


def _sample_noise(error: Array, drive: PreparedLog) -> float:
    """Give the noise of a sample by the second differences of what is left [rad].

    By their mean square: most of them are small where digits repeat.
    """
    least = drive.least_noise["yaw"]
    ends = np.concatenate([np.diff(error[part], 2) for part in drive.parts()]) / math.sqrt(6.0)
    most = 4.0 * max(spread(ends), least)
    return max(math.sqrt(float(np.mean(np.clip(ends, -most, most) ** 2))), least)


def _octaves(white: Array, step: float) -> list[Octave]:
    """Give the octaves of innovations that are white noise of deviation 1."""
    from scipy.special import chdtri

    power = np.abs(np.fft.rfft(white)[1:]) ** 2 / len(white)
    hz, high, found = 1.0 / (len(white) * step), len(power), []
    count = max(1, int(math.log2(len(power))) - 1)
    while high >= 4:
        low = high // 2
        freedom = 2 * (high - low)
        most = max(float(chdtri(freedom, RISK / count)) / freedom, NOTABLE)
        found.append(Octave(low * hz, high * hz, float(np.mean(power[low:high])), most))
        high = low
    return found


def _most_correlated(white: Array, turning: Array, step: float) -> tuple[float, float]:
    """Give the largest correlation with the turning, and how long before it was [s]."""
    own, other = ((x - x.mean()) / max(float(np.std(x)), 1e-12) for x in (white, turning))
    lags = range(max(2, int(LONGEST / step)))
    found = [abs(float(np.mean(own[k:] * other[: len(other) - k]))) for k in lags]
    return max(found), step * int(np.argmax(found))


def excitation(drive: PreparedLog, length: float) -> dict[str, tuple[float, float]]:
    """Give what a drive went through, least and most, as an `Identification` has it."""
    drives = drive.speed != 0.0
    changes = np.abs(np.diff(drive.commands)) / np.maximum(np.diff(drive.times), 1e-3)
    still = list(stretches(~drive.moving))
    rest = float(np.sum(~drive.moving)) * drive.usual_step

    def ends(values: Array, share: float = 0.02) -> tuple[float, float]:
        return float(np.quantile(values, share)), float(np.quantile(values, 1.0 - share))

    return {
        "speed": ends(drive.speed[drives]),
        "curvature": ends(np.tan(drive.commands) / length),
        "steer_rate": (0.0, float(np.quantile(changes, 0.98))),
        "acceleration": ends(drive.acceleration[drives]),
        "stops": (float(len(still)), rest),
    }
