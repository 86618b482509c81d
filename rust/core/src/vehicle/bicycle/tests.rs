use super::*;

#[test]
fn test_state_transition_location_is_the_predicted_one() {
    let vehicle = VehicleState {
        x: 3.0,
        y: -2.0,
        yaw: 0.7,
        speed: 12.0,
    };
    let state = SVector::<f64, 5>::new(3.0, -2.0, 0.7, 12.0, 0.3);
    let next = state_transition(state, Vector2::new(0.5, 0.1), -0.2, 0.05);
    let location = get_predicted_location(vehicle, -0.2, 0.05);
    assert_eq!((next.x, next.y), (location.x, location.y));
    assert_eq!((next.z, next.w), (0.7 + 0.3 * 0.05, 12.5));
}

#[test]
fn test_kinematic_bicycle_drives_its_circle() {
    let mut vehicle = VehicleState {
        x: 0.0,
        y: 0.0,
        yaw: 0.0,
        speed: 5.0,
    };
    let (steer, wheelbase): (f64, f64) = (0.2, 3.0);
    let radius = wheelbase / tan(steer);
    for _ in 0..1000 {
        vehicle = kinematic_bicycle(vehicle, steer, 0.0, wheelbase, 0.01);
        let (dx, dy) = (vehicle.x, vehicle.y - radius);
        assert!((crate::math::sqrt(dx * dx + dy * dy) - radius).abs() < 1e-4);
    }
}
