"""The search for the lookahead point, as POP and pure pursuit share it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from popsteer.reference.error import config_in_range, config_optional
from popsteer.reference.lateral import resolved
from popsteer.reference.path.lookahead import Lookahead, get_crossing, get_lookahead_point
from popsteer.reference.path.resample import grid, window

if TYPE_CHECKING:
    from popsteer.reference.path.follow import Located
    from popsteer.reference.path.view import PathView

__all__ = ["Search", "check_search"]


class SearchParams(Protocol):
    """The parameters of a controller that searches for a lookahead point."""

    @property
    def lookahead_gain(self) -> float:
        """Velocity constant k_v [s]."""

    @property
    def min_lookahead(self) -> float | None:
        """Least lookahead ld_min [m]."""

    @property
    def exact_lookahead(self) -> bool:
        """Whether the first crossing of the circle counts, instead of the paper's search."""

    @property
    def lookahead_tolerance(self) -> float | None:
        """Threshold ε of the paper's search [m]."""

    @property
    def window_ahead(self) -> float | None:
        """Arc ahead of the vehicle that the paper's search looks at [m]."""

    @property
    def grid_spacing(self) -> float | None:
        """Greatest distance of neighbours on the re-discretised path [m]."""


def check_search(params: SearchParams) -> None:
    """Settle the parameters of a controller that searches for a lookahead point."""
    config_in_range(params, "lookahead_gain", 0.0, 1e3)
    config_optional(params, "min_lookahead", 0.0, 1e4)
    config_optional(params, "lookahead_tolerance", 1e-9, 1e3)
    config_optional(params, "window_ahead", 1e-3, 1e6)
    config_optional(params, "grid_spacing", 1e-6, 1e3)


@dataclass(frozen=True)
class Search:
    """The search, from the resolved parameters of the same names."""

    lookahead_gain: float
    min_lookahead: float
    exact_lookahead: bool
    lookahead_tolerance: float
    window_ahead: float
    grid_spacing: float

    @classmethod
    def of(cls, params: SearchParams) -> Search:
        """Take the search from resolved parameters."""
        return cls(
            lookahead_gain=params.lookahead_gain,
            min_lookahead=resolved(params.min_lookahead),
            exact_lookahead=params.exact_lookahead,
            lookahead_tolerance=resolved(params.lookahead_tolerance),
            window_ahead=resolved(params.window_ahead),
            grid_spacing=resolved(params.grid_spacing),
        )

    def find(self, path: PathView, at: Located, lookahead: float) -> Lookahead:
        """Find the lookahead point at distance `lookahead` [m] from a located vehicle."""
        if self.exact_lookahead:
            point, found = get_crossing(path, at.closest, at.position, lookahead)
            return Lookahead(0, point, found)
        nearest = at.closest.nearest_waypoint(path)
        waypoints = grid(path, window(path, nearest, self.window_ahead), self.grid_spacing)
        return get_lookahead_point(waypoints, at.position, lookahead, self.lookahead_tolerance)
