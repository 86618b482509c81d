use super::*;
use crate::Path;
use crate::path::lookahead::get_lookahead_point;
use crate::path::resample::{Grid, window};
use alloc::vec::Vec;
use proptest::prelude::*;

/// Waypoints from steps of a drawn length and turn, about an origin near or far away.
fn paths() -> impl Strategy<Value = (Path, f64)> {
    let step = (prop_oneof![Just(1.0), 0.05..3.0, Just(6.0)], -3.0..3.0_f64);
    let bend = prop_oneof![Just(0.0), Just(0.05), Just(1.0)];
    let origin = prop_oneof![Just(0.0), -1e3..1e3, Just(1e7), Just(-1e7)];
    (
        proptest::collection::vec(step, 2..30),
        bend,
        origin,
        any::<bool>(),
    )
        .prop_filter_map(
            "closing segment of no length",
            |(steps, bend, origin, closed)| {
                let (mut x, mut y, mut yaw) = (origin, -origin, 0.3);
                let (mut xs, mut ys) = (Vec::new(), Vec::new());
                for (length, turn) in steps {
                    xs.push(x);
                    ys.push(y);
                    yaw += bend * turn;
                    x += length * crate::math::cos(yaw);
                    y += length * crate::math::sin(yaw);
                }
                Path::new(&xs, &ys, None, closed && xs.len() > 2)
                    .ok()
                    .map(|path| (path, origin))
            },
        )
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

    #[test]
    fn test_jump_finds_what_the_plain_loop_finds(
        (path, origin) in paths(),
        nearest in 0_usize..30,
        place in (-12.0..12.0_f64, -12.0..12.0_f64),
        on_the_path in any::<bool>(),
        lookahead in prop_oneof![0.0..15.0, Just(1.0), Just(6.0), Just(0.0)],
        tangent in any::<bool>(),
        tolerance in prop_oneof![Just(0.01), 1e-9..0.5, Just(1e3)],
        on_the_edge in prop_oneof![Just(0.0), Just(1.0), Just(-1.0)],
        spacing in prop_oneof![Just(0.01), 0.01..2.0],
        ahead in prop_oneof![Just(20.0), 0.1..40.0],
    ) {
        let view = path.view();
        let nearest = nearest % view.len();
        let position = if on_the_path {
            view.waypoint(nearest)
        } else {
            Point::new(origin + place.0, -origin + place.1)
        };
        // A circle that touches a segment, to within rounding.
        let lookahead = if tangent {
            let (start, end) = view.segment(nearest % view.segments());
            let along = end - start;
            let to = position - start;
            let length = sqrt(along.x * along.x + along.y * along.y);
            ((along.x * to.y - along.y * to.x) / length).abs()
        } else {
            lookahead
        };
        // ... or whose threshold's inner or outer edge does.
        let lookahead = (lookahead + on_the_edge * tolerance).max(0.0);
        let grid = Grid::new(view, window(&view, nearest, ahead), spacing);
        let plain = get_lookahead_point(&grid, position, lookahead, tolerance);
        let found = find_lookahead_point(
            &view, nearest, ahead, spacing, position, lookahead, tolerance,
        );
        prop_assert_eq!(found, (plain.point, plain.found));
    }
}
