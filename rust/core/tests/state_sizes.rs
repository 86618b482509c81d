//! What a state takes [bytes]: it is kept for each vehicle, and copied where a step is tried out.
//!
//! A state that grows past its bound either holds too much, or the bound is raised knowingly.

use core::mem::size_of;

use popsteer_core::laws::{PidState, PopState, PreviewPopState, PurePursuitState, StanleyState};
use popsteer_core::tracker::{MonitorState, TrackerState};
use popsteer_core::vehicle::{Estimator, InFlight, Past};

/// 196 commands in flight, 130 past angles, and all the rest.
const TRACKER: usize = 3160 + 2120 + 1544;

#[test]
fn test_states_of_controllers_are_no_larger_than_recorded() {
    for (name, size, most) in [
        ("stanley", size_of::<StanleyState>(), 0),
        ("pop", size_of::<PopState>(), 8),
        ("pure pursuit", size_of::<PurePursuitState>(), 8),
        ("preview pop", size_of::<PreviewPopState>(), 16),
        // 500 terms of the integral, whatever the length of the buffer.
        ("pid", size_of::<PidState>(), 4080),
    ] {
        assert!(size <= most, "{name}: {size} of {most}");
    }
}

#[test]
fn test_state_of_a_tracker_is_no_larger_than_recorded() {
    for (name, size, most) in [
        ("in flight", size_of::<InFlight>(), 3160),
        ("past", size_of::<Option<Past>>(), 2120),
        ("estimator", size_of::<Estimator>(), 752),
        ("monitor", size_of::<MonitorState>(), 272),
        ("all", size_of::<TrackerState<StanleyState>>(), TRACKER),
    ] {
        assert!(size <= most, "{name}: {size} of {most}");
    }
}
