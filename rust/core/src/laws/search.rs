//! The search for the lookahead point, as POP and pure pursuit share it.

use crate::geometry::Point;
use crate::path::follow::Located;
use crate::path::jump::find_lookahead_point;
use crate::path::lookahead::get_crossing;
use crate::path::view::PathView;

/// The search, from the parameters of the same names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Search {
    pub(super) lookahead_gain: f64,
    pub(super) min_lookahead: f64,
    pub(super) exact_lookahead: bool,
    pub(super) lookahead_tolerance: f64,
    pub(super) window_ahead: f64,
    pub(super) grid_spacing: f64,
}

macro_rules! search_of {
    ($params:expr) => {
        $crate::laws::search::Search {
            lookahead_gain: $params.lookahead_gain,
            min_lookahead: $params.min_lookahead,
            exact_lookahead: $params.exact_lookahead,
            lookahead_tolerance: $params.lookahead_tolerance,
            window_ahead: $params.window_ahead,
            grid_spacing: $params.grid_spacing,
        }
    };
}
pub(super) use search_of;

/// The point to aim at, and whether it lies on the lookahead circle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target {
    pub(super) point: Point,
    pub(super) found: bool,
}

impl Search {
    /// The lookahead point at distance `lookahead` [m] from a located vehicle.
    #[inline]
    pub(super) fn find(&self, path: &PathView<'_>, at: &Located, lookahead: f64) -> Target {
        let (point, found) = if self.exact_lookahead {
            get_crossing(path, &at.closest, at.position, lookahead)
        } else {
            find_lookahead_point(
                path,
                at.closest.nearest_waypoint(path),
                self.window_ahead,
                self.grid_spacing,
                at.position,
                lookahead,
                self.lookahead_tolerance,
            )
        };
        Target { point, found }
    }
}
