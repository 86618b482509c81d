use super::*;

#[test]
fn test_noise_every_quantity_has_its_own_deviation() {
    let noise = Noise {
        position: 0.3,
        yaw: 0.01,
        speed: 2.0,
    };
    let mut perception = Perception::new(noise, 1, 2);
    let here = VehicleState::ORIGIN;
    let count = 20_000;
    let mut sums = [0.0; 4];
    for _ in 0..count {
        let seen = perception.of(here);
        for (sum, value) in sums.iter_mut().zip([seen.x, seen.y, seen.yaw, seen.speed]) {
            *sum += value * value;
        }
    }
    for (sum, expected) in sums.iter().zip([0.3, 0.3, 0.01, 2.0]) {
        let deviation = (sum / f64::from(count)).sqrt();
        assert!((deviation / expected - 1.0).abs() < 0.03, "{sums:?}");
    }
}

#[test]
fn test_noise_is_what_the_generator_draws_added_in_the_order_of_the_fields() {
    let noise = Noise {
        position: 0.3,
        yaw: 0.01,
        speed: 2.0,
    };
    let here = VehicleState {
        x: 10.0,
        y: 20.0,
        yaw: 0.1,
        speed: 5.0,
    };
    let mut random = Pcg64::new(1, 2);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let seen = Perception::new(noise, 1, 2).of(here);
    let expected = [
        10.0 + 0.3 * draw(),
        20.0 + 0.3 * draw(),
        wrap(0.1 + 0.01 * draw()),
        5.0 + 2.0 * draw(),
    ];
    let got = [seen.x, seen.y, seen.yaw, seen.speed];
    assert_eq!(got.map(f64::to_bits), expected.map(f64::to_bits));
}
