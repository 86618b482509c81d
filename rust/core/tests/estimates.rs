//! The filter of the estimates beside its definition: least squares over all measurements at once,
//! written out in dense matrices; and what the estimator makes of single motions.

mod dense;

use dense::solve;
use nalgebra::SVector;
use popsteer_core::vehicle::kalman::{Change, Walk};
use popsteer_core::vehicle::{AdaptParams, Estimate, Estimator};
use popsteer_core::{Vehicle, VehicleState};

const CAR: Vehicle = Vehicle {
    understeer: 0.004,
    dead_time: 0.3,
    ..Vehicle::PAPER
};

#[track_caller]
fn assert_close(found: f64, wanted: f64) {
    let off = (found - wanted).abs();
    assert!(off <= 1e-8 * wanted.abs().max(1.0), "{found}, not {wanted}");
}

/// Deviations of the priors, and variance of the noise.
const PRIOR: [f64; 2] = [0.3, 0.1];
const NOISE: f64 = 2e-4;

/// The inverse of a symmetric matrix.
fn inverse(rows: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let size = rows.len();
    let column = |k: usize| {
        let with = |(i, row): (usize, &Vec<f64>)| {
            let mut row = row.clone();
            row.push(if i == k { 1.0 } else { 0.0 });
            row
        };
        solve(rows.iter().enumerate().map(with).collect())
    };
    (0..size).map(column).collect()
}

/// Slopes, what is left open, and the measured level, of each period.
fn changes() -> Vec<([f64; 2], f64, f64)> {
    let wave = |k: u32, rate: f64| (rate * f64::from(k)).sin();
    let mut level = 0.0;
    (1..=30_u32)
        .map(|k| {
            let slopes = [0.1 * wave(k, 0.4) + 0.02, 0.05 * wave(k, 1.1)];
            level += 1.2 * slopes[0] - 0.08 * slopes[1];
            let open = 1e-5 * (1.0 + wave(k, 0.7));
            (slopes, open, level + 0.014 * wave(k * k, 0.9))
        })
        .collect()
}

/// Parameters and their covariance by least squares over all levels at once: unknown are both
/// parameters and each level, beginning with the first; each row is divided by its deviation.
fn all_at_once(changes: &[([f64; 2], f64, f64)]) -> (Vec<f64>, Vec<Vec<f64>>) {
    let size = 2 + changes.len() + 1;
    let mut rows: Vec<(Vec<f64>, f64)> = Vec::new();
    let mut add = |entries: &[(usize, f64)], right: f64, variance: f64| {
        let mut row = vec![0.0; size];
        for (place, value) in entries {
            row[*place] = value / variance.sqrt();
        }
        rows.push((row, right / variance.sqrt()));
    };
    add(&[(0, 1.0)], 1.0, PRIOR[0] * PRIOR[0]);
    add(&[(1, 1.0)], 0.0, PRIOR[1] * PRIOR[1]);
    add(&[(2, 1.0)], 0.0, NOISE);
    for (k, (slopes, open, measured)) in changes.iter().enumerate() {
        let step = [
            (0, -slopes[0]),
            (1, -slopes[1]),
            (2 + k, -1.0),
            (3 + k, 1.0),
        ];
        add(&step, 0.0, *open);
        add(&[(3 + k, 1.0)], *measured, NOISE);
    }
    let product = |i: usize, j: usize| rows.iter().map(|(row, _)| row[i] * row[j]).sum::<f64>();
    let normal: Vec<Vec<f64>> = (0..size)
        .map(|i| (0..size).map(|j| product(i, j)).collect())
        .collect();
    let equations = normal.iter().enumerate().map(|(i, row)| {
        let right = rows.iter().map(|(each, right)| each[i] * right).sum();
        row.iter().copied().chain([right]).collect()
    });
    (solve(equations.collect()), inverse(&normal))
}

#[test]
fn test_filter_is_the_least_squares_over_all_levels_at_once() {
    let changes = changes();
    let mut walk = Walk::new([1.0, 0.0], &PRIOR, NOISE);
    let mut last = 0.0;
    for (k, (slopes, open, measured)) in changes.iter().enumerate() {
        let slopes = SVector::from(*slopes);
        let innovation = walk.observe(
            &Change {
                measured: measured - last,
                expected: slopes.dot(&walk.mean),
                slopes,
                open: *open,
                noise: NOISE,
                dt: 0.05,
            },
            NOISE,
        );
        // None of these is an outlier, and the noise is the given one.
        assert!(innovation.value.abs() < 4.0 * innovation.variance.sqrt());
        last = *measured;
        let (found, covariance) = all_at_once(&changes[..=k]);
        assert_close(walk.mean[0], found[0]);
        assert_close(walk.mean[1], found[1]);
        assert_close(walk.level + measured, found[3 + k]);
        for (place, other) in [(0, 0), (0, 1), (1, 1)] {
            let wanted = covariance[place][other];
            let off = (walk.covariance[(place, other)] - wanted).abs();
            assert!(off <= 1e-6 * PRIOR[place] * PRIOR[other], "{off}");
        }
        assert_close(walk.variance, covariance[3 + k][3 + k]);
    }
    assert!((walk.mean[0] - 1.2).abs() < 0.05, "{}", walk.mean);
}

#[test]
fn test_nothing_stands_out_where_rounding_left_a_variance_below_0() {
    let mut walk = Walk::new([0.0], &[1.0], NOISE);
    walk.covariance[(0, 0)] = -1e-18;
    let found = walk.beyond_doubt(&SVector::from([1.0]));
    assert_eq!(found.to_bits(), 0.0_f64.to_bits(), "{found}");
}

#[test]
fn test_forgetting_takes_information_down_to_that_of_the_prior() {
    let mut walk = Walk::new([1.0, 0.0], &PRIOR, NOISE);
    walk.covariance *= 0.1;
    walk.covariance[(0, 1)] = 0.002;
    walk.covariance[(1, 0)] = 0.002;
    let information = |walk: &Walk<2>| {
        let rows = [0, 1].map(|i| [0, 1].map(|j| walk.covariance[(i, j)]).to_vec());
        inverse(&rows).concat()
    };
    let before = information(&walk);
    let mean = walk.mean;
    for _ in 0..10_000 {
        walk.forget(1e-4, &PRIOR);
    }
    // After one time constant, exp(-1) of what is beyond the prior's is kept.
    let prior = Walk::new([1.0, 0.0], &PRIOR, NOISE);
    let known = information(&prior);
    for (k, found) in information(&walk).iter().enumerate() {
        let wanted = known[k] + (before[k] - known[k]) * f64::exp(-1.0);
        assert!((found / wanted - 1.0).abs() < 1e-3, "{found} {wanted}");
    }
    // At once, however long it was, it is no more than the prior's; and the estimate stays.
    walk.covariance *= 1e-3;
    for _ in 0..1000 {
        walk.forget(1e3, &PRIOR);
        let share = walk.covariance[(0, 0)] / (PRIOR[0] * PRIOR[0]);
        assert!(share > 0.0 && share <= 1.0 + 1e-9, "{share} {walk:?}");
    }
    let share = walk.covariance[(0, 0)] / (PRIOR[0] * PRIOR[0]);
    assert!((share - 1.0).abs() < 1e-6, "{share}");
    assert_eq!(walk.mean, mean);
}

#[test]
fn test_innovations_have_the_variance_that_the_filter_says_and_the_noise_is_found() {
    // A multiplicative congruential generator: twelve draws less six are nearly normal.
    let mut seed = 1_u64;
    let mut normal = || {
        let draw = |_| {
            seed = seed * 48271 % 2_147_483_647;
            #[expect(clippy::cast_precision_loss, reason = "below 2^31")]
            let share = seed as f64 / 2_147_483_647.0;
            share
        };
        (0..12).map(draw).sum::<f64>() - 6.0
    };
    let mut walk = Walk::new([1.0, 0.0], &PRIOR, 1e-4);
    let (mut level, mut last, mut sum) = (0.0, 0.0, 0.0);
    for k in 0..4000_u32 {
        let slopes = SVector::from([0.1 * (0.2 * f64::from(k)).sin(), 0.02]);
        level += slopes.dot(&SVector::from([0.8, 0.05])) + 1e-3 * normal();
        let measured = level + 0.02 * normal();
        let change = Change {
            measured: measured - last,
            expected: slopes.dot(&walk.mean),
            slopes,
            open: 1e-6,
            noise: walk.noise.variance,
            dt: 0.05,
        };
        let innovation = walk.observe(&change, 1e-4);
        last = measured;
        if k >= 1000 {
            sum += innovation.value * innovation.value / innovation.variance;
        }
    }
    assert!(
        (walk.noise.variance.sqrt() / 0.02 - 1.0).abs() < 0.15,
        "{}",
        walk.noise.variance
    );
    assert!((sum / 3000.0 - 1.0).abs() < 0.15, "{sum}");
    assert!((walk.mean[0] - 0.8).abs() < 3.0 * walk.covariance[(0, 0)].sqrt());
}

/// What is estimated on a circle to either side at speeds that change between `speeds` [m/s], of a
/// vehicle with this gain and this understeer in addition to those given.
fn turned(gain: f64, understeer: f64, speeds: (f64, f64)) -> (Estimator, f64) {
    let params = AdaptParams::DEFAULT;
    let mut estimator = Estimator::default();
    let mut here = VehicleState {
        x: 0.0,
        y: 0.0,
        yaw: 0.0,
        speed: speeds.0,
    };
    for k in 0..1600_u32 {
        let time = 0.05 * f64::from(k);
        let share = 0.5 - 0.5 * (0.3 * time).cos();
        let angle = 0.05 * (0.9 * time).sin();
        let reached = popsteer_core::vehicle::wheels::WheelIntegrals {
            turn: 0.05 * angle.tan(),
            slope: 0.05 * (1.0 + angle.tan() * angle.tan()),
            change: 0.05 * 0.045 * (0.9 * time).cos(),
        };
        let speed = speeds.0 + share * (speeds.1 - speeds.0);
        let mean = 0.5 * (here.speed + speed);
        let length = CAR.turning_length(mean) + understeer * mean * mean;
        let before = here;
        here.yaw += gain * mean / length * reached.turn;
        here.speed = speed;
        estimator.last_measured = Some(before);
        estimator.observe_turn(&params, &CAR, here, reached, 0.05);
    }
    (estimator, here.speed)
}

#[test]
fn test_understeer_is_learnt_where_speeds_differ_and_holds_at_others() {
    for (gain, understeer) in [(1.0, 0.003), (0.9, 0.002), (1.1, -0.002), (1.0, 0.0)] {
        let (estimator, speed) = turned(gain, understeer, (5.0, 25.0));
        let [found, more] = [0, 1].map(|k| estimator.turning.get(k));
        assert!((found - gain).abs() < 0.01, "{found} of {gain}");
        let more = more / CAR.wheelbase;
        assert!((more - understeer).abs() < 2e-4, "{more} of {understeer}");
        // The gain that controllers use is that at the present speed.
        let length = CAR.turning_length(speed);
        let wanted = gain * length / (length + understeer * speed * speed);
        assert!((estimator.estimate.gain - wanted).abs() < 0.01);
    }
}

#[test]
fn test_acceleration_is_that_of_the_speeds_and_noise_in_them_is_none() {
    let at = |speed: f64| VehicleState {
        x: 0.0,
        y: 0.0,
        yaw: 0.0,
        speed,
    };
    let still = popsteer_core::vehicle::wheels::WheelIntegrals::default();
    let found = |speed: &dyn Fn(u32) -> f64, dt: f64| {
        let mut estimator = Estimator::default();
        let mut largest = [0.0_f64; 2];
        for k in 1..400 {
            estimator.last_measured = Some(at(speed(k - 1)));
            estimator.observe_turn(&AdaptParams::DEFAULT, &CAR, at(speed(k)), still, dt);
            let acceleration = estimator.estimate.acceleration.abs();
            for (largest, from) in largest.iter_mut().zip([6, 100]) {
                if k > from {
                    *largest = largest.max(acceleration);
                }
            }
        }
        (estimator.estimate.acceleration, largest)
    };
    for dt in [0.01, 0.05, 0.2] {
        let braking = found(&|k| 300.0 - 1.5 * dt * f64::from(k), dt).0;
        assert!((braking + 1.5).abs() < 0.02, "{dt}: {braking}");
    }
    // Noise of 0.1 m/s: a difference over 0.1 s would be up to 2 m/s^2.
    let noise = |k: u32| (f64::from(k * k) * 0.9).sin();
    let [_, noisy] = found(&|k| 10.0 + 0.14 * noise(k), 0.05).1;
    assert!(noisy < 0.5, "{noisy}");
    // And it is none in the first second.
    let [first, _] = found(&|k| 10.0 + 0.3 * noise(k + 1), 0.05).1;
    assert!(first < 2.5, "{first}");
    // One that changes at once is followed as soon, however exactly the last one was known.
    for (dt, from) in [(0.01, 360), (0.05, 392)] {
        let turned =
            |k: u32| 1.3 * f64::from(k.min(from)) - 1.8 * f64::from(k.saturating_sub(from));
        let followed = found(&|k| 10.0 + dt * turned(k), dt).0;
        assert!((followed + 1.8).abs() < 0.1, "{dt}: {followed}");
    }
    let mut estimator = Estimator::default();
    for _ in 0..3 {
        estimator.last_measured = Some(at(100.0));
        estimator.observe_turn(&AdaptParams::DEFAULT, &CAR, at(0.0), still, 0.05);
    }
    assert!(estimator.estimate.acceleration >= -20.0 * 3.0);
}

/// The slip that is estimated of a vehicle that slides aside by `slip` at `speed` [m/s], its
/// position measured with `noise` [m].
fn slid(speed: f64, slip: f64, noise: f64, dt: f64) -> f64 {
    let mut estimator = Estimator::default();
    let (mut x, mut y) = (0.0, 0.0);
    let mut before = None;
    for k in 0..200_u32 {
        let now = VehicleState {
            x,
            y: y + noise * (f64::from(k * k) * 0.9).sin(),
            yaw: 0.0,
            speed,
        };
        estimator.last_measured = before;
        estimator.observe_slip(&AdaptParams::DEFAULT, &CAR, now, 0.0, dt);
        before = Some(now);
        x += speed * dt * slip.cos();
        y += speed * dt * slip.sin();
    }
    estimator.estimate.slip
}

#[test]
fn test_slip_is_learnt_at_every_speed_and_noise_is_no_slip() {
    for speed in [0.3, 1.0, 3.0, 10.0, -2.0] {
        for dt in [0.05, 0.4] {
            let found = slid(speed, 0.02, 0.0, dt);
            assert!((found - 0.02).abs() < 2e-3, "{speed} {dt}: {found}");
        }
        let found = slid(speed, 0.02, 0.01, 0.05);
        assert!((found - 0.02).abs() < 8e-3, "{speed}: {found}");
        let found = slid(speed, 0.0, 0.02, 0.05);
        assert!(found.abs() < 2e-3, "{speed}: {found}");
    }
}

/// The scale that is estimated of a speed signal that says `share` of the speed, `late` [s] ago, of a
/// vehicle that accelerates from `speed` to 12 m/s, its position measured with `noise` [m].
fn scaled(share: f64, speed: f64, (late, noise): (f64, f64), dt: f64) -> f64 {
    let mut estimator = Estimator::default();
    let still = popsteer_core::vehicle::wheels::WheelIntegrals::default();
    let at = |time: f64| f64::min(speed + 2.0 * f64::max(time, 0.0), 12.0);
    let (mut x, mut before) = (0.0, None);
    for k in 0..400_u32 {
        let time = f64::from(k) * dt;
        let now = VehicleState {
            x: x + noise * (f64::from(k * k) * 0.9).sin(),
            y: 0.0,
            yaw: 0.0,
            speed: share * at(time - late),
        };
        estimator.last_measured = before;
        estimator.observe_turn(&AdaptParams::DEFAULT, &CAR, now, still, dt);
        before = Some(now);
        x += 0.5 * (at(time) + at(time + dt)) * dt;
    }
    estimator.estimate.speed_scale
}

#[test]
fn test_scale_of_the_speed_is_learnt_and_noise_and_lateness_are_none() {
    for speed in [0.0, 3.0, 12.0] {
        for dt in [0.02, 0.05, 0.4] {
            for share in [0.7, 0.85, 0.95, 1.05, 1.2, 1.5] {
                let exact = share * scaled(share, speed, (0.0, 0.0), dt);
                assert!((exact - 1.0).abs() < 3e-3, "{speed} {dt} {share}: {exact}");
                let noisy = share * scaled(share, speed, (0.0, 0.03), dt);
                assert!((noisy - 1.0).abs() < 0.03, "{speed} {dt} {share}: {noisy}");
            }
            for late in [-0.2, 0.0, 0.3] {
                let found = scaled(1.0, speed, (late, 0.03), dt);
                assert!((found - 1.0).abs() < 0.02, "{speed} {dt} {late}: {found}");
            }
        }
        for other in [0.2778, 0.5, -1.0, 2.0, 3.6] {
            let found = scaled(other, speed, (0.0, 0.0), 0.05);
            assert!((found - 1.0).abs() < 1e-9, "{speed} {other}: {found}");
        }
    }
}

#[test]
fn test_estimates_beyond_their_bounds_are_refused() {
    let fits = |estimate: Estimate| {
        let estimator = Estimator {
            estimate,
            ..Estimator::default()
        };
        estimator.checked(&CAR).is_ok()
    };
    let braking = |acceleration| Estimate {
        acceleration,
        ..Estimate::DEFAULT
    };
    assert!(fits(braking(-59.9)) && fits(braking(59.9)));
    assert!(!fits(braking(-60.1)) && !fits(braking(60.1)));
    let there = |x: f64| {
        let estimator = Estimator {
            last_measured: Some(VehicleState {
                x,
                y: -x,
                yaw: 0.0,
                speed: 0.0,
            }),
            ..Estimator::default()
        };
        estimator.checked(&CAR).is_ok()
    };
    // A point of a vehicle at the bound of the coordinates may lie beyond that.
    assert!(there(1.9e9) && !there(2.1e9));
}
