use super::*;

/// A turn that is not measured, of 0.1 rad/s at 5 m/s for a second, and where the vehicle went.
fn driven(obeys: bool) -> Course {
    let mut course = Course::default();
    let mut angle = 0.0;
    for _ in 0..20 {
        let aside = if obeys { 5.0 * 0.05 * angle } else { 0.0 };
        course.add(0.1 * 0.05, 5.0 * 0.05, aside);
        angle += 0.1 * 0.05;
    }
    course
}

#[test]
fn test_a_vehicle_that_moves_aside_of_its_heading_has_turned() {
    assert!(driven(true).blames_heading(0.02, false));
    assert!(!driven(false).blames_heading(0.02, true));
}

#[test]
fn test_what_noise_hides_is_decided_by_a_heading_that_repeats() {
    for obeys in [false, true] {
        assert!(driven(obeys).blames_heading(1.0, true));
        assert!(!driven(obeys).blames_heading(1.0, false));
    }
}
