//! Controllers beside a straight path answer by their equations, by hand.

mod straight;

use popsteer_core::laws::{
    LateralLaw, Pid, PidParams, PidState, Pop, PopParams, PurePursuit, PurePursuitParams,
    PurePursuitState, Stanley, StanleyParams,
};
use popsteer_core::vehicle::bicycle::kinematic_bicycle;
use popsteer_core::{Path, Point, Reported, Status, Tracker, Vehicle, VehicleState};
use straight::{CAR, assert_close, beside, straight};

/// The angles on the way through `places`, a tenth of a second apart.
fn angles<L: LateralLaw>(law: L, places: &[VehicleState]) -> Vec<f64> {
    let tracker = Tracker::of(law);
    let mut state = tracker.initial_state();
    let path = straight();
    let step = |&place| {
        let command = tracker.step(&path.view(), &mut state, place, 0.1, Reported::NOTHING);
        command.unwrap().steer
    };
    places.iter().map(step).collect()
}

fn angle<L: LateralLaw>(law: L, place: VehicleState) -> f64 {
    angles(law, &[place])[0]
}

#[test]
fn test_pure_pursuit_drives_the_circle_through_the_lookahead_point() {
    let law = |alpha_by_arccos| {
        let params = PurePursuitParams {
            lookahead_gain: 0.8,
            min_lookahead: Some(6.0),
            alpha_by_arccos,
            ..PurePursuitParams::DEFAULT
        };
        PurePursuit::new(CAR, params).unwrap()
    };
    // The least lookahead, and the one that grows with the speed.
    for (speed, lookahead) in [(2.0, 6.0), (7.5, 6.0), (10.0, 8.0), (15.0, 12.0)] {
        for left in [-4.0, -0.5, 0.0, 1.0, 5.0_f64] {
            for heading in [-0.6, 0.0, 0.2_f64] {
                let place = beside(30.0, left, heading, speed);
                // The point on the path that far off, seen from the vehicle.
                let bearing = -(left / lookahead).asin() - heading;
                let expected = (6.0 * bearing.sin() / lookahead).atan();
                assert_close(angle(law(false), place), expected);
                // Straight ahead an arc cosine loses half of the digits.
                assert!((angle(law(true), place) - expected).abs() < 1e-6);
            }
        }
    }
    // A point behind is turned to as one abeam.
    let behind = beside(30.0, 0.0, 2.5, 5.0);
    assert_close(angle(law(false), behind), -1.0_f64.atan());
    let behind = beside(30.0, 0.0, -2.5, 5.0);
    assert_close(angle(law(false), behind), 1.0_f64.atan());
}

/// Algorithm 1: of the angles about the last one, the one whose location a step later lies closest
/// to the lookahead point.
#[test]
fn test_pop_takes_the_candidate_predicted_closest_to_the_lookahead_point() {
    let params = PopParams {
        lookahead_gain: 0.3,
        min_lookahead: Some(5.0),
        steer_span: 0.06,
        candidate_count: 13,
        ..PopParams::DEFAULT
    };
    let places: Vec<_> = (0..30_u32)
        .map(|k| {
            let wave = |rate: f64| (rate * f64::from(k)).sin();
            (1.5 * wave(0.3), 0.4 * wave(0.17), 8.0 + 6.0 * wave(0.5))
        })
        .collect();
    let steps: Vec<_> = places
        .iter()
        .map(|&(left, heading, speed)| beside(30.0, left, heading, speed))
        .collect();
    let found = angles(Pop::new(CAR, params).unwrap(), &steps);
    let mut last = 0.0;
    for (&(left, heading, speed), found) in places.iter().zip(found) {
        // The front axle, and the point on the path ahead of it.
        let front = left + 3.0 * heading.sin();
        let lookahead = 5.0 + 0.3 * speed;
        let ahead = (lookahead * lookahead - front * front).sqrt();
        let distance = |steer: f64| {
            let travel = 0.1 * speed;
            let (sin, cos) = (heading + steer).sin_cos();
            (travel * cos - ahead).hypot(travel * sin + front)
        };
        let candidates = (-6..=6).map(|k| last + 0.01 * f64::from(k));
        let best = candidates.min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
        last = best.unwrap();
        assert_close(found, last);
    }
}

#[test]
fn test_stanley_takes_off_the_heading_and_the_error_of_the_front_axle() {
    let law = |heading_behind, smoothing_length| {
        let params = StanleyParams {
            cross_track_gain: 1.5,
            speed_gain: 1.3,
            softening: Some(0.5),
            heading_behind,
            smoothing_length: Some(smoothing_length),
            ..StanleyParams::DEFAULT
        };
        Stanley::new(CAR, params).unwrap()
    };
    for (left, heading, speed) in [(1.0, 0.2, 5.0), (-0.4, 0.5, 12.0), (0.3, -0.3, 1.0_f64)] {
        let error = left + 3.0 * f64::sin(heading);
        let expected = -(heading + (1.5 * error / (0.5 + 1.3 * speed)).atan());
        let place = beside(30.0, left, heading, speed);
        // On a straight path it does not matter where its heading is taken.
        for law in [law(false, 0.0), law(true, 0.0), law(false, 2.0)] {
            assert_close(angle(law, place), expected);
        }
    }
}

#[test]
fn test_pid_weighs_the_error_its_sum_and_its_rate() {
    let law = |integral_with_dt, smoothing_length, derivative_filter| {
        let params = PidParams {
            kp: Some(0.2),
            ki: Some(0.05),
            kd: Some(0.1),
            buffer_length: 2,
            integral_with_dt,
            smoothing_length: Some(smoothing_length),
            derivative_filter,
            ..PidParams::DEFAULT
        };
        Pid::new(CAR, params).unwrap()
    };
    let places = [
        beside(30.0, 0.5, 0.1, 5.0),
        beside(30.5, 0.4, -0.2, 5.0),
        beside(31.0, 0.2, -0.1, 5.0),
        // At rest nothing is summed.
        beside(31.0, 0.2, -0.1, 0.0),
    ];
    let error = |left: f64, heading: f64| left + 3.0 * heading.sin();
    let errors = [
        error(0.5, 0.1),
        error(0.4, -0.2),
        error(0.2, -0.1),
        error(0.2, -0.1),
    ];
    let summed = [
        errors[0],
        errors[0] + errors[1],
        errors[1] + errors[2],
        errors[1] + errors[2],
    ];
    for (integral_with_dt, weight) in [(true, 0.1), (false, 1.0)] {
        // The rate of the error is that of the axle across the path, which is straight.
        for (smoothing_length, filter) in [(0.0, 0.0), (6.0, 0.0), (0.0, 0.3), (6.0, 0.3)] {
            let angles = angles(law(integral_with_dt, smoothing_length, filter), &places);
            let mut rate = 0.0;
            for (k, &angle) in angles.iter().enumerate() {
                if k > 0 {
                    rate += (errors[k] - errors[k - 1] - rate * 0.1) / (filter + 0.1);
                }
                let expected = -(0.2 * errors[k] + 0.05 * weight * summed[k] + 0.1 * rate);
                assert_close(angle, expected);
            }
        }
    }
}

/// Along a bend at a constant distance from it the error does not change, however far a step goes.
#[test]
fn test_rate_of_a_pid_is_none_at_a_constant_distance_from_a_bend() {
    let point =
        |angle: f64, radius: f64| (50.0 + radius * angle.cos(), -20.0 + radius * angle.sin());
    let (x, y): (Vec<f64>, Vec<f64>) = (0..1440)
        .map(|k| point(f64::from(k) * std::f64::consts::TAU / 1440.0, 20.0))
        .unzip();
    let path = Path::new(&x, &y, None, true).unwrap();
    let params = PidParams {
        kp: Some(0.0),
        ki: Some(0.0),
        kd: Some(0.5),
        smoothing_length: Some(2.0),
        ..PidParams::DEFAULT
    };
    let tracker = Tracker::of(Pid::new(CAR, params).unwrap());
    let mut state = tracker.initial_state();
    for k in 0..20 {
        let angle = 0.1 * f64::from(k);
        let (front_x, front_y) = point(angle, 19.5);
        let yaw = angle + std::f64::consts::FRAC_PI_2;
        let vehicle = VehicleState {
            x: front_x - 3.0 * yaw.cos(),
            y: front_y - 3.0 * yaw.sin(),
            yaw,
            speed: 19.5,
        };
        let command = tracker
            .step(&path.view(), &mut state, vehicle, 0.1, Reported::NOTHING)
            .unwrap();
        assert!((command.cross_track_error - 0.5).abs() < 1e-3);
        assert!(command.steer.abs() < 0.02, "{k}: {command:?}");
    }
}

/// What a PID has summed up does not count for a vehicle that is off its path.
#[test]
fn test_pid_forgets_off_the_path() {
    let params = PidParams {
        kp: Some(0.0),
        ki: Some(0.05),
        kd: Some(0.01),
        lost_distance: Some(3.0),
        smoothing_length: Some(0.0),
        derivative_filter: 0.0,
        ..PidParams::DEFAULT
    };
    let lefts = [0.5, 0.7, 5.0, 1.0];
    let places = lefts.map(|left| beside(30.0, left, 0.0, 5.0));
    let found = angles(Pid::new(CAR, params).unwrap(), &places);
    let expected = [
        (0.5, 0.0),
        (0.5 + 0.7, 0.7 - 0.5),
        (5.0, 0.0),
        (5.0 + 1.0, 1.0 - 5.0),
    ];
    for (found, (sum, change)) in found.into_iter().zip(expected) {
        assert_close(found, -(0.05 * 0.1 * sum + 0.01 * change / 0.1));
    }
}

/// Waypoints that zigzag by centimetres: the segments lead to and fro, the path straight on.
#[test]
fn test_smoothed_heading_of_a_zigzag_is_that_of_its_way() {
    let x: Vec<f64> = (0..200).map(|k| 0.25 * f64::from(k)).collect();
    let y: Vec<f64> = (0..200)
        .map(|k| if k % 2 == 0 { 0.03 } else { -0.03 })
        .collect();
    let path = Path::new(&x, &y, None, false).unwrap();
    let along = |x: f64| VehicleState {
        x: x - 3.0,
        y: 0.0,
        yaw: 0.0,
        speed: 5.0,
    };
    let stanley = |smoothing_length| {
        let params = StanleyParams {
            cross_track_gain: 0.0,
            smoothing_length: Some(smoothing_length),
            ..StanleyParams::DEFAULT
        };
        let tracker = Tracker::of(Stanley::new(CAR, params).unwrap());
        let mut state = tracker.initial_state();
        let path = path.view();
        // Between two waypoints, where the path falls.
        tracker
            .steer(&path, &mut state, along(20.125), 0.1, Reported::NOTHING)
            .unwrap()
    };
    assert_close(stanley(0.0).abs(), f64::atan2(0.06, 0.25));
    assert!(stanley(2.0).abs() < 0.03, "{}", stanley(2.0));
    let params = PidParams {
        kp: Some(0.0),
        ki: Some(0.0),
        kd: Some(1.0),
        smoothing_length: Some(2.0),
        ..PidParams::DEFAULT
    };
    let tracker = Tracker::of(Pid::new(CAR, params).unwrap());
    let mut state = tracker.initial_state();
    for k in 0..20 {
        let place = along(20.0 + 0.1 * f64::from(k));
        let steer = tracker
            .steer(&path.view(), &mut state, place, 0.1, Reported::NOTHING)
            .unwrap();
        assert!(steer.abs() < 0.05, "{k}: {steer}");
    }
}

#[test]
fn test_controllers_tell_when_they_find_no_lookahead_point_and_when_the_wheels_end() {
    let car = Vehicle {
        max_steer: 0.2,
        ..CAR
    };
    let path = straight();
    let status =
        |tracker: &dyn Fn(VehicleState) -> Status, left: f64| tracker(beside(30.0, left, 0.0, 5.0));
    let pop = |place| {
        let tracker = Tracker::of(Pop::new(car, PopParams::DEFAULT).unwrap());
        let mut state = tracker.initial_state();
        let mut step = || {
            tracker
                .step(&path.view(), &mut state, place, 0.1, Reported::NOTHING)
                .unwrap()
        };
        (0..10).map(|_| step().status).last().unwrap()
    };
    let pursuit = |place| {
        let law = PurePursuit::new(car, PurePursuitParams::DEFAULT).unwrap();
        let tracker = Tracker::of(law);
        let mut state = tracker.initial_state();
        tracker
            .step(&path.view(), &mut state, place, 0.1, Reported::NOTHING)
            .unwrap()
            .status
    };
    for tracker in [&pop as &dyn Fn(VehicleState) -> Status, &pursuit] {
        let near = status(tracker, 0.1);
        assert!(!near.contains(Status::LOOKAHEAD_LOST) && !near.contains(Status::SATURATED));
        let lost = status(tracker, 20.0);
        assert!(lost.contains(Status::LOOKAHEAD_LOST) && lost.contains(Status::SATURATED));
    }
}

#[test]
fn test_controllers_of_a_late_vehicle_adapt_by_themselves() {
    let late = Vehicle {
        dead_time: 0.2,
        ..CAR
    };
    let adapts = |car| {
        let law = Stanley::new(car, StanleyParams::DEFAULT).unwrap();
        Tracker::of(law).adapt().is_some()
    };
    assert!(adapts(late) && !adapts(CAR));
}

#[test]
fn test_controllers_steer_at_most_the_largest_angle() {
    let far = beside(30.0, 5.0, 1.0, 5.0);
    let stanley = Stanley::new(CAR, StanleyParams::DEFAULT).unwrap();
    let pid = PidParams {
        kp: Some(10.0),
        ..PidParams::DEFAULT
    };
    assert_close(angle(stanley, far), -1.22);
    assert_close(angle(Pid::new(CAR, pid).unwrap(), far), -1.22);
}

#[test]
fn test_state_that_a_pid_cannot_reach_is_refused() {
    let law = Pid::new(CAR, PidParams::DEFAULT).unwrap();
    let good = law.initial_state();
    assert!(law.check_state(&good).is_ok());
    let far = PidState {
        previous_error: Some(1e300),
        ..good
    };
    let jumped = PidState {
        previous_position: Some(Point::new(0.0, -1e300)),
        ..good
    };
    let quick = PidState {
        rate: f64::NAN,
        ..good
    };
    let far_off = PidState {
        previous_position: Some(Point::new(3.9e9, 0.0)),
        ..good
    };
    assert!(law.check_state(&far_off).is_ok());
    let shorter = PidParams {
        buffer_length: 7,
        ..PidParams::DEFAULT
    };
    let other = Pid::new(CAR, shorter).unwrap().initial_state();
    for (bad, field) in [
        (far, "law.previous_error"),
        (jumped, "law.previous_position"),
        (quick, "law.rate"),
        (other, "law.buffer.length"),
    ] {
        assert_eq!(law.check_state(&bad).unwrap_err().field, field);
    }
    let law = PurePursuit::new(CAR, PurePursuitParams::DEFAULT).unwrap();
    let bad = PurePursuitState {
        previous_alpha: 3.2,
    };
    assert_eq!(
        law.check_state(&bad).unwrap_err().field,
        "law.previous_alpha"
    );
}

#[test]
fn test_kinematic_bicycle_gains_speed_by_its_acceleration() {
    let before = beside(30.0, 0.4, 0.2, 5.0);
    let after = kinematic_bicycle(before, 0.1, 1.5, 3.0, 0.2);
    assert_close(after.speed, 5.0 + 1.5 * 0.2);
    assert_close(after.yaw, before.yaw + 5.0 * 0.2 * 0.1_f64.tan() / 3.0);
}

#[test]
fn test_tracked_points_are_the_axles_that_the_equations_are_about() {
    let car = Vehicle {
        rear_axle: -1.25,
        ..CAR
    };
    let stanley = Stanley::new(car, StanleyParams::DEFAULT).unwrap();
    let pursuit = PurePursuit::new(car, PurePursuitParams::DEFAULT).unwrap();
    assert_close(Tracker::of(stanley).tracked_point(), -1.25 + 3.0);
    assert_close(Tracker::of(pursuit).tracked_point(), -1.25);
    let params = PurePursuitParams {
        search_distance: Some(7.5),
        ..PurePursuitParams::DEFAULT
    };
    let follow = *Tracker::of(PurePursuit::new(car, params).unwrap()).follow();
    assert_close(follow.search_distance, 7.5);
}

#[test]
fn test_conditions_are_added_to_a_status() {
    let mut status = Status::SATURATED;
    status |= Status::END_OF_PATH;
    assert_eq!(status, Status::SATURATED | Status::END_OF_PATH);
    assert_eq!(format!("{status:?}"), format!("{status}"));
    // Three of the conditions are faults, wherever they stand.
    let faults = Status::INPUT_LOST | Status::DEVIATING | Status::IMPLAUSIBLE;
    assert_eq!(status.faults(), Status::OK);
    assert_eq!((status | faults).faults(), faults);
}
