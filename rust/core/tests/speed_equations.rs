//! Controllers of the speed answer by their equations, by hand.

mod straight;

use popsteer_core::speed::{
    CoupledLongitudinal, CoupledLongitudinalParams, Phase, SpeedPid, SpeedPidParams, SpeedPidState,
    SpeedTracker, SpeedTrackerParams, SpeedTrackerState,
};
use popsteer_core::vehicle::noise::Jitter;
use popsteer_core::{Path, PathView, Vehicle, VehicleState};
use straight::{CAR, assert_close, beside, straight};

#[test]
fn test_coupled_pedals_are_equation_7() {
    let params = CoupledLongitudinalParams {
        cutoff: 0.4,
        steer_limit: 0.8,
        speed_limit: 20.0,
    };
    let law = CoupledLongitudinal::new(params).unwrap();
    for (speed, steer) in [
        (5.0, 0.0),
        (10.0, 0.3),
        (15.0, -0.6),
        (25.0, 0.7),
        (30.0, -0.8),
    ] {
        let pedals = law.step(speed, steer).unwrap();
        let command = 0.4 + ((20.0 - speed) / 20.0 - f64::abs(steer) / 0.8) * 0.6;
        assert_close(pedals.throttle - pedals.brake, command);
        assert!(pedals.throttle.min(pedals.brake) <= 0.0);
    }
}

#[test]
fn test_speed_pid_weighs_the_error_its_integral_and_its_rate() {
    let params = SpeedPidParams {
        kp: 0.1,
        ki: 0.3,
        kd: 0.02,
    };
    let law = SpeedPid::new(params).unwrap();
    let mut state = SpeedPidState::default();
    let (mut integral, mut previous) = (0.0, None);
    for (speed, target) in [
        (5.0, 7.0),
        (5.2, 7.0),
        (6.0, 7.0),
        (7.5, 7.0),
        (8.0, 6.0_f64),
    ] {
        let error = target - speed;
        integral += 0.3 * error * 0.1;
        let rate = previous.map_or(0.0, |previous| (error - previous) / 0.1);
        previous = Some(error);
        let pedals = law.step(&mut state, speed, target, 0.1).unwrap();
        let command: f64 = 0.1 * error + integral + 0.02 * rate;
        assert_close(pedals.throttle - pedals.brake, command);
    }
    // The integral's share does not wind up beyond the range of the command.
    for (target, most) in [(90.0, 1.0), (-90.0, -1.0)] {
        for _ in 0..50 {
            law.step(&mut state, 0.0, target, 0.1).unwrap();
        }
        assert_close(state.integral, most);
    }
    // What it reaches is a state; what it cannot reach is none.
    assert!(law.check_state(&state).is_ok());
    let wound_up = SpeedPidState {
        integral: 1.01,
        ..state
    };
    assert_eq!(law.check_state(&wound_up).unwrap_err().field, "integral");
}

/// The observer of the module `disturbance`, by hand, for a drive without delay; and the biases of the module
/// `bias`, of a vehicle that plans with 3 m/s^2.
struct Observer {
    drive: f64,
    slow: f64,
    speed: Option<f64>,
    estimate: f64,
    biases: Biases,
}

struct Biases {
    speed: [f64; 3],
    push: [f64; 3],
    mean: [f64; 3],
    covariance: [[f64; 3]; 3],
    own: [f64; 3],
}

impl Biases {
    /// Before anything was seen of a drive with this lag.
    fn new(lag: f64) -> Self {
        let deviations = [0.2, 0.1 + 0.25 * lag, 0.1 + 0.25 * lag];
        let mut covariance = [[0.0; 3]; 3];
        for (k, deviation) in deviations.iter().enumerate() {
            covariance[k][k] = deviation * deviation;
        }
        Self {
            speed: [0.0; 3],
            push: [0.0; 3],
            mean: [0.0; 3],
            covariance,
            own: [0.3 * 0.3, 0.0, 0.99 * 0.99],
        }
    }

    fn update(&mut self, error: f64, inputs: [f64; 3], (k, l): (f64, f64), dt: f64) {
        let (noise, slope) = ((0.01_f64 * 3.0).powi(2), (0.005_f64 * 3.0).powi(2) * dt);
        let [v, c, d] = self.own;
        let (v, c, d) = (v + 2.0 * dt * c + dt * dt * d, c + dt * d, d + slope);
        self.own = [
            (1.0 - k).powi(2) * v + k * k * noise,
            (1.0 - k) * (c - l * v) + k * l * noise,
            d - 2.0 * l * c + l * l * (v + noise),
        ];
        let slopes: [f64; 3] =
            core::array::from_fn(|i| self.speed[i] + dt * self.push[i] + inputs[i]);
        let dot = |row: &[f64; 3]| row.iter().zip(&slopes).map(|(a, b)| a * b).sum::<f64>();
        let cross: [f64; 3] = core::array::from_fn(|i| dot(&self.covariance[i]));
        let total = dot(&cross) + v * 0.8 / dt + noise;
        let most = 4.0 * total.sqrt();
        let error = (error - dot(&self.mean)).clamp(-most, most);
        for i in 0..3 {
            self.speed[i] = (1.0 - k) * slopes[i];
            self.push[i] -= l * slopes[i];
            self.mean[i] += cross[i] / total * error;
            for j in 0..3 {
                self.covariance[i][j] -= cross[i] * cross[j] / total;
            }
        }
        self.mean[0] = self.mean[0].clamp(-0.5, 0.0);
        let kept = f64::exp(-dt / 5.0);
        self.mean[0] *= kept;
        for k in 0..3 {
            self.covariance[0][k] *= kept;
            self.covariance[k][0] *= kept;
        }
        self.covariance[0][0] += (1.0 - kept * kept) * 0.2 * 0.2;
    }

    /// `g`, as far as it stands out.
    fn brakes(&self) -> f64 {
        let (g, variance) = (self.mean[0], self.covariance[0][0]);
        if g * g > variance {
            g * (1.0 - variance / (g * g))
        } else {
            0.0
        }
    }
}

impl Observer {
    fn new(lag: f64) -> Self {
        Self {
            drive: 0.0,
            slow: 0.0,
            speed: None,
            estimate: 0.0,
            biases: Biases::new(lag),
        }
    }

    /// What else accelerates the vehicle.
    fn disturbance(&self) -> f64 {
        self.estimate + self.biases.push[0] * self.biases.brakes()
    }

    fn update(
        &mut self,
        (command, known): (f64, f64),
        speed: f64,
        (lag, time): (f64, f64),
        dt: f64,
    ) {
        let answer = |from: f64, lag: f64| command + (from - command) * f64::exp(-dt / lag);
        let mean = command + (self.drive - command) * lag / dt * (1.0 - f64::exp(-dt / lag));
        let last = (self.drive, self.slow);
        self.drive = answer(self.drive, lag);
        self.slow = answer(self.slow, lag + 0.3);
        let before = self.speed.replace(speed);
        let Some(before) = before else { return };
        let predicted = before + dt * (mean + known + self.estimate);
        let error = speed - predicted;
        let explains = |other: &&f64| **other * error > 0.0;
        let others = [self.slow - self.drive, command - self.drive];
        let other = others
            .iter()
            .find(explains)
            .map_or(0.0, |other| other / 1.5);
        let share = 1.0 / (1.0 + other * other);
        let p = f64::exp(-dt / time);
        self.speed = Some(predicted + (1.0 - share * p * p) * error);
        self.estimate = (self.estimate + share * (1.0 - p).powi(2) / dt * error).clamp(-3.0, 3.0);
        let gains = (1.0 - share * p * p, share * (1.0 - p).powi(2) / dt);
        let inputs = [
            (mean * dt).min(0.0),
            last.0 - self.drive,
            last.1 - self.slow,
        ];
        self.biases.update(error, inputs, gains, dt);
    }
}

/// What the law wants of a plan with the square `w` and the acceleration `a` where the lag is over.
fn wanted(square: f64, slope: f64, z: f64) -> f64 {
    let target = square.sqrt();
    let ratio = if slope < 0.0 {
        (z / target).min(2.0)
    } else {
        1.0
    };
    slope * ratio + 1.5 * (target - z)
}

/// `u = z dz*/ds + kp (z* - z) - w` with `z = v + lag (a + w)` at `s + lag v`.
#[test]
fn test_speed_law_leads_the_vehicle_without_its_lag_along_the_plan() {
    let car = Vehicle {
        drive_delay: 0.0,
        drive_lag: 0.3,
        max_acceleration: Some(8.0),
        ..CAR
    };
    let params = SpeedTrackerParams {
        kp: 1.5,
        disturbance_time: 0.8,
        max_jerk: Some(1e6),
        reserve: 10.0,
        ..SpeedTrackerParams::DEFAULT
    };
    let tracker = SpeedTracker::new(car, params).unwrap();
    let gravity = -9.806_65 * f64::atan(0.05).sin();
    let path = straight().with_grade(&[0.05; 100]).unwrap();
    // 1 m/s^2 up to 40 m, and 0.5 m/s^2 back from there on: v^2 is linear between waypoints.
    let squares = |s: f64| if s <= 40.0 { 20.0 + 2.0 * s } else { 140.0 - s };
    let plan: Vec<f64> = (0..100).map(|s| squares(f64::from(s)).sqrt()).collect();
    let dt = 0.1;
    let mut state = SpeedTrackerState::default();
    let mut observer = Observer::new(0.3);
    for (along, faster) in [
        (32.5, 0.3),
        (33.5, 0.1),
        (34.5, 0.15),
        (35.5, 0.2),
        (36.6, 0.1),
        (37.6, 0.4),
    ] {
        let reference = squares(along).sqrt();
        let speed = reference + faster;
        let vehicle = beside(along, 0.4, 0.0, speed);
        if let Some(gate) = &mut state.gate {
            // These speeds are true.
            gate.pace = Jitter::default();
        }
        observer.update((state.law.acceleration, gravity), speed, (0.3, 0.8), dt);
        let command = tracker
            .step(&path.view(), &plan, &mut state, vehicle, dt)
            .unwrap();
        assert_close(command.reference_speed, reference);
        assert_close(command.distance_to_stop, 99.0 - along);
        assert_close(state.law.observer.disturbance, observer.estimate);
        let push = gravity + observer.disturbance();
        let brakes = 1.0 + observer.biases.brakes();
        let given = |u: f64| if u < 0.0 { brakes * u } else { u };
        let z = speed + 0.3 * (given(observer.drive) + push);
        let place = along + 0.3 * speed;
        let slope = if place + 0.05 * z < 40.0 { 1.0 } else { -0.5 };
        let expected = wanted(squares(place), slope, z) - push;
        let expected = expected / if expected < 0.0 { brakes } else { 1.0 };
        assert_close(command.acceleration, expected.max(-6.0));
        assert!(!command.reverse && !command.standing && !command.cannot_stop);
    }
    // Vehicle's limits hold for what is wanted: what gravity and drag take is given besides.
    let limited = |reserve, speed, along| {
        let params = SpeedTrackerParams { reserve, ..params };
        let tracker = SpeedTracker::new(car, params).unwrap();
        let vehicle = beside(along, 0.0, 0.0, speed);
        let mut state = SpeedTrackerState::default();
        let command = tracker.step(&straight().view(), &plan, &mut state, vehicle, dt);
        command.unwrap().acceleration
    };
    assert_close(limited(0.25, 1.0, 38.3), 8.25);
    assert_close(limited(0.25, 14.0, 45.0), -3.25);
    // The acceleration changes no faster than the largest jerk.
    let smooth = SpeedTrackerParams {
        max_jerk: Some(2.0),
        ..params
    };
    let smooth = SpeedTracker::new(car, smooth).unwrap();
    let mut state = SpeedTrackerState::default();
    let slow = beside(38.3, 0.0, 0.0, 1.0);
    for k in 1..6 {
        let command = smooth
            .step(&straight().view(), &plan, &mut state, slow, dt)
            .unwrap();
        assert_close(command.acceleration, 0.2 * f64::from(k));
    }
}

fn speed_tracker(drive_delay: f64) -> SpeedTracker {
    let params = SpeedTrackerParams {
        max_jerk: Some(1e6),
        reserve: 10.0,
        ..SpeedTrackerParams::DEFAULT
    };
    let car = Vehicle { drive_delay, ..CAR };
    SpeedTracker::new(car, params).unwrap()
}

/// The stopping curve, by hand: `y = J t^3 / 6`, `z* = J t^2 / 2` for the last `T = 1.5 (delay + dt)`, and a
/// constant deceleration of 3 m/s^2 before.
#[test]
fn test_speed_law_brakes_along_the_curve_that_ends_at_the_stop() {
    let tracker = speed_tracker(0.1);
    let path = straight();
    let plan = [6.0; 100];
    let step = |left: f64, speed: f64| {
        let mut state = SpeedTrackerState::default();
        let vehicle = beside(99.0 - left, 0.0, 0.0, speed);
        tracker
            .step(&path.view(), &plan, &mut state, vehicle, 0.1)
            .unwrap()
    };
    let time = 1.5 * (0.1 + 0.1);
    let jerk = 3.0 / time;
    let end = 3.0 * time * time / 6.0;
    let curve = |y: f64| {
        if y < end {
            let t = (6.0 * y / jerk).cbrt();
            (0.5 * jerk * t * t, jerk * t)
        } else {
            ((0.25 * 9.0 * time * time + 6.0 * (y - end)).sqrt(), 3.0)
        }
    };
    for (left, speed) in [
        (6.5, 5.9),
        (6.0, 5.8),
        (3.0, 4.0),
        (0.3, 0.8),
        (0.2, 0.4),
        (0.1, 0.2),
    ] {
        let y = left - 0.1 * speed;
        let (target, _) = curve(y);
        let (_, braking) = curve(y - 0.05 * speed);
        let ratio = (speed / target).min(2.0);
        let command = step(left, speed);
        let expected: f64 = -braking * ratio + 1.5 * (target - speed);
        assert_close(command.acceleration, expected.max(-6.0));
        assert_close(command.distance_to_stop, left);
        assert_eq!(command.phase, Phase::Stopping);
    }
    // Far enough off it is not braked yet; 3 m/s^2 from 0.3 m/s take 1.5 cm, and the delay 3 cm.
    assert!(step(84.0, 6.0).acceleration.abs() < 1e-9);
    assert!(!step(0.053, 0.3).standing);
    let arrived = step(0.051, 0.3);
    assert!(arrived.standing);
    assert_close(arrived.acceleration, -3.0);
}

#[test]
fn test_speed_tracker_goes_on_across_the_seam_and_across_a_change_of_the_path() {
    let tracker = speed_tracker(0.5);
    let side = |k: u32| f64::from(k % 40);
    let point = |k: u32| match k / 40 {
        0 => (side(k), 0.0),
        1 => (40.0, side(k)),
        2 => (40.0 - side(k), 40.0),
        _ => (0.0, 40.0 - side(k)),
    };
    let (x, y): (Vec<f64>, Vec<f64>) = (0..160).map(point).unzip();
    let closed = Path::new(&x, &y, None, true).unwrap();
    // Before the seam the speed rises, after it it falls.
    let squares = |k: u32| {
        if k < 80 {
            100.0 - f64::from(k)
        } else {
            f64::from(k) - 60.0
        }
    };
    let plan: Vec<f64> = (0..160).map(|k| squares(k).sqrt()).collect();
    for (arc, planned) in [(150.0, 0.5), (158.0, -0.5), (2.0, -0.5)] {
        let (x, y, yaw) = if arc < 80.0 {
            (arc, 0.0, 0.0)
        } else {
            (0.0, 160.0 - arc, -std::f64::consts::FRAC_PI_2)
        };
        let square = if arc < 80.0 { 100.0 - arc } else { arc - 60.0 };
        let speed = f64::sqrt(square);
        let vehicle = VehicleState { x, y, yaw, speed };
        let mut state = SpeedTrackerState::default();
        let command = tracker
            .step(&closed.view(), &plan, &mut state, vehicle, 0.1)
            .unwrap();
        assert_close(command.reference_speed, speed);
        let later = (arc + 0.5 * speed) % 160.0;
        let then = if later < 80.0 {
            100.0 - later
        } else {
            later - 60.0
        };
        assert_close(command.acceleration, wanted(then, planned, speed));
        assert!(command.distance_to_stop.is_infinite() && !command.reverse);
    }
    let mut state = SpeedTrackerState {
        waypoint: Some(30),
        ..SpeedTrackerState::default()
    };
    let after = |new: &Path, state: &mut SpeedTrackerState| {
        tracker.set_path(state, &closed.view(), &new.view());
        state.waypoint
    };
    // The same there: the place is kept. Shorter, or with other numbers: it is found again.
    let open = Path::new(&x[..50], &y[..50], None, false).unwrap();
    assert_eq!(after(&open, &mut state), Some(30));
    let shorter = Path::new(&x[..30], &y[..30], None, false).unwrap();
    let later = Path::new(&x[1..50], &y[1..50], None, false).unwrap();
    for (new, found) in [(shorter, 28), (later, 29)] {
        let mut state = state;
        assert_eq!(after(&new, &mut state), Some(found));
    }
}

/// The plan beyond a cusp is that of the way back: nobody drives by it before the cusp.
#[test]
fn test_speed_tracker_takes_no_acceleration_from_beyond_a_cusp() {
    let tracker = speed_tracker(1.0);
    let x = [0.0, 5.0, 10.0, 5.0, 0.0];
    let path = Path::new(&x, &[0.0; 5], None, false).unwrap();
    let path = path
        .with_reverse(&[false, false, true, true, true])
        .unwrap();
    let plan = [3.0, 3.0, 0.0, 3.0, 3.0];
    let vehicle = VehicleState {
        x: 9.8,
        y: 0.0,
        yaw: 0.0,
        speed: 0.25,
    };
    let mut state = SpeedTrackerState::default();
    let command = tracker
        .step(&path.view(), &plan, &mut state, vehicle, 0.1)
        .unwrap();
    // Within its delay of 1 s it is past the cusp.
    assert_close(command.distance_to_stop, 0.2);
    assert!(command.acceleration < 0.0);
}

/// Just before the seam of a lap, the acceleration is that of its first segment.
#[test]
fn test_speed_tracker_looks_across_the_seam() {
    let tracker = speed_tracker(0.1);
    let x = [0.0, 0.5, 1.0, 60.0, 60.0, 0.0];
    let y = [0.0, 0.0, 0.0, 0.0, 40.0, 40.0];
    let path = Path::new(&x, &y, None, true).unwrap();
    // 2 m/s^2 in the first half metre, back in the second.
    let plan = [1.0, 3.0_f64.sqrt(), 1.0, 1.0, 1.0, 1.0];
    let vehicle = VehicleState {
        x: 0.0,
        y: 0.05,
        yaw: -std::f64::consts::FRAC_PI_2,
        speed: 1.0,
    };
    let mut state = SpeedTrackerState::default();
    let command = tracker
        .step(&path.view(), &plan, &mut state, vehicle, 0.1)
        .unwrap();
    // 5 cm before the seam, and 10 cm on when the command begins to act.
    assert_close(command.acceleration, wanted(1.0 + 4.0 * 0.05, 2.0, 1.0));
}

/// A view that is given other directions than its path has stops where these change.
#[test]
fn test_stops_are_those_of_the_directions_that_a_view_is_given() {
    let tracker = speed_tracker(0.0);
    let x = [0.0, 5.0, 10.0, 15.0, 20.0];
    let path = Path::new(&x, &[0.0; 5], None, false).unwrap();
    let path = path.with_reverse(&[false, true, true, true, true]).unwrap();
    let onwards = [false, false, false, true, true];
    let vehicle = VehicleState {
        x: 2.0,
        y: 0.0,
        yaw: 0.0,
        speed: 1.0,
    };
    let stop = |path: &PathView<'_>| {
        let mut state = SpeedTrackerState::default();
        let command = tracker.step(path, &[1.0; 5], &mut state, vehicle, 0.1);
        command.unwrap().distance_to_stop
    };
    assert_close(stop(&path.view()), 3.0);
    assert_close(stop(&path.view().with_reverse(&onwards).unwrap()), 13.0);
}
