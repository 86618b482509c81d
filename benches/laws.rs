//! One control step of each law: the angle alone, and the command with its diagnostics.

use std::error::Error;
use std::hint::black_box;
use std::time::Duration;

use criterion::Criterion;
use popsteer_bench::{Course, Drive, WAYPOINTS};
use popsteer_core::LateralLaw;
use popsteer_core::lateral::{
    BangBang, BangBangParams, Pid, PidParams, Pop, PopParams, PreviewPop, PreviewPopParams,
    PurePursuit, PurePursuitParams, Stanley, StanleyParams, Tracker,
};
use popsteer_core::vehicle::{Actuator, ActuatorParams};

fn bench_law<L: LateralLaw>(criterion: &mut Criterion, course: &Course, name: &str, law: L) {
    let mut drive = Drive::new(course, law);
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
    bench_law(each, &course, "pop", Pop::new(PopParams::DEFAULT)?);
    let paper = PopParams {
        exact_lookahead: false,
        ..PopParams::DEFAULT
    };
    bench_law(each, &course, "pop-paper", Pop::new(paper)?);
    let actuator = Actuator::new(ActuatorParams {
        dead_time: 0.2,
        lag: 0.1,
        max_rate: Some(1.0),
        ..ActuatorParams::DEFAULT
    })?;
    let behind_actuator = Tracker::new(Pop::new(PopParams::DEFAULT)?, Some(actuator));
    bench_law(each, &course, "pop-actuator", behind_actuator);
    bench_law(
        each,
        &course,
        "preview-pop",
        PreviewPop::new(PreviewPopParams::DEFAULT)?,
    );
    bench_law(each, &course, "pid", Pid::new(PidParams::DEFAULT)?);
    bench_law(
        each,
        &course,
        "pure-pursuit",
        PurePursuit::new(PurePursuitParams::DEFAULT)?,
    );
    bench_law(
        each,
        &course,
        "stanley",
        Stanley::new(StanleyParams::DEFAULT)?,
    );
    bench_law(
        each,
        &course,
        "bang-bang",
        BangBang::new(BangBangParams::DEFAULT)?,
    );
    criterion.final_summary();
    Ok(())
}
