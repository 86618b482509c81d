//! The bound of a hand-over.

use super::*;

#[test]
fn test_handover_reaches_from_one_end_of_the_wheels_to_the_other() {
    let car = Vehicle {
        max_steer: 0.6,
        steer_offset: -0.05,
        ..Vehicle::PAPER
    };
    let most = 1.2 + 0.05 + Estimator::MAX_STEER_OFFSET;
    assert!((widest_offset(&car) - most).abs() < 1e-15);
}
