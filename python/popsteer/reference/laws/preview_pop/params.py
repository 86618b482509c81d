"""The parameters of preview POP."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from popsteer.reference.error import number, optional
from popsteer.reference.laws.law import Params
from popsteer.reference.math import PI

if TYPE_CHECKING:
    from popsteer.reference.vehicle import Vehicle

__all__ = ["PreviewPopParams"]


@dataclass(frozen=True, kw_only=True)
class PreviewPopParams(Params):
    """Parameters of `PreviewPop`. See `popsteer.PreviewPopParams`.

    Examples
    --------
    >>> PreviewPopParams(heading_cost=-1)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: heading_cost must be in [0, 1000], got -1.0
    """

    steer_span_rate: float | None = optional(1e-3, 1e6)  # δ_nbd over the control period [rad/s]
    horizon: float = number(1.0, 0.05, 100.0)  # of the prediction [s]
    heading_cost: float | None = optional(0.0, 1e3)  # of 1 rad in cross-track error [m/rad]
    steer_rate_cost: float | None = optional(1e-5, 1e3)  # of 1 rad/s [m s/rad]
    approach_angle: float = number(0.25, 1e-3, 0.5 * PI)  # of a path far off [rad]
    min_speed: float | None = optional(1e-3, 1e4)  # least speed of the prediction [m/s]
    smoothing_length: float | None = optional(0.0, 1e3)  # of the path's heading [m]

    def _scaled(self, vehicle: Vehicle) -> dict[str, float]:
        wheelbase = vehicle.wheelbase
        rate = vehicle.max_steer_rate
        return super()._scaled(vehicle) | {
            "steer_span_rate": 60.0 * (PI / 180.0) if rate is None else rate,
            "heading_cost": wheelbase,
            "steer_rate_cost": wheelbase / 12.0,
            "min_speed": 5.0 / 3.0 * wheelbase,
            "smoothing_length": 2.0 / 3.0 * wheelbase,
        }
