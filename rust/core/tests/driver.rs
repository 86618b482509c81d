//! The whole vehicle in one step, around a plant of the test's own.

#[path = "driver/rig.rs"]
mod rig;

use popsteer_core::driver::Sensed;
use popsteer_core::laws::{Law, PreviewPop, PreviewPopParams, Stanley, StanleyParams};
use popsteer_core::vehicle::Fault;
use popsteer_core::{Path, Reported, Status, VehicleState};
use rig::{CAR, DT, NAN, Rig, bends};

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

#[test]
fn test_angle_that_comes_with_a_pose_of_no_age_is_one_that_the_wheels_have() {
    for pose_age in [-1.0, 9.0, f64::NAN] {
        let mut rig = Rig::preview(bends());
        let pose = rig.plant.pose();
        rig.step(Sensed::from(pose), DT);
        let odd = Sensed {
            reported: Reported {
                applied_steer: Some(1.5),
                pose_age,
                ..Reported::NOTHING
            },
            ..Sensed::from(pose)
        };
        rig.step(odd, DT);
        let steer = rig.state.tracker.tracking.steer;
        assert!(steer.abs() <= rig.driver.vehicle().max_steer, "{steer}");
        let check = rig.driver.check_state(&rig.path.view(), &rig.state);
        assert_eq!(check, Ok(()));
    }
}
