//! Drives one controller around the course: what `instruction_counts.py` counts the instructions
//! of.
//!
//! `steps LAW steer|step LAPS` prints how many steps it has taken. What comes before them (making
//! the course, the lap that warms up) is the same for any number of laps, so the difference of two
//! runs is the steps' alone.

use std::env;
use std::error::Error;
use std::hint::black_box;
use std::io::{Write, stdout};

use popsteer_bench::{Course, DELAYED, FREE, LapRunner, PAPER, SLOW, WAYPOINTS};
use popsteer_core::laws::{
    Pid, PidParams, Pop, PopParams, PreviewPop, PreviewPopParams, PurePursuit, PurePursuitParams,
    Stanley, StanleyParams,
};
use popsteer_core::{LateralLaw, Tracker, Vehicle};

// One function for each controller, so that what else the program holds does not move into its
// loop.
#[inline(never)]
fn take_steps<L: LateralLaw>(course: &Course, law: L, call: &str, steps: usize) {
    let mut drive = LapRunner::new(course, Tracker::of(law));
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
    let car = Vehicle::DEFAULT;
    let pop = PopParams::DEFAULT;
    let pursuit = PurePursuitParams::DEFAULT;
    let stanley = StanleyParams::DEFAULT;
    let preview = |car| PreviewPop::new(car, PreviewPopParams::DEFAULT);
    match law.as_str() {
        "pop" => take_steps(&course, Pop::new(car, pop)?, call, steps),
        "pop-paper" => take_steps(&course, Pop::new(car, PAPER)?, call, steps),
        "pop-late" => take_steps(&course, Pop::new(DELAYED, pop)?, call, steps),
        "preview-pop" => take_steps(&course, preview(car)?, call, steps),
        "preview-pop-free" => take_steps(&course, preview(FREE)?, call, steps),
        "preview-pop-slow" => take_steps(&course, preview(SLOW)?, call, steps),
        "preview-pop-late" => take_steps(&course, preview(DELAYED)?, call, steps),
        "pid" => take_steps(&course, Pid::new(car, PidParams::DEFAULT)?, call, steps),
        "pure-pursuit" => take_steps(&course, PurePursuit::new(car, pursuit)?, call, steps),
        "stanley" => take_steps(&course, Stanley::new(car, stanley)?, call, steps),
        _ => return Err("unknown law".into()),
    }
    writeln!(stdout(), "{steps}")?;
    Ok(())
}
