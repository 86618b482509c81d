//! A driver in what comes seldom: two conditions at once, what comes again after a fault, boundaries, the
//! other gear, a second release.

#[path = "driver/rig.rs"]
mod rig;

use popsteer_core::driver::Drive;
use popsteer_core::vehicle::Fault;
use popsteer_core::{Path, VehicleState};
use rig::{DT, NAN, Rig, bends};

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

/// A motor that takes an acceleration for what it is passes rest within a period, and would go on to the
/// other way: it is held there.
#[test]
fn test_driver_of_a_motor_that_passes_rest_within_a_period_holds_it_there() {
    let x: Vec<f64> = (0..=80).map(f64::from).collect();
    for reverse in [false, true] {
        for fault in [None, Some(Fault::Speed), Some(Fault::Steering)] {
            for begin in 0..20 {
                let line = Path::new(&x, &[0.0; 81], None, false).unwrap();
                let line = line.with_reverse(&[reverse; 81]).unwrap();
                let mut rig = Rig::preview(line);
                let yaw = if reverse { core::f64::consts::PI } else { 0.0 };
                rig.plant.rear.yaw = yaw;
                rig.drive(2.0 + DT * f64::from(begin), |_, pose| pose);
                let mut rear = rig.plant.rear;
                let gear = rear.speed.signum();
                rig.state.held = fault.is_none();
                rig.state.fault = fault;
                let mut held = None;
                for k in 0..200 {
                    let drive = rig.step(rear.ahead(1.35), DT);
                    held = held.or(drive.hold.then_some(k));
                    rear.speed += gear * drive.acceleration * DT;
                    if drive.hold {
                        rear.speed = 0.0;
                    }
                    rear.x += rear.speed * yaw.cos() * DT;
                    assert!(gear * rear.speed > -0.5, "{fault:?} {begin} {k}");
                }
                assert!(held.is_some(), "{reverse} {fault:?} {begin}");
            }
        }
    }
}

/// A speed with the wrong sign is a fault at once. The vehicle comes to rest and is held, whatever noise the
/// positions have by which its speed is found since.
#[test]
fn test_driver_of_a_speed_with_the_wrong_sign_holds_the_vehicle_at_rest() {
    for noise in [0.0, 1e-9, 0.01] {
        let mut rig = Rig::preview(bends());
        let mut random = 1_u64;
        let mut drawn = move || {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            let share = f64::from(u32::try_from(random >> 32).unwrap()) / f64::from(u32::MAX);
            noise * (3.4 * share - 1.7)
        };
        let mut sense = move |pose: VehicleState| VehicleState {
            x: pose.x + drawn(),
            y: pose.y + drawn(),
            speed: -pose.speed,
            ..pose
        };
        let drive = rig.drive(4.0, |_, pose| sense(pose));
        assert_eq!(drive.fault, Some(Fault::Speed), "{noise}");
        for k in 0..200 {
            let drive = rig.drive(DT, |_, pose| sense(pose));
            assert!(drive.hold && drive.acceleration < 0.0, "{noise} {k}");
        }
        assert!(rig.plant.rear.speed.abs() < 1e-9, "{noise}");
    }
}
