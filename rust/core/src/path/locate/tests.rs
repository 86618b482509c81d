use super::*;
use crate::Path;
use alloc::vec::Vec;

#[test]
fn test_locate_out_and_back_keeps_to_the_branch_of_the_heading() {
    let x: Vec<f64> = (0..100).chain((0..100).rev()).map(f64::from).collect();
    let y: Vec<f64> = (0..200).map(|k| if k < 100 { 0.0 } else { 0.5 }).collect();
    let path = Path::new(&x, &y, None, false).unwrap();
    // Nearer to the other branch all the way, and near the turn.
    for (at, last) in [(50.2, 50), (95.7, 95), (97.5, 97)] {
        let position = Point::new(at, 0.4);
        let there = locate(
            &path.view(),
            last,
            position,
            Point::new(1.0, 0.0),
            6.0,
            OPPOSITE,
        );
        assert_eq!(there.segment, last);
        let turned = locate(
            &path.view(),
            last,
            position,
            Point::new(-1.0, 0.0),
            6.0,
            OPPOSITE,
        );
        assert_eq!(turned.segment > 99, at > 95.0);
    }
}
