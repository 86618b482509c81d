//! The controllers of the playground by name.

use popsteer_core::error::ConfigError;
use popsteer_core::lateral::{Pid, Pop, PreviewPop, PurePursuit, Stanley};
use popsteer_core::{Tracker, Vehicle};
use popsteer_sim::Law;

/// Their names, as on the command line. The third is preview POP for a vehicle whose limits it is
/// not given: it plans as if the wheels could turn at any rate.
pub(crate) const NAMES: [&str; 6] = [
    "pop",
    "preview-pop",
    "preview-pop-unlimited",
    "pure-pursuit",
    "stanley",
    "pid",
];

/// The controller of that name with its default tuning, for a vehicle as it is `believed`.
pub(crate) fn make(name: &str, believed: Vehicle) -> Result<Option<Tracker<Law>>, ConfigError> {
    let unlimited = Vehicle {
        max_steer_rate: None,
        max_lateral_acceleration: None,
        ..believed
    };
    Ok(Some(Tracker::of(match name {
        "pop" => Law::from(Pop::new(believed, Default::default())?),
        "preview-pop" => Law::from(PreviewPop::new(believed, Default::default())?),
        "preview-pop-unlimited" => Law::from(PreviewPop::new(unlimited, Default::default())?),
        "pure-pursuit" => Law::from(PurePursuit::new(believed, Default::default())?),
        "stanley" => Law::from(Stanley::new(believed, Default::default())?),
        "pid" => Law::from(Pid::new(believed, Default::default())?),
        _ => return Ok(None),
    })))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn test_controllers_each_name_makes_one() {
        for name in NAMES {
            assert!(make(name, Vehicle::DEFAULT).unwrap().is_some(), "{name}");
        }
        assert!(make("mpc", Vehicle::DEFAULT).unwrap().is_none());
        let bad = Vehicle {
            wheelbase: 0.0,
            ..Vehicle::DEFAULT
        };
        assert_eq!(make("pop", bad).unwrap_err().field, "wheelbase");
    }
}
