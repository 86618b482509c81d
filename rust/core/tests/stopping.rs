//! Stops on slopes, on a longitudinal vehicle of its own: a drive with dead time and lag, brakes that
//! act against the motion, gravity.

use popsteer_core::Status;
use popsteer_core::math::from_count;
use popsteer_core::speed::{
    SpeedCommand, SpeedTracker, SpeedTrackerParams, SpeedTrackerState, Told,
};
use popsteer_core::{Path, Vehicle, VehicleState};

const DT: f64 = 0.05;
const SUBSTEPS: u32 = 50;
const GRAVITY: f64 = 9.806_65;

/// A vehicle on a straight path along x.
#[derive(Clone, Debug)]
struct Car {
    x: f64,
    speed: f64,
    /// What drive (positive) or brakes (negative) give [m/s²].
    pull: f64,
    lag: f64,
    brakes: f64,
    grade: f64,
    /// Commands that have not arrived yet, oldest first.
    flight: std::collections::VecDeque<f64>,
}

impl Car {
    fn new(speed: f64, lag: f64, grade: f64) -> Self {
        Self {
            x: 0.0,
            speed,
            pull: 0.0,
            lag,
            brakes: 6.0,
            grade,
            flight: std::collections::VecDeque::new(),
        }
    }

    fn after(mut self, delay: usize) -> Self {
        self.flight = std::iter::repeat_n(0.0, delay).collect();
        self
    }

    fn advance(&mut self, command: f64) {
        self.flight.push_back(command);
        let command = self.flight.pop_front().unwrap().max(-self.brakes);
        let dt = DT / f64::from(SUBSTEPS);
        let slope = -GRAVITY * self.grade / self.grade.hypot(1.0);
        for _ in 0..SUBSTEPS {
            self.pull += (command - self.pull) * (1.0 - (-dt / self.lag).exp());
            let free = self.speed + dt * (slope + self.pull.max(0.0));
            let braked = dt * (-self.pull).max(0.0);
            self.speed = free.signum() * (free.abs() - braked).max(0.0);
            self.x += dt * self.speed;
        }
    }
}

/// What a drive came to.
#[derive(Debug, Default)]
struct Driven {
    /// Where it stands, past the end [m].
    past: f64,
    /// Root mean square error of the speed after 3 s [m/s].
    rms: f64,
    /// Strongest deceleration [m/s²].
    hardest: f64,
    standing: bool,
    changes: usize,
    /// When it was first said that it cannot stop [s].
    warned: Option<f64>,
}

fn straight(length: u32, speed: f64, grade: f64) -> Path {
    let x: Vec<f64> = (0..=length).map(f64::from).collect();
    let path = Path::new(&x, &vec![0.0; x.len()], Some(&vec![speed; x.len()]), false).unwrap();
    if grade.abs() > 0.0 {
        path.with_grade(&vec![grade; x.len()]).unwrap()
    } else {
        path
    }
}

fn car(comfort: f64, lag: f64) -> Vehicle {
    Vehicle {
        max_deceleration: Some(comfort),
        brake_deceleration: Some(6.0),
        drive_lag: lag,
        ..Vehicle::DEFAULT
    }
}

fn drive(vehicle: &Vehicle, path: &Path, mut car: Car, time: f64) -> Driven {
    let vehicle = Vehicle {
        drive_delay: vehicle.drive_delay + from_count(car.flight.len()) * DT,
        ..*vehicle
    };
    let tracker = SpeedTracker::new(vehicle, SpeedTrackerParams::DEFAULT).unwrap();
    let plan = tracker.plan(&path.view()).unwrap();
    let mut state = SpeedTrackerState::default();
    let mut driven = Driven::default();
    let (mut squares, mut count) = (0.0, 0_u32);
    for k in 0..popsteer_core::math::to_count(time / DT) {
        let before = car.speed;
        let measured = VehicleState {
            x: car.x,
            speed: car.speed,
            ..VehicleState::ORIGIN
        };
        let command: SpeedCommand = tracker
            .step(&path.view(), &plan, &mut state, measured, DT)
            .unwrap();
        if from_count(k) * DT > 3.0 && !command.standing {
            let error = car.speed - command.reference_speed;
            squares += error * error;
            count += 1;
        }
        car.advance(command.acceleration);
        driven.hardest = driven.hardest.max((before - car.speed) / DT);
        if command.cannot_stop && driven.warned.is_none() {
            driven.warned = Some(from_count(k) * DT);
        }
        driven.changes += usize::from(command.standing != driven.standing);
        driven.standing = command.standing;
    }
    driven.past = car.x - path.view().length();
    driven.rms = (squares / f64::from(count)).sqrt();
    driven
}

#[test]
fn test_speed_tracker_stops_on_slopes_told_and_untold() {
    let mut failed = Vec::new();
    for comfort in [1.5, 3.0] {
        for grade in [0.0, 0.02, -0.02, 0.05, -0.05, 0.08, -0.08, 0.1, -0.1] {
            for (grade_told, lag_told, delay) in [
                (true, true, 0),
                (true, false, 0),
                (false, true, 0),
                (false, false, 0),
                (false, true, 4),
            ] {
                let path = straight(200, 12.0, if grade_told { grade } else { 0.0 });
                let vehicle = car(comfort, if lag_told { 0.3 } else { 0.0 });
                let car = Car::new(12.0, 0.3, grade).after(delay);
                let driven = drive(&vehicle, &path, car, 50.0);
                let most = if grade_told { 0.1 } else { 0.3 };
                let fine = driven.past.abs() <= most
                    && driven.rms <= 0.3
                    && driven.hardest <= comfort + 0.5
                    && (driven.standing && driven.warned.is_none());
                if !fine {
                    failed.push((comfort, grade, grade_told, lag_told, delay, driven));
                }
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

/// Noise of the position as a generator of its own makes it: the sum of twelve uniform numbers.
struct Noise(u64);

impl Noise {
    fn next(&mut self, deviation: f64) -> f64 {
        let mut sum = -6.0;
        for _ in 0..12 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            sum += f64::from(u32::try_from(self.0 >> 32).unwrap()) / 4_294_967_296.0;
        }
        deviation * sum
    }
}

#[test]
fn test_vehicle_stands_through_noise_and_leaves_when_the_path_goes_on() {
    for grade in [0.0, 0.1, -0.1] {
        let tracker = SpeedTracker::new(car(1.5, 0.3), SpeedTrackerParams::DEFAULT).unwrap();
        let (short, long) = (straight(100, 12.0, 0.0), straight(140, 12.0, 0.0));
        let plans = [&short, &long].map(|path| tracker.plan(&path.view()).unwrap());
        let mut state = SpeedTrackerState::default();
        let mut vehicle = Car::new(0.0, 0.3, grade);
        vehicle.x = 99.99;
        vehicle.pull = -3.0;
        let mut noise = Noise(1);
        let mut stood = Vec::new();
        for _ in 0..400 {
            let x = vehicle.x + noise.next(0.02);
            let measured = VehicleState {
                x,
                speed: vehicle.speed,
                ..VehicleState::ORIGIN
            };
            let command = tracker
                .step(&short.view(), &plans[0], &mut state, measured, DT)
                .unwrap();
            vehicle.advance(command.acceleration);
            stood.push(command.standing);
        }
        let changes = stood.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert!(changes <= 1 && *stood.last().unwrap(), "{grade}: {changes}");
        assert!((vehicle.x - 99.99).abs() < 0.05, "{grade}: {}", vehicle.x);
        // A path that ends 40 m further on is gone on along.
        tracker.set_path(&mut state, &short.view(), &long.view());
        for _ in 0..400 {
            let measured = VehicleState {
                x: vehicle.x,
                speed: vehicle.speed,
                ..VehicleState::ORIGIN
            };
            let command = tracker
                .step(&long.view(), &plans[1], &mut state, measured, DT)
                .unwrap();
            vehicle.advance(command.acceleration);
        }
        assert!(
            state.law.standing && (vehicle.x - 140.0).abs() < 0.3,
            "{grade}: {}",
            vehicle.x
        );
    }
}

/// 10 m before the end at 12 m/s: 7.2 m/s² would stop there, and the brakes give 6. Where 5 m/s² do,
/// it stops in its place, harder than a plan brakes.
#[test]
fn test_vehicle_that_cannot_stop_brakes_with_all_it_has_and_says_so_at_once() {
    for (length, cannot) in [(10, true), (18, false)] {
        let path = straight(length, 12.0, 0.0);
        let driven = drive(&car(1.5, 0.05), &path, Car::new(12.0, 0.05, 0.0), 20.0);
        assert!(driven.standing, "{driven:?}");
        if cannot {
            assert!(driven.warned == Some(0.0), "{driven:?}");
            assert!(
                driven.hardest > 5.9 && driven.past > 1.0 && driven.past < 5.0,
                "{driven:?}"
            );
        } else {
            assert!(driven.warned.is_none(), "{driven:?}");
            assert!(
                driven.hardest > 4.0 && driven.past.abs() < 0.2,
                "{driven:?}"
            );
        }
    }
}

/// A speed of 0 is a stop wherever it is, and what comes after it is driven on another path's word.
#[test]
fn test_speed_of_zero_is_a_stop_alone_and_in_a_row_from_a_point_on_and_in_the_midst() {
    let tracker = SpeedTracker::new(car(3.0, 0.2), SpeedTrackerParams::DEFAULT).unwrap();
    let x: Vec<f64> = (0..=60).map(f64::from).collect();
    let cases: [(&dyn Fn(usize) -> bool, f64); 6] = [
        (&|k| k == 30, 30.0),
        (&|k| k >= 30, 30.0),
        (&|k| (30..40).contains(&k), 30.0),
        (&|k| k == 0 || k == 60, 60.0), // a start, and the end
        (&|k| k <= 2, 60.0),            // a start of several waypoints
        (&|_| true, 0.0),
    ];
    for (case, (is_zero, stop)) in cases.iter().enumerate() {
        let speed: Vec<f64> = (0..=60)
            .map(|k| if is_zero(k) { 0.0 } else { 5.0 })
            .collect();
        let path = Path::new(&x, &vec![0.0; 61], Some(&speed), false).unwrap();
        let plan = tracker.plan(&path.view()).unwrap();
        let mut state = SpeedTrackerState::default();
        let mut vehicle = Car::new(0.0, 0.2, 0.0);
        for _ in 0..800 {
            let measured = VehicleState {
                x: vehicle.x,
                speed: vehicle.speed,
                ..VehicleState::ORIGIN
            };
            let command = tracker
                .step(&path.view(), &plan, &mut state, measured, DT)
                .unwrap();
            vehicle.advance(command.acceleration);
        }
        assert!(state.law.standing, "{case}: {}", vehicle.x);
        assert!((vehicle.x - stop).abs() < 0.1, "{case}: {}", vehicle.x);
    }
}

/// What a sensor makes of a car: of its step, the car at each step so far, and what was measured last, a
/// pose with its age.
type Sensor = dyn Fn(usize, &[Car], VehicleState) -> (VehicleState, f64);

fn glitches(k: usize) -> bool {
    k >= 100 && k % 17 == 3
}

/// The car as it was `steps` ago, with that age [s].
fn old(cars: &[Car], steps: usize) -> (VehicleState, f64) {
    let steps = steps.min(cars.len() - 1);
    let car = &cars[cars.len() - 1 - steps];
    (
        at(std::slice::from_ref(car), 0.0, 1.0),
        DT * from_count(steps),
    )
}

fn at(cars: &[Car], off: f64, faster: f64) -> VehicleState {
    let car = cars.last().unwrap();
    VehicleState {
        x: car.x + off,
        speed: car.speed * faster,
        ..VehicleState::ORIGIN
    }
}

#[test]
fn test_speed_tracker_stops_by_poses_that_are_old_repeated_or_wrong_for_a_moment() {
    let path = straight(100, 12.0, 0.0);
    let tracker = SpeedTracker::new(car(1.5, 0.3), SpeedTrackerParams::DEFAULT).unwrap();
    let plan = tracker.plan(&path.view()).unwrap();
    let cases: [(&str, &Sensor); 7] = [
        ("as it is", &|_, car, _| (at(car, 0.0, 1.0), 0.0)),
        ("poses 0.2 s old", &|_, cars, _| old(cars, 4)),
        ("ages of 0 to 0.2 s", &|k, cars, _| old(cars, k % 5)),
        ("a pose in 0.4 s", &|k, car, last| {
            let here = at(car, 0.0, 1.0).x;
            let x = if k % 8 == 0 { here } else { last.x };
            (
                VehicleState {
                    x,
                    ..at(car, 0.0, 1.0)
                },
                0.0,
            )
        }),
        ("glitches ahead", &|k, car, _| {
            (at(car, if glitches(k) { 5.0 } else { 0.0 }, 1.0), 0.0)
        }),
        ("glitches back", &|k, car, _| {
            (at(car, if glitches(k) { -5.0 } else { 0.0 }, 1.0), 0.0)
        }),
        ("glitches of the speed", &|k, car, _| {
            (at(car, 0.0, if glitches(k) { 3.0 } else { 1.0 }), 0.0)
        }),
    ];
    for (name, sensor) in cases {
        let mut state = SpeedTrackerState::default();
        let mut car = Car::new(0.0, 0.3, 0.0);
        let mut measured = VehicleState::ORIGIN;
        let mut cars = Vec::new();
        for k in 0..900 {
            let age;
            cars.push(car.clone());
            (measured, age) = sensor(k, &cars, measured);
            let command = tracker
                .step_told(&path.view(), &plan, &mut state, measured, DT, aged(age))
                .unwrap();
            assert!(!command.cannot_stop, "{name}: step {k}");
            car.advance(command.acceleration);
        }
        assert!(state.law.standing, "{name}: {}", car.x);
        assert!((car.x - 100.0).abs() < 0.1, "{name}: {}", car.x);
    }
    // A pose that repeats for longer is a fault: it brakes, and says so.
    let mut state = SpeedTrackerState::default();
    let frozen = VehicleState {
        x: 90.0,
        speed: 3.0,
        ..VehicleState::ORIGIN
    };
    for k in 0..40 {
        let command = tracker
            .step(&path.view(), &plan, &mut state, frozen, DT)
            .unwrap();
        let fault = command.status.contains(Status::IMPLAUSIBLE);
        assert_eq!(fault, k > 12, "{k}");
        assert!(!fault || command.acceleration < -1.0 || k < 20, "{k}");
    }
}

fn aged(pose_age: f64) -> Told {
    Told {
        pose_age,
        ..Told::default()
    }
}

/// A stop line, forwards and backwards: the stop point is the front's, and backwards the rear axle stops.
#[test]
fn test_stop_point_counts_forwards_and_the_rear_axle_backwards() {
    let x: Vec<f64> = (0..=60).map(f64::from).collect();
    let speed: Vec<f64> = (0..=60).map(|k| if k == 30 { 0.0 } else { 4.0 }).collect();
    for (reverse, stop_point, rests) in [
        (false, None, 30.0),
        (false, Some(3.0), 27.0),
        (true, None, 30.0),
        (true, Some(3.0), 30.0),
    ] {
        let vehicle = Vehicle {
            stop_point,
            ..car(2.0, 0.2)
        };
        let tracker = SpeedTracker::new(vehicle, SpeedTrackerParams::DEFAULT).unwrap();
        let path = Path::new(&x, &[0.0; 61], Some(&speed), false).unwrap();
        let path = path.with_reverse(&[reverse; 61]).unwrap();
        let plan = tracker.plan(&path.view()).unwrap();
        let (mut state, mut vehicle) = (SpeedTrackerState::default(), Car::new(0.0, 0.2, 0.0));
        for _ in 0..500 {
            let (yaw, sign) = if reverse {
                (core::f64::consts::PI, -1.0)
            } else {
                (0.0, 1.0)
            };
            let measured = VehicleState {
                x: vehicle.x,
                y: 0.0,
                yaw,
                speed: sign * vehicle.speed,
            };
            let command = tracker
                .step(&path.view(), &plan, &mut state, measured, DT)
                .unwrap();
            vehicle.advance(command.acceleration);
        }
        assert!(state.law.standing, "{reverse} {stop_point:?}");
        assert!(
            (vehicle.x - rests).abs() < 0.1,
            "{reverse} {stop_point:?} {}",
            vehicle.x
        );
    }
}

/// Weak brakes on slopes up and down: what is left of them decides whether it can stop, and holds it.
#[test]
fn test_weak_brakes_stop_uphill_what_they_cannot_stop_downhill_and_hold_it_on_both() {
    // At 5 m/s 6 m before the end: 2.1 m/s² of 3; a slope of 15 % gives or takes 1.5.
    for (grade, cannot) in [(0.0, false), (0.15, false), (-0.15, true)] {
        let vehicle = Vehicle {
            brake_deceleration: Some(3.0),
            ..car(1.5, 0.05)
        };
        let tracker = SpeedTracker::new(vehicle, SpeedTrackerParams::DEFAULT).unwrap();
        let path = straight(6, 5.0, grade);
        let plan = tracker.plan(&path.view()).unwrap();
        let (mut state, mut vehicle) = (SpeedTrackerState::default(), Car::new(5.0, 0.05, grade));
        vehicle.brakes = 3.0;
        let (mut warned, mut command) = (false, None);
        for _ in 0..200 {
            let measured = at(std::slice::from_ref(&vehicle), 0.0, 1.0);
            let found = tracker
                .step(&path.view(), &plan, &mut state, measured, DT)
                .unwrap();
            warned |= found.cannot_stop;
            vehicle.advance(found.acceleration);
            command = Some(found);
        }
        assert_eq!(warned, cannot, "{grade}: {}", vehicle.x);
        // Held with more than the slope pulls, whichever way that is.
        let hold = -command.unwrap().acceleration;
        let pull = (GRAVITY * grade).abs();
        assert!(
            vehicle.speed.abs() < 1e-9 && hold > 1.5 * pull,
            "{grade}: {hold}"
        );
    }
}

/// A stop line on either side of a lap's seam, and one that was overrun across it.
#[test]
fn test_stop_lines_beside_the_seam_of_a_lap_are_as_far_as_they_are() {
    let count = 126_u32;
    let turn = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(count);
    let radius = 20.0;
    let x: Vec<f64> = (0..count).map(|k| radius * turn(k).sin()).collect();
    let y: Vec<f64> = (0..count).map(|k| radius * (1.0 - turn(k).cos())).collect();
    for line in [2, count - 2] {
        let speed: Vec<f64> = (0..count)
            .map(|k| if k == line { 0.0 } else { 4.0 })
            .collect();
        let path = Path::new(&x, &y, Some(&speed), true).unwrap();
        let tracker = SpeedTracker::new(car(2.0, 0.2), SpeedTrackerParams::DEFAULT).unwrap();
        let plan = tracker.plan(&path.view()).unwrap();
        let length = path.view().length();
        let due = path.view().arc(usize::try_from(line).unwrap());
        let due = if line == 2 { due + length } else { due };
        let (mut state, mut vehicle) = (SpeedTrackerState::default(), Car::new(0.0, 0.2, 0.0));
        vehicle.x = length - 15.0;
        let mut last = 0.0;
        for k in 0..480 {
            if k == 400 {
                vehicle.x += 2.5; // pushed over its line: across the seam, from the one before
            }
            let angle = vehicle.x / length * std::f64::consts::TAU;
            let measured = VehicleState {
                x: radius * angle.sin(),
                y: radius * (1.0 - angle.cos()),
                yaw: angle,
                speed: vehicle.speed,
            };
            let command = tracker
                .step(&path.view(), &plan, &mut state, measured, DT)
                .unwrap();
            vehicle.advance(command.acceleration);
            if k == 399 {
                assert!(command.standing, "{line}");
                assert!(
                    (vehicle.x - due).abs() < 0.15,
                    "{line}: {} {due}",
                    vehicle.x
                );
            }
            last = command.distance_to_stop;
        }
        assert!((last + 2.5).abs() < 0.3, "{line}: {last}");
    }
}
