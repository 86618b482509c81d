//! [`relocalise`](popsteer_core::path::locate::relocalise) without visiting every waypoint.
//!
//! Neighbours on a path are neighbours in the plane. So the R*-tree does not hold waypoints but
//! runs of them, each as its bounding box: a sixteenth of the entries, and the coordinates stay
//! in the path. The search takes the runs by the distance of their boxes and shows their
//! waypoints to the core's own [`Relocalisation`], until no box that is left can matter.
//!
//! The distance to a box is computed from the same differences, squares and sum as that to a
//! waypoint. Each of these operations is monotone, rounding included, so the box is never found
//! farther off than a waypoint in it: the answer is the plain scan's, to the bit.

use popsteer_core::path::locate::Relocalisation;
use popsteer_core::{PathView, Point};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

/// Waypoints in a run: with more of them the index gets smaller, and a search dearer.
const RUN: usize = 16;

/// A spatial index of the waypoints of one path.
///
/// # Examples
///
/// ```
/// use popsteer_core::{Path, Point, path::locate::relocalise};
/// use popsteer_sim::PathIndex;
///
/// // There along the x axis, and back 2 m beside it.
/// let x: Vec<f64> = (0..100).chain((0..100).rev()).map(f64::from).collect();
/// let y: Vec<f64> = (0..200).map(|k| if k < 100 { 0.0 } else { 2.0 }).collect();
/// let path = Path::new(&x, &y, None, false)?;
/// let index = PathIndex::new(&path.view());
/// let position = Point::new(30.2, 0.9);
/// assert_eq!(index.relocalise(&path.view(), position, 0.1), 30);
/// assert_eq!(index.relocalise(&path.view(), position, 3.1), 169);
/// assert_eq!(relocalise(&path.view(), position, 3.1), 169);
/// # Ok::<(), popsteer_core::PathError>(())
/// ```
#[derive(Clone, Debug)]
pub struct PathIndex {
    /// Bounding boxes, each with the number of its run.
    runs: RTree<GeomWithData<Rectangle<[f64; 2]>, u32>>,
}

impl PathIndex {
    /// The index of the waypoints of `path`, in O(N log N).
    pub fn new(path: &PathView<'_>) -> Self {
        let boxes = path.x().chunks(RUN).zip(path.y().chunks(RUN)).map(|(x, y)| {
            let ((left, right), (low, high)) = (ends(x), ends(y));
            Rectangle::from_aabb(AABB::from_corners([left, low], [right, high]))
        });
        // More than u32::MAX runs would be 68 billion waypoints, or two terabytes of path.
        let runs = (0..).zip(boxes).map(|(run, bounds)| GeomWithData::new(bounds, run));
        Self {
            runs: RTree::bulk_load(runs.collect()),
        }
    }

    /// What [`relocalise`](popsteer_core::path::locate::relocalise) answers on `path`, the path
    /// that the index was made of.
    pub fn relocalise(&self, path: &PathView<'_>, position: Point, yaw: f64) -> usize {
        let mut search = Relocalisation::new(position, yaw);
        let by_distance = self
            .runs
            .nearest_neighbor_iter_with_distance_2([position.x, position.y]);
        for (run, squared_distance) in by_distance {
            if search.is_settled(squared_distance) {
                break;
            }
            let first = run.data as usize * RUN;
            let x = path.x().iter().skip(first).take(RUN);
            let y = path.y().iter().skip(first).take(RUN);
            for (index, (&x, &y)) in (first..).zip(x.zip(y)) {
                search.visit(path, index, Point::new(x, y));
            }
        }
        search.waypoint()
    }
}

/// The least and the greatest of some numbers.
fn ends(values: &[f64]) -> (f64, f64) {
    let start = (f64::INFINITY, f64::NEG_INFINITY);
    values
        .iter()
        .fold(start, |(low, high), &value| (low.min(value), high.max(value)))
}
