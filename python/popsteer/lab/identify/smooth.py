"""Yaw rates without most of their noise, for plots."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

_WIDTH = 0.25  # s


def smoothed(values: NDArray[Any], period: float) -> NDArray[np.float64]:
    """Smooth a line, sampled every `period` [s], by a Hann window of 0.25 s; its gaps stay."""
    size = max(1, round(_WIDTH / period))
    kernel = np.hanning(2 * size + 1)[1:-1] if size > 1 else np.ones(1)
    if len(kernel) > len(values):
        return values
    whole = np.isfinite(values)
    weight = np.convolve(whole.astype(np.float64), kernel, mode="same")
    smooth = np.convolve(np.where(whole, values, 0.0), kernel, mode="same")
    return np.where(whole, smooth / np.maximum(weight, 1e-12), np.nan)
