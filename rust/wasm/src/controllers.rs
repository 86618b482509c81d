//! The controllers of the playground by name.

use popsteer_core::error::ConfigError;
use popsteer_core::laws::{
    Pid, PidParams, Pop, PopParams, PreviewPop, PreviewPopParams, PurePursuit, PurePursuitParams,
    Stanley, StanleyParams,
};
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
pub(crate) fn make(name: &str, believed: &Vehicle) -> Result<Option<Tracker<Law>>, ConfigError> {
    let unlimited = Vehicle {
        max_steer_rate: None,
        max_lateral_acceleration: None,
        ..*believed
    };
    Ok(Some(Tracker::of(match name {
        "pop" => Law::from(Pop::new(*believed, PopParams::DEFAULT)?),
        "preview-pop" => Law::from(PreviewPop::new(*believed, PreviewPopParams::DEFAULT)?),
        "preview-pop-unlimited" => {
            Law::from(PreviewPop::new(unlimited, PreviewPopParams::DEFAULT)?)
        }
        "pure-pursuit" => Law::from(PurePursuit::new(*believed, PurePursuitParams::DEFAULT)?),
        "stanley" => Law::from(Stanley::new(*believed, StanleyParams::DEFAULT)?),
        "pid" => Law::from(Pid::new(*believed, PidParams::DEFAULT)?),
        _ => return Ok(None),
    })))
}
