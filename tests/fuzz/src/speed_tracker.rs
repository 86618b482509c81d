//! The tracker of planned speeds: its plan, and a life of good and bad inputs along it.

use crate::bytes::Bytes;
use crate::scene::{Waypoints, car, dt, symmetric, vehicle};
use popsteer_core::bounds::{MAX_DT, MIN_DT};
use popsteer_core::speed::bias::Bias;
use popsteer_core::speed::disturbance::{MAX_DISTURBANCE, Observer};
use popsteer_core::speed::{
    SpeedCommand, SpeedState, SpeedTracker, SpeedTrackerParams, SpeedTrackerState, Told,
};
use popsteer_core::status::HOLD_LIMIT;
use popsteer_core::{Path, PathView, Status, Vehicle};

/// What stands for the limits that a vehicle does not say: top speed [m/s] and acceleration
/// [m/s^2].
const UNSAID: (f64, f64) = (25.0, 2.0);

/// What may have been found of a drive, or not.
fn bias(bytes: &mut Bytes) -> Bias {
    let mut drawn = Bias::new(0.3, 3.0);
    for k in 0..3 {
        drawn.speed[k] = symmetric(bytes, 1.0, 1e9);
        drawn.push[k] = symmetric(bytes, 1.0, 1e9);
        drawn.mean[k] = symmetric(bytes, 0.5, 1e9);
        for other in 0..3 {
            drawn.covariance[(k, other)] = symmetric(bytes, 0.1, 1e9);
        }
    }
    drawn
}

/// One life on one path, and on the one that replaces it.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let (Ok(first), Ok(second)) = (
        Waypoints::draw(&mut bytes).path(),
        Waypoints::draw(&mut bytes).path(),
    ) else {
        return;
    };
    let standard = SpeedTrackerParams::DEFAULT;
    let kp = bytes.parameter(standard.kp, [0.0, 5.0], [0.0, 1e3]);
    let disturbance_time = bytes.parameter(standard.disturbance_time, [0.1, 5.0], [1e-3, 1e3]);
    let jerk = bytes.parameter(20.0, [1.0, 50.0], [1e-3, 1e6]);
    let params = SpeedTrackerParams {
        kp,
        disturbance_time,
        max_jerk: Some(jerk),
        reserve: bytes.parameter(standard.reserve, [0.0, 2.0], [0.0, 1e3]),
        drive_delay: None,
    };
    let drawn = car(&mut bytes);
    let tracker = match SpeedTracker::new(drawn, params) {
        Ok(tracker) => tracker,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    let (Some(first), Some(second)) = (
        planned(&tracker, (&drawn, jerk), first),
        planned(&tracker, (&drawn, jerk), second),
    ) else {
        return;
    };
    let mut life = Life {
        tracker,
        params,
        most: drawn.max_acceleration.unwrap_or(UNSAID.1) + params.reserve + MAX_DISTURBANCE,
        top: drawn.max_speed.unwrap_or(UNSAID.0),
        least: -drawn.strongest_braking(),
        on: first,
        other: second,
        state: SpeedTrackerState::default(),
    };
    for _ in 0..24 {
        if bytes.is_empty() {
            break;
        }
        life.go_on(&mut bytes);
    }
}

/// A path and its plan, whose speeds keep the limits; none where the vehicle's are no plan's.
fn planned(
    tracker: &SpeedTracker,
    (car, jerk): (&Vehicle, f64),
    path: Path,
) -> Option<(Path, Vec<f64>)> {
    let view = path.view();
    let plan = match tracker.plan(&view) {
        Ok(plan) => plan,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return None;
        }
    };
    assert_eq!(plan.len(), view.len());
    let top = car.max_speed.unwrap_or(UNSAID.0);
    for (k, &speed) in plan.iter().enumerate() {
        let own = view.speed().map_or(f64::INFINITY, |speeds| speeds[k].abs());
        // A 0, or less than 1 mm/s, beside a start or a cusp is no stop: it is crept through.
        let own = if own >= 1e-3 {
            own
        } else {
            0.1 * car.wheelbase
        };
        // The squares of speeds below 1e-150 m/s are rounded to few digits.
        let most = top.min(own) + 1e-150;
        assert!((0.0..=most).contains(&speed), "{speed} at {k}");
    }
    if !view.is_closed() {
        assert!(plan[view.len() - 1] <= 0.0, "it stops at the end");
    }
    let driving = car.max_acceleration.unwrap_or(UNSAID.1);
    let braking = car.comfort_braking();
    for segment in 0..view.segments() {
        let next = (segment + 1) % view.len();
        let (from, to) = (plan[segment] * plan[segment], plan[next] * plan[next]);
        let rise = to - from;
        let (x, y) = (view.x(), view.y());
        let length = 2.0 * (x[next] - x[segment]).hypot(y[next] - y[segment]);
        // The spacing is a difference of arc lengths, and a speed rounded off to the jerk one of places.
        let times = jerk / (driving + braking) * from.max(to).sqrt();
        let places = 1e-15 * view.length() * (driving.max(braking) + 4.0 * times);
        let rounding = 1e-9 * from.max(to) + places + 1e-12;
        let range = -braking * length - rounding..=driving * length + rounding;
        assert!(
            range.contains(&rise),
            "{rise} not in {range:?} at {segment}: {plan:?}"
        );
    }
    Some((path, plan))
}

struct Life {
    tracker: SpeedTracker,
    params: SpeedTrackerParams,
    /// Bound of the speed command [m/s].
    top: f64,
    /// Bounds of the acceleration [m/s^2].
    least: f64,
    most: f64,
    on: (Path, Vec<f64>),
    other: (Path, Vec<f64>),
    state: SpeedTrackerState,
}

impl Life {
    fn go_on(&mut self, bytes: &mut Bytes) {
        match bytes.below(16) {
            0 => self.state = SpeedTrackerState::default(),
            1 => self.restore(bytes),
            2 => {
                let before = self.state;
                let same = self.on.0.clone();
                let (old, new) = (self.on.0.view(), same.view());
                self.tracker.set_path(&mut self.state, &old, &new);
                assert_eq!(self.state, before, "the same path changes nothing");
            }
            3 => {
                let (old, new) = (self.on.0.view(), self.other.0.view());
                self.tracker.set_path(&mut self.state, &old, &new);
                std::mem::swap(&mut self.on, &mut self.other);
            }
            _ => self.step(bytes),
        }
        let view = self.on.0.view();
        assert_eq!(self.tracker.check_state(&view, &self.state), Ok(()));
    }

    /// A state made up, where it is one that the tracker could have.
    fn restore(&mut self, bytes: &mut Bytes) {
        let wanted = SpeedTrackerState {
            waypoint: (bytes.byte() & 1 == 0).then(|| usize::from(bytes.byte() / 4)),
            law: SpeedState {
                acceleration: symmetric(bytes, 5.0, 1e4),
                observer: Observer {
                    disturbance: symmetric(bytes, 0.5, 3.0),
                    bias: (bytes.byte() & 1 == 0).then(|| bias(bytes)),
                    ..Observer::default()
                },
                standing: bytes.byte() & 1 == 0,
                waits: (bytes.number([0.0, 3.0], [0.0, 1e3]), 0.0),
                ..SpeedState::default()
            },
            ..SpeedTrackerState::default()
        };
        match self.tracker.check_state(&self.on.0.view(), &wanted) {
            Ok(()) => self.state = wanted,
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }

    fn step(&mut self, bytes: &mut Bytes) {
        let (path, plan) = &self.on;
        let view = path.view();
        let measured = vehicle(bytes, &view);
        let dt = dt(bytes);
        let age = bytes.number([0.0, 0.3], [-0.1, 1.1]);
        let before = self.state;
        // The rounding of two stamps makes an age of 0 negative.
        let aged = age <= 1.0 && age > -MIN_DT;
        let good = measured.checked().is_ok() && dt.is_finite() && aged;
        let told = Told {
            pose_age: age,
            reverse_gear: (bytes.byte() < 64).then(|| bytes.byte() & 1 == 0),
            stop: bytes.byte() < 8,
        };
        let answer = self
            .tracker
            .step_told(&view, plan, &mut self.state, measured, dt, told);
        assert_eq!(answer.is_ok(), good);
        match answer {
            Err(error) => {
                assert!(!error.to_string().is_empty());
                assert_eq!(self.state, before, "a refused input changes nothing");
            }
            Ok(command) if !(1e-6..=MAX_DT).contains(&dt) => {
                let held = before.held.saturating_add(1);
                assert_eq!(self.state, SpeedTrackerState { held, ..before });
                let last = before.command.map(|last| SpeedCommand {
                    status: command.status,
                    ..last
                });
                assert!(last.is_none_or(|last| last == command), "{command:?}");
                assert!(last.is_some() || (command.standing && command.acceleration == 0.0));
                let lost = command.status.contains(Status::INPUT_LOST);
                assert_eq!(lost, held > HOLD_LIMIT);
                assert!(lost || command.status == Status::INPUT_HELD);
            }
            Ok(command) => self.check_command(&view, before.law.acceleration, &command, dt),
        }
    }

    fn check_command(&self, path: &PathView<'_>, before: f64, command: &SpeedCommand, dt: f64) {
        let SpeedCommand {
            acceleration,
            speed,
            reference_speed,
            distance_to_stop,
            ..
        } = *command;
        assert!(acceleration.to_bits() == self.state.law.acceleration.to_bits());
        assert!(reference_speed >= 0.0 && reference_speed.is_finite());
        assert!((-self.top..=self.top).contains(&speed), "{speed}");
        assert!(!distance_to_stop.is_nan() && distance_to_stop <= f64::INFINITY);
        let segment = self.state.waypoint.expect("a step knows its place");
        assert!(segment < path.segments());
        // Within the bounds, or on the way back to them at the full jerk from where it was; a change
        // of direction starts from 0.
        let change = self.params.max_jerk.unwrap_or(0.0) * dt;
        let rounding = 1e-12 * (1.0 + before.abs() + change);
        let within = |from: f64| {
            let low = self.least.max(from - change).min(from + change) - rounding;
            let high = self.most.min(from + change).max(from - change) + rounding;
            (low..=high).contains(&acceleration)
        };
        // A vehicle at rest is held at once, and let go where its slope begins to move it.
        let noise = self
            .state
            .gate
            .map_or(0.0, |gate| gate.pace.variance.sqrt());
        let rests = self.state.law.speed.abs() < 0.03 + 3.0 * noise;
        let free = (self.least..=self.most.max(before) + change + MAX_DISTURBANCE + rounding)
            .contains(&acceleration);
        assert!(
            within(before) || within(0.0) || (rests && free),
            "{acceleration}"
        );
    }
}
