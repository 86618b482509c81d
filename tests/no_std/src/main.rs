//! Steering without an operating system's help: 1,000 steps of POP along a sine, then 1,000 of
//! preview POP with a late vehicle, an angle a line.
//!
//! The panic handler calls a function that does not exist. If any path through the core's public
//! functions used here could panic, the handler would be kept and the program would not link.
#![no_std]
#![no_main]

use core::ffi::{c_char, c_int};
use core::hint::black_box;

use popsteer_core::driver::{Driver, DriverParams, Sensed};
use popsteer_core::laws::pid::error_buffer::ErrorBuffer;
use popsteer_core::laws::{
    Law, Pid, PidParams, Pop, PopParams, PreviewPop, PreviewPopParams, PurePursuit,
    PurePursuitParams, Stanley, StanleyParams,
};
use popsteer_core::path::jump::find_lookahead_point;
use popsteer_core::path::lookahead::{get_crossing, get_lookahead_point};
use popsteer_core::path::preview::Preview;
use popsteer_core::path::relocalise::relocalise;
use popsteer_core::path::resample::{Grid, window};
use popsteer_core::path::{locate, projection};
use popsteer_core::speed::{
    CoupledLongitudinal, CoupledLongitudinalParams, SpeedPid, SpeedPidParams, SpeedPidState,
    SpeedTracker, SpeedTrackerParams,
};
use popsteer_core::tracker::Tracker;
use popsteer_core::vehicle::bicycle::{get_predicted_location, kinematic_bicycle};
use popsteer_core::vehicle::{AdaptParams, Estimate, InFlight};
use popsteer_core::{LateralLaw, PathView, Point, Reported, Status, Vehicle, VehicleState, math};

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

/// Limited in every way, with commands in flight.
const DELAYED: Vehicle = Vehicle {
    wheelbase: 2.7,
    rear_axle: -1.35,
    no_slip_point: Some(-1.2),
    turning_wheelbase: Some(2.8),
    understeer: 0.002,
    steer_offset: 0.01,
    steer_lag: 0.1,
    dead_time: 0.15,
    max_steer: 0.6,
    max_steer_rate: Some(0.5),
    max_lateral_acceleration: Some(4.0),
    ..Vehicle::DEFAULT
};

/// A few steps of a controller, its answers and its state seen by the optimizer as unknown.
fn steps<L: LateralLaw>(tracker: &Tracker<L>, path: &PathView<'_>, vehicle: VehicleState) -> f64 {
    let mut state = black_box(tracker.initial_state());
    let dt = black_box(0.05);
    let mut sum = tracker
        .step(path, &mut state, black_box(vehicle), dt, Reported::NOTHING)
        .map_or(0.0, |c| c.steer + c.cross_track_error);
    sum += tracker
        .relocalise(path, &mut state, vehicle.x, vehicle.y, vehicle.yaw)
        .map_or(0.0, |()| 1.0);
    sum += tracker
        .steer(path, &mut state, black_box(vehicle), dt, Reported::NOTHING)
        .unwrap_or(0.0);
    if let Ok(taken_over) = tracker.state_from(black_box(0.1)) {
        state = taken_over;
    }
    for x in black_box([0.0, f64::NAN, 0.1]) {
        let seen = VehicleState { x, ..vehicle };
        let command =
            tracker.step_or_hold(path, &mut state, seen, dt, black_box(1), Reported::NOTHING);
        let known = Status::from_bits(command.status.bits());
        sum += known.map_or(0.0, |status| math::from_count(status.names().count()));
        sum += command.steer + tracker.estimate(&state).gain;
    }
    tracker.set_path(&mut state, path, black_box(path));
    sum += tracker.check_state(path, &state).map_or(0.0, |()| 1.0);
    sum + tracker.tracked_point()
}

/// A law that takes its vehicle as it is, and one that is late, limited and estimated.
fn both<L: LateralLaw, E>(
    path: &PathView<'_>,
    vehicle: VehicleState,
    law: impl Fn(Vehicle) -> Result<L, E>,
) -> f64 {
    let mut sum = 0.0;
    if let Ok(law) = law(black_box(Vehicle::PAPER)) {
        sum += steps(&Tracker::of(law), path, vehicle);
    }
    if let Ok(law) = law(black_box(DELAYED))
        && let Ok(tracker) = Tracker::new(law, black_box(Some(AdaptParams::DEFAULT)))
    {
        sum += steps(&tracker, path, vehicle);
    }
    sum
}

/// Every public controller, so that none of them can panic.
fn all_laws(path: &PathView<'_>, vehicle: VehicleState) -> f64 {
    let paper = PopParams {
        exact_lookahead: false,
        ..PopParams::DEFAULT
    };
    let mut sum = 0.0;
    for params in black_box([PopParams::DEFAULT, paper]) {
        sum += both(path, vehicle, |car| Pop::new(car, params));
    }
    let params = black_box(PreviewPopParams::DEFAULT);
    sum += both(path, vehicle, |car| PreviewPop::new(car, params));
    let params = black_box(PidParams::DEFAULT);
    sum += both(path, vehicle, |car| Pid::new(car, params));
    let params = black_box(PurePursuitParams::DEFAULT);
    sum += both(path, vehicle, |car| PurePursuit::new(car, params));
    let params = black_box(StanleyParams::DEFAULT);
    sum += both(path, vehicle, |car| Stanley::new(car, params));
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

/// The whole vehicle by any of the controllers: steps on what comes, and on what does not.
fn driver(path: &PathView<'_>, vehicle: VehicleState) -> f64 {
    let car = black_box(DELAYED);
    let Ok(law) = PreviewPop::new(car, black_box(PreviewPopParams::DEFAULT)) else {
        return 0.0;
    };
    let Ok(speed) = SpeedTracker::new(car, black_box(SpeedTrackerParams::DEFAULT)) else {
        return 0.0;
    };
    let tracker = Tracker::of(black_box(Law::from(law)));
    let Ok(driver) = Driver::new(tracker, speed, black_box(DriverParams::DEFAULT)) else {
        return 0.0;
    };
    let plan = black_box([5.0; WAYPOINTS]);
    let mut state = black_box(driver.initial_state());
    let mut sum = 0.0;
    for x in black_box([0.0, f64::NAN, 0.1]) {
        let sensed = Sensed {
            gear: black_box(Some(true)),
            ..Sensed::from(VehicleState { x, ..vehicle })
        };
        let drive = driver.step(path, &plan, &mut state, sensed, black_box(0.05));
        sum += drive.steer + drive.acceleration + drive.speed;
        sum += drive
            .fault
            .map_or(0.0, |fault| math::from_count(fault.name().len()));
    }
    driver.set_path(&mut state, path, black_box(path));
    state.held = black_box(true);
    let released = driver.release(&mut state).is_some();
    sum += driver.check_state(path, &state).map_or(0.0, |()| 1.0);
    sum + driver.state_from(black_box(0.1)).map_or(0.0, |_| 1.0) + f64::from(u8::from(released))
}

/// Commands on their way to the wheels.
fn in_flight(vehicle: VehicleState) -> f64 {
    let car = black_box(DELAYED);
    let mut in_flight = InFlight::settled(&car, black_box(0.1));
    for dt in black_box([0.05, 1e-6, 0.3]) {
        in_flight.elapse(&car, black_box(0.2), dt, black_box(0.0));
    }
    let estimate = black_box(Estimate::DEFAULT);
    let (seen, wheel) = in_flight.predict(&car, vehicle, in_flight.wheel(), &estimate);
    let integrals = in_flight.wheel_integrals(&car, black_box(0.2), black_box(0.05));
    let restored = InFlight::restore(
        black_box([(0.1, 0.05), (0.2, 0.1)]).into_iter(),
        in_flight.wheel(),
        black_box(car.dead_time),
    );
    let sum: f64 = in_flight.commands().map(|(steer, _)| steer).sum();
    let turned = seen.x + wheel + integrals.turn;
    sum + turned + restored.map_or(0.0, |in_flight| in_flight.wheel())
}

/// The plain functions, called the same way.
fn all_functions(path: &PathView<'_>, vehicle: VehicleState) -> f64 {
    let position = black_box(vehicle.point_ahead(1.0));
    let index = black_box(7_usize);
    let nearest = projection::nearest_waypoint(path, position);
    let heading = Point::new(math::cos(vehicle.yaw), math::sin(vehicle.yaw));
    let opposite = black_box(locate::OPPOSITE);
    let located = locate::locate(path, index, position, heading, black_box(6.0), opposite);
    let scanned = locate::locate_by_scan(path, index, position, heading, black_box(6.0), opposite);
    let (crossing, _) = get_crossing(path, &located, position, black_box(6.0));
    let mut turns = black_box([0.0; 20]);
    let arc_length = scanned.arc_length(path);
    let mut ahead = Preview::new(path, black_box(2.0), scanned.segment, arc_length, 20.0);
    let (along, _) = ahead.turns(arc_length, black_box(1.0), &mut turns);
    // No numbers that make sense: what refuses them has to link, too.
    let path = &path.with_yaw(path.x(), Some(path.y())).unwrap_or(*path);
    let located = located.nearest_waypoint(path);
    let jumped_to = relocalise(path, position, black_box(0.3), opposite);
    let closest = projection::project(path, index, position);
    let mut sum = math::from_count(nearest + located + jumped_to) + closest.cross_track_error;
    sum += crossing.x + along + projection::path_yaw_behind(path, index);
    sum += projection::reference_speed(path, &closest).unwrap_or(0.0);
    let grid = Grid::new(*path, window(path, index, black_box(20.0)), black_box(0.01));
    let (lookahead, tolerance) = black_box((6.0, 0.01));
    let found = get_lookahead_point(&grid, position, lookahead, tolerance);
    let (jumped, _) = find_lookahead_point(path, index, 20.0, 0.01, position, lookahead, tolerance);
    sum += found.point.x + math::from_count(found.index) + jumped.x;
    sum += get_predicted_location(vehicle, black_box(0.1), 0.05).x;
    let terms = black_box([1.0, 2.0, 3.0]);
    if cfg!(feature = "planted-panic") {
        sum += terms[index];
    }
    let mut buffer = ErrorBuffer::new(black_box(5));
    terms.into_iter().for_each(|term| buffer.push(term));
    sum + buffer.sum() + buffer.terms().count() as f64
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
    let vehicle = VehicleState {
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
        let sum = all_laws(&path, vehicle)
            + all_functions(&path, vehicle)
            + driver(&path, vehicle)
            + in_flight(vehicle);
        if black_box(sum).is_nan() {
            return 3;
        }
    }
    let pop = Pop::new(Vehicle::DEFAULT, PopParams::DEFAULT);
    let preview_pop = PreviewPop::new(DELAYED, PreviewPopParams::DEFAULT);
    let (Ok(pop), Ok(preview_pop)) = (pop, preview_pop) else {
        return 2;
    };
    if drive(&Tracker::of(pop), &path, vehicle) && drive(&Tracker::of(preview_pop), &path, vehicle)
    {
        0
    } else {
        4
    }
}

/// Prints an angle for each of 1,000 steps; whether every one was answered.
fn drive<L: LateralLaw>(
    tracker: &Tracker<L>,
    path: &PathView<'_>,
    mut vehicle: VehicleState,
) -> bool {
    let mut state = tracker.initial_state();
    for _ in 0..1000 {
        let Ok(command) = tracker.step(path, &mut state, vehicle, 0.05, Reported::NOTHING) else {
            return false;
        };
        // SAFETY: the format asks for one double and gets one.
        unsafe { printf(c"%.17g\n".as_ptr(), command.steer) };
        vehicle = kinematic_bicycle(vehicle, command.steer, 0.0, 3.0, 0.05);
    }
    true
}
