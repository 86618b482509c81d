use super::super::locate::{OPPOSITE, locate, locate_by_scan};
use super::*;
use crate::Path;
use crate::math::{atan2, cos, sin};
use alloc::vec::Vec;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

    #[test]
    fn test_locate_is_what_the_scan_finds(
        steps in proptest::collection::vec(
            (prop_oneof![Just(1.0), 0.01..3.0, Just(20.0)], -3.0..3.0_f64), 2..60),
        bend in prop_oneof![Just(0.0), Just(0.05), Just(0.4), Just(1.0)],
        origin in prop_oneof![Just(0.0), -1e3..1e3, Just(1e7), Just(-1e9)],
        lattice in any::<bool>(),
        turns in proptest::collection::vec(any::<bool>(), 60),
        closed in any::<bool>(),
        reversing in any::<bool>(),
        at in 0_usize..60,
        aside in (prop_oneof![Just(0.0), -12.0..12.0], prop_oneof![Just(0.0), -12.0..12.0]),
        yaw in -3.2..3.2_f64,
        aligned in any::<bool>(),
        reach in prop_oneof![Just(6.0), 0.0..30.0],
        opposite in prop_oneof![Just(10.0), 0.0..20.0],
        last in 0_usize..60,
        near in any::<bool>(),
    ) {
        let (mut x, mut y, mut heading) = (origin, -origin, 0.3);
        let (mut xs, mut ys) = (Vec::new(), Vec::new());
        for (length, turn) in steps {
            xs.push(x);
            ys.push(y);
            heading += bend * turn;
            let (dx, dy) = (length * cos(heading), length * sin(heading));
            if lattice {
                x += crate::math::from_count(crate::math::to_count(dx.abs())).copysign(dx);
                y += 1.0 + crate::math::from_count(crate::math::to_count(dy.abs()));
            } else {
                x += dx;
                y += dy;
            }
        }
        let Ok(path) = Path::new(&xs, &ys, None, closed && xs.len() > 2) else {
            return Ok(());
        };
        let path = if reversing {
            path.with_reverse(turns.get(..xs.len()).unwrap()).unwrap()
        } else {
            path
        };
        let view = path.view();
        let at = view.segment_at(at % view.len());
        let (start, end) = view.segment(at);
        let middle = 0.5 * (start + end);
        let position = Point::new(middle.x + aside.0, middle.y + aside.1);
        let yaw = if aligned {
            atan2(end.y - start.y, end.x - start.x) + 0.1 * yaw
        } else {
            yaw
        };
        let heading = Point::new(cos(yaw), sin(yaw));
        let last = if near { (at + last % 5) % view.len() } else { last % view.len() };
        let scanned = locate_by_scan(&view, last, position, heading, reach, opposite);
        let found = locate(&view, last, position, heading, reach, opposite);
        prop_assert_eq!(found, scanned);
    }
}

#[test]
fn test_locate_decides_without_the_scan_in_plain_driving() {
    let x: Vec<f64> = (0..400).map(f64::from).collect();
    let y: Vec<f64> = x.iter().map(|x| 5.0 * sin(x / 20.0)).collect();
    let path = Path::new(&x, &y, None, false).unwrap();
    let heading = |at: f64| {
        let slope = 0.25 * cos(at / 20.0);
        Point::new(1.0, slope) / sqrt(1.0 + slope * slope)
    };
    let decided = (0..3900).filter(|&k| {
        let at = 0.1 * f64::from(k);
        let position = Point::new(at, 5.0 * sin(at / 20.0) + 0.3);
        let last = crate::math::to_count(at);
        locate_nearby(&path.view(), last, position, heading(at), 6.0, OPPOSITE).is_some()
    });
    assert!(decided.count() > 3890);
}
