use super::*;
use crate::vehicle::noise::Noise;

const DT: f64 = 0.05;

/// The sums of `changes` that are all alike, of which those within `explained` are explained.
fn sums(change: f64, explained: (f64, f64), steps: u32) -> Cusum {
    let mut sum = Cusum::default();
    for _ in 0..steps {
        sum.add(change, explained, (0.0, DT), 1e3);
    }
    sum
}

#[test]
fn test_what_is_beyond_adds_up_to_its_side_and_what_is_within_takes_off() {
    for (change, over, under) in [(0.5, 0.2, 0.0), (-0.6, 0.0, 0.4), (0.1, 0.0, 0.0)] {
        let sum = sums(change, (-0.2, 0.3), 10);
        assert!((sum.over - 10.0 * over).abs() < 1e-12, "{sum:?}");
        assert!((sum.under - 10.0 * under).abs() < 1e-12, "{sum:?}");
    }
    let mut sum = sums(0.5, (-0.2, 0.3), 10);
    for _ in 0..4 {
        sum.add(0.0, (-0.2, 0.3), (0.0, DT), 1e3);
    }
    assert!((sum.over - 0.8).abs() < 1e-12, "{sum:?}");
    for _ in 0..4 {
        sum.add(0.0, (-0.2, 0.3), (0.0, DT), 1e3);
    }
    assert_eq!(sum, Cusum::default());
}

#[test]
fn test_a_sum_beyond_tolerance_and_noise_is_said_and_ends_at_twice_that() {
    let (noise, tolerance) = (0.01, 0.1);
    let limit = 0.1 + 8.0 * 0.01;
    assert!((Cusum::limit(tolerance, noise) - limit).abs() < 1e-15);
    let mut sum = Cusum::default();
    for k in 1..100 {
        let beyond = sum.add(0.05, (0.0, 0.0), (noise, DT), tolerance);
        let expected = (f64::from(k) * (0.05 - noise * DT)).min(2.0 * limit);
        assert!((sum.over - expected).abs() < 1e-12, "{k}: {sum:?}");
        assert_eq!(beyond, expected > limit, "{k}: {sum:?}");
        assert_eq!(sum.most(), sum.over);
    }
}

/// Numbers of a normal distribution: each of twelve of a generator of its own (Marsaglia's xorshift).
fn normal() -> impl FnMut() -> f64 {
    let mut seed = 0x2545_f491_4f6c_dd1d_u64;
    move || {
        let mut total = -6.0;
        for _ in 0..12 {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            total += f64::from(u32::try_from(seed >> 32).unwrap()) / f64::from(u32::MAX);
        }
        total
    }
}

/// White noise of a level, as large as can be, in periods of `dt`: how many of `steps` steps alarm.
fn alarms(steps: u32, dt: f64, deviations: f64) -> u32 {
    let mut normal = normal();
    let (mut sum, mut last, mut found) = (Cusum::default(), normal(), 0);
    // The limit is of the noise alone: its deviations are taken from, or added to, the tolerance.
    let tolerance = deviations - Cusum::DEVIATIONS;
    for _ in 0..steps {
        let level = normal();
        if sum.add(level - last, (0.0, 0.0), (1.0, dt), tolerance) {
            found += 1;
            sum = Cusum::default();
        }
        last = level;
    }
    found
}

/// The same of noise that nobody knows, in drives of 200 steps: `known` is what is taken for it.
fn alarms_of_starts(drives: u32, dt: f64, known: fn(&Noise) -> f64) -> u32 {
    let (mut normal, mut found) = (normal(), 0);
    for _ in 0..drives {
        // A fifth of what it is.
        let (mut sum, mut noise, mut last) = (Cusum::default(), Noise::new(0.2), normal());
        for _ in 0..200 {
            let level = normal();
            noise.observe(level - last, dt);
            if sum.add(level - last, (0.0, 0.0), (known(&noise), dt), 0.0) {
                found += 1;
                sum = Cusum::default();
            }
            last = level;
        }
    }
    found
}

#[test]
fn test_white_noise_alarms_as_seldom_as_is_said() {
    for dt in [0.1, 0.05, 0.01] {
        assert!(alarms(400_000, dt, 8.0) <= 1, "{dt}");
        assert!(alarms(400_000, dt, 7.0) <= 20, "{dt}");
    }
    // And not because nothing ever does.
    assert!(alarms(400_000, 0.01, 5.0) > 400);
}

#[test]
fn test_noise_of_which_little_is_known_alarms_as_seldom() {
    for dt in [0.1, 0.05, 0.01] {
        assert!(alarms_of_starts(2000, dt, Noise::at_most) <= 1, "{dt}");
        // As if it were known to be what was seen of it.
        assert!(alarms_of_starts(2000, dt, Noise::deviation) > 400, "{dt}");
    }
}

#[test]
fn test_sums_that_no_changes_make_are_refused() {
    for (over, under) in [(-1.0, 0.0), (0.0, f64::NAN), (1e101, 0.0)] {
        let error = Cusum { over, under }.checked("gate").unwrap_err();
        assert_eq!(error.field, "gate");
    }
    assert!(sums(0.5, (0.0, 0.1), 5).checked("gate").is_ok());
}
