//! The whole vehicle in one step, around a plant of the test's own.

use popsteer_core::driver::{Drive, Driver, DriverParams, DriverState, Sensed};
use popsteer_core::laws::{Law, LawState, PreviewPop, PreviewPopParams, Stanley, StanleyParams};
use popsteer_core::speed::{SpeedTracker, SpeedTrackerParams};
use popsteer_core::vehicle::Fault;
use popsteer_core::{Path, Reported, Status, Tracker, Vehicle, VehicleState};

const DT: f64 = 0.05;
const CAR: Vehicle = Vehicle {
    wheelbase: 2.7,
    rear_axle: -1.35,
    max_steer: 0.6,
    max_steer_rate: Some(0.5),
    steer_lag: 0.1,
    dead_time: 0.15,
    max_lateral_acceleration: Some(4.0),
    max_speed: Some(10.0),
    max_deceleration: Some(1.5),
    ..Vehicle::DEFAULT
};

/// A bicycle with a lag and a dead time of its own, whose brakes brake in every gear.
struct Plant {
    rear: VehicleState,
    wheel: f64,
    in_flight: Vec<f64>,
    sign: f64,
}

impl Plant {
    fn at(x: f64, y: f64, yaw: f64, speed: f64) -> Self {
        Self {
            rear: VehicleState { x, y, yaw, speed },
            wheel: 0.0,
            in_flight: vec![0.0; 15],
            sign: 1.0,
        }
    }

    /// The pose of the vehicle's point.
    fn pose(&self) -> VehicleState {
        self.rear.ahead(-CAR.rear_axle)
    }

    fn go(&mut self, drive: &Drive, dt: f64) {
        let gear = if drive.reverse { -1.0 } else { 1.0 };
        for _ in 0..5 {
            let h = dt / 5.0;
            self.in_flight.push(self.sign * drive.steer);
            let gap = self.in_flight.remove(0) - self.wheel;
            self.wheel += (gap * (1.0 - (-h / CAR.steer_lag).exp())).clamp(-0.5 * h, 0.5 * h);
            let v = &mut self.rear.speed;
            if drive.acceleration >= 0.0 && !drive.hold {
                *v += gear * drive.acceleration * h;
            } else {
                *v = (v.abs() + drive.acceleration.min(0.0) * h)
                    .max(0.0)
                    .copysign(*v);
            }
            let rear = &mut self.rear;
            rear.x += h * rear.speed * rear.yaw.cos();
            rear.y += h * rear.speed * rear.yaw.sin();
            rear.yaw += h * rear.speed * self.wheel.tan() / CAR.wheelbase;
        }
    }
}

struct Rig {
    driver: Driver<Law>,
    state: DriverState<LawState>,
    path: Path,
    plan: Vec<f64>,
    plant: Plant,
    /// How far the rear axle was from the path at most [m].
    off: f64,
}

impl Rig {
    fn new(law: impl Into<Law>, path: Path) -> Self {
        let speed = SpeedTracker::new(CAR, SpeedTrackerParams::DEFAULT).unwrap();
        let driver = Driver::new(Tracker::of(law.into()), speed, DriverParams::DEFAULT).unwrap();
        let plan = speed.plan(&path.view()).unwrap();
        let state = driver.initial_state();
        let (x, y) = (path.view().x(), path.view().y());
        let yaw = (y[1] - y[0]).atan2(x[1] - x[0]);
        let plant = Plant::at(x[0], y[0], yaw, 0.0);
        let off = 0.0;
        Self {
            driver,
            state,
            path,
            plan,
            plant,
            off,
        }
    }

    fn preview(path: Path) -> Self {
        Self::new(
            PreviewPop::new(CAR, PreviewPopParams::DEFAULT).unwrap(),
            path,
        )
    }

    fn step(&mut self, sensed: impl Into<Sensed>, dt: f64) -> Drive {
        let (path, state) = (self.path.view(), &mut self.state);
        self.driver
            .step(&path, &self.plan, state, sensed.into(), dt)
    }

    /// Drives for `time` [s] on what `sense` makes of time and pose; the last answer.
    fn drive(
        &mut self,
        time: f64,
        mut sense: impl FnMut(f64, VehicleState) -> VehicleState,
    ) -> Drive {
        let mut last = None;
        let steps = popsteer_core::math::to_count(time / DT + 0.5);
        for k in 0..steps {
            let given = sense(popsteer_core::math::from_count(k) * DT, self.plant.pose());
            let drive = self.step(given, DT);
            assert!(drive.steer.abs() <= CAR.max_steer && drive.acceleration.is_finite());
            self.plant.go(&drive, DT);
            let rear = self.plant.rear;
            let at = self.path.view();
            let distances = at
                .x()
                .iter()
                .zip(at.y())
                .map(|(x, y)| (x - rear.x).hypot(y - rear.y));
            self.off = self.off.max(distances.fold(f64::INFINITY, f64::min));
            last = Some(drive);
        }
        last.unwrap()
    }
}

/// Bends of 4 m to both sides, every 0.25 m a waypoint.
fn bends() -> Path {
    let x: Vec<f64> = (0..800).map(|k| 0.25 * f64::from(k)).collect();
    let y: Vec<f64> = x.iter().map(|x| 4.0 * (1.0 - (x / 15.0).cos())).collect();
    Path::new(&x, &y, None, false).unwrap()
}

/// 30 m out and back on one line.
fn shuttle() -> Path {
    let x: Vec<f64> = (0..=120)
        .map(|k| 30.0 - 0.5 * f64::from((k - 60_i32).abs()))
        .collect();
    let back: Vec<bool> = (0..=120).map(|k| k >= 60).collect();
    Path::new(&x, &[0.0; 121], None, false)
        .unwrap()
        .with_reverse(&back)
        .unwrap()
}

const NAN: VehicleState = VehicleState {
    x: f64::NAN,
    y: f64::NAN,
    yaw: f64::NAN,
    speed: f64::NAN,
};

#[test]
fn test_driver_drives_to_the_end_and_stands_there() {
    for law in [
        Law::from(PreviewPop::new(CAR, PreviewPopParams::DEFAULT).unwrap()),
        Law::from(Stanley::new(CAR, StanleyParams::DEFAULT).unwrap()),
    ] {
        let mut rig = Rig::new(law, bends());
        let end = rig.drive(50.0, |_, pose| pose);
        let (x, rear) = (rig.path.view().x()[799], rig.plant.rear);
        assert!(
            (rear.x - x).abs() < 0.1 && rear.speed.abs() < 1e-9,
            "{rear:?}"
        );
        assert!(
            end.hold && end.fault.is_none() && rig.off < 0.5,
            "{end:?} {}",
            rig.off
        );
    }
}

#[test]
fn test_driver_changes_its_gear_where_it_stands_and_comes_back() {
    let mut rig = Rig::preview(shuttle());
    let mut changed = 0;
    let mut last = false;
    for _ in 0..1200 {
        let pose = rig.plant.pose();
        let drive = rig.step(pose, DT);
        if drive.reverse != last {
            assert!(pose.speed.abs() < 0.06, "{pose:?}");
            changed += 1;
            last = drive.reverse;
        }
        rig.plant.go(&drive, DT);
    }
    assert_eq!(changed, 1);
    assert!(
        rig.plant.rear.x.abs() < 0.05 && rig.plant.rear.speed == 0.0,
        "{:?}",
        rig.plant.rear
    );
}

#[test]
fn test_driver_waits_for_the_gear_that_is_reported() {
    let mut rig = Rig::preview(shuttle());
    let mut waited = 0;
    for k in 0..1600 {
        let pose = rig.plant.pose();
        // The gearbox shifts a second after it is asked to.
        let gear = Some(waited >= 20);
        let sensed = Sensed {
            gear,
            ..Sensed::from(pose)
        };
        let drive = rig.step(sensed, DT);
        if drive.reverse && waited < 20 {
            assert!(drive.acceleration <= 0.0 || k == 0, "{k} {drive:?}");
            waited += 1;
        }
        rig.plant.go(&drive, DT);
    }
    assert!(
        waited == 20 && rig.plant.rear.x.abs() < 0.05,
        "{:?}",
        rig.plant.rear
    );
}

/// Any signal dies in mid-bend: it says which, stands, and is not farther off than its page says.
#[test]
fn test_driver_stops_by_what_is_still_believed() {
    type Lose = fn(VehicleState) -> VehicleState;
    let cases: [(Lose, Fault, f64); 4] = [
        (|_| NAN, Fault::Input, 0.6),
        (|v| VehicleState { x: f64::NAN, ..v }, Fault::Position, 0.4),
        (|v| VehicleState { yaw: f64::NAN, ..v }, Fault::Heading, 0.4),
        (
            |v| VehicleState {
                speed: f64::NAN,
                ..v
            },
            Fault::Speed,
            0.4,
        ),
    ];
    for (lose, fault, most) in cases {
        for at in [6.0, 9.0, 12.0, 15.0] {
            let mut rig = Rig::preview(bends());
            rig.drive(at, |_, pose| pose);
            rig.off = 0.0;
            let end = rig.drive(14.0, |_, pose| lose(pose));
            assert_eq!(end.fault, Some(fault), "{at}");
            assert!(
                end.hold && rig.plant.rear.speed.abs() < 0.1,
                "{fault} {at} {:?}",
                rig.plant.rear
            );
            assert!(rig.off < most, "{fault} {at}: {} m", rig.off);
        }
    }
}

#[test]
fn test_driver_stops_for_a_frozen_pose_and_for_a_wrong_sign() {
    let mut rig = Rig::preview(bends());
    rig.drive(8.0, |_, pose| pose);
    let frozen = rig.plant.pose();
    rig.off = 0.0;
    let end = rig.drive(12.0, |_, _| frozen);
    assert_eq!(end.fault, Some(Fault::Position));
    assert!(
        end.hold && rig.plant.rear.speed.abs() < 0.1 && rig.off < 0.6,
        "{}",
        rig.off
    );

    let mut rig = Rig::preview(bends());
    rig.plant.sign = -1.0;
    let end = rig.drive(20.0, |_, pose| pose);
    assert_eq!(end.fault, Some(Fault::Steering));
    assert!(
        end.hold && rig.plant.rear.speed.abs() < 0.1 && rig.off < 2.5,
        "{} {:?} {end:?}",
        rig.off,
        rig.plant.rear
    );
}

#[test]
fn test_driver_bridges_a_gap_and_goes_on_after_release() {
    let mut rig = Rig::preview(bends());
    rig.drive(8.0, |_, pose| pose);
    let drive = rig.drive(0.4, |_, _| NAN);
    assert!(
        drive.fault.is_none() && drive.status.contains(Status::INPUT_HELD),
        "{drive:?}"
    );
    let drive = rig.drive(4.0, |_, pose| pose);
    assert!(
        drive.fault.is_none() && rig.off < 0.3,
        "{drive:?} {}",
        rig.off
    );

    rig.drive(10.0, |_, _| NAN);
    // It comes again, and the vehicle stays where it is until it is released.
    let drive = rig.drive(5.0, |_, pose| pose);
    assert_eq!((drive.fault, drive.hold), (Some(Fault::Input), true));
    assert_eq!(rig.driver.release(&mut rig.state), Some(Fault::Input));
    let drive = rig.drive(30.0, |_, pose| pose);
    assert!(
        drive.fault.is_none() && drive.hold && rig.off < 0.5,
        "{drive:?} {}",
        rig.off
    );
    assert!((rig.plant.rear.x - rig.path.view().x()[799]).abs() < 0.1);
}

#[test]
fn test_driver_of_a_clock_that_repeats_and_jumps_drives_as_with_an_even_one() {
    let even = {
        let mut rig = Rig::preview(bends());
        rig.drive(20.0, |_, pose| pose);
        rig.off
    };
    for jump in [0.0, -60.0, 2e3, -1e-3] {
        let mut rig = Rig::preview(bends());
        let (mut last, mut held) = (0.0, 0);
        for k in 1..=400_i32 {
            // A loop of 20 Hz whose clock shows every other step alone, and jumps once.
            let now = 0.1 * f64::from(k / 2) + if k > 200 { jump } else { 0.0 };
            let (dt, pose) = (now - last, rig.plant.pose());
            last = now;
            let drive = rig.step(pose, dt);
            assert!(drive.fault.is_none(), "{jump} {k} {drive:?}");
            held += i32::from(drive.status.contains(Status::INPUT_HELD));
            rig.plant.go(&drive, DT);
            let at = rig.path.view();
            let rear = rig.plant.rear;
            let distances = at
                .x()
                .iter()
                .zip(at.y())
                .map(|(x, y)| (x - rear.x).hypot(y - rear.y));
            rig.off = rig.off.max(distances.fold(f64::INFINITY, f64::min));
        }
        assert!(rig.off < even + 0.1, "{jump}: {} {even}", rig.off);
        assert!((200..=202).contains(&held), "{jump}: {held}");
    }
}

#[test]
fn test_driver_is_held_by_its_operator_until_it_is_to_go() {
    let mut rig = Rig::preview(bends());
    rig.drive(8.0, |_, pose| pose);
    rig.state.held = true;
    let drive = rig.drive(10.0, |_, pose| pose);
    assert!(drive.hold && drive.fault.is_none() && rig.off < 0.3);
    let stood = rig.plant.rear.x;
    rig.state.held = false;
    rig.drive(5.0, |_, pose| pose);
    assert!(rig.plant.rear.x > stood + 5.0);
}

#[test]
fn test_driver_that_knows_nothing_holds_and_one_odd_report_changes_nothing() {
    let mut rig = Rig::preview(bends());
    let drive = rig.drive(3.0, |_, _| NAN);
    assert!(drive.hold && drive.fault.is_none() && drive.steer.abs() < 1e-12);
    let pose = rig.plant.pose();
    let odd = Sensed {
        reported: Reported {
            applied_steer: Some(f64::NAN),
            measured_steer: Some(9.0),
            pose_age: 0.0,
            roll: f64::NAN,
        },
        ..Sensed::from(pose)
    };
    assert!(rig.step(odd, DT).fault.is_none());
    let check = rig.driver.check_state(&rig.path.view(), &rig.state);
    assert_eq!(check, Ok(()));
}

/// What a fault blames may come again, and be wrong: it is believed no more than what does not come.
#[test]
fn test_driver_believes_nothing_of_what_is_blamed_until_it_is_released() {
    type Sense = fn(VehicleState) -> VehicleState;
    let cases: [(Fault, Sense, Sense); 3] = [
        (
            Fault::Position,
            |v| VehicleState { x: f64::NAN, ..v },
            |v| VehicleState { y: v.y + 3.0, ..v },
        ),
        (
            Fault::Heading,
            |v| VehicleState { yaw: f64::NAN, ..v },
            |v| VehicleState {
                yaw: v.yaw + 0.5,
                ..v
            },
        ),
        (
            Fault::Speed,
            |v| VehicleState {
                speed: f64::NAN,
                ..v
            },
            |v| VehicleState {
                speed: 0.5 * v.speed,
                ..v
            },
        ),
    ];
    for (fault, lost, wrong) in cases {
        let answers = [lost, wrong].map(|sense| {
            let mut rig = Rig::preview(bends());
            rig.drive(9.0, |_, pose| pose);
            rig.state.fault = Some(fault);
            let drives: Vec<Drive> = (0..60).map(|_| rig.drive(DT, |_, v| sense(v))).collect();
            drives
        });
        for (k, (lost, wrong)) in answers[0].iter().zip(&answers[1]).enumerate() {
            let of = |drive: &Drive| (drive.steer, drive.acceleration, drive.distance_to_stop);
            assert_eq!(of(lost), of(wrong), "{fault} {k}");
        }
    }
}

/// A heading that lives shows itself a frozen localisation's where it stops to change later.
#[test]
fn test_driver_without_a_position_notes_the_heading_and_the_speed_that_freeze_after_it() {
    let mut rig = Rig::preview(bends());
    rig.drive(9.0, |_, pose| pose);
    rig.state.fault = Some(Fault::Position);
    let mut alive = rig.plant.pose();
    rig.drive(0.5, |_, pose| {
        alive = VehicleState {
            x: f64::NAN,
            ..pose
        };
        alive
    });
    assert_eq!(
        (rig.state.signals.heading, rig.state.signals.speed),
        (0.0, 0.0)
    );
    rig.drive(0.25, |_, _| alive);
    let counted = (rig.state.signals.heading, rig.state.signals.speed);
    assert!(counted.0 > 0.2 && counted.1 > 0.2, "{counted:?}");
}

/// Exactly the time that is bridged is no fault yet, of each signal alone and of all.
#[test]
fn test_driver_bridges_just_its_hold_time() {
    type Lose = fn(VehicleState) -> VehicleState;
    let cases: [(Lose, Fault); 4] = [
        (|_| NAN, Fault::Input),
        (|v| VehicleState { y: f64::NAN, ..v }, Fault::Position),
        (|v| VehicleState { yaw: f64::NAN, ..v }, Fault::Heading),
        (
            |v| VehicleState {
                speed: f64::NAN,
                ..v
            },
            Fault::Speed,
        ),
    ];
    for (lose, fault) in cases {
        let mut rig = Rig::preview(bends());
        rig.drive(6.0, |_, pose| pose);
        // Four times an eighth are the half second of the default, to the bit.
        let found: Vec<Option<Fault>> = (0..5)
            .map(|_| {
                let drive = rig.step(lose(rig.plant.pose()), 0.125);
                rig.plant.go(&drive, 0.125);
                drive.fault
            })
            .collect();
        assert_eq!(found, [None, None, None, None, Some(fault)]);
    }
}

/// A clock that stands in one of its ways: the vehicle is told to brake, by acceleration and by speed.
#[test]
fn test_driver_of_a_clock_that_stands_brakes_to_a_speed_of_zero() {
    for dt in [0.0, -1.0, f64::NAN] {
        let mut rig = Rig::preview(bends());
        rig.drive(8.0, |_, pose| pose);
        let mut last = rig.step(rig.plant.pose(), dt);
        for _ in 0..101 {
            last = rig.step(rig.plant.pose(), dt);
        }
        assert_eq!(last.fault, Some(Fault::Input), "{dt}");
        assert_eq!((last.speed, last.acceleration), (0.0, -1.5), "{dt}");
    }
}

/// Operator and fault at once: at rest and in motion the harder of both brakes, and neither lets go of
/// what the other holds.
#[test]
fn test_driver_with_a_fault_and_an_operator_at_once_does_what_both_want() {
    let path = |end: u32| {
        let x: Vec<f64> = (0..=end).map(f64::from).collect();
        Path::new(&x, &vec![0.0; x.len()], None, false).unwrap()
    };
    let both = [
        (false, None),
        (true, None),
        (false, Some(Fault::Speed)),
        (true, Some(Fault::Speed)),
        (false, Some(Fault::Deviation)),
        (true, Some(Fault::Deviation)),
    ];
    for (held, fault) in both {
        let mut rig = Rig::preview(path(40));
        rig.drive(5.0, |_, pose| pose);
        (rig.state.held, rig.state.fault) = (held, fault);
        let drive = rig.drive(0.5, |_, pose| pose);
        let braking = -drive.acceleration;
        match (held, fault) {
            (false, None) => assert!(braking < 1.4, "{drive:?}"),
            (_, Some(Fault::Deviation)) => assert!(braking > 2.0, "{drive:?}"),
            _ => assert!((braking - 1.5).abs() < 0.1, "{held} {fault:?} {drive:?}"),
        }
        // It stands at its end; a path that goes on moves it only where nothing stops it.
        (rig.state.held, rig.state.fault) = (false, None);
        rig.drive(20.0, |_, pose| pose);
        (rig.state.held, rig.state.fault) = (held, fault);
        let (old, new) = (path(40), path(80));
        rig.driver
            .set_path(&mut rig.state, &old.view(), &new.view());
        rig.plan = rig.driver.speed().plan(&new.view()).unwrap();
        rig.path = new;
        let stood = rig.plant.rear.x;
        let drive = rig.drive(4.0, |_, pose| pose);
        let stops = held || fault.is_some();
        assert_eq!(drive.hold, stops, "{held} {fault:?}");
        assert_eq!(rig.plant.rear.x - stood < 0.02, stops, "{held} {fault:?}");
        // The one goes, the other still stops it; then it drives.
        rig.state.held = false;
        assert_eq!(rig.drive(1.0, |_, pose| pose).hold, fault.is_some());
        assert_eq!(rig.driver.release(&mut rig.state), fault);
        assert!(!rig.drive(3.0, |_, pose| pose).hold, "{held} {fault:?}");
    }
}

/// What was found before a release says nothing after it, the second time as the first.
#[test]
fn test_driver_that_is_released_has_nothing_of_its_fault_left() {
    let mut rig = Rig::preview(bends());
    rig.drive(6.0, |_, pose| pose);
    for _ in 0..2 {
        rig.drive(1.0, |_, _| NAN);
        rig.state.doubt = Some(Fault::CannotStop);
        rig.state.signals.repeats = 7;
        assert_eq!(rig.driver.release(&mut rig.state), Some(Fault::Input));
        assert_eq!(rig.driver.release(&mut rig.state), None);
        let left = &rig.state;
        assert_eq!((left.fault, left.doubt), (None, None));
        assert_eq!(left.signals, rig.driver.initial_state().signals);
        let drive = rig.drive(2.0, |_, pose| pose);
        assert_eq!(drive.fault, None);
    }
}

/// One speed that is wrong, forwards and backwards along one line: as little is believed of it.
#[test]
fn test_driver_backwards_believes_as_little_of_one_wrong_speed_as_forwards() {
    let x: Vec<f64> = (0..=80).map(f64::from).collect();
    let line = || Path::new(&x, &[0.0; 81], None, false).unwrap();
    for wrong in [0.0, -1.0, 2.0] {
        let answers = [false, true].map(|reverse| {
            let path = if reverse {
                line().with_reverse(&[true; 81]).unwrap()
            } else {
                line()
            };
            let mut rig = Rig::preview(path);
            if reverse {
                rig.plant.rear.yaw = core::f64::consts::PI;
            }
            rig.drive(5.0, |_, pose| pose);
            let driving = rig.plant.rear.speed.abs();
            assert!(driving > 3.0, "{reverse}: {driving}");
            let drive = rig.drive(DT, |_, pose| VehicleState {
                speed: wrong * pose.speed,
                ..pose
            });
            drive.acceleration
        });
        let apart = (answers[0] - answers[1]).abs();
        assert!(apart < 1e-3, "{wrong}: {answers:?}");
    }
}

/// Too fast for its end: that is said while its operator brakes it, too, and as soon.
#[test]
fn test_driver_that_cannot_stop_says_so_also_while_it_is_held() {
    let steps = [false, true].map(|held| {
        let mut rig = Rig::preview(bends());
        rig.drive(8.0, |_, pose| pose);
        rig.state.held = held;
        // Another path ends 4 m ahead.
        let (old, ahead) = (bends(), rig.plant.rear.x + 4.0);
        let (x, y) = (old.view().x(), old.view().y());
        let count = x.iter().take_while(|&&x| x < ahead).count();
        let new = Path::new(&x[..count], &y[..count], None, false).unwrap();
        rig.driver
            .set_path(&mut rig.state, &old.view(), &new.view());
        rig.plan = rig.driver.speed().plan(&new.view()).unwrap();
        rig.path = new;
        let faults: Vec<_> = (0..4)
            .map(|_| rig.drive(DT, |_, pose| pose).fault)
            .collect();
        faults
            .iter()
            .position(|&fault| fault == Some(Fault::CannotStop))
    });
    assert_eq!(steps, [Some(2), Some(2)]);
}

/// A stop line that is passed twice stays the one at which the vehicle stands, however the waypoints of
/// a fresh path count.
#[test]
fn test_driver_at_a_line_that_is_passed_twice_stands_at_its_own_on_a_shorter_path() {
    let lines = |from: i32| {
        let x: Vec<f64> = (from..=120)
            .map(|k| 30.0 - 0.5 * f64::from((k - 60_i32).abs()))
            .collect();
        let back: Vec<bool> = (from..=120).map(|k| k >= 60).collect();
        let speed: Vec<f64> = (from..=120)
            .map(|k| if k == 50 || k == 70 { 0.0 } else { 3.0 })
            .collect();
        Path::new(&x, &vec![0.0; x.len()], Some(&speed), false)
            .unwrap()
            .with_reverse(&back)
            .unwrap()
    };
    let mut rig = Rig::preview(lines(0));
    assert!(rig.drive(20.0, |_, pose| pose).hold);
    assert!((rig.plant.rear.x - 25.0).abs() < 0.1);
    let new = lines(45);
    rig.driver
        .set_path(&mut rig.state, &lines(0).view(), &new.view());
    assert_eq!(rig.state.speed.stop.map(|(waypoint, ..)| waypoint), Some(5));
    assert!(rig.state.speed.standing);
}
