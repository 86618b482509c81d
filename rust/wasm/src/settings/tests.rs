use super::*;

const GOOD: [f64; 8] = [2.7, 0.15, 0.1, 0.4, 10.0, 0.0, -2.0, 1.0];

#[test]
fn test_settings_bad_number_is_named() {
    assert!(Settings::of(&GOOD).is_ok());
    for (index, name) in NAMES.iter().enumerate() {
        for bad in [f64::NAN, f64::INFINITY, -1e7] {
            let mut numbers = GOOD;
            numbers[index] = bad;
            assert_eq!(Settings::of(&numbers).unwrap_err().field, *name);
        }
    }
    assert_eq!(Settings::of(&GOOD[..7]).unwrap_err().field, "known");
    assert_eq!(Settings::of(&[]).unwrap_err().field, "wheelbase");
}

#[test]
fn test_settings_unknown_vehicle_has_wheels_that_turn_at_once() {
    let mut numbers = GOOD;
    assert_eq!(Settings::of(&numbers).unwrap().believed.dead_time, 0.1);
    numbers[7] = 0.0;
    let settings = Settings::of(&numbers).unwrap();
    let believed = settings.believed;
    assert_eq!(
        (
            believed.steer_lag,
            believed.dead_time,
            believed.max_steer_rate
        ),
        (0.0, 0.0, None)
    );
    assert_eq!(settings.plant.vehicle.steer_lag, 0.15);
}
