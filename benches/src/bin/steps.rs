//! Drives one law around the course: what `instruction_counts.py` counts the instructions of.
//!
//! `steps LAW steer|step LAPS` prints how many steps it has taken. What comes before them (making
//! the course, the lap that warms up) is the same for any number of laps, so the difference of two
//! runs is the steps' alone.

use std::env;
use std::error::Error;
use std::hint::black_box;
use std::io::{Write, stdout};

use popsteer_bench::{Course, Drive, WAYPOINTS};
use popsteer_core::LateralLaw;
use popsteer_core::lateral::{
    BangBang, BangBangParams, Pid, PidParams, Pop, PopParams, PreviewPop, PreviewPopParams,
    PurePursuit, PurePursuitParams, Stanley, StanleyParams,
};

// One function for each law, so that what else the program holds does not move into its loop.
#[inline(never)]
fn take_steps<L: LateralLaw>(course: &Course, law: L, call: &str, steps: usize) {
    let mut drive = Drive::new(course, law);
    if call == "steer" {
        for _ in 0..steps {
            black_box(drive.steer());
        }
    } else {
        for _ in 0..steps {
            black_box(drive.step());
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<_> = env::args().skip(1).collect();
    let [law, call, laps] = arguments.as_slice() else {
        return Err("usage: steps LAW steer|step LAPS".into());
    };
    if !["steer", "step"].contains(&call.as_str()) {
        return Err("the call is steer or step".into());
    }
    let course = Course::new(WAYPOINTS)?;
    let steps = laps.parse::<usize>()? * course.lap.len();
    match law.as_str() {
        "pop" => take_steps(&course, Pop::new(PopParams::DEFAULT)?, call, steps),
        "pop-paper" => {
            let paper = PopParams {
                exact_lookahead: false,
                ..PopParams::DEFAULT
            };
            take_steps(&course, Pop::new(paper)?, call, steps);
        }
        "preview-pop" => {
            let law = PreviewPop::new(PreviewPopParams::DEFAULT)?;
            take_steps(&course, law, call, steps);
        }
        "pid" => take_steps(&course, Pid::new(PidParams::DEFAULT)?, call, steps),
        "pure-pursuit" => {
            let law = PurePursuit::new(PurePursuitParams::DEFAULT)?;
            take_steps(&course, law, call, steps);
        }
        "stanley" => take_steps(&course, Stanley::new(StanleyParams::DEFAULT)?, call, steps),
        "bang-bang" => take_steps(
            &course,
            BangBang::new(BangBangParams::DEFAULT)?,
            call,
            steps,
        ),
        _ => return Err("unknown law".into()),
    }
    writeln!(stdout(), "{steps}")?;
    Ok(())
}
