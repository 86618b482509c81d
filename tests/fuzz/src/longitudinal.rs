//! Throttle and brake: both laws over a life of good and bad inputs.

use crate::bytes::Bytes;
use crate::scene::dt;
use popsteer_core::bounds::MAX_SPEED;
use popsteer_core::speed::{
    CoupledLongitudinal, CoupledLongitudinalParams, Pedals, SpeedPid, SpeedPidParams, SpeedPidState,
};
use popsteer_core::vehicle::state::checked_dt;
use std::f64::consts::PI;

const SPEEDS: [f64; 2] = [-MAX_SPEED, MAX_SPEED];

/// Drives one law or the other.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    if bytes.byte() & 1 == 0 {
        coupled(&mut bytes);
    } else {
        speed_pid(&mut bytes);
    }
}

fn check_pedals(pedals: Pedals) {
    let range = 0.0..=1.0;
    assert!(range.contains(&pedals.throttle) && range.contains(&pedals.brake));
    assert!(pedals.throttle.min(pedals.brake) <= 0.0);
}

fn coupled(bytes: &mut Bytes) {
    let standard = CoupledLongitudinalParams::DEFAULT;
    let law = CoupledLongitudinal::new(CoupledLongitudinalParams {
        cutoff: bytes.parameter(standard.cutoff, [0.3, 0.7], [0.0, 1.0]),
        steer_limit: bytes.parameter(standard.steer_limit, [0.3, 1.3], [1e-3, 1.57]),
        speed_limit: bytes.parameter(standard.speed_limit, [5.0, 70.0], [1e-3, MAX_SPEED]),
    });
    let law = match law {
        Ok(law) => law,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    for _ in 0..8 {
        let speed = bytes.number([0.0, 40.0], SPEEDS);
        let steer = bytes.number([-1.0, 1.0], [-PI, PI]);
        let good = speed.abs() <= MAX_SPEED && steer.abs() <= PI;
        let answer = law.step(speed, steer);
        assert_eq!(answer.is_ok(), good);
        if let Ok(pedals) = answer {
            check_pedals(pedals);
        }
        if bytes.is_empty() {
            break;
        }
    }
}

fn speed_pid(bytes: &mut Bytes) {
    let standard = SpeedPidParams::DEFAULT;
    let law = SpeedPid::new(SpeedPidParams {
        kp: bytes.parameter(standard.kp, [0.0, 2.0], [0.0, 1e6]),
        ki: bytes.parameter(standard.ki, [0.0, 2.0], [0.0, 1e6]),
        kd: bytes.parameter(standard.kd, [0.0, 2.0], [0.0, 1e6]),
    });
    let law = match law {
        Ok(law) => law,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    let mut state = SpeedPidState::default();
    for _ in 0..8 {
        let before = state;
        match bytes.below(16) {
            0 => state = SpeedPidState::default(),
            1 => {
                let wanted = SpeedPidState {
                    integral: bytes.number([-1.0, 1.0], [-1.0, 1.0]),
                    previous_error: (bytes.byte() & 1 == 0)
                        .then(|| bytes.number([-30.0, 30.0], [-2.0 * MAX_SPEED, 2.0 * MAX_SPEED])),
                };
                if law.check_state(&wanted).is_ok() {
                    state = wanted;
                }
            }
            _ => {
                let speed = bytes.number([0.0, 40.0], SPEEDS);
                let target = bytes.number([0.0, 40.0], SPEEDS);
                let dt = dt(bytes);
                match law.step(&mut state, speed, target, dt) {
                    Ok(pedals) => {
                        check_pedals(pedals);
                        // In no time nothing is remembered.
                        assert!(checked_dt(dt).is_ok() || state == before);
                    }
                    Err(error) => {
                        assert!(!error.to_string().is_empty());
                        assert_eq!(state, before);
                    }
                }
            }
        }
        assert_eq!(law.check_state(&state), Ok(()));
        if bytes.is_empty() {
            break;
        }
    }
}
