//! After construction no controller allocates: counted over 100,000 steps of each.
#![expect(unsafe_code, reason = "an allocator is unsafe to implement")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;

use popsteer_core::driver::{Driver, DriverParams};
use popsteer_core::laws::{
    Pid, PidParams, Pop, PopParams, PreviewPop, PreviewPopParams, PurePursuit, PurePursuitParams,
    Stanley, StanleyParams,
};
use popsteer_core::speed::{
    CoupledLongitudinal, CoupledLongitudinalParams, SpeedPid, SpeedPidParams, SpeedPidState,
    SpeedTracker, SpeedTrackerParams, SpeedTrackerState,
};
use popsteer_core::tracker::Tracker;
use popsteer_core::vehicle::AdaptParams;
use popsteer_core::vehicle::bicycle::kinematic_bicycle;
use popsteer_core::{LateralLaw, Path, Reported, Status, Vehicle, VehicleState};

thread_local! {
    /// Allocations of this thread: the test harness has threads of its own.
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: hands everything on to the system's allocator; the counter itself does not allocate.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's promises are the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promises are the same.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations_of(work: impl FnOnce()) -> usize {
    let before = ALLOCATIONS.with(Cell::get);
    work();
    ALLOCATIONS.with(Cell::get) - before
}

/// A wavy loop.
fn path() -> Path {
    loop_of(100.0)
}

/// The same 1 m farther out.
fn path_aside() -> Path {
    loop_of(101.0)
}

fn loop_of(middle: f64) -> Path {
    let angle = |k: u32| f64::from(k) * std::f64::consts::TAU / 600.0;
    let radius = |k: u32| middle + 4.0 * (12.0 * angle(k)).sin();
    let (x, y): (Vec<f64>, Vec<f64>) = (0..600)
        .map(|k| (radius(k) * angle(k).cos(), radius(k) * angle(k).sin()))
        .unzip();
    Path::new(&x, &y, None, true).unwrap()
}

const START: VehicleState = VehicleState {
    x: 101.0,
    y: 0.0,
    yaw: 1.5,
    speed: 8.0,
};

/// Limited in every way, with commands in flight.
const DELAYED: Vehicle = Vehicle {
    rear_axle: -1.35,
    steer_offset: 0.01,
    dead_time: 0.3,
    max_steer_rate: Some(0.8),
    ..Vehicle::DEFAULT
};

/// Drives round and round, with a step refused now and then.
fn drive<L: LateralLaw>(tracker: &Tracker<L>) {
    let path = path();
    let mut state = tracker.initial_state();
    let mut vehicle = START;
    let mut steered = 0.0;
    let count = allocations_of(|| {
        for k in 0..100_000 {
            if k % 1000 == 999 {
                let bad = VehicleState {
                    x: f64::NAN,
                    ..vehicle
                };
                assert!(
                    tracker
                        .step(&path.view(), &mut state, bad, 0.05, Reported::NOTHING)
                        .is_err()
                );
            }
            let command = tracker.step(&path.view(), &mut state, vehicle, 0.05, Reported::NOTHING);
            let command = command.unwrap();
            steered += command.steer.abs();
            vehicle = kinematic_bicycle(vehicle, command.steer, 0.0, 3.0, 0.05);
        }
    });
    assert!(steered > 0.0, "the controller never steered");
    assert_eq!(count, 0);
}

/// The same with hand-overs, and with inputs refused for which the last command is held.
fn drive_and_hold<L: LateralLaw>(tracker: &Tracker<L>) {
    let path = path();
    let other = path_aside();
    let mut state = tracker.state_from(0.1).unwrap();
    let mut vehicle = START;
    let (mut steered, mut held) = (0.0, 0);
    let count = allocations_of(|| {
        for k in 0..100_000 {
            if k % 5000 == 0 {
                tracker.set_path(&mut state, &path.view(), &other.view());
                tracker.set_path(&mut state, &other.view(), &path.view());
            }
            let seen = VehicleState {
                x: if k % 1000 == 999 { f64::NAN } else { vehicle.x },
                ..vehicle
            };
            let dt = if k % 7 == 0 { 0.001 } else { 0.05 };
            let command =
                tracker.step_or_hold(&path.view(), &mut state, seen, dt, 3, Reported::NOTHING);
            held += usize::from(command.status.contains(Status::INPUT_HELD));
            steered += command.steer.abs();
            vehicle = kinematic_bicycle(vehicle, command.steer, 0.0, 3.0, dt);
        }
    });
    assert!(steered > 0.0, "the controller never steered");
    assert_eq!((count, held), (0, 100));
}

/// With a vehicle that is taken as it is, and with one that is late, limited and estimated.
fn drive_all<L: LateralLaw>(law: impl Fn(Vehicle) -> L) {
    drive(&Tracker::of(law(Vehicle::PAPER)));
    let late = Tracker::new(law(DELAYED), Some(AdaptParams::DEFAULT)).unwrap();
    drive(&late);
    drive_and_hold(&late);
}

#[test]
fn test_pop_steps_allocate_nothing() {
    drive_all(|vehicle| Pop::new(vehicle, PopParams::DEFAULT).unwrap());
}

#[test]
fn test_preview_pop_steps_allocate_nothing() {
    drive_all(|vehicle| PreviewPop::new(vehicle, PreviewPopParams::DEFAULT).unwrap());
}

#[test]
fn test_pid_steps_allocate_nothing() {
    drive_all(|vehicle| Pid::new(vehicle, PidParams::DEFAULT).unwrap());
}

#[test]
fn test_pure_pursuit_steps_allocate_nothing() {
    drive_all(|vehicle| PurePursuit::new(vehicle, PurePursuitParams::DEFAULT).unwrap());
}

#[test]
fn test_stanley_steps_allocate_nothing() {
    drive_all(|vehicle| Stanley::new(vehicle, StanleyParams::DEFAULT).unwrap());
}

#[test]
fn test_longitudinal_steps_allocate_nothing() {
    let coupled = CoupledLongitudinal::new(CoupledLongitudinalParams::default()).unwrap();
    let pid = SpeedPid::new(SpeedPidParams::default()).unwrap();
    let mut state = SpeedPidState::default();
    let mut throttle = 0.0;
    let count = allocations_of(|| {
        for k in 0..100_000 {
            let speed = f64::from(k % 300) / 10.0;
            throttle += coupled.step(speed, 0.1).unwrap().throttle;
            throttle += pid.step(&mut state, speed, 15.0, 0.05).unwrap().throttle;
        }
    });
    assert!(throttle > 0.0);
    assert_eq!(count, 0);
}

#[test]
fn test_speed_tracker_steps_allocate_nothing() {
    let (path, other) = (path(), path_aside());
    let tracker = SpeedTracker::new(DELAYED, SpeedTrackerParams::DEFAULT).unwrap();
    let plans = [&path, &other].map(|each| tracker.plan(&each.view()).unwrap());
    let mut state = SpeedTrackerState::default();
    let mut vehicle = START;
    let mut pull = 0.0;
    let count = allocations_of(|| {
        for k in 0..100_000 {
            if k % 5000 == 0 {
                tracker.set_path(&mut state, &path.view(), &other.view());
                tracker.set_path(&mut state, &other.view(), &path.view());
            }
            let command = tracker
                .step(&path.view(), &plans[0], &mut state, vehicle, 0.05)
                .unwrap();
            pull += command.acceleration.abs();
            // Round and round, by what the path's bend on average takes.
            vehicle = kinematic_bicycle(vehicle, 0.03, command.acceleration, 3.0, 0.05);
        }
    });
    assert!(pull > 0.0);
    assert_eq!(count, 0);
}

#[test]
fn test_driver_steps_allocate_nothing() {
    let path = path();
    let speed = SpeedTracker::new(DELAYED, SpeedTrackerParams::DEFAULT).unwrap();
    let law = PreviewPop::new(DELAYED, PreviewPopParams::DEFAULT).unwrap();
    let driver = Driver::new(Tracker::of(law), speed, DriverParams::DEFAULT).unwrap();
    let plan = speed.plan(&path.view()).unwrap();
    let mut state = driver.initial_state();
    let mut vehicle = START;
    let (mut faults, mut steered) = (0, 0.0);
    let count = allocations_of(|| {
        for k in 0..100_000 {
            let x = if k % 1000 > 970 { f64::NAN } else { vehicle.x };
            let seen = VehicleState { x, ..vehicle };
            let drive = driver.step(&path.view(), &plan, &mut state, seen.into(), 0.05);
            steered += drive.steer.abs();
            faults += usize::from(driver.release(&mut state).is_some());
            vehicle = kinematic_bicycle(vehicle, drive.steer, drive.acceleration, 3.0, 0.05);
        }
    });
    assert!(steered > 0.0 && faults > 0);
    assert_eq!(count, 0);
}

#[test]
fn test_counter_sees_an_allocation() {
    assert_eq!(allocations_of(|| drop(black_box(vec![1.0; 3]))), 1);
}
