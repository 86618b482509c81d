use super::*;

#[test]
fn test_reverse_by_the_signs_of_the_speeds() {
    let x = [0.0, 1.0, 2.0, 1.0, 0.0, -1.0];
    let y = [0.0; 6];
    let directions = |speed: &[f64]| {
        let path = Path::new(&x, &y, Some(speed), false).unwrap();
        (0..5)
            .map(|k| path.view().is_reverse(k))
            .collect::<Vec<_>>()
    };
    assert_eq!(
        directions(&[1.0, 1.0, -1.0, 0.0, 0.0, -1.0]),
        [false, false, true, true, true]
    );
    assert_eq!(
        directions(&[0.0, 1.0, 0.0, -1.0, 0.0, 0.0]),
        [false, false, true, true, true]
    );
    assert!(
        Path::new(&x, &y, Some(&[1.0; 6]), false)
            .unwrap()
            .view()
            .reverse()
            .is_none()
    );
}

#[test]
fn test_distinct_waypoints_keep_the_last_of_several() {
    let x = [0.0, 0.0, 1.0, 2.0, 2.0, 2.0, 0.0];
    let y = [0.0; 7];
    assert_eq!(distinct_waypoints(&x, &y, false), [1, 2, 5, 6]);
    assert_eq!(distinct_waypoints(&x, &y, true), [1, 2, 5]);
    assert_eq!(distinct_waypoints(&[1.0; 3], &[1.0; 3], true), [2]);
    // The last coincides with both before, which do not with each other.
    let close = [0.0, 1.2e-9, 0.6e-9, 1.0];
    assert_eq!(distinct_waypoints(&close, &[0.0; 4], false), [2, 3]);
}
