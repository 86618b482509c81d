//! The near neighbourhood of the vehicle, interpolated linearly and re-discretised.
//!
//! The paper's waypoints, about 1 m apart, are too sparse to steer by; those around the vehicle
//! are joined by straight lines and cut into a grid of 0.01 m.

use super::view::PathView;
use crate::error::PathError;
use crate::geometry::{Point, get_distance};
use crate::math::{ceil_to_count, from_count};

/// The most points that a grid may have where all of them are stored or visited. Ten million take
/// 160 MB, and are enough for 100 km at the paper's spacing. A control step needs no such bound: it
/// [jumps](super::jump) along the grid without making it.
pub const MAX_GRID_POINTS: usize = 10_000_000;

/// A stretch of consecutive segments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// The first segment, which starts at the waypoint of the same index.
    pub first: usize,
    /// How many segments follow each other, across the seam of a closed path too.
    pub segments: usize,
}

/// From one waypoint behind `nearest` to the first that lies `ahead` [m] of arc beyond it; at
/// most to the end of an open path, and once around a closed one.
pub fn window(path: &PathView<'_>, nearest: usize, ahead: f64) -> Window {
    let (first, behind) = match path.previous(nearest) {
        Some(previous) => (previous, 1),
        None => (nearest, 0),
    };
    let mut segments = behind;
    let mut last = nearest;
    let mut lap = 0.0;
    while segments < path.segments() {
        let Some(next) = path.next(last) else { break };
        if next < last {
            lap = path.length();
        }
        segments += 1;
        last = next;
        if path.arc(last) + lap - path.arc(nearest) >= ahead {
            break;
        }
    }
    Window { first, segments }
}

/// The grid on one segment: `count` points from its start on, its end left to the next segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentGrid {
    /// The start of the segment [m].
    pub start: Point,
    /// From the start of the segment to its end [m].
    pub along: Point,
    /// How many grid points the segment carries.
    pub count: usize,
}

impl SegmentGrid {
    /// Cuts segment `segment` evenly, no two neighbours farther apart than `spacing` [m].
    #[inline]
    pub fn new(path: &PathView<'_>, segment: usize, spacing: f64) -> Self {
        let (start, end) = path.segment(segment);
        Self::between(start, end, spacing)
    }

    /// Cuts the line from `start` to `end` so.
    #[inline]
    pub(super) fn between(start: Point, end: Point, spacing: f64) -> Self {
        let count = ceil_to_count(get_distance(start, end) / spacing);
        Self {
            start,
            along: end - start,
            count,
        }
    }

    /// Grid point `index` of `count` [m].
    #[inline]
    pub fn point(&self, index: usize) -> Point {
        let fraction = from_count(index) / from_count(self.count);
        self.start + self.along * fraction
    }
}

/// The fine grid over a window: the points of each segment in turn, then the last waypoint.
/// Nothing is stored; points are made when asked for.
#[derive(Clone, Copy, Debug)]
pub struct Grid<'a> {
    path: PathView<'a>,
    window: Window,
    spacing: f64,
}

impl<'a> Grid<'a> {
    /// The grid over `window`, with neighbours at most `spacing` [m] apart.
    #[inline]
    pub fn new(path: PathView<'a>, window: Window, spacing: f64) -> Self {
        Self {
            path,
            window,
            spacing,
        }
    }

    /// The grid itself where it has at most [`MAX_GRID_POINTS`].
    ///
    /// # Errors
    ///
    /// [`PathError::GridTooLarge`].
    pub fn checked(self) -> Result<Self, PathError> {
        let points = self.segments().fold(1_usize, |points, segment| {
            points.saturating_add(segment.count)
        });
        if points > MAX_GRID_POINTS {
            return Err(PathError::GridTooLarge {
                points,
                most: MAX_GRID_POINTS,
            });
        }
        Ok(self)
    }

    /// The grids of the window's segments, in order.
    #[inline]
    pub fn segments(&self) -> impl Iterator<Item = SegmentGrid> + use<'a> {
        let (path, window, spacing) = (self.path, self.window, self.spacing);
        (0..window.segments)
            .map(move |k| SegmentGrid::new(&path, path.around(window.first + k), spacing))
    }

    /// The last point of the grid: the waypoint that ends the window [m].
    #[inline]
    pub fn last(&self) -> Point {
        self.path
            .waypoint(self.path.around(self.window.first + self.window.segments))
    }

    /// The grid points in order.
    pub fn points(&self) -> impl Iterator<Item = Point> + use<'a> {
        self.segments()
            .flat_map(|segment| (0..segment.count).map(move |index| segment.point(index)))
            .chain(core::iter::once(self.last()))
    }
}
