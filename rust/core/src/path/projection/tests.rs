use super::*;
use crate::Path;

fn bent() -> Path {
    Path::new(
        &[0.0, 10.0, 10.0],
        &[0.0, 0.0, 10.0],
        Some(&[1.0, 2.0, 4.0]),
        false,
    )
    .unwrap()
}

#[test]
fn test_project_either_side_signs_the_error() {
    let path = bent();
    let left = project(&path.view(), 0, Point::new(4.0, 1.5));
    assert_eq!((left.segment, left.cross_track_error), (0, 1.5));
    assert!((left.fraction - 0.4).abs() < 1e-15);
    let right = project(&path.view(), 1, Point::new(12.0, 5.0));
    assert_eq!((right.segment, right.cross_track_error), (1, -2.0));
    assert_eq!(reference_speed(&path.view(), &right), Some(3.0));
}

#[test]
fn test_project_beyond_the_end_measures_to_the_side() {
    let path = bent();
    let beyond = project(&path.view(), 2, Point::new(9.0, 14.0));
    assert_eq!(beyond.cross_track_error, 1.0);
    assert_eq!(reference_speed(&path.view(), &beyond), Some(4.0));
}
