use super::*;

#[test]
fn test_coupled_at_rest_full_throttle_and_brakes_beyond_the_limit() {
    let law = CoupledLongitudinal::new(CoupledLongitudinalParams::DEFAULT).unwrap();
    assert_eq!(
        law.step(0.0, 0.0),
        Ok(Pedals {
            throttle: 1.0,
            brake: 0.0
        })
    );
    let fast = law.step(4.0 * 69.44, 0.0).unwrap();
    assert_eq!(
        fast,
        Pedals {
            throttle: 0.0,
            brake: 1.0
        }
    );
    assert_eq!(law.step(f64::NAN, 0.0).unwrap_err().field, "speed");
}

#[test]
fn test_speed_pid_too_slow_throttles_and_too_fast_brakes() {
    let law = SpeedPid::new(SpeedPidParams::DEFAULT).unwrap();
    let mut state = SpeedPidState::default();
    assert_eq!(law.step(&mut state, 0.0, 20.0, 0.05).unwrap().throttle, 1.0);
    assert_eq!(law.step(&mut state, 20.0, 5.0, 0.05).unwrap().brake, 1.0);
    let before = state;
    assert!(law.step(&mut state, 20.0, f64::INFINITY, 0.05).is_err());
    assert_eq!(state, before);
}
