"""The parameters of preview POP."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from popsteer.reference.error import config_in_range, config_optional
from popsteer.reference.laws.law import Params
from popsteer.reference.math import PI

if TYPE_CHECKING:
    from popsteer.reference.vehicle import Vehicle

__all__ = ["PreviewPopParams"]


@dataclass(frozen=True, kw_only=True)
class PreviewPopParams(Params):
    """Parameters of `PreviewPop`.

    Attributes
    ----------
    steer_span_rate : float or None
        Optimization range δ_nbd over the control period [rad/s]: an angle lies at most this times
        Δt from the last one. The vehicle's `max_steer_rate` by default; 60°/s, the paper's 3° in
        50 ms, where it has none.
    horizon : float
        How long the prediction looks ahead [s]. Longer: bends are entered earlier and a lag is
        anticipated. If it is shorter than the lag and the return to the path, the vehicle
        oscillates. Up to twice as long if the vehicle has a `max_steer_rate` and its wheels need
        it.
    heading_cost : float or None
        How many metres of cross-track error are as bad as 1 rad of heading error [m/rad]; None is
        a wheelbase. More: the path is joined more gently, and offsets take longer to vanish.
    steer_rate_cost : float or None
        How many metres of cross-track error are as bad as turning the wheels at 1 rad/s
        [m s/rad]; None is a twelfth of the wheelbase. More: calmer wheels, less noise passed on,
        wider bends where the model is wrong.
    approach_angle : float
        Heading at which the path is approached from afar [rad]; less if the vehicle's limits would
        not straighten it in time. More: sooner back on the path, by a sharper manoeuvre.
    min_speed : float or None
        Below this speed [m/s] the wheels turn in proportion to the distance travelled, and the
        prediction looks as far as at this speed; at rest they keep their angle. Where the
        vehicle's `max_steer_rate` is given, they turn at all of it down to half this speed. None is
        5/3 wheelbases a second.
    smoothing_length : float or None
        Length of path over which its direction is taken [m]; None is 2/3 of the wheelbase. More:
        less of the waypoints' noise is steered, and bends shorter than this are cut.
    search_distance : float or None
        Arc of the path that is searched on each side of the last projection [m], in addition to the
        distance travelled in a step; None is two wheelbases.
    lost_distance : float or None
        Distance from the path beyond which the vehicle is lost and is searched for on the whole
        path [m]; None is ten wheelbases.

    Raises
    ------
    ConfigError
        Naming the parameter that is out of its range.

    Examples
    --------
    >>> PreviewPopParams(horizon=2).horizon
    2.0
    >>> PreviewPopParams(heading_cost=-1)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: heading_cost must be in [0, 1000], got -1.0
    """

    steer_span_rate: float | None = None
    horizon: float = 1.0
    heading_cost: float | None = None
    steer_rate_cost: float | None = None
    approach_angle: float = 0.25
    min_speed: float | None = None
    smoothing_length: float | None = None
    search_distance: float | None = None
    lost_distance: float | None = None

    def __post_init__(self) -> None:
        config_optional(self, "steer_span_rate", 1e-3, 1e6)
        config_in_range(self, "horizon", 0.05, 100.0)
        config_optional(self, "heading_cost", 0.0, 1e3)
        config_optional(self, "steer_rate_cost", 1e-5, 1e3)
        config_in_range(self, "approach_angle", 1e-3, 0.5 * PI)
        config_optional(self, "min_speed", 1e-3, 1e4)
        config_optional(self, "smoothing_length", 0.0, 1e3)
        super().__post_init__()

    def _scaled(self, vehicle: Vehicle) -> dict[str, float]:
        """Return the defaults that scale with `vehicle`, by parameter."""
        wheelbase = vehicle.wheelbase
        rate = vehicle.max_steer_rate
        return super()._scaled(vehicle) | {
            "steer_span_rate": 60.0 * (PI / 180.0) if rate is None else rate,
            "heading_cost": wheelbase,
            "steer_rate_cost": wheelbase / 12.0,
            "min_speed": 5.0 / 3.0 * wheelbase,
            "smoothing_length": 2.0 / 3.0 * wheelbase,
        }
