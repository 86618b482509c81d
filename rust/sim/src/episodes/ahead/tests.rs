use super::*;
use popsteer_core::Path;

#[test]
fn test_point_ahead_lies_on_the_path_goes_on_beyond_its_ends_and_round_a_closed_one() {
    let (x, y) = ([0.0, 4.0, 4.0, 0.0], [0.0, 0.0, 4.0, 4.0]);
    let open = Path::new(&x, &y, None, false).unwrap();
    let closed = Path::new(&x, &y, None, true).unwrap();
    for near in 0..4 {
        let at = |path: &Path, arc| point_at(&path.view(), arc, near).0;
        assert_eq!(at(&open, 5.0), Point::new(4.0, 1.0));
        assert_eq!(at(&open, -2.0), Point::new(-2.0, 0.0));
        assert_eq!(at(&open, 14.0), Point::new(-2.0, 4.0));
        assert_eq!(at(&closed, 14.0), Point::new(0.0, 2.0));
        assert_eq!(at(&closed, 17.0), Point::new(1.0, 0.0));
        assert_eq!(at(&closed, -1.0), Point::new(0.0, 1.0));
    }
}

#[test]
fn test_point_far_ahead_is_found_by_halves() {
    let x: Vec<f64> = (0..1000).map(f64::from).collect();
    let path = Path::new(&x, &vec![0.0; 1000], None, false).unwrap();
    for (arc, near) in [(900.5, 3), (3.25, 900), (20.0, 2)] {
        assert_eq!(
            point_at(&path.view(), arc, near).0,
            Point::new(arc, 0.0),
            "{arc} from {near}"
        );
    }
}
