//! Points of the plane, and how far apart they are.

use crate::math::sqrt;

/// A point or a displacement in the plane [m].
pub type Point = nalgebra::Vector2<f64>;

/// Euclidean distance of two points [m], the paper's Equation 4.
#[inline]
pub fn get_distance(a: Point, b: Point) -> f64 {
    sqrt(squared_distance(a, b))
}

/// The square of [`get_distance`], enough where distances are only compared [m^2].
#[inline]
pub(crate) fn squared_distance(a: Point, b: Point) -> f64 {
    let dx = b.x - a.x;
    let dy = b.y - a.y;
    dx * dx + dy * dy
}
