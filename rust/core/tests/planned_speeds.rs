//! Planned speeds keep every limit, and at every waypoint one of the limits is reached: no greater
//! speed is within them. The limits are written here as their definitions say.

use popsteer_core::speed::{Course, Limit, OverSpeed, SpeedLimits, path_curvature, plan_speeds};
use popsteer_core::{Path, Vehicle};

const FALLING: OverSpeed<'static> = OverSpeed {
    speeds: &[2.0, 8.0, 14.0],
    values: &[5.0, 3.0, 1.5],
};
const PLAIN: OverSpeed<'static> = OverSpeed {
    speeds: &[0.0],
    values: &[4.0],
};
/// How nearly a limit counts as reached or kept.
const NEARLY: f64 = 1e-6;

fn car(understeer: f64, max_steer_rate: Option<f64>) -> Vehicle {
    Vehicle {
        wheelbase: 2.5,
        max_steer: 0.5,
        understeer,
        max_steer_rate,
        ..Vehicle::PAPER
    }
}

/// Bends to both sides, straights between them, speed limits, uneven spacing.
struct Track {
    curvature: Vec<f64>,
    spacing: Vec<f64>,
    speed_limits: Vec<f64>,
    cusps: Vec<bool>,
}

fn track(closed: bool) -> Track {
    let count = 120_u32;
    let wave = |k: u32| {
        let bend = (0.21 * f64::from(k)).sin() * (0.047 * f64::from(k)).cos();
        0.12 * bend.abs().powf(0.8).copysign(bend)
    };
    let straight = |k: u32| (30..42).contains(&k);
    let segments = if closed { count } else { count - 1 };
    Track {
        curvature: (0..count)
            .map(|k| match k {
                // Tighter than the wheels can steer.
                50 => 0.3,
                k if straight(k) => 0.0,
                k => wave(k),
            })
            .collect(),
        spacing: (0..segments)
            .map(|k| 0.6 + 0.5 * f64::from(k % 7))
            .collect(),
        speed_limits: (0..count)
            .map(|k| if (60..75).contains(&k) { 4.0 } else { 30.0 })
            .collect(),
        cusps: (0..count).map(|k| k == 90).collect(),
    }
}

/// Straight between the points of a table, constant beyond them.
fn at(over: &OverSpeed<'_>, speed: f64) -> f64 {
    let (speeds, values) = (over.speeds, over.values);
    let Some(next) = speeds.iter().position(|&known| known > speed) else {
        return values[values.len() - 1];
    };
    if next == 0 {
        return values[0];
    }
    let share = (speed - speeds[next - 1]) / (speeds[next] - speeds[next - 1]);
    values[next - 1] * (1.0 - share) + values[next] * share
}

/// What the friction ellipse leaves along the path.
fn available(limits: &SpeedLimits<'_>, over: &OverSpeed<'_>, squared: f64, curvature: f64) -> f64 {
    let most = at(over, squared.sqrt());
    let used = squared * curvature.abs() / limits.max_lateral_acceleration;
    let share = if limits.exponent.is_infinite() {
        1.0
    } else {
        (1.0 - used.min(1.0).powf(limits.exponent)).powf(1.0 / limits.exponent)
    };
    limits
        .longitudinal_grip
        .map_or(most * share, |grip| most.min(grip * share))
}

/// How fast the wheels turn at most along a segment, by the bound that `SpeedLimits` states [rad/s].
fn turning(limits: &SpeedLimits<'_>, from: f64, to: f64, length: f64, speed: f64) -> f64 {
    let car = &limits.vehicle;
    let longer = car.understeer * speed * speed;
    let most = at(&limits.acceleration, 0.0).max(at(&limits.deceleration, 0.0));
    let least = if from.signum() == to.signum() {
        from.abs().min(to.abs())
    } else {
        0.0
    };
    let change = (to - from).abs() / length * (car.wheelbase + longer);
    let rising = from.abs().max(to.abs()) * 2.0 * car.understeer * most;
    speed * (change + rising) / (1.0 + (least * car.wheelbase).powi(2))
}

fn check(track: &Track, closed: bool, limits: &SpeedLimits<'_>) -> Vec<Limit> {
    let course = Course {
        sharp: None,
        curvature: &track.curvature,
        spacing: &track.spacing,
        closed,
        cusps: Some(&track.cusps),
        speed_limits: Some(&track.speed_limits),
        grade: None,
        start_speed: Some(3.0),
        end_speed: Some(1.0),
    };
    let count = track.curvature.len();
    let mut speed = vec![0.0; count];
    let mut limit = vec![Limit::default(); count];
    plan_speeds(&course, limits, &mut speed, &mut limit).unwrap();
    let car = &limits.vehicle;
    for k in 0..count {
        let (v, bend) = (speed[k], track.curvature[k].abs());
        // How much of each limit is used: at most all of it.
        let mut used = vec![
            (Limit::TopSpeed, v / limits.max_speed),
            (Limit::SpeedLimit, v / track.speed_limits[k]),
            (
                Limit::Lateral,
                v * v * bend / limits.max_lateral_acceleration,
            ),
        ];
        if car.understeer > 0.0 && bend * car.wheelbase < car.max_steer.tan() {
            let wheels = bend * (car.wheelbase + car.understeer * v * v);
            used.push((Limit::SteerAngle, wheels / car.max_steer.tan()));
        }
        if track.cusps[k] {
            assert!(v <= 0.0 && limit[k] == Limit::Stop);
            continue;
        }
        if !closed && k == 0 {
            used.push((Limit::Stop, v / 3.0));
        }
        if !closed && k + 1 == count {
            used.push((Limit::Stop, v / 1.0));
        }
        let before = (k > 0 || closed).then(|| (k + count - 1) % count);
        let after = (k + 1 < count || closed).then(|| (k + 1) % count);
        for (from, to) in [(before, Some(k)), (Some(k), after)] {
            if let (Some(from), Some(to), Some(rate)) = (from, to, car.max_steer_rate)
                && !track.cusps[to]
            {
                let (one, other) = (track.curvature[from], track.curvature[to]);
                let turning = turning(limits, one, other, track.spacing[from], v);
                used.push((Limit::SteerRate, turning / rate));
            }
        }
        // The acceleration of a segment holds at both of its ends.
        let mut reach = |other: usize, segment: usize, over: &OverSpeed<'_>, by: Limit| {
            let there = speed[other] * speed[other];
            let one = available(limits, over, v * v, track.curvature[k]);
            let two = available(limits, over, there, track.curvature[other]);
            let most = there + 2.0 * track.spacing[segment] * one.min(two);
            if v * v >= there {
                used.push((by, v * v / most));
            }
        };
        if let Some(before) = before {
            reach(before, before, &limits.acceleration, Limit::Driving);
        }
        if let Some(after) = after {
            reach(after, k, &limits.deceleration, Limit::Braking);
        }
        for &(by, share) in &used {
            assert!(share <= 1.0 + NEARLY, "{by:?} at {k}: {share}, {v} m/s");
        }
        assert!(
            used.iter().any(|&(_, share)| share >= 1.0 - NEARLY),
            "nothing limits {v} m/s at {k}: {used:?}"
        );
        // The limit that is named has limited it, or has before rounding did.
        assert!(
            used.iter()
                .any(|&(by, share)| by == limit[k] && share >= 0.998),
            "{:?} at {k}: {used:?}",
            limit[k]
        );
    }
    limit
}

#[test]
fn test_planned_speeds_are_the_greatest_within_the_limits() {
    let mut seen = [false; 8];
    for closed in [false, true] {
        let track = track(closed);
        for exponent in [1.0, 1.5, 2.0, f64::INFINITY] {
            for longitudinal_grip in [None, Some(3.5)] {
                for (acceleration, deceleration) in
                    [(PLAIN, FALLING), (FALLING, PLAIN), (FALLING, FALLING)]
                {
                    for (understeer, rate) in [(0.0, None), (0.05, None), (0.005, Some(0.6))] {
                        let limits = SpeedLimits {
                            max_speed: 12.0,
                            max_lateral_acceleration: 6.0,
                            acceleration,
                            deceleration,
                            longitudinal_grip,
                            exponent,
                            vehicle: car(understeer, rate),
                        };
                        for limit in check(&track, closed, &limits) {
                            seen[usize::from(limit.code())] = true;
                        }
                    }
                }
            }
        }
    }
    assert_eq!(seen, [true; 8], "each limit is met somewhere");
}

/// A vehicle whose wheels need not turn is not slowed, and a lap is the same from wherever it is
/// counted.
#[test]
fn test_lap_is_planned_alike_wherever_it_begins() {
    let plan = |first: usize| {
        let Track {
            mut curvature,
            mut spacing,
            mut speed_limits,
            mut cusps,
        } = track(true);
        curvature.rotate_left(first);
        spacing.rotate_left(first);
        speed_limits.rotate_left(first);
        cusps.fill(false);
        let course = Course {
            sharp: None,
            curvature: &curvature,
            spacing: &spacing,
            closed: true,
            cusps: None,
            speed_limits: Some(&speed_limits),
            grade: None,
            start_speed: None,
            end_speed: None,
        };
        let limits = SpeedLimits {
            max_speed: 12.0,
            max_lateral_acceleration: 6.0,
            acceleration: FALLING,
            deceleration: PLAIN,
            longitudinal_grip: None,
            exponent: 2.0,
            vehicle: car(0.01, Some(0.8)),
        };
        let mut speed = vec![0.0; 120];
        let mut limit = vec![Limit::default(); 120];
        plan_speeds(&course, &limits, &mut speed, &mut limit).unwrap();
        speed.rotate_right(first);
        speed
    };
    let one = plan(0);
    for first in [1, 33, 64, 119] {
        for (k, (a, b)) in one.iter().zip(plan(first)).enumerate() {
            assert!((a - b).abs() < 1e-9, "{k} from {first}: {a}, {b}");
        }
    }
}

/// Along a clothoid the curvature grows with the arc; smoothing keeps it, waypoints between the
/// nodes have what lies between, and the way back has the opposite.
#[test]
fn test_curvature_of_a_clothoid_grows_with_its_arc() {
    let rate = 0.004;
    for spacing in [0.13, 0.4, 1.0] {
        let (mut x, mut y) = (vec![0.0], vec![0.0]);
        let (mut at, steps) = ((0.0, 0.0), 100);
        let mut s: f64 = 0.0;
        while s < 30.0 {
            for _ in 0..steps {
                let part = spacing / f64::from(steps);
                let yaw = 0.5 * rate * (s + 0.5 * part).powi(2);
                at = (at.0 + part * yaw.cos(), at.1 + part * yaw.sin());
                s += part;
            }
            x.push(at.0);
            y.push(at.1);
        }
        let path = Path::new(&x, &y, None, false).unwrap();
        let found = path_curvature(&path.view(), 2.0);
        for (k, value) in (0..).zip(&found) {
            let s = spacing * f64::from(k);
            // The ends of a path are smoothed from one side.
            if (10.0..20.0).contains(&s) {
                assert!(
                    (value - rate * s).abs() < 1.2e-3,
                    "{spacing} {s} m: {value}"
                );
            }
        }
        x.reverse();
        y.reverse();
        let back = Path::new(&x, &y, None, false).unwrap();
        let back = path_curvature(&back.view(), 2.0);
        for (there, back) in found.iter().zip(back.iter().rev()).skip(20) {
            assert!((there + back).abs() < 2e-4, "{there} {back}");
        }
    }
}

/// The curvature of a closed path does not depend on where its waypoints begin.
#[test]
fn test_curvature_of_a_loop_is_the_same_wherever_it_begins() {
    for (count, size) in [(13_u32, 4.0), (90, 20.0), (400, 20.0)] {
        let point = |k: u32| {
            let angle = f64::from(k) * std::f64::consts::TAU / f64::from(count);
            let radius = size * (1.0 + 0.2 * (3.0 * angle).cos());
            (radius * angle.cos(), radius * angle.sin())
        };
        let curvature = |first: u32| {
            let points = (0..count).map(|k| point((k + first) % count));
            let (x, y): (Vec<f64>, Vec<f64>) = points.unzip();
            let path = Path::new(&x, &y, None, true).unwrap();
            path_curvature(&path.view(), 2.0)
        };
        let one = curvature(0);
        for first in [1, 5, count - 1] {
            let mut other = curvature(first);
            other.rotate_right(usize::try_from(first).unwrap());
            for (k, (a, b)) in one.iter().zip(&other).enumerate() {
                assert!(
                    (a - b).abs() < 2e-3 / size,
                    "{k} of {count} from {first}: {a} {b}"
                );
            }
        }
        assert!(one.iter().any(|value| value.abs() > 0.5 / size));
    }
}
