use super::*;

#[test]
fn test_path_arc_length_open_and_closed() {
    let (x, y) = ([0.0, 3.0, 3.0], [0.0, 0.0, 4.0]);
    let mut s = [0.0; 3];
    let open = PathView::new(&x, &y, None, false, &mut s).unwrap();
    assert_eq!((open.length(), open.segments()), (7.0, 2));
    assert_eq!(open.s(), [0.0, 3.0, 7.0]);
    let mut s = [0.0; 3];
    let closed = PathView::new(&x, &y, None, true, &mut s).unwrap();
    assert_eq!((closed.length(), closed.segments()), (12.0, 3));
}

#[test]
fn test_path_bad_waypoints_names_them() {
    let mut s = [0.0; 3];
    let error = |x: &[f64], y: &[f64], closed, s: &mut [f64]| {
        PathView::new(x, y, None, closed, s)
            .map(|_| ())
            .unwrap_err()
    };
    assert_eq!(
        error(&[0.0], &[0.0], false, &mut s[..1]),
        PathError::TooFewWaypoints { count: 1, least: 2 }
    );
    assert_eq!(
        error(&[0.0, 1.0, 1.0], &[0.0; 3], false, &mut s),
        PathError::Coinciding { index: 1, next: 2 }
    );
    assert_eq!(
        error(&[0.0, 1.0, 0.0], &[0.0, 1.0, 0.0], true, &mut s),
        PathError::Coinciding { index: 2, next: 0 }
    );
    assert_eq!(
        error(&[0.0, 1.0], &[0.0], false, &mut s[..2]),
        PathError::LengthMismatch {
            field: "y",
            length: 1,
            waypoints: 2
        }
    );
    assert!(matches!(
        error(&[0.0, f64::NAN], &[0.0; 2], false, &mut s[..2]),
        PathError::OutOfRange {
            field: "x",
            index: 1,
            ..
        }
    ));
}
