"""How the times of many calls are summed up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence


@dataclass(frozen=True)
class Percentiles:
    """How long a call takes [ns].

    Attributes
    ----------
    p50, p99, p999, max : float
        Median, 99th and 99.9th percentile, greatest: all of one distribution, calls timed one by
        one, as the clock read them. One reading of the clock is in each.
    net_p50 : float or None
        Median over batches of calls, per call, net of the clock and of the loop around them; None
        for what is not called in batches.
    """

    p50: float
    p99: float
    p999: float
    max: float
    net_p50: float | None

    @classmethod
    def of(cls, singles: Sequence[int], net_p50: float | None) -> Percentiles:
        """Sum up what single calls took [ns], by times that were read, never means of two of them.

        `net_p50` is rounded to 0.01 ns.
        """
        p50, p99, p999 = np.percentile(singles, (50.0, 99.0, 99.9), method="higher").tolist()
        net = None if net_p50 is None else round(net_p50, 2)
        return cls(p50, p99, p999, max(singles), net)
