//! [`relocalise`](popsteer_core::path::relocalise::relocalise) without visiting every segment.
//!
//! Neighbours on a path are neighbours in the plane. So the R*-tree does not hold segments but
//! runs of them, each as its bounding box: few entries, and the coordinates stay
//! in the path. The search takes the runs by the distance of their boxes and shows their
//! segments to the core's own [`Relocalisation`], until no box that is left can matter: the
//! answer is the plain scan's, to the bit.

use popsteer_core::path::relocalise::Relocalisation;
use popsteer_core::{PathView, Point};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

/// Segments in a run. With more of them the index is smaller, but a search visits more; at this
/// length neither outweighs the other.
const RUN: usize = 32;

/// A spatial index of the segments of one path.
///
/// # Examples
///
/// ```
/// use popsteer_core::{Path, Point, path::relocalise::relocalise};
/// use popsteer_sim::PathIndex;
///
/// // There along the x axis, and back 2 m beside it.
/// let x: Vec<f64> = (0..100).chain((0..100).rev()).map(f64::from).collect();
/// let y: Vec<f64> = (0..200).map(|k| if k < 100 { 0.0 } else { 2.0 }).collect();
/// let path = Path::new(&x, &y, None, false)?;
/// let index = PathIndex::new(&path.view());
/// let position = Point::new(30.2, 0.9);
/// assert_eq!(index.relocalise(&path.view(), position, 0.1, 10.0), 30);
/// assert_eq!(index.relocalise(&path.view(), position, 3.1, 10.0), 168);
/// assert_eq!(relocalise(&path.view(), position, 3.1, 10.0), 168);
/// # Ok::<(), popsteer_core::PathError>(())
/// ```
#[derive(Clone, Debug)]
pub struct PathIndex {
    /// Bounding boxes, each with the number of its run.
    runs: RTree<GeomWithData<Rectangle<[f64; 2]>, u32>>,
}

impl PathIndex {
    /// The index of the segments of `path`, in O(N log N).
    pub fn new(path: &PathView<'_>) -> Self {
        let boxes = (0..path.segments()).step_by(RUN).map(|first| {
            // A run ends at the waypoint to which its last segment leads, the first one where
            // that closes the path.
            let ends = (first..=first + RUN).map(|waypoint| waypoint % path.len());
            let count = RUN.min(path.segments() - first) + 1;
            let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
            for waypoint in ends.take(count) {
                let point = [path.x()[waypoint], path.y()[waypoint]];
                for axis in 0..2 {
                    low[axis] = low[axis].min(point[axis]);
                    high[axis] = high[axis].max(point[axis]);
                }
            }
            Rectangle::from_aabb(AABB::from_corners(low, high))
        });
        // More than u32::MAX runs would be 68 billion waypoints, or two terabytes of path.
        let runs = (0..)
            .zip(boxes)
            .map(|(run, bounds)| GeomWithData::new(bounds, run));
        Self {
            runs: RTree::bulk_load(runs.collect()),
        }
    }

    /// What [`relocalise`](popsteer_core::path::relocalise::relocalise) answers on `path`, the path
    /// that the index was made of.
    pub fn relocalise(
        &self,
        path: &PathView<'_>,
        position: Point,
        yaw: f64,
        opposite_distance: f64,
    ) -> usize {
        let mut search = Relocalisation::new(position, yaw, opposite_distance);
        let by_distance = self
            .runs
            .nearest_neighbor_iter_with_distance_2([position.x, position.y]);
        for (run, squared_distance) in by_distance {
            if search.is_settled(squared_distance) {
                break;
            }
            let first = run.data as usize * RUN;
            for segment in first..path.segments().min(first + RUN) {
                search.visit(path, segment);
            }
        }
        search.segment()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use popsteer_core::Path;
    use popsteer_core::path::relocalise::relocalise;
    use proptest::prelude::*;

    /// A path, and positions to ask for: its waypoints, places beside them, and anywhere.
    fn check(xs: &[f64], ys: &[f64], closed: bool, spots: &[(f64, f64, f64)]) {
        let ends_meet = xs.first() == xs.last() && ys.first() == ys.last();
        let path = Path::new(xs, ys, None, closed && xs.len() > 2 && !ends_meet).unwrap();
        let view = path.view();
        let index = PathIndex::new(&view);
        for (k, &(aside_x, aside_y, yaw)) in spots.iter().enumerate() {
            let at = 37 * k % xs.len();
            let position = Point::new(xs[at] + aside_x, ys[at] + aside_y);
            assert_eq!(
                index.relocalise(&view, position, yaw, 10.0),
                relocalise(&view, position, yaw, 10.0),
                "{position} {yaw}"
            );
        }
    }

    fn spots() -> impl Strategy<Value = Vec<(f64, f64, f64)>> {
        let aside = || {
            prop_oneof![
                Just(0.0),
                (-6..=6_i32).prop_map(|k| 0.5 * f64::from(k)),
                -30.0..30.0,
                -1e5..1e5
            ]
        };
        let quarters = (-4..=4_i32).prop_map(|k| f64::from(k) * std::f64::consts::FRAC_PI_2);
        let yaw = prop_oneof![quarters, -7.0..7.0];
        proptest::collection::vec((aside(), aside(), yaw), 8)
    }

    fn origins() -> impl Strategy<Value = (f64, f64)> {
        prop_oneof![Just((0.0, 0.0)), Just((1e7, -1e7)), Just((-7.3e6, 0.1))]
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

        #[test]
        fn test_index_on_random_paths_finds_what_the_plain_scan_finds(
            steps in proptest::collection::vec((0.01..3.0_f64, -3.2..3.2_f64), 2..1500),
            bend in prop_oneof![Just(0.02), Just(0.3), Just(1.0)],
            origin in origins(),
            closed in any::<bool>(),
            spots in spots(),
        ) {
            let (mut x, mut y, mut yaw) = (origin.0, origin.1, 0.3_f64);
            let (xs, ys): (Vec<_>, Vec<_>) = steps
                .iter()
                .map(|&(length, turn)| {
                    yaw += bend * turn;
                    x += length * yaw.cos();
                    y += length * yaw.sin();
                    (x, y)
                })
                .unzip();
            check(&xs, &ys, closed, &spots);
        }

        /// Waypoints that come back to the same places again and again, with ties all over.
        #[test]
        fn test_index_on_a_lattice_finds_what_the_plain_scan_finds(
            steps in proptest::collection::vec(0..4_usize, 2..1500),
            size in 2..40_i32,
            origin in origins(),
            closed in any::<bool>(),
            spots in spots(),
        ) {
            let (mut x, mut y) = (0, 0);
            let (xs, ys): (Vec<_>, Vec<_>) = steps
                .iter()
                .map(|&way| {
                    let (dx, dy) = [(1, 0), (0, 1), (-1, 0), (0, -1)][way];
                    // The walls of the lattice throw the walk back.
                    x += if (0..size).contains(&(x + dx)) { dx } else { -dx };
                    y += if (0..size).contains(&(y + dy)) { dy } else { -dy };
                    (origin.0 + f64::from(x), origin.1 + f64::from(y))
                })
                .unzip();
            check(&xs, &ys, closed, &spots);
        }

        /// All on one line, there and back over the same places.
        #[test]
        fn test_index_on_one_line_finds_what_the_plain_scan_finds(
            run in 1..300_u32,
            laps in 1..6_u32,
            along in prop_oneof![Just((1.0, 0.0)), Just((0.0, 2.5)), Just((0.3, 0.4))],
            origin in origins(),
            spots in spots(),
        ) {
            let places = (0..=laps * run).map(|k| {
                let (lap, k) = (k / run, k % run);
                f64::from(if lap % 2 == 0 { k } else { run - k })
            });
            let (xs, ys): (Vec<_>, Vec<_>) = places
                .map(|place| (origin.0 + place * along.0, origin.1 + place * along.1))
                .unzip();
            check(&xs, &ys, false, &spots);
        }
    }
}
