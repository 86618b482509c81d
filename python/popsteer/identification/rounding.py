"""What digits take away: the steps in which a signal is recorded, and what they hide of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from popsteer.identification.drive import Array, PreparedLog

LEVELS = 5
"""A signal that moves by one level of its digits at a time, over as many at least, is rounded."""
SHOWN = 0.02
"""The share of the variance of rounding that the heading must show: the fit takes up the rest."""


def grain_of(values: Array) -> float:
    """Give the step of the digits of a signal that is rounded; 0 where it is not."""
    levels = np.unique(values)
    steps = np.diff(levels)
    steps = steps[steps > 1e-12]
    if not steps.size:
        return 0.0
    # The digits of a step that was converted are rounded, too: its multiples tell it.
    above = levels - levels[0]
    whole = np.round(above / float(np.min(steps)))
    grain = float(whole @ above / (whole @ whole))
    return grain if float(np.max(np.abs(above - grain * whole))) < 1e-2 * grain else 0.0


def rounding_of(values: Array) -> float:
    """Give the standard deviation of what rounding to the digits takes away."""
    return grain_of(values) / float(np.sqrt(12.0))


def unrounded(times: Array, values: Array, grain: float) -> Array:
    """Give a signal that moves from level to level of its digits without the stairs.

    Halfway between two levels as it goes from one to the other; and the level itself in between, as
    soon as it gets there at the pace of the level before.
    """
    changes = 1 + np.flatnonzero(np.diff(values))
    single = np.abs(values[changes] - values[changes - 1]) < 1.5 * grain
    if len(np.unique(values)) < LEVELS or np.mean(single) < 0.5:
        return values
    through = 0.5 * (times[changes] + times[changes - 1])
    half = 0.5 * (values[changes] + values[changes - 1])[single]
    jumps = changes[~single]  # of a larger step both ends are known
    edges = np.concatenate((times[:1], through, times[-1:]))
    levels = values[np.concatenate(([0], changes))]
    lasts = np.diff(edges)
    before = 0.5 * np.minimum(lasts, np.concatenate((lasts[:1], lasts[:-1])))
    after = 0.5 * np.minimum(lasts, np.concatenate((lasts[1:], lasts[-1:])))
    knots = np.concatenate(
        (through[single], times[jumps], times[jumps - 1], edges[:-1] + before, edges[1:] - after)
    )
    heights = np.concatenate((half, values[jumps], values[jumps - 1], levels, levels))
    order = np.argsort(knots, kind="stable")
    found: Array = np.interp(times, knots[order], heights[order])
    return found


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
    levels, level = np.unique(drive.recorded, return_inverse=True)
    delayed = drive.t - values["dead_time"] - values["steer_lag"]
    level = level[np.clip(np.searchsorted(drive.times, delayed, side="right") - 1, 0, None)]
    length = values["turning_wheelbase"] + values["understeer"] * drive.sample_speed**2
    turn = (drive.sample_speed / np.maximum(length, 1e-3))[:-1] * np.diff(drive.t)
    total, size = np.zeros((len(levels), added[0].shape[1])), step * step / 12.0
    stretches = []
    for piece, part in zip(added, drive.parts(), strict=True):
        rows = slice(part.start, part.stop - 1)
        np.add.at(total, level[rows], piece * turn[rows, None] / innovation)
        # The heading's error over each stretch of one command, by how far a radian turns it.
        starts = np.flatnonzero(np.diff(level[rows], prepend=-1))
        stretches.append(np.add.reduceat((np.diff(error[part]), turn[rows]), starts, axis=1))
    # Its variance as the heading shows it: of stretches that count alike, or by their length.
    off, gain = np.concatenate(stretches, axis=1) ** 2
    alike = gain / (2.0 * sample**2 + size * gain) ** 2
    shown = any(
        weight @ (off - 2.0 * sample**2) > SHOWN * size * (weight @ gain)
        for weight in (alike, np.ones_like(gain))
    )
    if shown or drive.commands is not drive.recorded:
        return step, 2.0 * size * total.T @ total
    return 0.0, 0.0 * total.T @ total
