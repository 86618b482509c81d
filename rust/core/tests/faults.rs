//! Sensors and wheels that fail in mid-drive: which of them is named, how soon, and that a healthy
//! drive names none. The vehicle is integrated by its equations in steps of a millisecond.

use popsteer_core::laws::{PreviewPop, PreviewPopParams};
use popsteer_core::vehicle::Fault;
use popsteer_core::{Path, Reported, Status, Tracker, Vehicle, VehicleState};

const DT: f64 = 0.05;
/// When something fails [s].
const START: f64 = 8.0;

/// Bends to both sides, `size` times as large as those of a car: 25 m in radius at least.
fn bends(size: f64) -> Path {
    let x: Vec<f64> = (0..900).map(|n| 0.5 * size * f64::from(n)).collect();
    let wave = |x: &f64| 4.0 * size * (x / (10.0 * size)).sin();
    let y: Vec<f64> = x.iter().map(wave).collect();
    Path::new(&x, &y, None, false).unwrap()
}

/// A vehicle of this wheelbase [m].
fn car(wheelbase: f64) -> Vehicle {
    Vehicle {
        wheelbase,
        steer_lag: 0.15,
        dead_time: 0.1,
        max_steer: 0.6,
        max_steer_rate: Some(0.5),
        max_lateral_acceleration: None,
        ..Vehicle::DEFAULT
    }
}

/// The drive of `car` at `speed` [m/s]: from [`START`] on the pose is as `sense`d after a time [s],
/// and the wheels as `turn`ed. When a fault was said first [s], and which.
fn drive(
    wheelbase: f64,
    speed: f64,
    sense: impl Fn(f64, VehicleState, VehicleState) -> VehicleState,
    turn: impl Fn(f64, f64, f64) -> f64,
) -> Option<(f64, Fault)> {
    let (car, path) = (car(wheelbase), bends(wheelbase / 2.7));
    let tracker = Tracker::of(PreviewPop::new(car, PreviewPopParams::DEFAULT).unwrap());
    let mut state = tracker.initial_state();
    let mut here = VehicleState {
        x: 0.0,
        y: 0.0,
        yaw: 0.38,
        speed,
    };
    let (mut wheel, mut frozen) = (0.0, (here, 0.0));
    let mut commands = vec![0.0; 100];
    for step in 0..300_u32 {
        let time = DT * f64::from(step);
        let measured = if time < START {
            frozen = (here, wheel);
            here
        } else {
            sense(time - START, here, frozen.0)
        };
        let command = tracker
            .step(&path.view(), &mut state, measured, DT, Reported::NOTHING)
            .unwrap();
        let fault = state.fault(&car);
        assert_eq!(
            fault.is_some(),
            command.status.contains(Status::IMPLAUSIBLE),
            "{fault:?}"
        );
        if let Some(fault) = fault {
            return Some((time - START, fault));
        }
        for _ in 0..50 {
            commands.push(command.steer);
            let arrived = commands[commands.len() - 101];
            wheel += 0.001 * ((arrived - wheel) / car.steer_lag).clamp(-0.5, 0.5);
            let angle = if time < START {
                wheel
            } else {
                turn(time - START, wheel, frozen.1)
            };
            here.x += 0.001 * speed * here.yaw.cos();
            here.y += 0.001 * speed * here.yaw.sin();
            here.yaw += 0.001 * speed * angle.tan() / wheelbase;
        }
    }
    None
}

/// The healthy signals and wheels.
fn as_it_is(_: f64, now: VehicleState, _: VehicleState) -> VehicleState {
    now
}
fn obeying(_: f64, wheel: f64, _: f64) -> f64 {
    wheel
}

#[test]
fn test_a_fault_is_named_by_the_signal_that_fails() {
    for (wheelbase, speed) in [(0.33, 2.0), (2.7, 8.0), (7.5, 10.0)] {
        let sensed = |sense: fn(f64, VehicleState, VehicleState) -> VehicleState| {
            drive(wheelbase, speed, sense, obeying)
        };
        let turned = |turn: fn(f64, f64, f64) -> f64| drive(wheelbase, speed, as_it_is, turn);
        assert_eq!(sensed(as_it_is), None, "{wheelbase}");
        let frozen = sensed(|_, now, then| VehicleState {
            speed: now.speed,
            ..then
        });
        let compass = sensed(|_, now, then| VehicleState {
            yaw: then.yaw,
            ..now
        });
        let dead = sensed(|_, now, _| VehicleState { speed: 0.0, ..now });
        let backwards = sensed(|_, now, _| VehicleState {
            speed: -now.speed,
            ..now
        });
        let stuck = turned(|_, _, then| then);
        let wrong_sign = turned(|_, wheel, _| -wheel);
        for (name, found, expected) in [
            ("frozen", frozen, Fault::Position),
            ("compass", compass, Fault::Heading),
            ("dead", dead, Fault::Speed),
            ("backwards", backwards, Fault::Speed),
            ("stuck", stuck, Fault::Steering),
            ("wrong sign", wrong_sign, Fault::Steering),
        ] {
            let (time, fault) = found.unwrap_or_else(|| panic!("{wheelbase} {name}: none"));
            assert_eq!(fault, expected, "{wheelbase} {name} after {time}");
            assert!(time <= 1.5, "{wheelbase} {name}: {time}");
        }
    }
}
