"""The search for the lookahead point, as POP and pure pursuit share it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from popsteer.reference.error import config_in_range, config_optional
from popsteer.reference.laws.law import Params
from popsteer.reference.path.lookahead import Lookahead, get_crossing, get_lookahead_point
from popsteer.reference.path.resample import grid, window

if TYPE_CHECKING:
    from types import SimpleNamespace

    from popsteer.reference.path.follow import Located
    from popsteer.reference.path.view import PathView
    from popsteer.reference.vehicle import Vehicle

__all__ = ["SearchParams", "find_lookahead"]


@dataclass(frozen=True, kw_only=True)
class SearchParams(Params):
    """The parameters of a controller that searches for a lookahead point."""

    def __post_init__(self) -> None:
        config_in_range(self, "lookahead_gain", 0.0, 1e3)
        config_optional(self, "min_lookahead", 0.0, 1e4)
        config_optional(self, "lookahead_tolerance", 1e-9, 1e3)
        config_optional(self, "window_ahead", 1e-3, 1e6)
        config_optional(self, "grid_spacing", 1e-6, 1e3)
        super().__post_init__()

    def _scaled(self, vehicle: Vehicle) -> dict[str, float]:
        """Return the defaults that scale with `vehicle`, by parameter."""
        return super()._scaled(vehicle) | {
            "lookahead_tolerance": vehicle.wheelbase / 300.0,
            "window_ahead": 20.0 / 3.0 * vehicle.wheelbase,
            "grid_spacing": vehicle.wheelbase / 300.0,
        }


def find_lookahead(
    path: PathView, params: SimpleNamespace, at: Located, lookahead: float
) -> Lookahead:
    """Find the lookahead point at distance `lookahead` [m] from a located vehicle.

    `params` are resolved `SearchParams`.
    """
    if params.exact_lookahead:
        point, found = get_crossing(path, at.closest, at.position, lookahead)
        return Lookahead(0, point, found)
    nearest = at.closest.nearest_waypoint(path)
    waypoints = grid(path, window(path, nearest, params.window_ahead), params.grid_spacing)
    return get_lookahead_point(waypoints, at.position, lookahead, params.lookahead_tolerance)
