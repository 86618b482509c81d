use super::*;

#[test]
fn test_state_bad_field_is_named() {
    let good = VehicleState {
        x: 1.0,
        y: 2.0,
        yaw: 0.0,
        speed: -3.0,
    };
    assert_eq!(good.checked(), Ok(good));
    for bad in [f64::NAN, f64::INFINITY, 1e308] {
        let field = |state: VehicleState| state.checked().unwrap_err().field;
        assert_eq!(field(VehicleState { x: bad, ..good }), "x");
        assert_eq!(field(VehicleState { y: -bad, ..good }), "y");
        assert_eq!(field(VehicleState { yaw: bad, ..good }), "yaw");
        assert_eq!(field(VehicleState { speed: bad, ..good }), "speed");
    }
    for bad in [0.0, -0.05, f64::NAN, f64::MIN_POSITIVE, 1e4] {
        assert_eq!(checked_dt(bad).unwrap_err().field, "dt");
    }
}
