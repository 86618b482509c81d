//! What the monitor knows after a motion that was not seen.

use popsteer_core::laws::{Stanley, StanleyParams};
use popsteer_core::tracker::{MonitorParams, MonitorState, Reported, TrackerState};
use popsteer_core::vehicle::Noise;
use popsteer_core::{Path, Tracker, Vehicle, VehicleState};

const DT: f64 = 0.05;

/// After a period that is too long nothing of the motion before it counts: what the monitor then says is
/// what one says that knows the noise and the offset of before, and has seen no motion.
#[test]
fn test_monitor_after_an_interruption_answers_as_one_that_has_seen_no_motion() {
    let law = Stanley::new(Vehicle::PAPER, StanleyParams::DEFAULT).unwrap();
    let tracker = Tracker::of(law)
        .monitored(Some(MonitorParams::DEFAULT))
        .unwrap();
    let path = Path::new(&[-100.0, 500.0], &[0.0, 0.0], None, false).unwrap();
    let step = |state: &mut TrackerState<_>, k: u32, dt: f64| {
        let turned = 0.3 * (0.4 * f64::from(k)).sin() + 0.002 * f64::from(k % 3);
        let vehicle = VehicleState {
            x: 0.2 * f64::from(k),
            y: 2.0 * (0.1 * f64::from(k)).cos(),
            yaw: turned,
            speed: 4.0,
        };
        tracker
            .step(&path.view(), state, vehicle, dt, Reported::NOTHING)
            .unwrap();
    };
    let mut first = tracker.initial_state();
    step(&mut first, 0, DT);
    let unmoved = first.monitor.unwrap();
    let mut state = tracker.initial_state();
    for k in 0..50 {
        step(&mut state, k, DT);
    }
    let moved = state.monitor.unwrap();
    assert!(moved.turned.most() > 0.0 && moved.noise.last.is_some());
    let mut fresh = state;
    fresh.monitor = Some(MonitorState {
        wheel: moved.wheel,
        noise: Noise {
            last: None,
            ..moved.noise
        },
        known: moved.known,
        gain: moved.gain,
        heading: moved.heading,
        alarm: moved.alarm,
        within: moved.within,
        ..unmoved
    });
    for (k, dt) in [(50, 0.71), (51, DT), (52, DT), (53, DT), (54, DT)] {
        step(&mut state, k, dt);
        step(&mut fresh, k, dt);
        assert_eq!(state.monitor, fresh.monitor, "step {k}");
    }
}
