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
