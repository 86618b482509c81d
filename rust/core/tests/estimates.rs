//! What the estimator makes of single motions: least squares over all of them at once, and the
//! gradient steps of dead time and slip, written out.

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
                },
                measured: turn + 0.002 * wave(k * k, 0.9) + jump,
                speeds: (speed(k), speed(k + 1)),
                dt,
            }
        })
        .collect()
}

/// The expected turn, and its derivative by the steering offset.
fn expected(car: &Vehicle, period: &Period) -> (f64, f64) {
    let speed = 0.5 * (period.speeds.0 + period.speeds.1);
    let share = speed / (car.wheelbase + car.understeer * speed * speed);
    (share * period.reached.turn, share * period.reached.slope)
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

/// The measured turns as they count: at most `2 (|a| + 0.15 |b|)` off the estimated one.
fn counted(car: &Vehicle, periods: &[Period], all: &[Estimator]) -> Vec<f64> {
    let one = |(period, before): (&Period, &Estimator)| {
        let (a, b) = expected(car, period);
        let Estimate {
            gain, steer_offset, ..
        } = before.estimate;
        let middle = gain * (a + steer_offset * b);
        let most = 2.0 * (a.abs() + 0.15 * b.abs());
        period.measured.clamp(middle - most, middle + most)
    };
    periods.iter().zip(all).map(one).collect()
}

#[track_caller]
fn assert_close(found: f64, wanted: f64) {
    let off = (found - wanted).abs();
    assert!(off <= 1e-9 * wanted.abs().max(1.0), "{found}, not {wanted}");
}

/// `minimise sum exp(-age / turn_time) (y - g a - h b)^2 + 1e-4 (g - 1)^2 + 0.1 h^2` over all
/// periods at once, with the gain `g` and the offset `h / g`.
#[test]
fn test_gain_and_offset_are_the_least_squares_over_all_periods() {
    let periods = periods();
    let blind = Vehicle {
        dead_time: 0.0,
        ..CAR
    };
    for car in [CAR, blind] {
        let all = observed(&car, &periods);
        let counted = counted(&car, &periods, &all);
        assert!(counted.iter().zip(&periods).any(|(y, p)| *y < p.measured));
        for n in [1, 2, 7, 41, 60] {
            let (mut aa, mut ab, mut bb, mut ay, mut by) = (1e-4, 0.0, 0.1, 1e-4, 0.0);
            let mut age = 0.0;
            for (period, y) in periods.iter().zip(&counted).take(n).rev() {
                let (a, b) = expected(&car, period);
                let weight = f64::exp(-age / PARAMS.turn_time);
                aa += weight * a * a;
                ab += weight * a * b;
                bb += weight * b * b;
                ay += weight * a * y;
                by += weight * b * y;
                age += period.dt;
            }
            let best = solve(vec![vec![aa, ab, ay], vec![ab, bb, by]]);
            let found = &all[n];
            assert_close(found.known().gain, best[0]);
            if car.dead_time > 0.0 {
                assert_close(found.estimate.gain, best[0]);
                assert_close(found.estimate.steer_offset, best[1] / best[0]);
            } else {
                // Without a dead time controllers use the gain 1, and the offset that is best then.
                assert_close(found.estimate.gain, 1.0);
                assert_close(found.estimate.steer_offset, (by - ab) / bb);
            }
        }
    }
}

/// What the fit leaves over, `r`, and the change `c` of the expected turn, per second: a step of
/// `r c / (0.01 + sum exp(-age / turn_time) c^2)`, with `r` at most what half the dead time makes.
#[test]
fn test_dead_time_takes_the_step_of_its_gradient() {
    let periods = periods();
    let all = observed(&CAR, &periods);
    let counted = counted(&CAR, &periods, &all);
    let (mut sum, mut last) = (0.0, 0.0);
    let mut longer: f64 = 0.0;
    for ((period, y), after) in periods.iter().zip(&counted).zip(&all[1..]) {
        let (a, b) = expected(&CAR, period);
        let change = (last - a) / period.dt;
        sum = sum * f64::exp(-period.dt / PARAMS.turn_time) + change * change;
        let Estimate {
            gain, steer_offset, ..
        } = after.estimate;
        let most = 0.15 * change.abs();
        let rest = (y - gain * (a + steer_offset * b)).clamp(-most, most);
        let step = rest * change / (sum + 0.01);
        longer = (longer + step.clamp(-period.dt, period.dt)).clamp(-0.15, 0.15);
        assert_close(after.estimate.longer_dead_time, longer);
        last = a;
    }
    assert!(longer.abs() > 1e-4, "{longer}");
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

/// `slip + slip_length bend` misses the sample by `m`: a normalised step of `dt / slip_time`
/// towards it, shared by a bend of 0.03 per wheelbase.
#[test]
fn test_slip_takes_the_normalised_step_towards_its_sample() {
    let before = VehicleState {
        x: 7.0,
        y: -3.0,
        yaw: 3.1,
        speed: 6.0,
    };
    for (slip, turn, bend, dt) in [
        (0.05, 0.0, 0.0, 0.1),
        (-0.08, 0.1, 0.04, 0.05),
        (0.11, -0.06, -0.2, 0.1),
        // The sample counts as at most 0.6, the slip as at most 0.15.
        (1.2, 0.0, 0.01, 0.9),
    ] {
        for (known, known_length, way) in [(0.0, 0.0, 1.0), (0.03, -0.4, 1.0), (0.01, 0.2, -1.0)] {
            // The vehicle moves 7 m/s in the mean, off its mean heading by the slip.
            let (travel, speed) = (way * 7.0 * dt, way * 8.0);
            let direction = before.yaw + 0.5 * turn;
            let aside = travel * slip;
            let now = VehicleState {
                x: before.x + travel * direction.cos() - aside * direction.sin(),
                y: before.y + travel * direction.sin() + aside * direction.cos(),
                yaw: before.yaw + turn - std::f64::consts::TAU,
                speed,
            };
            let mut estimator = Estimator {
                last_measured: Some(VehicleState {
                    speed: way * before.speed,
                    ..before
                }),
                estimate: Estimate {
                    slip: known,
                    slip_length: known_length,
                    ..Estimate::DEFAULT
                },
                ..Estimator::default()
            };
            let looked = |asked: f64| {
                assert_close(asked, travel);
                bend
            };
            estimator.observe_slip(&PARAMS, &CAR, now, looked, dt);
            let split = (0.03_f64 / 3.0).powi(2);
            let missed = slip.clamp(-0.6, 0.6) - (known + known_length * bend);
            let step = dt / 2.0 * missed / (split + bend * bend);
            let found = estimator.estimate;
            assert_close(found.slip, (known + step * split).clamp(-0.15, 0.15));
            assert_close(
                found.slip_length,
                (known_length + step * bend).clamp(-3.0, 3.0),
            );
        }
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
        estimator.observe_slip(&PARAMS, &CAR, at(0.01, speed), |_| 0.0, 0.1);
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
