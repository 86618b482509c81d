//! One control step of each controller: the angle alone, and the command with its diagnostics.

use std::error::Error;
use std::hint::black_box;
use std::time::Duration;

use criterion::Criterion;
use popsteer_bench::{Course, DELAYED, FREE, LapRunner, PAPER, SLOW, WAYPOINTS};
use popsteer_core::laws::{
    Pid, PidParams, Pop, PopParams, PreviewPop, PreviewPopParams, PurePursuit, PurePursuitParams,
    Stanley, StanleyParams,
};
use popsteer_core::{LateralLaw, Tracker, Vehicle};

fn bench_law<L: LateralLaw>(criterion: &mut Criterion, course: &Course, name: &str, law: L) {
    let mut drive = LapRunner::new(course, Tracker::of(law));
    let mut group = criterion.benchmark_group(name);
    group.bench_function("steer", |bencher| bencher.iter(|| black_box(drive.steer())));
    group.bench_function("step", |bencher| bencher.iter(|| black_box(drive.step())));
    group.finish();
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut criterion = Criterion::default()
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2))
        .configure_from_args();
    let course = Course::new(WAYPOINTS)?;
    let each = &mut criterion;
    let car = Vehicle::DEFAULT;
    let pop = PopParams::DEFAULT;
    bench_law(each, &course, "pop", Pop::new(car, pop)?);
    bench_law(each, &course, "pop-paper", Pop::new(car, PAPER)?);
    bench_law(each, &course, "pop-late", Pop::new(DELAYED, pop)?);
    let preview = |car| PreviewPop::new(car, PreviewPopParams::DEFAULT);
    bench_law(each, &course, "preview-pop", preview(car)?);
    bench_law(each, &course, "preview-pop-free", preview(FREE)?);
    bench_law(each, &course, "preview-pop-slow", preview(SLOW)?);
    bench_law(each, &course, "preview-pop-late", preview(DELAYED)?);
    bench_law(each, &course, "pid", Pid::new(car, PidParams::DEFAULT)?);
    let law = PurePursuit::new(car, PurePursuitParams::DEFAULT)?;
    bench_law(each, &course, "pure-pursuit", law);
    let law = Stanley::new(car, StanleyParams::DEFAULT)?;
    bench_law(each, &course, "stanley", law);
    criterion.final_summary();
    Ok(())
}
