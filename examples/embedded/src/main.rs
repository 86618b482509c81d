//! popsteer on a microcontroller: no operating system, no allocation, no panic.
//!
//!     rustup target add thumbv7em-none-eabihf
//!     cargo build --release --target thumbv7em-none-eabihf
//!
//! builds it for a Cortex-M4F, such as an STM32F4; `link.x` has its memory. In QEMU:
//!
//!     cargo run --release --target thumbv7em-none-eabihf --features semihosting \
//!         --config 'target.thumbv7em-none-eabihf.runner="qemu-system-arm -M mps2-an386 -nographic -semihosting -kernel"'
//!
//! For the machine it is built on, `cargo run --release` runs the same steps.
#![no_std]
#![no_main]

#[cfg(target_os = "none")]
mod cortex_m;
#[cfg(not(target_os = "none"))]
mod host;

use popsteer_core::lateral::{Pop, PopParams, PreviewPop, PreviewPopParams, Tracker};
use popsteer_core::vehicle::bicycle::kinematic_bicycle;
use popsteer_core::{LateralLaw, PathView, Vehicle, VehicleState, math};

const WAYPOINTS: usize = 200;
/// The control period [s].
const DT: f64 = 0.05;

/// What is true of the car; the rest is as usual.
const CAR: Vehicle = Vehicle {
    wheelbase: 2.7,
    dead_time: 0.15,
    max_steer: 0.6,
    max_steer_rate: Some(0.5),
    ..Vehicle::DEFAULT
};

/// A hundred steps each of POP and of preview POP along a sine; `command` is given every angle
/// [rad].
fn drive(mut command: impl FnMut(f64)) {
    // The caller owns all memory: two arrays that a planner fills, and one for the arc lengths.
    let (mut x, mut y, mut s) = ([0.0; WAYPOINTS], [0.0; WAYPOINTS], [0.0; WAYPOINTS]);
    for (k, (x, y)) in (0_u32..).zip(x.iter_mut().zip(&mut y)) {
        *x = f64::from(k);
        *y = 8.0 * math::sin(f64::from(k) / 25.0);
    }
    let Ok(path) = PathView::new(&x, &y, None, false, &mut s) else {
        return;
    };
    if let Ok(pop) = Pop::new(CAR, PopParams::DEFAULT) {
        follow(&Tracker::of(pop), &path, &mut command);
    }
    if let Ok(preview_pop) = PreviewPop::new(CAR, PreviewPopParams::DEFAULT) {
        follow(&Tracker::of(preview_pop), &path, &mut command);
    }
}

// Once for each controller: their states need the stack one after the other.
#[inline(never)]
fn follow<L: LateralLaw>(tracker: &Tracker<L>, path: &PathView<'_>, command: &mut impl FnMut(f64)) {
    let mut state = tracker.initial_state();
    // Your localisation.
    let mut vehicle = VehicleState {
        x: 0.0,
        y: 1.0,
        yaw: 0.3,
        speed: 8.0,
    };
    for _ in 0..100 {
        let answer = tracker.step_or_hold(path, &mut state, vehicle, DT, 10);
        command(answer.steer);
        vehicle = kinematic_bicycle(vehicle, answer.steer, 0.0, CAR.wheelbase, DT);
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    unsafe extern "C" {
        fn the_core_can_panic() -> !;
    }
    // SAFETY: never runs; the function does not exist, so linking fails where a panic is possible.
    unsafe { the_core_can_panic() }
}
