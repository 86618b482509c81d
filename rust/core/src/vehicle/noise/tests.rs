use super::*;
use alloc::vec::Vec;

#[test]
fn test_noise_is_a_sixth_of_the_mean_square_of_differences_of_changes() {
    let mut noise = Noise::new(0.3);
    assert_eq!(noise.deviation(), 0.3);
    for k in 0..4000 {
        noise.observe(if k % 2 == 0 { 0.5 } else { -0.5 }, 0.05);
    }
    assert!((noise.variance - 1.0 / 6.0).abs() < 1e-9, "{noise:?}");
    assert_eq!(noise.count, 40.0);
}

#[test]
fn test_what_changes_evenly_is_no_noise() {
    let mut noise = Noise::new(0.0);
    for _ in 0..100 {
        noise.observe(0.7, 0.05);
    }
    assert_eq!(noise.variance, 0.0);
    // A jump counts twice, as the change into it and out of it.
    noise.observe(0.1, 0.05);
    let once = noise.variance;
    noise.observe(0.7, 0.05);
    assert!(once > 0.0 && noise.variance > 1.5 * once, "{noise:?}");
}

#[test]
fn test_first_guess_counts_until_as_much_is_seen() {
    let mut noise = Noise::new(1.0);
    noise.observe(0.0, 0.05);
    assert_eq!(noise.variance, 1.0);
    noise.observe(0.0, 0.05);
    assert!((noise.variance - 2.0 / 3.0).abs() < 1e-12, "{noise:?}");
}

#[test]
fn test_in_long_periods_it_is_a_mean_of_as_many_changes() {
    let mut noise = Noise::new(0.0);
    for k in 0..400 {
        noise.observe(if k % 2 == 0 { 0.5 } else { -0.5 }, 0.5);
    }
    assert_eq!(noise.count, 40.0);
}

#[test]
fn test_noise_of_few_changes_may_be_far_more() {
    let mut noise = Noise::new(0.1);
    let mut shares = Vec::new();
    for count in 1..=200 {
        assert_eq!(noise.count, f64::from(count.min(200)));
        shares.push(noise.at_most() / noise.deviation());
        noise.observe(if count % 2 == 0 { 0.1 } else { -0.1 }, 0.01);
    }
    assert!(shares.is_sorted_by(|a, b| a > b), "{shares:?}");
    let ends = shares.first().zip(shares.last()).unwrap();
    assert!((ends.0 - 170.0).abs() < 1e-12 && (ends.1 - 1.004_225).abs() < 1e-12);
}

#[test]
fn test_noise_that_no_changes_show_is_refused() {
    let noise = Noise::new(0.1);
    for wrong in [
        Noise {
            variance: -1.0,
            ..noise
        },
        Noise {
            last: Some(1e50),
            ..noise
        },
        Noise {
            count: f64::INFINITY,
            ..noise
        },
    ] {
        assert_eq!(wrong.checked("monitor").unwrap_err().field, "monitor");
    }
    assert!(noise.checked("monitor").is_ok());
}
