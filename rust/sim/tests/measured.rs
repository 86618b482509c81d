//! What a simulation measures, by hand: vehicles on rails, whose errors are known.

use std::sync::Arc;

use popsteer_core::path::Follow;
use popsteer_core::{Path, Point, Status, Vehicle, VehicleState};
use popsteer_sim::plant::KinematicBicycle;
use popsteer_sim::{Control, Plant, PlantState, Settings, Simulation};

const CAR: Vehicle = Vehicle {
    steer_offset: 0.02,
    ..Vehicle::PAPER
};

fn count(number: usize) -> f64 {
    popsteer_core::math::from_count(number)
}

fn close(number: f64, expected: f64) -> bool {
    (number - expected).abs() <= 1e-9
}

/// Beside a straight path from the origin: the wheels' angle is at once its heading error [rad] and
/// a tenth of its cross-track error [m], and the throttle a tenth of its speed [m/s].
#[derive(Debug)]
struct Beside {
    path_yaw: f64,
}

impl Plant for Beside {
    fn name(&self) -> &'static str {
        "beside"
    }

    fn vehicle(&self) -> &Vehicle {
        &CAR
    }

    fn advance(&self, state: &mut PlantState, control: Control, dt: f64, substeps: usize) {
        let (sin, cos) = self.path_yaw.sin_cos();
        let at = &mut state.vehicle;
        let along = at.x * cos + at.y * sin + at.speed * dt * count(substeps);
        let left = 10.0 * control.steer;
        (at.x, at.y) = (along * cos - left * sin, along * sin + left * cos);
        at.yaw = self.path_yaw + control.steer;
        at.speed = 10.0 * control.throttle;
    }
}

fn straight(yaw: f64) -> Arc<Path> {
    let points: Vec<f64> = (0..100).map(f64::from).collect();
    let x: Vec<f64> = points.iter().map(|s| s * yaw.cos()).collect();
    let y: Vec<f64> = points.iter().map(|s| s * yaw.sin()).collect();
    Arc::new(Path::new(&x, &y, Some(&[7.0; 100]), false).unwrap())
}

fn tracked() -> Follow {
    Follow::of(&CAR, CAR.rear_axle, 0.0)
}

/// Mean, root of the mean square and largest of absolute values.
fn stats(errors: &[f64]) -> [f64; 3] {
    let mean = errors.iter().map(|e| e.abs()).sum::<f64>() / count(errors.len());
    let squares = errors.iter().map(|e| e * e).sum::<f64>() / count(errors.len());
    [
        mean,
        squares.sqrt(),
        errors.iter().fold(0.0, |most, e| e.abs().max(most)),
    ]
}

#[test]
fn test_metrics_of_a_run_are_those_of_its_errors() {
    let yaw = 0.4;
    let settings = Settings {
        dt: 0.05,
        settling_time: 0.1,
        stop_distance: 60.0,
        ..Settings::DEFAULT
    };
    let start = VehicleState {
        x: 0.0,
        y: 0.0,
        yaw,
        speed: 4.0,
    };
    let plant = Arc::new(Beside { path_yaw: yaw });
    let mut simulation = Simulation::new(straight(yaw), plant, start, tracked(), settings).unwrap();
    assert_eq!(*simulation.settings(), settings);
    assert!(close(simulation.progress(), 3.0 / 99.0) && !simulation.is_finished());

    let steers = [0.11, -0.08, 0.05, -0.13, 0.01, -0.02];
    let throttles = [0.3, 0.9, 0.2, 0.7, 1.0, 0.4];
    let status = [
        Status::OK,
        Status::INPUT_LOST,
        Status::OK,
        Status::OK,
        Status::OK,
        Status::OK,
    ];
    for ((&steer, &throttle), &status) in steers.iter().zip(&throttles).zip(&status) {
        let control = Control {
            steer,
            throttle,
            ..Control::default()
        };
        simulation
            .step(control, Point::new(1.0, 2.0), status)
            .unwrap();
    }
    // A step is measured before the vehicle moves; the command 0 is 0.02 at the wheels.
    let headings: Vec<f64> = [0.0]
        .into_iter()
        .chain(steers[..5].iter().map(|steer| steer + 0.02))
        .collect();
    let offsets: Vec<f64> = headings.iter().map(|angle| 10.0 * angle).collect();
    let speeds: Vec<f64> = [4.0]
        .into_iter()
        .chain(throttles[..5].iter().map(|throttle| 10.0 * throttle))
        .collect();
    let rates: Vec<f64> = steers.windows(2).map(|w| (w[1] - w[0]) / 0.05).collect();
    assert_eq!(simulation.records().len(), 6);
    for (k, record) in simulation.records().iter().enumerate() {
        assert!(close(record.time, 0.05 * count(k)));
        assert!(close(record.cross_track_error, offsets[k]));
        assert!(close(record.heading_error, headings[k]));
        assert!(close(record.rear_cross_track_error, offsets[k]));
        assert!(close(record.rear_heading_error, headings[k]));
        assert!(close(record.steer, steers[k]) && close(record.throttle, throttles[k]));
        assert_eq!(record.target, Point::new(1.0, 2.0));
    }
    let metrics = simulation.metrics();
    for errors in [metrics.reference, metrics.rear_axle] {
        for (got, of) in [
            (errors.cross_track, &offsets[..]),
            (errors.settled_cross_track, &offsets[2..]),
            (errors.heading, &headings[..]),
            (errors.settled_heading, &headings[2..]),
        ] {
            let [mean_abs, rms, max_abs] = stats(of);
            assert!(close(got.mean_abs, mean_abs) && close(got.rms, rms));
            assert!(close(got.max_abs, max_abs));
        }
    }
    assert!(close(metrics.rms_steer_rate, stats(&rates)[1]));
    assert!(close(metrics.max_abs_steer, 0.13));
    let gone: f64 = speeds.iter().map(|speed| speed.abs()).sum();
    assert!(close(metrics.mean_speed, gone / 6.0));
    assert!(close(metrics.time, 0.3) && metrics.steps == 6 && !metrics.finished);
    assert_eq!(metrics.faults, Status::INPUT_LOST);

    // The front axle leads; at the end it has at most the stop distance ahead of it.
    let travelled = 0.05 * speeds.iter().sum::<f64>();
    assert!(close(simulation.progress(), (travelled + 3.0) / 99.0));
    let ahead = |arc: f64| {
        let control = Control {
            steer: -0.02,
            throttle: 1.0,
            ..Control::default()
        };
        let (sin, cos) = yaw.sin_cos();
        let start = VehicleState {
            x: arc * cos,
            y: arc * sin,
            yaw,
            speed: 10.0,
        };
        let plant = Arc::new(Beside { path_yaw: yaw });
        let mut simulation =
            Simulation::new(straight(yaw), plant, start, tracked(), settings).unwrap();
        simulation
            .step(control, Point::default(), Status::OK)
            .unwrap();
        simulation.is_finished()
    };
    // 99 m less 60 m, less the wheelbase, less the step of 0.5 m.
    assert!(!ahead(35.4) && ahead(35.6));
}

/// Round and round the unit circle times 20.
#[derive(Debug)]
struct Round;

const RADIUS: f64 = 20.0;

fn on_circle(angle: f64, speed: f64) -> VehicleState {
    VehicleState {
        x: RADIUS * angle.cos(),
        y: RADIUS * angle.sin(),
        yaw: angle + std::f64::consts::FRAC_PI_2,
        speed,
    }
}

impl Plant for Round {
    fn name(&self) -> &'static str {
        "round"
    }

    fn vehicle(&self) -> &Vehicle {
        &Vehicle::PAPER
    }

    fn advance(&self, state: &mut PlantState, _: Control, dt: f64, substeps: usize) {
        let at = state.vehicle;
        let angle = at.y.atan2(at.x) + at.speed * dt * count(substeps) / RADIUS;
        state.vehicle = on_circle(angle, at.speed);
    }
}

/// Whichever way a waypoint is passed at which the arc begins again, the share of a lap grows with
/// the way; a lap ends where it began.
#[test]
fn test_lap_counts_the_way_across_the_seam() {
    let angles = (0..400).map(|k| f64::from(k) * std::f64::consts::TAU / 400.0);
    let (x, y): (Vec<f64>, Vec<f64>) = angles
        .map(|angle| (RADIUS * angle.cos(), RADIUS * angle.sin()))
        .unzip();
    let path = Arc::new(Path::new(&x, &y, None, true).unwrap());
    let length = path.view().length();
    let settings = Settings::DEFAULT;
    // Its front axle, 3 m ahead, is just before the seam.
    let start = on_circle(-0.2, 10.0);
    let follow = Follow::of(&Vehicle::PAPER, 0.0, 0.0);
    let mut lap = Simulation::new(path, Arc::new(Round), start, follow, settings).unwrap();
    let mut steps = 0;
    while !lap.is_finished() {
        lap.step(Control::default(), Point::default(), Status::OK)
            .unwrap();
        steps += 1;
        let way = 0.5 * f64::from(steps) / length;
        assert!((lap.progress() - way).abs() < 1e-3, "{way}");
        assert!(steps < 300);
    }
    assert!((f64::from(steps) * 0.5 - (length - settings.stop_distance)).abs() <= 0.51);
}

#[test]
fn test_simulation_tells_the_direction_and_the_speed_of_the_path() {
    let plant: Arc<dyn Plant> = Arc::new(KinematicBicycle::DEFAULT);
    let start = |yaw| VehicleState {
        x: 20.0,
        y: 0.0,
        yaw,
        speed: 0.0,
    };
    let begun = |path: Arc<Path>, yaw| {
        let plant = Arc::clone(&plant);
        Simulation::new(path, plant, start(yaw), tracked(), Settings::DEFAULT).unwrap()
    };
    let forwards = begun(straight(0.0), 0.0);
    assert!(!forwards.reverse());
    assert_eq!(forwards.reference_speed(), Some(7.0));
    let backwards = Path::clone(&straight(0.0))
        .with_reverse(&[true; 100])
        .unwrap();
    let backwards = begun(Arc::new(backwards), std::f64::consts::PI);
    assert!(backwards.reverse());
    assert_eq!(backwards.reference_speed(), Some(-7.0));
}

#[test]
fn test_errors_are_those_of_the_point_that_is_tracked_from_now_on() {
    let plant = Arc::new(Beside { path_yaw: 0.0 });
    let start = VehicleState {
        x: 20.0,
        y: 0.5,
        yaw: 0.1,
        speed: 4.0,
    };
    let settings = Settings::DEFAULT;
    let mut simulation = Simulation::new(straight(0.0), plant, start, tracked(), settings).unwrap();
    let front = Follow::of(&CAR, CAR.rear_axle, 3.0);
    simulation.track(front);
    simulation
        .step(Control::default(), Point::default(), Status::OK)
        .unwrap();
    let record = simulation.records()[0];
    assert!(close(record.cross_track_error, 0.5 + 3.0 * 0.1_f64.sin()));
    assert!(close(record.rear_cross_track_error, 0.5));
}

/// What a run has come to is saved with it.
#[test]
fn test_finished_or_lost_run_is_restored_as_such() {
    for (y, finished) in [(0.0, true), (100.0, false)] {
        let start = VehicleState {
            x: 95.0,
            y,
            yaw: 0.0,
            speed: 4.0,
        };
        let fresh = || {
            let plant = Arc::new(Beside { path_yaw: 0.0 });
            Simulation::new(straight(0.0), plant, start, tracked(), Settings::DEFAULT).unwrap()
        };
        let mut run = fresh();
        // Beside the path by 10 times the angle.
        let control = Control {
            steer: if finished { -0.02 } else { 1.5 },
            ..Control::default()
        };
        while !run.is_over() {
            run.step(control, Point::default(), Status::OK).unwrap();
        }
        let again = fresh().restored(run.save());
        assert_eq!(again.is_finished(), run.is_finished());
        assert_eq!(again.is_over(), run.is_over());
        assert_eq!(again.metrics().steps, run.metrics().steps);
        assert_eq!(run.is_finished(), finished);
    }
}
