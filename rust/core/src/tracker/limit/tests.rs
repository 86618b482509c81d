use super::*;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

    #[test]
    fn test_lateral_limit_without_the_arc_is_that_of_the_arc(
        wheel in prop_oneof![-1.57..1.57, -1e-7..1e-7, Just(0.0)],
        near in prop_oneof![Just(0.0), -3e-16..3e-16, -2e-9..2e-9, -0.1..0.1],
        at_limit: bool,
        speed in prop_oneof![Just(0.0), -40.0..40.0, -1e4..1e4],
        gain in 0.4..2.5,
        most in prop_oneof![Just(4.0), (-3.0..6.0).prop_map(|e| f64::powf(10.0, e))],
        understeer in prop_oneof![Just(0.0), 0.0..0.01],
    ) {
        let vehicle = Vehicle {
            understeer,
            max_lateral_acceleration: Some(most),
            ..Vehicle::DEFAULT
        };
        let widest = atan(most * vehicle.turning_length(speed) / (speed * speed * gain));
        let wheel = if at_limit {
            (widest * (1.0 + near)).copysign(wheel)
        } else {
            wheel
        };
        let limited = vehicle.limit_lateral_acceleration(wheel, speed, gain);
        prop_assert_eq!(limited.to_bits(), saturate(wheel, -widest, widest).to_bits());
    }
}
