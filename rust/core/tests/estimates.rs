//! What the estimator makes of single motions: least squares over all of them at once, written out.

mod dense;

use dense::solve;
use popsteer_core::vehicle::wheels::WheelIntegrals;
use popsteer_core::vehicle::{AdaptParams, Estimate, Estimator};
use popsteer_core::{Vehicle, VehicleState};

const CAR: Vehicle = Vehicle {
    understeer: 0.004,
    dead_time: 0.3,
    ..Vehicle::PAPER
};
/// Quick, so that forgetting is seen.
const PARAMS: AdaptParams = AdaptParams {
    turn_time: 1.5,
    slip_time: 2.0,
    min_speed: Some(1.0),
};

/// One period: what the wheels did, the turn that was measured, and the speeds.
#[derive(Clone, Copy)]
struct Period {
    reached: WheelIntegrals,
    measured: f64,
    speeds: (f64, f64),
    dt: f64,
}

/// Bends to both sides, at speeds and periods that change, measured with errors; in one of them
/// the heading jumps.
fn periods() -> Vec<Period> {
    let wave = |k: u32, rate: f64| (rate * f64::from(k)).sin();
    (0..60_u32)
        .map(|k| {
            let dt = 0.05 + 0.02 * wave(k, 1.7);
            let angle = 0.12 * wave(k, 0.21) + 0.02;
            let speed = |k: u32| 9.0 + 2.0 * wave(k, 0.11);
            let turn = 1.15 * speed(k) / 3.3 * dt * (angle + 0.03).tan();
            let jump = if k == 40 { 0.3 } else { 0.0 };
            Period {
                reached: WheelIntegrals {
                    turn: dt * angle.tan(),
                    slope: dt * (1.0 + angle.tan().powi(2)),
                    change: 0.03 * wave(k, 0.37) * dt,
                },
                measured: turn + 0.002 * wave(k * k, 0.9) + jump,
                speeds: (speed(k), speed(k + 1)),
                dt,
            }
        })
        .collect()
}

/// The expected turn, its derivative by the steering offset, and that by a shorter dead time.
fn expected(car: &Vehicle, period: &Period) -> [f64; 3] {
    let speed = 0.5 * (period.speeds.0 + period.speeds.1);
    let share = speed / (car.wheelbase + car.understeer * speed * speed);
    let WheelIntegrals {
        turn,
        slope,
        change,
    } = period.reached;
    [share * turn, share * slope, share * change]
}

/// The estimator after each period, from the heading `yaw` on.
fn observed(car: &Vehicle, periods: &[Period]) -> Vec<Estimator> {
    let mut estimator = Estimator::default();
    let mut yaw = 3.0;
    let state = |yaw: f64, speed: f64| VehicleState {
        x: 0.0,
        y: 0.0,
        yaw,
        speed,
    };
    let mut all = vec![estimator];
    for period in periods {
        estimator.last_measured = Some(state(yaw, period.speeds.0));
        yaw += period.measured;
        if yaw > std::f64::consts::PI {
            yaw -= std::f64::consts::TAU;
        }
        let now = state(yaw, period.speeds.1);
        estimator.observe_turn(&PARAMS, car, now, period.reached, period.dt);
        all.push(estimator);
    }
    all
}

/// The measured turns as they count: at most `2 (|a| + 0.15 |b|)` and six deviations of the noise
/// off the estimated one.
fn counted(car: &Vehicle, periods: &[Period], all: &[Estimator]) -> Vec<f64> {
    let one = |(period, before): (&Period, &Estimator)| {
        let [a, b, _] = expected(car, period);
        let Estimate {
            gain, steer_offset, ..
        } = before.estimate;
        let middle = gain * (a + steer_offset * b);
        let most = 2.0 * (a.abs() + 0.15 * b.abs()) + 6.0 * before.turning.noise.sqrt();
        period.measured.clamp(middle - most, middle + most)
    };
    periods.iter().zip(all).map(one).collect()
}

#[track_caller]
fn assert_close(found: f64, wanted: f64) {
    let off = (found - wanted).abs();
    assert!(off <= 1e-9 * wanted.abs().max(1.0), "{found}, not {wanted}");
}

/// Sums of `rows` and their answers over the last 2 s, then `M` and `m` over all periods at once,
/// as dense matrices.
fn all_at_once(
    rows: &[Vec<f64>],
    answers: &[f64],
    dts: &[f64],
    time: f64,
) -> (Vec<Vec<f64>>, Vec<f64>) {
    let size = rows[0].len();
    let (mut m, mut y) = (vec![vec![0.0; size]; size], vec![0.0; size]);
    let age = |from: usize, to: usize| dts[from + 1..=to].iter().sum::<f64>();
    let last = rows.len() - 1;
    for (k, dt) in dts.iter().enumerate().take(rows.len()) {
        let kept = |i: usize| f64::exp(-age(i, k) / 2.0);
        let sum = |column: usize| (0..=k).map(|i| kept(i) * rows[i][column]).sum::<f64>();
        let sums: Vec<f64> = (0..size).map(sum).collect();
        let answer: f64 = (0..=k).map(|i| kept(i) * answers[i]).sum();
        let weight = dt * f64::exp(-age(k, last) / time);
        for row in 0..size {
            y[row] += weight * sums[row] * answer;
            for column in 0..size {
                m[row][column] += weight * sums[row] * sums[column];
            }
        }
    }
    (m, y)
}

/// The priors: a least weight, and the noise over 1 s against the doubt.
fn prior(least: f64, noise: f64, doubt: f64) -> f64 {
    least + noise / (doubt * doubt)
}

#[test]
fn test_gain_offset_and_dead_time_are_the_least_squares_over_all_periods() {
    let periods = periods();
    let blind = Vehicle {
        dead_time: 0.0,
        ..CAR
    };
    for car in [CAR, blind] {
        let all = observed(&car, &periods);
        let counted = counted(&car, &periods, &all);
        assert!(counted.iter().zip(&periods).any(|(y, p)| *y < p.measured));
        let row = |(period, before): (&Period, &Estimator)| {
            let [a, b, c] = expected(&car, period);
            vec![a + before.estimate.longer_dead_time * c, b, -c]
        };
        let rows: Vec<Vec<f64>> = periods.iter().zip(&all).map(row).collect();
        let dts: Vec<f64> = periods.iter().map(|period| period.dt).collect();
        for n in [1, 2, 7, 41, 60] {
            let (m, y) = all_at_once(&rows[..n], &counted[..n], &dts[..n], PARAMS.turn_time);
            let noise = all[n - 1].turning.noise;
            // The gain with the others free, but for a thousandth of their least weights.
            let weight = prior(3e-3, noise, 0.1);
            let joint = solve(vec![
                vec![m[0][0] + weight, m[0][1], m[0][2], y[0] + weight],
                vec![m[1][0], m[1][1] + 1e-3, m[1][2], y[1]],
                vec![m[2][0], m[2][1], m[2][2] + 2e-6, y[2]],
            ]);
            let fitted = joint[0].clamp(0.4, 2.5);
            let found = all[n].estimate;
            assert_close(found.gain, fitted);
            let [by_offset, by_delay] = [prior(1.0, noise, 0.03), prior(2e-3, noise, 0.1)];
            let others = solve(vec![
                vec![m[1][1] + by_offset, m[1][2], y[1] / fitted - m[1][0]],
                vec![m[2][1], m[2][2] + by_delay, y[2] / fitted - m[2][0]],
            ]);
            assert_close(found.steer_offset, others[0].clamp(-0.15, 0.15));
            let (last, dt) = (all[n - 1].estimate.longer_dead_time, dts[n - 1]);
            let longer = others[1].clamp(last - 0.2 * dt, last + 0.2 * dt);
            let unseen = car.dead_time <= 0.0 && longer < 0.005;
            let longer = if unseen { 0.0 } else { longer };
            assert_close(
                found.longer_dead_time,
                longer.clamp(-car.dead_time, Estimator::MAX_LONGER),
            );
        }
    }
}

/// The acceleration is that of the speed, smoothed over a tenth of a second, up to 20 wheelbases.
#[test]
fn test_acceleration_is_smoothed_over_a_tenth_of_a_second() {
    let periods = periods();
    let mut acceleration = 0.0;
    for (period, after) in periods.iter().zip(&observed(&CAR, &periods)[1..]) {
        let now = (period.speeds.1 - period.speeds.0) / period.dt;
        acceleration += (1.0 - f64::exp(-period.dt / 0.1)) * (now - acceleration);
        assert_close(after.estimate.acceleration, acceleration);
    }
    let mut crash = periods[0];
    crash.speeds = (100.0, 0.0);
    let found = observed(&CAR, &[crash; 3])[3].estimate.acceleration;
    assert_close(found, -20.0 * 3.0);
}

#[test]
fn test_slip_is_the_least_squares_over_all_periods() {
    for (way, yaw_noise) in [(1.0, 0.0), (-1.0, 0.0), (1.0, 2e-4)] {
        let mut estimator = Estimator::default();
        estimator.turning.noise = yaw_noise;
        estimator.turning.noise_time = 5.0;
        let (mut least, mut most) = (1.0_f64, 0.0_f64);
        let mut here = VehicleState {
            x: 7.0,
            y: -3.0,
            yaw: 3.1,
            speed: way * 7.0,
        };
        let (mut rows, mut answers, mut dts) = (vec![], vec![], vec![]);
        for k in 0..50_u32 {
            let wave = |rate: f64| (rate * f64::from(k)).sin();
            let (dt, bend, turn) = (0.06 + 0.03 * wave(1.3), 0.04 * wave(0.2), 0.02 * wave(0.2));
            let speed = way * (7.0 + wave(0.1));
            let travel = 0.5 * (here.speed + speed) * dt;
            let aside = travel * (0.02 + 0.3 * bend) + 0.004 * wave(5.1);
            let direction = here.yaw + 0.5 * turn;
            let now = VehicleState {
                x: here.x + travel * direction.cos() - aside * direction.sin(),
                y: here.y + travel * direction.sin() + aside * direction.cos(),
                yaw: here.yaw + turn,
                speed,
            };
            let noise = estimator.sliding.noise;
            estimator.last_measured = Some(here);
            estimator.observe_slip(&PARAMS, &CAR, now, bend, dt);
            here = now;
            let square = (travel / dt) * (travel / dt) / CAR.wheelbase;
            rows.push(vec![
                travel / CAR.wheelbase,
                travel / CAR.wheelbase * square * bend,
            ]);
            answers.push(aside / CAR.wheelbase);
            dts.push(dt);
            let (m, y) = all_at_once(&rows, &answers, &dts, PARAMS.slip_time);
            let doubt = 0.1 * CAR.wheelbase / square;
            let weights = [
                m[0][0] + prior(0.25, noise, 0.02),
                m[1][1] + prior(0.04, noise, doubt),
            ];
            let best = solve(vec![
                vec![weights[0], m[0][1], y[0]],
                vec![m[1][0], weights[1], y[1]],
            ]);
            // Sums over 2 s, in which the noise of the heading adds up. None is seen before the first.
            let heading = 2.0 * travel / dt / CAR.wheelbase;
            let seen = if k == 0 { 0.0 } else { noise };
            let density = (seen + heading * heading * yaw_noise) * dt;
            let [slip, compliance] = [0, 1].map(|i| {
                let share = (1.0 - density / weights[i] / (best[i] * best[i])).max(0.0);
                (least, most) = (least.min(share), most.max(share));
                best[i] * share
            });
            assert_close(estimator.estimate.slip, slip.clamp(-0.15, 0.15));
            let length = compliance * speed * speed / CAR.wheelbase;
            assert_close(estimator.estimate.slip_length, length.clamp(-3.0, 3.0));
        }
        // Some did not stand out of the noise, some did.
        assert!(least < 0.1 && most > 0.9, "{least} to {most}");
        assert!((estimator.estimate.slip - 0.02).abs() < 0.01);
    }
}

#[test]
fn test_slip_is_not_taken_from_a_slow_vehicle() {
    let at = |y: f64, speed: f64| VehicleState {
        x: 0.0,
        y,
        yaw: 0.0,
        speed,
    };
    for (speed, learns) in [(1.01, true), (0.99, false), (-1.01, true), (-0.99, false)] {
        let mut estimator = Estimator {
            last_measured: Some(at(0.0, speed)),
            ..Estimator::default()
        };
        estimator.observe_slip(&PARAMS, &CAR, at(0.01, speed), 0.0, 0.1);
        assert_eq!(estimator.estimate.slip.abs() > 0.0, learns, "{speed}");
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
