use super::*;
use crate::Path;
use crate::math::{PI, from_count, sin};
use crate::path::locate::OPPOSITE;
use alloc::vec::Vec;
use core::f64::consts::{FRAC_PI_2, TAU};

/// A figure of eight that crosses itself at the origin, leading 27 and 153 degrees there.
fn eight() -> Path {
    let (x, y): (Vec<_>, Vec<_>) = (0..400)
        .map(|k| TAU * from_count(k) / 400.0)
        .map(|t| (50.0 * sin(t), 12.5 * sin(2.0 * t)))
        .unzip();
    Path::new(&x, &y, None, true).unwrap()
}

#[test]
fn test_relocalise_on_a_crossing_takes_the_branch_of_the_heading() {
    let path = eight();
    let crossing = Point::new(0.0, 0.0);
    for (yaw, branches) in [(0.464, [399, 0]), (PI - 0.464, [199, 200])] {
        for askew in [-0.5, 0.0, 0.5] {
            let found = relocalise(&path.view(), crossing, yaw + askew, OPPOSITE);
            assert!(branches.contains(&found), "{yaw} {askew} {found}");
        }
    }
}

#[test]
fn test_relocalise_square_crossing_goes_by_the_heading() {
    // Along x, round by the right, and back across it along y.
    let path = Path::new(
        &[-30.0, 30.0, 30.0, 0.0, 0.0],
        &[0.0, 0.0, -30.0, -30.0, 30.0],
        None,
        false,
    )
    .unwrap();
    let found = |yaw| relocalise(&path.view(), Point::new(0.3, -0.2), yaw, OPPOSITE);
    assert_eq!([0.0, 0.7, -0.7].map(found), [0; 3]);
    assert_eq!([FRAC_PI_2, 0.9, 2.3].map(found), [3; 3]);
}

#[test]
fn test_relocalise_there_and_back_weighs_distance_against_heading() {
    // There, and back so far beside it.
    let found = |apart: f64, yaw: f64| {
        let path = Path::new(
            &[0.0, 10.0, 10.0, 0.0],
            &[0.0, 0.0, apart, apart],
            None,
            false,
        );
        relocalise(&path.unwrap().view(), Point::new(5.0, 0.0), yaw, OPPOSITE)
    };
    assert_eq!((found(9.0, 0.0), found(9.0, PI)), (0, 2));
    assert_eq!((found(11.0, 0.0), found(11.0, PI)), (0, 0));
}

#[test]
fn test_relocalise_on_a_reverse_stretch_looks_against_it() {
    let (x, y) = ([0.0, 10.0, 0.0], [0.0, 0.0, 1.0]);
    let path = Path::new(&x, &y, None, false).unwrap();
    let path = path.with_reverse(&[false, true, false]).unwrap();
    let found = |yaw| relocalise(&path.view(), Point::new(2.0, 0.7), yaw, OPPOSITE);
    assert_eq!((found(0.0), found(PI)), (1, 1));
    assert_eq!(
        relocalise(&path.view(), Point::new(2.0, 0.1), 0.0, OPPOSITE),
        0
    );
}
