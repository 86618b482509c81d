"""The search for the lookahead point, as POP and pure pursuit share it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from popsteer.reference.error import number, optional
from popsteer.reference.laws.law import Params
from popsteer.reference.path.lookahead import Lookahead, get_crossing, get_lookahead_point
from popsteer.reference.path.resample import grid, window

if TYPE_CHECKING:
    from types import SimpleNamespace

    from popsteer.reference.path.follow import Located
    from popsteer.reference.path.view import PathView
    from popsteer.reference.vehicle import Vehicle


def _fine(car: Vehicle) -> float:
    return car.wheelbase / 300.0


@dataclass(frozen=True, kw_only=True)
class SearchParams(Params):
    """The parameters of a controller that searches for a lookahead point."""

    lookahead_gain: float = number(0.0, 0.0, 1e3)  # k_v [s]
    min_lookahead: float | None = optional(0.0, 1e4)  # ld_min [m]
    exact_lookahead: bool = True  # the path's first crossing of the circle, not the paper's search
    # of the paper's search [m]: ε, the arc that it looks at, the greatest distance of grid points
    lookahead_tolerance: float | None = optional(1e-9, 1e3, scaled=_fine)
    window_ahead: float | None = optional(1e-3, 1e6, scaled=lambda car: 20.0 / 3.0 * car.wheelbase)
    grid_spacing: float | None = optional(1e-6, 1e3, scaled=_fine)


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
