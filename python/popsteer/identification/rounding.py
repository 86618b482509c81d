"""What digits take away: the steps in which a signal is recorded, and what they hide of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

LEVELS = 5
"""A signal that moves by one level of its digits at a time, over as many at least, is rounded."""


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
