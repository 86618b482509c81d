//! Where do I aim? The paper's search for the lookahead point.

use super::resample::Grid;
use super::view::get_distance;
use crate::Point;

/// What the search came back with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lookahead {
    /// The index of the point in the grid.
    pub index: usize,
    /// The point itself [m].
    pub point: Point,
    /// Whether it lies on the circle; otherwise it is the last point of the grid.
    pub found: bool,
}

/// The first grid point whose distance from `position` differs from `lookahead` [m] by at most
/// `tolerance` [m], else the last: the paper's `get_lookahead_point_index` (Equation 5) and
/// `get_lookahead_point` in one pass.
///
/// The equation prints only the distance; the text, "almost equal to the lookahead distance",
/// says what is compared.
pub fn get_lookahead_point(
    grid: &Grid<'_>,
    position: Point,
    lookahead: f64,
    tolerance: f64,
) -> Lookahead {
    let mut last = Lookahead {
        index: 0,
        point: grid.last(),
        found: false,
    };
    for (index, point) in grid.points().enumerate() {
        let difference = get_distance(position, point) - lookahead;
        if difference.abs() <= tolerance {
            return Lookahead {
                index,
                point,
                found: true,
            };
        }
        last.index = index;
    }
    last
}

/// The index alone: the paper's `get_lookahead_point_index` (Equation 5).
pub fn get_lookahead_point_index(
    grid: &Grid<'_>,
    position: Point,
    lookahead: f64,
    tolerance: f64,
) -> usize {
    get_lookahead_point(grid, position, lookahead, tolerance).index
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Path;
    use crate::path::resample::window;

    #[test]
    fn test_lookahead_straight_lies_on_the_circle() {
        let path = Path::new(&[0.0, 10.0, 20.0, 30.0], &[0.0; 4], None, false).unwrap();
        let view = path.view();
        let grid = Grid::new(view, window(&view, 0, 20.0), 0.01);
        let found = get_lookahead_point(&grid, Point::new(1.0, 0.0), 6.0, 0.01);
        assert!(found.found);
        assert!((found.point.x - 7.0).abs() <= 0.01 + 1e-12);
    }

    #[test]
    fn test_lookahead_out_of_reach_takes_the_last() {
        let path = Path::new(&[0.0, 10.0], &[0.0; 2], None, false).unwrap();
        let view = path.view();
        let grid = Grid::new(view, window(&view, 0, 20.0), 0.01);
        let lost = get_lookahead_point(&grid, Point::new(0.0, 0.0), 50.0, 0.01);
        assert_eq!(
            lost,
            Lookahead {
                index: 1000,
                point: Point::new(10.0, 0.0),
                found: false
            }
        );
    }
}
