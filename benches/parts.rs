//! The rooms that a step walks through, each by itself.

use std::error::Error;
use std::hint::black_box;
use std::time::Duration;

use criterion::Criterion;
use popsteer_bench::{Course, DT, WAYPOINTS};
use popsteer_core::lateral::PopParams;
use popsteer_core::path::PathView;
use popsteer_core::path::jump::find_lookahead_point;
use popsteer_core::path::locate::{locate, nearest_waypoint, project};
use popsteer_core::path::lookahead::get_lookahead_point;
use popsteer_core::path::resample::{Grid, window};
use popsteer_core::vehicle::predict::get_predicted_location;
use popsteer_core::{Point, VehicleState};

/// A state of the lap, and what the rooms before have found out about it.
#[derive(Clone, Copy)]
struct At {
    vehicle: VehicleState,
    position: Point,
    nearest: usize,
}

fn located(course: &Course) -> Vec<At> {
    let mut last = None;
    course
        .lap
        .iter()
        .map(|&vehicle| {
            let position = vehicle.point_ahead(PopParams::DEFAULT.wheelbase);
            let nearest = locate(&course.path.view(), last, position);
            last = Some(nearest);
            At {
                vehicle,
                position,
                nearest,
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

fn bench_path(criterion: &mut Criterion, path: PathView<'_>, lap: &[At]) {
    let params = PopParams::DEFAULT;
    bench_part(criterion, "path/nearest_waypoint", lap, |at| {
        nearest_waypoint(&path, at.position)
    });
    let mut last = None;
    bench_part(criterion, "path/locate", lap, |at| {
        let nearest = locate(&path, last, at.position);
        last = Some(nearest);
        nearest
    });
    bench_part(criterion, "path/project", lap, |at| {
        project(&path, at.nearest, at.position)
    });
    bench_part(criterion, "path/window", lap, |at| {
        window(&path, at.nearest, params.window_ahead)
    });
    // The search as the laws do it, and the plain loop that defines what it finds.
    let lookahead = |at: At| params.min_lookahead + params.lookahead_gain * at.vehicle.speed;
    bench_part(criterion, "path/find_lookahead_point", lap, |at| {
        find_lookahead_point(
            &path,
            at.nearest,
            params.window_ahead,
            params.grid_spacing,
            at.position,
            lookahead(at),
            params.lookahead_tolerance,
        )
    });
    bench_part(criterion, "path/get_lookahead_point", lap, |at| {
        let ahead = window(&path, at.nearest, params.window_ahead);
        let grid = Grid::new(path, ahead, params.grid_spacing);
        get_lookahead_point(
            &grid,
            at.position,
            lookahead(at),
            params.lookahead_tolerance,
        )
    });
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut criterion = Criterion::default()
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .configure_from_args();
    let course = Course::new(WAYPOINTS)?;
    let lap = located(&course);
    bench_path(&mut criterion, course.path.view(), &lap);
    bench_part(
        &mut criterion,
        "vehicle/get_predicted_location",
        &lap,
        |at| get_predicted_location(at.vehicle, 0.1, DT),
    );
    criterion.final_summary();
    Ok(())
}
