//! The modules that a step passes through, each by itself.

use std::error::Error;
use std::hint::black_box;
use std::time::Duration;

use criterion::Criterion;
use popsteer_bench::{Course, DELAYED, DT, WAYPOINTS};
use popsteer_core::laws::{Pop, PopParams};
use popsteer_core::path::jump::find_lookahead_point;
use popsteer_core::path::locate::{OPPOSITE, locate, locate_by_scan};
use popsteer_core::path::lookahead::{get_crossing, get_lookahead_point};
use popsteer_core::path::projection::{nearest_waypoint, project};
use popsteer_core::path::relocalise::relocalise;
use popsteer_core::path::resample::{Grid, window};
use popsteer_core::path::{Follow, Located, PathView};
use popsteer_core::vehicle::bicycle::get_predicted_location;
use popsteer_core::vehicle::{AdaptParams, Estimate, Estimator, InFlight};
use popsteer_core::{LateralLaw, Vehicle, VehicleState};

/// A state of the lap, and what the modules before have found out about it.
#[derive(Clone, Copy)]
struct At {
    vehicle: VehicleState,
    located: Located,
    /// The waypoint of the last place.
    last: usize,
    nearest: usize,
    lookahead: f64,
    /// How far the controller looks around the last place [m].
    reach: f64,
}

/// The parameters of POP.
fn search() -> PopParams<f64> {
    PopParams::DEFAULT.resolved(&Vehicle::DEFAULT)
}

fn located(course: &Course, follow: &Follow) -> Vec<At> {
    let PopParams { min_lookahead, .. } = search();
    let gain = PopParams::DEFAULT.lookahead_gain;
    let path = course.path.view();
    let mut last = None;
    course
        .lap
        .iter()
        .map(|&vehicle| {
            let located = follow.locate(&path, last, vehicle, DT);
            let segment = located.closest.segment;
            At {
                vehicle,
                located,
                last: last.replace(segment).unwrap_or(segment),
                nearest: located.closest.nearest_waypoint(&path),
                lookahead: min_lookahead + gain * vehicle.speed,
                reach: follow.search_distance + vehicle.speed * DT,
            }
        })
        .collect()
}

/// Times `part` on one state after the other.
fn bench_part<T>(criterion: &mut Criterion, name: &str, lap: &[At], mut part: impl FnMut(At) -> T) {
    let mut states = lap.iter().copied().cycle();
    criterion.bench_function(name, |bencher| {
        bencher.iter(|| states.next().map(|at| part(black_box(at))));
    });
}

/// Where am I?
fn bench_locate(criterion: &mut Criterion, path: PathView<'_>, lap: &[At], follow: &Follow) {
    bench_part(criterion, "path/nearest_waypoint", lap, |at| {
        nearest_waypoint(&path, at.located.position)
    });
    bench_part(criterion, "path/project", lap, |at| {
        project(&path, at.nearest, at.located.position)
    });
    // The closest point as the controllers find it, and the scan that defines it.
    bench_part(criterion, "path/locate", lap, |at| {
        let (here, heading) = (at.located.position, at.located.heading);
        locate(&path, at.last, here, heading, at.reach, OPPOSITE)
    });
    bench_part(criterion, "path/locate_by_scan", lap, |at| {
        let (here, heading) = (at.located.position, at.located.heading);
        locate_by_scan(&path, at.last, here, heading, at.reach, OPPOSITE)
    });
    bench_part(criterion, "path/follow", lap, |at| {
        follow.locate(&path, Some(at.last), at.vehicle, DT)
    });
    bench_part(criterion, "path/relocalise", lap, |at| {
        relocalise(&path, at.located.position, at.vehicle.yaw, OPPOSITE)
    });
}

/// Where do I aim?
fn bench_lookahead(criterion: &mut Criterion, path: PathView<'_>, lap: &[At]) {
    let params = search();
    bench_part(criterion, "path/get_crossing", lap, |at| {
        let place = at.located;
        get_crossing(&path, &place.closest, place.position, at.lookahead)
    });
    bench_part(criterion, "path/window", lap, |at| {
        window(&path, at.nearest, params.window_ahead)
    });
    // The paper's search as the controllers do it, and the plain loop that defines what it finds.
    bench_part(criterion, "path/find_lookahead_point", lap, |at| {
        find_lookahead_point(
            &path,
            at.nearest,
            params.window_ahead,
            params.grid_spacing,
            at.located.position,
            at.lookahead,
            params.lookahead_tolerance,
        )
    });
    bench_part(criterion, "path/get_lookahead_point", lap, |at| {
        let ahead = window(&path, at.nearest, params.window_ahead);
        let grid = Grid::new(path, ahead, params.grid_spacing);
        let (here, tolerance) = (at.located.position, params.lookahead_tolerance);
        get_lookahead_point(&grid, here, at.lookahead, tolerance)
    });
}

/// Where will the vehicle be, and what is it?
fn bench_vehicle(criterion: &mut Criterion, lap: &[At]) {
    bench_part(criterion, "vehicle/get_predicted_location", lap, |at| {
        get_predicted_location(at.vehicle, 0.1, DT)
    });
    // Four commands in flight.
    let mut in_flight = InFlight::settled(&DELAYED, 0.1);
    for _ in 0..8 {
        in_flight.elapse(&DELAYED, 0.1, DT, 0.0);
    }
    let estimate = Estimate::DEFAULT;
    bench_part(criterion, "vehicle/predict", lap, |at| {
        in_flight.predict(&DELAYED, at.vehicle, in_flight.wheel(), &estimate)
    });
    bench_part(criterion, "vehicle/wheel_integrals", lap, |at| {
        in_flight.wheel_integrals(&DELAYED, 0.01 * at.vehicle.speed, DT)
    });
    let mut estimator = Estimator::default();
    bench_part(criterion, "vehicle/observe_turn", lap, |at| {
        let reached = in_flight.wheel_integrals(&DELAYED, 0.1, DT);
        estimator.observe_turn(&AdaptParams::DEFAULT, &DELAYED, at.vehicle, reached, DT);
        estimator.last_measured = Some(at.vehicle);
    });
    bench_part(criterion, "vehicle/elapse", lap, |at| {
        in_flight.elapse(&DELAYED, 0.01 * at.vehicle.speed, DT, 0.0);
    });
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut criterion = Criterion::default()
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .configure_from_args();
    let course = Course::new(WAYPOINTS)?;
    let law = Pop::new(Vehicle::DEFAULT, PopParams::DEFAULT)?;
    let (path, follow) = (course.path.view(), law.follow());
    let lap = located(&course, follow);
    bench_locate(&mut criterion, path, &lap, follow);
    bench_lookahead(&mut criterion, path, &lap);
    bench_vehicle(&mut criterion, &lap);
    criterion.final_summary();
    Ok(())
}
