use super::bicycle::{get_predicted_location, kinematic_bicycle};
use super::state::{VehicleState, checked_dt, period};
use super::timed::{Timed, clipped};
use super::*;
use crate::math::{PI, cos, exp, saturate, sin, sqrt, tan};
use alloc::vec::Vec;

#[test]
fn test_vehicle_bad_field_is_named() {
    assert_eq!(Vehicle::DEFAULT.checked(), Ok(Vehicle::DEFAULT));
    for bad in [f64::NAN, f64::INFINITY, -1e7] {
        let mut car = Vehicle {
            drive_lag: bad,
            ..Vehicle::DEFAULT
        };
        assert_eq!(car.checked().unwrap_err().field, "drive_lag");
        car.no_slip_point = Some(bad);
        assert_eq!(car.checked().unwrap_err().field, "no_slip_point");
        car.wheelbase = bad;
        assert_eq!(car.checked().unwrap_err().field, "wheelbase");
    }
}

#[test]
fn test_vehicle_points_are_told_from_the_pose() {
    let car = Vehicle {
        rear_axle: -1.25,
        ..Vehicle::DEFAULT
    };
    assert_eq!((car.front_axle(), car.no_slip()), (1.75, -1.25));
    let slipping = Vehicle {
        no_slip_point: Some(0.0),
        turning_wheelbase: Some(3.5),
        understeer: 0.01,
        ..car
    };
    assert_eq!(
        (slipping.no_slip(), slipping.turning_length(10.0)),
        (0.0, 4.5)
    );
}

#[test]
fn test_antenna_beside_and_above_is_where_a_rotation_about_the_road_puts_it() {
    let car = Vehicle {
        antenna_left: 0.5,
        antenna_height: 3.0,
        ..Vehicle::DEFAULT
    };
    // z up: a roll to the right turns left into up, and up into right.
    let roll: f64 = 0.08;
    let left = 0.5 * roll.cos() - 3.0 * roll.sin();
    assert!((car.antenna_offset(roll) - left).abs() < 1e-15);
    assert!(car.antenna_offset(roll) < car.antenna_offset(0.0));
    let point = VehicleState {
        x: 1.0,
        y: 2.0,
        yaw: 0.5 * PI,
        speed: 3.0,
    };
    // Heading along y, left is against x.
    let antenna = point.left(0.5);
    assert!((antenna.x - 0.5).abs() < 1e-15 && (antenna.y - 2.0).abs() < 1e-15);
    let back = antenna.left(-0.5);
    assert!((back.x - point.x).abs() < 1e-15 && back.speed.to_bits() == point.speed.to_bits());
    assert_eq!(point.left(0.0), point);
}

#[test]
fn test_state_bad_field_is_named() {
    let good = VehicleState {
        x: 1.0,
        y: 2.0,
        yaw: 0.0,
        speed: -3.0,
    };
    assert_eq!(good.checked(), Ok(good));
    for bad in [f64::NAN, f64::INFINITY, 1e308] {
        let field = |state: VehicleState| state.checked().unwrap_err().field;
        assert_eq!(field(VehicleState { x: bad, ..good }), "x");
        assert_eq!(field(VehicleState { y: -bad, ..good }), "y");
        assert_eq!(field(VehicleState { yaw: bad, ..good }), "yaw");
        assert_eq!(field(VehicleState { speed: bad, ..good }), "speed");
    }
    for bad in [0.0, -0.05, f64::MIN_POSITIVE, 1e4] {
        assert_eq!(checked_dt(bad).unwrap_err().field, "dt");
        assert_eq!(period(bad), Ok(None));
    }
    for bad in [f64::NAN, f64::INFINITY, -f64::INFINITY] {
        assert_eq!(period(bad).unwrap_err().field, "dt");
    }
    assert_eq!([1e-6, 1e3].map(period), [Ok(Some(1e-6)), Ok(Some(1e3))]);
}

fn car(steer_lag: f64, max_steer_rate: Option<f64>) -> Vehicle {
    Vehicle {
        steer_lag,
        max_steer_rate,
        ..Vehicle::DEFAULT
    }
}

#[test]
fn test_move_wheel_is_a_first_order_response_with_a_limited_rate() {
    let lagging = car(0.1, None).move_wheel(0.0, 1.0, 0.1);
    assert!((lagging.wheel - (1.0 - exp(-1.0))).abs() < 1e-15);
    let slow = car(0.0, Some(0.5));
    assert_eq!(slow.move_wheel(0.0, 1.0, 0.1).wheel, 0.05);
    assert_eq!(slow.move_wheel(0.0, 0.01, 0.1).wheel, 0.01);
    // Against the differential equation in small steps.
    let both = car(0.2, Some(0.4));
    for (start, command, time) in [(0.0, 0.3, 0.5), (0.1, -0.6, 2.5), (0.2, 0.25, 0.3)] {
        let (mut wheel, mut sum) = (start, 0.0);
        let step = time / 1e5;
        for _ in 0..100_000 {
            let rate = saturate((command - wheel) / 0.2, -0.4, 0.4);
            sum += (wheel + 0.5 * rate * step) * step;
            wheel += rate * step;
        }
        let moved = both.move_wheel(start, command, time);
        assert!((moved.wheel - wheel).abs() < 1e-5, "{moved:?} {wheel}");
        assert!((moved.mean - sum / time).abs() < 1e-5, "{moved:?}");
    }
}

#[test]
fn test_predicted_location_is_that_of_equation_6() {
    let at = |yaw, speed, steer, dt| {
        let (x, y) = (3.0, -2.0);
        let location = get_predicted_location(VehicleState { x, y, yaw, speed }, steer, dt);
        (location.x, location.y)
    };
    // The paper's first two rows: x + cos(yaw + steer) dt speed, y + sin(yaw + steer) dt speed.
    for (yaw, steer) in [(0.7, -0.2), (-PI, PI), (1e6, -PI), (2.0, 1.0)] {
        for (speed, dt) in [(12.0, 0.05), (-3.0, 1e3), (1e4, 1e-6)] {
            let heading = yaw + steer;
            let expected = (
                3.0 + cos(heading) * dt * speed,
                -2.0 + sin(heading) * dt * speed,
            );
            assert_eq!(at(yaw, speed, steer, dt), expected, "{yaw} {steer}");
        }
    }
    // Straight on, backwards, and at a stand.
    assert_eq!(at(0.0, 10.0, 0.0, 0.5), (8.0, -2.0));
    assert_eq!(at(0.3, -10.0, -0.3, 0.5), (-2.0, -2.0));
    assert_eq!(at(1.0, 0.0, 0.5, 0.5), (3.0, -2.0));
    let (x, y) = at(PI, 4.0, -0.5 * PI, 0.25);
    assert!((x - 3.0).abs() < 1e-15 && (y + 1.0).abs() < 1e-15);
}

#[test]
fn test_kinematic_bicycle_drives_its_circle() {
    let mut vehicle = VehicleState {
        x: 0.0,
        y: 0.0,
        yaw: 0.0,
        speed: 5.0,
    };
    let (steer, wheelbase): (f64, f64) = (0.2, 3.0);
    let radius = wheelbase / tan(steer);
    for _ in 0..1000 {
        vehicle = kinematic_bicycle(vehicle, steer, 0.0, wheelbase, 0.01);
        let (dx, dy) = (vehicle.x, vehicle.y - radius);
        assert!((sqrt(dx * dx + dy * dy) - radius).abs() < 1e-4);
    }
}

#[test]
fn test_kinematic_bicycle_moves_along_the_heading_of_mid_step() {
    let (x, y, yaw) = (3.0, -2.0, 0.7);
    for (speed, steer) in [(12.0, -0.2), (-3.0, 1.4), (1e4, -PI), (0.0, 0.3)] {
        for (acceleration, wheelbase, dt) in [(1.5, 3.0, 0.05), (-1e6, 1e-3, 1e3), (0.0, 1e3, 1e-6)]
        {
            let before = VehicleState { x, y, yaw, speed };
            let after = kinematic_bicycle(before, steer, acceleration, wheelbase, dt);
            let turn = speed * dt * tan(steer) / wheelbase;
            let middle = yaw + 0.5 * turn;
            let expected = VehicleState {
                x: x + speed * dt * cos(middle),
                y: y + speed * dt * sin(middle),
                yaw: yaw + turn,
                speed: speed + acceleration * dt,
            };
            assert_eq!(after, expected, "{speed} {steer} {dt}");
        }
    }
}

#[test]
fn test_ring_beyond_its_capacity_forgets_the_oldest() {
    let mut timed = Timed::<3>::EMPTY;
    for k in 0..5 {
        timed.push(f64::from(k), 0.25);
    }
    let kept: Vec<_> = timed.iter().collect();
    assert_eq!(kept, [(2.0, 0.25), (3.0, 0.25), (4.0, 0.25)]);
    assert_eq!(Timed::restore("field", kept.into_iter()), Ok(timed));
    let refused = Timed::<3>::restore("field", [(0.0, 1.0); 4].into_iter()).unwrap_err();
    assert_eq!((refused.field, refused.value), ("field", 4.0));
}

#[test]
fn test_short_angles_are_joined_to_their_mean() {
    let mut timed = Timed::<3>::EMPTY;
    for (angle, duration) in [(1.0, 0.25), (4.0, 0.5), (2.0, 0.25)] {
        timed.push_or_join(angle, duration, 0.75);
    }
    assert!(timed.iter().eq([(3.0, 0.75), (2.0, 0.25)]));
}

#[test]
fn test_angles_that_do_not_last_are_none_and_the_shortest_have_a_mean() {
    let (mut timed, least) = (Timed::<3>::EMPTY, f64::from_bits(1));
    for (angle, duration) in [(1.0, 0.0), (1.0, 0.0), (1.5, least), (1.5, least)] {
        timed.push_or_join(angle, duration, 0.75);
    }
    assert!(timed.iter().eq([(1.5, 2.0 * least)]));
}

#[test]
fn test_take_empties_the_ring_in_order() {
    let mut timed = Timed::<3>::EMPTY;
    timed.push(1.0, 0.5);
    timed.push(2.0, 0.25);
    assert_eq!(timed.take(0.125), Some((1.0, 0.125)));
    assert_eq!(timed.take(1.0), Some((1.0, 0.375)));
    assert_eq!(timed.take(0.25), Some((2.0, 0.25)));
    assert_eq!(timed.take(1.0), None);
}

#[test]
fn test_clipped_lasts_as_long_as_is_wanted() {
    let timed = [(1.0, 0.25), (2.0, 0.5)];
    let within = |time| clipped(timed.into_iter(), time).collect::<Vec<_>>();
    assert_eq!(within(0.0), []);
    assert_eq!(within(0.25), [(1.0, 0.25)]);
    assert_eq!(within(0.5), [(1.0, 0.25), (2.0, 0.25)]);
    assert_eq!(within(9.0), timed);
}
