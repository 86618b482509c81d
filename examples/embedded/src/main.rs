//! popsteer on a microcontroller: no operating system, no allocation, no panic.
//!
//!     cargo build --release --target thumbv7em-none-eabihf     # for a Cortex-M4F
//!     cargo run --release                                      # on your machine
#![no_std]
#![no_main]

#[cfg(target_os = "none")]
mod cortex_m;
#[cfg(not(target_os = "none"))]
mod host;
mod panic;

use popsteer_core::laws::{Pop, PopParams, PreviewPop, PreviewPopParams};
use popsteer_core::vehicle::bicycle::kinematic_bicycle;
use popsteer_core::{LateralLaw, PathView, Reported, Tracker, Vehicle, VehicleState, math};

const WAYPOINTS: usize = 200;
const DT: f64 = 0.05; // the control period [s]
const START: VehicleState = VehicleState {
    x: 0.0,
    y: 1.0,
    yaw: 0.3,
    speed: 8.0,
};
const CAR: Vehicle = Vehicle {
    wheelbase: 2.7,
    dead_time: 0.15,
    max_steer: 0.6,
    max_steer_rate: Some(0.5),
    ..Vehicle::DEFAULT
};

/// A hundred steps each of POP and of preview POP along a sine; `command` gets every angle [rad].
fn drive(mut command: impl FnMut(f64)) -> Option<()> {
    // The caller owns all memory: two arrays that a planner fills, and one for the arc lengths.
    let (mut x, mut y, mut s) = ([0.0; WAYPOINTS], [0.0; WAYPOINTS], [0.0; WAYPOINTS]);
    for (k, (x, y)) in (0_u32..).zip(x.iter_mut().zip(&mut y)) {
        *x = f64::from(k);
        *y = 8.0 * math::sin(f64::from(k) / 25.0);
    }
    let path = PathView::new(&x, &y, None, false, &mut s).ok()?;
    let pop = Pop::new(CAR, PopParams::DEFAULT).ok()?;
    follow(&Tracker::of(pop), &path, &mut command);
    let preview_pop = PreviewPop::new(CAR, PreviewPopParams::DEFAULT).ok()?;
    follow(&Tracker::of(preview_pop), &path, &mut command);
    Some(())
}

#[inline(never)] // once for each controller: their states need the stack one after the other
fn follow<L: LateralLaw>(tracker: &Tracker<L>, path: &PathView<'_>, command: &mut impl FnMut(f64)) {
    let mut state = tracker.initial_state();
    let mut vehicle = START; // your localisation
    for _ in 0..100 {
        let answer = tracker.step_or_hold(path, &mut state, vehicle, DT, 10, Reported::NOTHING);
        command(answer.steer);
        vehicle = kinematic_bicycle(vehicle, answer.steer, 0.0, CAR.wheelbase, DT);
    }
}
