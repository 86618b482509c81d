use super::*;
use std::format;

#[test]
fn test_status_conditions_stand_side_by_side() {
    let both = Status::SATURATED | Status::END_OF_PATH;
    assert!(both.contains(Status::SATURATED) && both.contains(Status::END_OF_PATH));
    assert!(!both.contains(Status::OFF_PATH) && both.contains(Status::OK));
    assert_eq!(format!("{both} {}", Status::OK), "saturated|end-of-path ok");
    assert_eq!(both.level(), Level::Degraded);
    assert_eq!((both | Status::INPUT_LOST).level(), Level::Fault);
    assert_eq!(Status::OK.level(), Level::Ok);
    assert_eq!(Status::from_bits(both.bits()), Some(both));
    assert_eq!(Status::from_bits(1 << 31), None);
}

#[test]
fn test_status_every_condition_has_a_bit_of_its_own() {
    let all = Status::NAMES.iter().fold(0, |all, (each, _)| {
        assert_eq!(each.bits().count_ones(), 1);
        assert_eq!(all & each.bits(), 0);
        all | each.bits()
    });
    assert_eq!(all.count_ones(), 14);
}
