use super::*;
use crate::vehicle::bicycle::advance;
use alloc::vec::Vec;

fn car(dead_time: f64, steer_lag: f64, max_steer_rate: Option<f64>) -> Vehicle {
    Vehicle {
        steer_lag,
        dead_time,
        max_steer_rate,
        ..Vehicle::DEFAULT
    }
}

#[test]
fn test_elapse_brings_a_command_after_the_dead_time() {
    let car = car(0.2, 0.0, None);
    let mut in_flight = InFlight::settled(&car, 0.0);
    let wheels: Vec<f64> = (1..8)
        .map(|k| {
            in_flight.elapse(&car, 0.1 * f64::from(k), 0.05, 0.0);
            in_flight.wheel()
        })
        .collect();
    let expected = [0.0, 0.0, 0.0, 0.0, 0.1, 0.2, 0.3];
    for (wheel, expected) in wheels.iter().zip(expected) {
        assert!((wheel - expected).abs() < 1e-12, "{wheels:?}");
    }
}

#[test]
fn test_elapse_durations_always_add_up_to_the_dead_time() {
    let car = car(0.3, 0.1, None);
    let mut in_flight = InFlight::settled(&car, 0.2);
    let mut dt = 1e-6;
    for k in 0..100_000_u32 {
        dt = if k % 1000 == 0 {
            0.7
        } else {
            1e-6 + (dt * 7.3) % 0.004
        };
        in_flight.elapse(&car, 0.001 * f64::from(k % 300), dt, 0.0);
        let total: f64 = in_flight.commands().map(|(_, duration)| duration).sum();
        assert!((total - 0.3).abs() < 1e-9, "{k} {total}");
    }
    let commands = in_flight.commands().collect::<Vec<_>>().into_iter();
    let restored = InFlight::restore(commands, in_flight.wheel(), 0.3).unwrap();
    assert!(restored.commands().eq(in_flight.commands()));
}

#[test]
fn test_elapse_of_a_full_ring_keeps_the_dead_time() {
    let car = car(0.3, 0.1, None);
    // Of a state that was put together: steps leave no ring full.
    let short = 1e-4;
    let rest = 0.3 - short * from_count(InFlight::CAPACITY - 1);
    let commands: Vec<_> = (0..InFlight::CAPACITY)
        .map(|k| (0.1, if k == 0 { rest } else { short }))
        .collect();
    let mut in_flight = InFlight::restore(commands.into_iter(), 0.0, 0.3).unwrap();
    in_flight.elapse(&car, 0.2, 0.02, 0.0);
    assert_eq!(in_flight.check(0.3), Ok(()));
}

#[test]
fn test_settled_wheels_stand_at_the_command_and_its_offset() {
    let car = Vehicle {
        steer_offset: 0.02,
        ..car(0.2, 0.1, None)
    };
    let mut in_flight = InFlight::settled(&car, 0.3);
    assert_eq!(in_flight.wheel(), 0.32);
    in_flight.elapse(&car, 0.3, 0.05, 0.0);
    assert_eq!(in_flight.wheel(), 0.32);
}

#[test]
fn test_predict_braking_stops_and_does_not_turn_round() {
    let car = car(0.6, 0.1, None);
    let in_flight = InFlight::settled(&car, 0.0);
    for speed in [1.0, -1.0] {
        let state = VehicleState {
            x: 0.0,
            y: 0.0,
            yaw: 0.0,
            speed,
        };
        let estimate = Estimate {
            acceleration: -5.0 * speed,
            ..Estimate::DEFAULT
        };
        let (seen, _) = in_flight.predict(&car, state, in_flight.wheel, &estimate);
        assert_eq!(seen.speed, 0.0);
        assert!((seen.x - 0.1 * speed).abs() < 1e-12, "{seen:?}");
    }
}

#[test]
fn test_predict_is_where_the_vehicle_comes_to_be() {
    let car = car(0.25, 0.1, None);
    // One line of commands as the controller keeps it, and one as the vehicle has it.
    let (mut kept, mut real) = (InFlight::settled(&car, 0.0), InFlight::settled(&car, 0.0));
    let mut vehicle = VehicleState {
        x: 1.0,
        y: 2.0,
        yaw: 0.3,
        speed: 8.0,
    };
    let (mut last, mut predicted, mut driven) = (0.0, Vec::new(), Vec::new());
    for command in [0.1, -0.2, 0.3, 0.05, 0.1, 0.0, 0.1, 0.0, 0.2, 0.0] {
        if !driven.is_empty() {
            kept.elapse(&car, last, 0.05, 0.0);
            predicted.push(
                kept.predict(&car, vehicle, kept.wheel, &Estimate::DEFAULT)
                    .0,
            );
        }
        driven.push(vehicle);
        last = command;
        for _ in 0..50 {
            real.elapse(&car, last, 0.001, 0.0);
            vehicle = advance(vehicle, 0.008, tan(real.wheel()) / 3.0, 0.0);
        }
    }
    for (there, predicted) in driven.iter().skip(6).zip(&predicted) {
        for (a, b) in [
            (predicted.x, there.x),
            (predicted.y, there.y),
            (predicted.yaw, there.yaw),
        ] {
            assert!((a - b).abs() < 2e-3, "{predicted:?} {there:?}");
        }
    }
}
