use super::*;
use popsteer_core::Point;
use popsteer_core::laws::{Pop, PopParams};
use popsteer_core::path::locate::locate;

#[test]
fn test_course_lap_stays_beside_the_path() {
    for waypoints in [1000, WAYPOINTS, 10_000] {
        let course = Course::new(waypoints).unwrap();
        let view = course.path.view();
        let mut last = 0;
        for state in &course.lap {
            let heading = Point::new(state.yaw.cos(), state.yaw.sin());
            let closest = locate(&view, last, state.point_ahead(0.0), heading, 6.0, 10.0);
            assert!(closest.cross_track_error().abs() < 0.35);
            assert!((state.yaw - closest.path_yaw()).sin().abs() < 0.1);
            last = closest.segment;
        }
        let spacing = view.length() / from_count(waypoints);
        assert!((1.0..1.05).contains(&spacing));
    }
}

#[test]
fn test_drive_goes_on_alike_after_a_lap() {
    let course = Course::new(1000).unwrap();
    let pop = Pop::new(Vehicle::PAPER, PopParams::DEFAULT).unwrap();
    let mut drive = LapRunner::new(&course, Tracker::of(pop));
    let mut again = drive.clone();
    for _ in 0..2 * course.lap.len() {
        let steer = drive.steer();
        assert!(steer.is_finite());
        assert_eq!(again.step().map(|command| command.steer), Some(steer));
    }
}
