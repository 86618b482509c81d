use super::*;

#[test]
fn test_vehicle_bad_field_is_named() {
    assert_eq!(Vehicle::DEFAULT.checked(), Ok(Vehicle::DEFAULT));
    for bad in [f64::NAN, f64::INFINITY, -1e7] {
        let mut car = Vehicle {
            drive_lag: bad,
            ..Vehicle::DEFAULT
        };
        assert_eq!(car.checked().unwrap_err().field, "drive_lag");
        car.no_slip_point = Some(bad);
        assert_eq!(car.checked().unwrap_err().field, "no_slip_point");
        car.wheelbase = bad;
        assert_eq!(car.checked().unwrap_err().field, "wheelbase");
    }
}

#[test]
fn test_vehicle_points_are_told_from_the_pose() {
    let car = Vehicle {
        rear_axle: -1.25,
        ..Vehicle::DEFAULT
    };
    assert_eq!((car.front_axle(), car.no_slip()), (1.75, -1.25));
    let slipping = Vehicle {
        no_slip_point: Some(0.0),
        turning_wheelbase: Some(3.5),
        understeer: 0.01,
        ..car
    };
    assert_eq!(
        (slipping.no_slip(), slipping.turning_length(10.0)),
        (0.0, 4.5)
    );
}
