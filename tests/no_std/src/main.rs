//! POP without an operating system's help: 1,000 steps along a sine, an angle a line.
//!
//! The panic handler calls a function that does not exist. If any path through the core's public
//! functions used here could panic, the handler would be kept and the program would not link.
#![no_std]
#![no_main]

use core::ffi::{c_char, c_int};
use core::hint::black_box;

use popsteer_core::lateral::pid::ErrorBuffer;
use popsteer_core::lateral::{
    BangBang, BangBangParams, Pid, PidParams, Pop, PopParams, PreviewPop, PreviewPopParams,
    PurePursuit, PurePursuitParams, Stanley, StanleyParams,
};
use popsteer_core::longitudinal::{
    CoupledLongitudinal, CoupledLongitudinalParams, SpeedPid, SpeedPidParams, SpeedPidState,
};
use popsteer_core::path::jump::find_lookahead_point;
use popsteer_core::path::locate;
use popsteer_core::path::lookahead::{
    get_crossing, get_lookahead_point, get_lookahead_point_index,
};
use popsteer_core::path::preview::Preview;
use popsteer_core::path::relocalise::relocalise;
use popsteer_core::path::resample::{Grid, window};
use popsteer_core::vehicle::predict::{
    get_predicted_location, kinematic_bicycle, state_transition,
};
use popsteer_core::vehicle::{Actuator, ActuatorParams};
use popsteer_core::{LateralLaw, PathView, Point, VehicleState, math};

#[link(name = "c")]
unsafe extern "C" {
    fn printf(format: *const c_char, ...) -> c_int;
    fn the_core_can_panic() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    // SAFETY: never runs; linking fails first.
    unsafe { the_core_can_panic() }
}

/// Asked for by the precompiled compiler runtime; never called, as a panic cannot unwind here.
#[unsafe(no_mangle)]
extern "C" fn rust_eh_personality() {}

const WAYPOINTS: usize = 600;

/// One step of a law, its answer and its state seen by the optimizer as unknown.
fn step<L: LateralLaw>(law: &L, path: &PathView<'_>, vehicle: VehicleState) -> f64 {
    let mut state = black_box(law.initial_state());
    let dt = black_box(0.05);
    let first = law
        .step(path, &mut state, black_box(vehicle), dt)
        .map_or(0.0, |c| c.steer);
    let checked = law.check_state(path, &state).is_ok()
        && law
            .relocalise(path, &mut state, vehicle.x, vehicle.y, vehicle.yaw)
            .is_ok();
    let second = law
        .steer(path, &mut state, black_box(vehicle), dt)
        .unwrap_or(0.0);
    if checked { first + second } else { 0.0 }
}

/// Every other public law once, so that none of them can panic either.
fn all_laws(path: &PathView<'_>, vehicle: VehicleState) -> f64 {
    let mut sum = 0.0;
    if let Ok(law) = Pop::new(black_box(PopParams::DEFAULT)) {
        sum += step(&law, path, vehicle);
    }
    let paper = PopParams {
        exact_lookahead: false,
        ..PopParams::DEFAULT
    };
    if let Ok(law) = Pop::new(black_box(paper)) {
        sum += step(&law, path, vehicle);
    }
    let over_horizon = PopParams {
        horizon: Some(0.8),
        ..PopParams::DEFAULT
    };
    if let Ok(law) = Pop::new(black_box(over_horizon)) {
        sum += step(&law, path, vehicle);
    }
    let learning = PreviewPopParams {
        turn_learning_time: 0.5,
        slip_learning_time: 2.0,
        ..PreviewPopParams::DEFAULT
    };
    if let Ok(law) = PreviewPop::new(black_box(learning)) {
        sum += step(&law, path, vehicle);
    }
    if let Ok(law) = Pid::new(black_box(PidParams::DEFAULT)) {
        sum += step(&law, path, vehicle);
    }
    if let Ok(law) = PurePursuit::new(black_box(PurePursuitParams::DEFAULT)) {
        sum += step(&law, path, vehicle);
    }
    if let Ok(law) = Stanley::new(black_box(StanleyParams::DEFAULT)) {
        sum += step(&law, path, vehicle);
    }
    if let Ok(law) = BangBang::new(black_box(BangBangParams::DEFAULT)) {
        sum += step(&law, path, vehicle);
    }
    if let Ok(law) = CoupledLongitudinal::new(black_box(CoupledLongitudinalParams::DEFAULT)) {
        sum += law
            .step(black_box(3.0), black_box(0.1))
            .map_or(0.0, |pedals| pedals.throttle);
    }
    if let Ok(law) = SpeedPid::new(black_box(SpeedPidParams::DEFAULT)) {
        let mut state = SpeedPidState::default();
        sum += law
            .step(&mut state, black_box(3.0), black_box(4.0), black_box(0.05))
            .map_or(0.0, |pedals| pedals.throttle);
    }
    sum
}

/// Commands on their way to the wheels.
fn actuator(vehicle: VehicleState) -> f64 {
    let params = ActuatorParams {
        dead_time: 0.2,
        lag: 0.1,
        max_rate: Some(1.0),
        learning_time: 10.0,
        ..ActuatorParams::DEFAULT
    };
    let Ok(actuator) = Actuator::new(black_box(params)) else {
        return 0.0;
    };
    let mut under_way = actuator.settled(black_box(0.1));
    for dt in black_box([0.05, 1e-6, 0.3]) {
        actuator.elapse(&mut under_way, black_box(0.2), dt);
    }
    let learnt = actuator.learn(&under_way, black_box(0.2), vehicle, black_box(0.05));
    actuator.elapse_learning(&mut under_way, black_box(0.2), black_box(0.05), learnt);
    let seen = actuator.predict(
        &under_way,
        black_box(0.2),
        vehicle,
        black_box(0.05),
        &learnt,
    );
    let limited = actuator.limit(black_box(0.1), black_box(0.9), black_box(0.05));
    let restored = actuator.restore(
        black_box([(0.1, 0.05), (0.2, 0.15)]).into_iter(),
        under_way.wheel(),
        black_box(learnt),
    );
    let sum: f64 = under_way.commands().map(|(steer, _)| steer).sum();
    sum + limited + seen.x + restored.map_or(0.0, |under_way| under_way.wheel())
}

/// The plain functions, called the same way.
fn all_functions(path: &PathView<'_>, vehicle: VehicleState) -> f64 {
    let position = black_box(vehicle.point_ahead(1.0));
    let index = black_box(7_usize);
    let nearest = locate::nearest_waypoint(path, position);
    let heading = Point::new(math::cos(vehicle.yaw), math::sin(vehicle.yaw));
    let opposite = black_box(locate::OPPOSITE);
    let located = locate::locate(path, index, position, heading, black_box(6.0), opposite);
    let scanned = locate::locate_by_scan(path, index, position, heading, black_box(6.0), opposite);
    let (crossing, _) = get_crossing(path, &located, position, black_box(6.0));
    let mut turns = black_box([0.0; 20]);
    let arc_length = scanned.arc_length(path);
    let mut ahead = Preview::new(path, black_box(2.0), scanned.segment, arc_length, 20.0);
    let path_yaw = ahead.turns(arc_length, black_box(1.0), &mut turns);
    let located = located.nearest_waypoint(path);
    let jumped_to = relocalise(path, position, black_box(0.3), opposite);
    let foot = locate::project(path, index, position);
    let mut sum = math::from_count(nearest + located + jumped_to) + foot.cross_track_error;
    sum += crossing.x + path_yaw + locate::path_yaw_behind(path, index);
    sum += locate::reference_speed(path, &foot).unwrap_or(0.0);
    let grid = Grid::new(*path, window(path, index, black_box(20.0)), black_box(0.01));
    let (lookahead, tolerance) = black_box((6.0, 0.01));
    let found = get_lookahead_point(&grid, position, lookahead, tolerance);
    let at = get_lookahead_point_index(&grid, position, lookahead, tolerance);
    let (jumped, _) = find_lookahead_point(path, index, 20.0, 0.01, position, lookahead, tolerance);
    sum += found.point.x + math::from_count(at) + jumped.x;
    sum += get_predicted_location(vehicle, black_box(0.1), 0.05).x;
    let state = black_box([0.0, 1.0, 0.2, 3.0, 0.1]);
    sum += state_transition(state.into(), black_box([0.1, 0.2]).into(), 0.1, 0.05).x;
    let terms = black_box([1.0, 2.0, 3.0]);
    if cfg!(feature = "planted-panic") {
        sum += terms[index];
    }
    let restored = ErrorBuffer::restore(black_box(5), &terms, black_box(3), black_box(6.0));
    sum + restored.map_or(0.0, |buffer| buffer.sum() + buffer.terms().count() as f64)
}

#[unsafe(no_mangle)]
extern "C" fn main() -> c_int {
    let (mut x, mut y, mut s) = ([0.0; WAYPOINTS], [0.0; WAYPOINTS], [0.0; WAYPOINTS]);
    for (k, (x, y)) in (0_u32..).zip(x.iter_mut().zip(y.iter_mut())) {
        *x = f64::from(k);
        *y = 8.0 * math::sin(f64::from(k) / 25.0);
    }
    let Ok(path) = PathView::new(&x, &y, None, black_box(false), &mut s) else {
        return 1;
    };
    let Ok(law) = Pop::new(PopParams::DEFAULT) else {
        return 2;
    };
    let mut state = law.initial_state();
    let mut vehicle = VehicleState {
        x: 0.0,
        y: 0.5,
        yaw: 0.3,
        speed: 10.0,
    };
    // The stretches that are driven backwards as a matter of run time.
    let backwards: [bool; WAYPOINTS] = core::array::from_fn(|k| black_box(k / 200 == 1));
    let Ok(shuttle) = path.with_reverse(&backwards) else {
        return 5;
    };
    for path in [path, shuttle] {
        let sum = all_laws(&path, vehicle) + all_functions(&path, vehicle) + actuator(vehicle);
        if black_box(sum).is_nan() {
            return 3;
        }
    }
    for _ in 0..1000 {
        let Ok(command) = law.step(&path, &mut state, vehicle, 0.05) else {
            return 4;
        };
        // SAFETY: the format asks for one double and gets one.
        unsafe { printf(c"%.17g\n".as_ptr(), command.steer) };
        vehicle = kinematic_bicycle(vehicle, command.steer, 0.0, 3.0, 0.05);
    }
    0
}
