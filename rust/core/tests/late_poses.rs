//! Poses that come late, of a vehicle that is integrated in small steps by its equations: the
//! tracker knows where the vehicle is, and where it will be; and what the wheels did, by hand.

use popsteer_core::laws::{PreviewPop, PreviewPopParams, Stanley, StanleyParams};
use popsteer_core::tracker::{Predicted, Reported};
use popsteer_core::vehicle::bicycle::{Rollout, advance};
use popsteer_core::vehicle::{Estimate, Past};
use popsteer_core::{Path, Status, Tracker, Vehicle, VehicleState};

/// Control period [s].
const DT: f64 = 0.05;
/// Steps of the equations in a control period.
const PARTS: usize = 100;

/// A vehicle and all that it did, a step of the equations an entry.
struct Truth {
    car: Vehicle,
    /// Direction of the motion of the no-slip point less the heading [rad].
    slip: f64,
    acceleration: f64,
    commands: Vec<f64>,
    wheel: f64,
    poses: Vec<VehicleState>,
}

impl Truth {
    /// One that has driven for a second under the command 0, and now is at `now`.
    fn new(car: &Vehicle, now: VehicleState) -> Self {
        let mut truth = Self {
            car: *car,
            slip: 0.0,
            acceleration: 0.0,
            commands: Vec::new(),
            wheel: car.steer_offset,
            poses: vec![now],
        };
        for _ in 0..20 {
            truth.drive(0.0);
        }
        truth
    }

    /// `wheel' = (command(t - dead_time) + steer_offset - wheel) / steer_lag` within the rate,
    /// `yaw' = v tan(wheel) / turning_wheelbase`, for a control period.
    fn drive(&mut self, command: f64) {
        let h = DT / 100.0;
        let car = self.car;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a dead time of whole steps"
        )]
        let late = (car.dead_time / h).round() as usize;
        for _ in 0..PARTS {
            self.commands.push(command);
            let arrived = self.commands.len().checked_sub(late + 1);
            let arrived = arrived.map_or(0.0, |k| self.commands[k]);
            let mut rate = (arrived + car.steer_offset - self.wheel) / car.steer_lag;
            if let Some(most) = car.max_steer_rate {
                rate = rate.clamp(-most, most);
            }
            let before = self.wheel;
            self.wheel += h * rate;
            let pose = self.now();
            let ahead = car.no_slip_point.unwrap_or(car.rear_axle);
            let turning = car.turning_wheelbase.unwrap_or(car.wheelbase);
            let turn = h * pose.speed * (0.5 * (before + self.wheel)).tan() / turning;
            let (sin, cos) = pose.yaw.sin_cos();
            let (x, y) = (pose.x + ahead * cos, pose.y + ahead * sin);
            let direction = pose.yaw + 0.5 * turn + self.slip;
            let yaw = pose.yaw + turn;
            self.poses.push(VehicleState {
                x: x + h * pose.speed * direction.cos() - ahead * yaw.cos(),
                y: y + h * pose.speed * direction.sin() - ahead * yaw.sin(),
                yaw,
                speed: pose.speed + h * self.acceleration,
            });
        }
    }

    fn now(&self) -> VehicleState {
        self.poses[self.poses.len() - 1]
    }

    /// The pose so many control periods ago, or parts of them.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "an age of whole steps"
    )]
    fn ago(&self, age: f64) -> VehicleState {
        let parts = (age / DT * 100.0).round() as usize;
        self.poses[self.poses.len() - 1 - parts]
    }
}

/// The direction of the straight path through the origin [rad].
const YAW: f64 = 0.5;

fn straight() -> Path {
    let along = (-20..400).map(|k| 2.0 * f64::from(k));
    let (x, y): (Vec<f64>, Vec<f64>) = along.map(|s| (s * YAW.cos(), s * YAW.sin())).unzip();
    Path::new(&x, &y, None, false).unwrap()
}

/// Cross-track error and heading error of the front axle.
fn errors(pose: &VehicleState) -> (f64, f64) {
    let ahead = 3.0 - 1.2;
    let (x, y) = (
        pose.x + ahead * pose.yaw.cos(),
        pose.y + ahead * pose.yaw.sin(),
    );
    (y * YAW.cos() - x * YAW.sin(), pose.yaw - YAW)
}

/// A vehicle whose point is none of its axles, and slips ahead of its rear axle.
const CAR: Vehicle = Vehicle {
    rear_axle: -1.2,
    no_slip_point: Some(-0.8),
    steer_lag: 0.2,
    steer_offset: 0.02,
    max_steer: 0.6,
    ..Vehicle::PAPER
};

const LATE: Vehicle = Vehicle {
    dead_time: 0.15,
    max_steer_rate: Some(0.5),
    ..CAR
};

/// How old the pose of each step is [s]; twice it is one that was given before. Nothing is
/// remembered of the wheels before the first pose with an age, so that is the first.
const AGES: [f64; 10] = [0.04, 0.0, 0.08, 0.03, 0.0, 0.12, 0.17, 0.06, 0.11, 0.02];

#[test]
fn test_late_pose_is_rolled_to_the_present_and_on_to_where_the_vehicle_will_be() {
    for car in [CAR, LATE] {
        let law = Stanley::new(car, StanleyParams::DEFAULT).unwrap();
        let tracker = Tracker::new(law, None).unwrap();
        let path = straight();
        let mut state = tracker.initial_state();
        let start = VehicleState {
            x: -1.5 * YAW.sin(),
            y: 1.5 * YAW.cos(),
            yaw: YAW - 0.1,
            speed: 8.0,
        };
        let mut truth = Truth::new(&car, start);
        let mut expected = Vec::new();
        let mut intended = [Predicted::DEFAULT; 10];
        let mut applied = None;
        for (k, &age) in AGES.iter().cycle().take(60).enumerate() {
            let reported = Reported {
                applied_steer: applied,
                pose_age: age,
                ..Reported::NOTHING
            };
            let pose = truth.ago(age);
            let command = tracker
                .step(&path.view(), &mut state, pose, DT, reported)
                .unwrap();
            let (here, now) = (state.answer.unwrap().vehicle, truth.now());
            let off = (here.x - now.x).hypot(here.y - now.y);
            assert!(off < 2e-3, "{k}: {here:?}, not {now:?}");
            assert!((here.yaw - now.yaw).abs() < 1e-3, "{k}: {here:?} {now:?}");
            let (error, heading) = errors(&now);
            let off = (command.cross_track_error - error).abs();
            assert!(off < 2e-3, "{k}: {command:?}, not {error}");
            let off = (command.heading_error - heading).abs();
            assert!(off < 1e-3, "{k}: {command:?}, not {heading}");
            expected.push((truth.poses.len() - 1, command));
            if k == 10 {
                // No driver comes in between: the trajectory that is intended is the one driven.
                let count = tracker.predict(&path.view(), &state, DT, &mut intended);
                assert_eq!(count, Ok(10));
            }
            // Now and then a driver steers.
            applied = (20..26).contains(&k).then_some(0.15);
            truth.drive(applied.unwrap_or(command.steer));
        }
        // When the command arrived.
        let late = if car.dead_time > 0.0 { 300 } else { 0 };
        for (k, command) in &expected {
            let Some(then) = truth.poses.get(k + late) else {
                continue;
            };
            let (error, heading) = errors(then);
            let off = (command.predicted_cross_track_error - error).abs();
            assert!(off < 3e-3, "{k}: {command:?}, not {error}");
            let off = (command.predicted_heading_error - heading).abs();
            assert!(off < 2e-3, "{k}: {command:?}, not {heading}");
        }
        for (instant, (k, command)) in intended.iter().zip(&expected[10..]) {
            let (there, then) = (instant.vehicle, &truth.poses[*k]);
            let off = (there.x - then.x).hypot(there.y - then.y);
            assert!(off < 5e-3, "{instant:?}, not {then:?}");
            assert!((there.yaw - then.yaw).abs() < 3e-3, "{instant:?} {then:?}");
            assert!((instant.steer - command.steer).abs() < 3e-3, "{instant:?}");
        }
    }
}

/// A small vehicle turns by a right angle in one period, in which its wheels go from side to side.
#[test]
fn test_poses_of_a_quick_vehicle_are_believed_in_long_periods() {
    let car = Vehicle {
        wheelbase: 0.1,
        steer_lag: 0.02,
        dead_time: 0.05,
        max_steer: 0.6,
        ..Vehicle::PAPER
    };
    let law = Stanley::new(car, StanleyParams::DEFAULT).unwrap();
    let tracker = Tracker::of(law);
    for periods in [1_usize, 2, 4, 6, 10] {
        for age in [0.0, 0.1] {
            let mut state = tracker.initial_state();
            let start = VehicleState {
                speed: 1.0,
                ..VehicleState::ORIGIN
            };
            let mut truth = Truth::new(&car, start);
            let mut applied = 0.0;
            for k in 0..200 / periods {
                let reported = Reported {
                    applied_steer: Some(applied),
                    pose_age: age,
                    ..Reported::NOTHING
                };
                let (pose, view) = (truth.ago(age), straight());
                let dt = DT * f64::from(u32::try_from(periods).unwrap());
                let command = tracker.step(&view.view(), &mut state, pose, dt, reported);
                let status = command.unwrap().status;
                assert!(
                    !status.contains(Status::OUTLIER),
                    "{periods} {age}: {k}: {status}"
                );
                applied = if k * periods / 40 % 2 > 0 {
                    0.38
                } else {
                    -0.38
                };
                (0..periods).for_each(|_| truth.drive(applied));
            }
        }
    }
}

/// A vehicle that turns less than it is believed to, later, and with its wheels askew, and slips.
#[test]
fn test_late_poses_show_the_vehicle_as_fresh_ones_do() {
    let x: Vec<f64> = (0..1600).map(|n| 0.5 * f64::from(n)).collect();
    let y: Vec<f64> = x.iter().map(|x| 5.0 * (x / 12.0).sin()).collect();
    let path = Path::new(&x, &y, None, false).unwrap();
    let given = Vehicle {
        steer_offset: 0.0,
        max_steer_rate: None,
        ..LATE
    };
    let real = Vehicle {
        turning_wheelbase: Some(3.5),
        steer_offset: 0.015,
        dead_time: 0.2,
        ..given
    };
    // The dead time is taken from how turns change from period to period, and is known less well
    // where these differ.
    for (ages, nearly) in [(&[0.0][..], 0.01), (&[0.08], 0.01), (&AGES, 0.04)] {
        let law = PreviewPop::new(given, PreviewPopParams::DEFAULT).unwrap();
        let tracker = Tracker::of(law);
        let mut state = tracker.initial_state();
        let start = VehicleState {
            x: 5.0,
            y: 2.2,
            yaw: 0.37,
            speed: 8.0,
        };
        let mut truth = Truth::new(&real, start);
        truth.slip = 0.02;
        truth.acceleration = 0.03;
        for &age in ages.iter().cycle().take(1200) {
            let reported = Reported {
                pose_age: age,
                ..Reported::NOTHING
            };
            let pose = truth.ago(age);
            let steer = tracker
                .steer(&path.view(), &mut state, pose, DT, reported)
                .unwrap();
            tracker.check_state(&path.view(), &state).unwrap();
            truth.drive(steer);
        }
        let known = tracker.estimate(&state);
        assert!((known.gain - 3.0 / 3.5).abs() < 0.02, "{known:?}");
        assert!((known.steer_offset - 0.015).abs() < 1e-3, "{known:?}");
        assert!((known.longer_dead_time - 0.05).abs() < nearly, "{known:?}");
        assert!((known.slip - 0.02).abs() < 2e-3, "{known:?}");
        assert!((known.acceleration - 0.03).abs() < 0.01, "{known:?}");
    }
}

/// Wheels that do at once what they are commanded.
const AT_ONCE: Vehicle = Vehicle {
    steer_lag: 0.0,
    ..Vehicle::PAPER
};

/// Straight on at 0.1 rad for long, at 0.3 rad for 0.2 s, and at -0.2 rad for the last 0.3 s.
fn past() -> Past {
    let mut past = Past::settled(0.1);
    past.elapse(&AT_ONCE, [(0.3, 9.0)].into_iter(), 0.1, 0.2);
    past.elapse(&AT_ONCE, [(-0.2, 9.0)].into_iter(), 0.3, 0.3);
    past
}

#[test]
fn test_angles_of_the_wheels_are_remembered_for_their_time() {
    let mut past = past();
    assert!((past.wheel() + 0.2).abs() < 1e-12 && (past.since() - 0.5).abs() < 1e-12);
    let angles: Vec<(f64, f64)> = past.angles().collect();
    assert_eq!(angles[angles.len() - 2..], [(0.3, 0.2), (-0.2, 0.3)]);
    assert!((angles[0].0 - 0.1).abs() < 1e-12);
    // From a pose 0.45 s old to one 0.1 s old.
    past.see(0.45);
    let reached = past.wheel_integrals(0.1);
    let turn = 0.15 * f64::tan(0.3) + 0.2 * f64::tan(-0.2);
    assert!((reached.turn - turn).abs() < 1e-12, "{reached:?}");
    past.see(0.05);
    assert!((past.since() - 0.05).abs() < 1e-12);
}

#[test]
fn test_old_pose_is_rolled_through_the_angles_since() {
    let start = VehicleState {
        x: 3.0,
        y: -2.0,
        yaw: 0.7,
        speed: 8.0,
    };
    for (age, turns) in [
        (0.2, &[(-0.2, 0.2)][..]),
        (0.4, &[(0.3, 0.1), (-0.2, 0.3)]),
        (0.7, &[(0.1, 0.2), (0.3, 0.2), (-0.2, 0.3)]),
    ] {
        let found = past().advance(&AT_ONCE, start, age, &Estimate::DEFAULT);
        let mut rollout = Rollout::new(&AT_ONCE, &Estimate::DEFAULT, start);
        for &(angle, time) in turns {
            rollout.turn(angle, time);
        }
        let expected = rollout.state();
        let off = (found.x - expected.x).abs() + (found.y - expected.y).abs();
        assert!(
            off < 1e-9 && (found.yaw - expected.yaw).abs() < 1e-12,
            "{age}"
        );
    }
}

/// A vehicle slips, and moves off its heading by that, and by what its curvature adds.
#[test]
fn test_slip_turns_the_way_and_not_the_vehicle() {
    let start = VehicleState {
        x: 3.0,
        y: -2.0,
        yaw: 0.7,
        speed: 8.0,
    };
    let estimate = Estimate {
        slip: 0.05,
        slip_length: 0.3,
        ..Estimate::DEFAULT
    };
    let mut rollout = Rollout::new(&AT_ONCE, &estimate, start);
    rollout.turn(0.2, 0.05);
    let curvature = 0.2_f64.tan() / 3.0;
    let expected = advance(start, 0.4, curvature, 0.05 + 0.3 * curvature);
    let found = rollout.state();
    assert!((found.x - expected.x).abs() < 1e-12 && (found.y - expected.y).abs() < 1e-12);
    assert!((found.yaw - 0.7 - 0.4 * curvature).abs() < 1e-12);
}

#[test]
fn test_pasts_are_equal_where_all_their_angles_are() {
    let driven = |angle: f64| {
        let mut past = Past::settled(0.1);
        past.elapse(&AT_ONCE, [(angle, 9.0)].into_iter(), 0.1, 0.2);
        past.elapse(&AT_ONCE, [(0.2, 9.0)].into_iter(), 0.1, 0.2);
        past
    };
    assert!(driven(0.3) == driven(0.3) && driven(0.3) != driven(0.31));
}

/// A localisation that jumps for good while its poses are old: from the jump on they are believed as
/// before it, whatever their age.
#[test]
fn test_old_poses_after_a_jump_of_the_localisation_are_believed_as_before_it() {
    let path = straight();
    for age in [0.0, 0.1, 0.25] {
        let tracker = Tracker::of(Stanley::new(CAR, StanleyParams::DEFAULT).unwrap());
        let mut state = tracker.initial_state();
        let mut after = Vec::new();
        for k in 0..160_u32 {
            let jump = if k >= 60 { 5.0 } else { 0.0 };
            let along = 5.0 * (DT * f64::from(k) - age) + jump;
            let pose = VehicleState {
                x: along * YAW.cos(),
                y: along * YAW.sin(),
                yaw: YAW,
                speed: 5.0,
            };
            let reported = Reported {
                pose_age: age,
                ..Reported::NOTHING
            };
            let command = tracker
                .step(&path.view(), &mut state, pose, DT, reported)
                .unwrap();
            if k >= 60 {
                after.push(command.status.contains(Status::OUTLIER));
            }
        }
        let doubted = after.iter().take_while(|&&outlier| outlier).count();
        assert!((1..40).contains(&doubted), "{age}: {doubted}");
        assert!(!after[doubted..].contains(&true), "{age}: {after:?}");
    }
}

/// A position that repeats while the car turns: its heading is believed while it lives, and by the wheels
/// from when it repeats, too, however long after.
#[test]
fn test_heading_of_a_frozen_position_is_rolled_on_once_it_freezes_too() {
    let angle = |k: u32| f64::from(k) * 0.01;
    let (x, y): (Vec<f64>, Vec<f64>) = (0..600)
        .map(|k| (50.0 * angle(k).sin(), 50.0 * (1.0 - angle(k).cos())))
        .unzip();
    let path = Path::new(&x, &y, None, false).unwrap();
    for lives in [0, 3, 6] {
        let tracker =
            Tracker::of(PreviewPop::new(Vehicle::PAPER, PreviewPopParams::DEFAULT).unwrap());
        let mut state = tracker.initial_state();
        let place = |k: u32, at: u32| {
            let yaw = 0.1 * DT * f64::from(k);
            let frozen = 0.1 * DT * f64::from(at);
            VehicleState {
                x: 50.0 * frozen.sin(),
                y: 50.0 * (1.0 - frozen.cos()),
                yaw,
                speed: 5.0,
            }
        };
        let mut headings = Vec::new();
        for k in 0..52_u32 {
            let pose = place(k.min(40 + lives), k.min(40));
            tracker
                .step(&path.view(), &mut state, pose, DT, Reported::NOTHING)
                .unwrap();
            headings.push(state.gate.as_ref().unwrap().believed.yaw);
        }
        // At 0.1 rad/s: within a quarter of it from the freeze of the heading on.
        let turned = headings[51] - headings[41 + lives as usize];
        let wanted = 0.1 * DT * f64::from(10 - lives);
        assert!(
            (turned - wanted).abs() < 0.25 * wanted,
            "{lives}: {turned} {wanted}"
        );
    }
}
