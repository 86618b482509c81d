//! How the cost of a POP step grows with the parameters it could grow with.

use std::error::Error;
use std::fmt::Display;
use std::hint::black_box;
use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion};
use popsteer_bench::{Course, LapRunner, PAPER, WAYPOINTS};
use popsteer_core::laws::{Pop, PopParams};
use popsteer_core::tracker::Tracker;
use popsteer_core::{ConfigError, Vehicle};

fn bench_pop(
    group: &mut BenchmarkGroup<'_, WallTime>,
    course: &Course,
    value: impl Display,
    params: PopParams,
) -> Result<(), ConfigError> {
    let mut drive = LapRunner::new(course, Tracker::of(Pop::new(Vehicle::PAPER, params)?));
    group.bench_function(BenchmarkId::from_parameter(value), |bencher| {
        bencher.iter(|| black_box(drive.steer()));
    });
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut criterion = Criterion::default()
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .configure_from_args();
    let course = Course::new(WAYPOINTS)?;
    let default = PopParams::DEFAULT;

    let mut group = criterion.benchmark_group("pop/candidate_count");
    for candidate_count in [5, 11, 21, 51, 101] {
        let params = PopParams {
            candidate_count,
            ..default
        };
        bench_pop(&mut group, &course, candidate_count, params)?;
    }
    group.finish();

    let mut group = criterion.benchmark_group("pop/window_ahead");
    for window_ahead in [12.0, 20.0, 50.0, 100.0] {
        let params = PopParams {
            window_ahead: Some(window_ahead),
            ..PAPER
        };
        bench_pop(&mut group, &course, window_ahead, params)?;
    }
    group.finish();

    let mut group = criterion.benchmark_group("pop/grid_spacing");
    for grid_spacing in [0.1, 0.05, 0.02, 0.01, 0.005] {
        // A coarse grid has a point on the circle only where the tolerance is as coarse.
        let params = PopParams {
            grid_spacing: Some(grid_spacing),
            lookahead_tolerance: Some(grid_spacing),
            ..PAPER
        };
        bench_pop(&mut group, &course, grid_spacing, params)?;
    }
    group.finish();

    let mut group = criterion.benchmark_group("pop/waypoints");
    for waypoints in [1_000, 10_000, 100_000] {
        bench_pop(&mut group, &Course::new(waypoints)?, waypoints, default)?;
    }
    group.finish();
    criterion.final_summary();
    Ok(())
}
