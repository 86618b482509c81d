//! The core's plain functions, with their arguments checked.

use popsteer_core::bounds::{MAX_COORDINATE, MAX_YAW};
use popsteer_core::error::{InputError, input_in_range as checked};
use popsteer_core::math::PI;

use popsteer_core::vehicle::bicycle;
use popsteer_core::vehicle::state::checked_dt;
use popsteer_core::{Point, VehicleState, geometry, math};
use pyo3::prelude::*;

use crate::errors::Raises;

/// A position whose coordinates are within the bounds.
pub(crate) fn checked_point(x: f64, y: f64) -> Result<Point, InputError> {
    checked("x", x, -MAX_COORDINATE, MAX_COORDINATE)?;
    checked("y", y, -MAX_COORDINATE, MAX_COORDINATE)?;
    Ok(Point::new(x, y))
}

/// Bring an angle into [-pi, pi] by whole turns.
///
/// Parameters
/// ----------
/// angle : float
///     Angle [rad], within 1e6.
///
/// Returns
/// -------
/// float
///     The same direction, in [-pi, pi]; an angle already there comes back unchanged.
///
/// Raises
/// ------
/// InputError
///     If the angle is not finite or beyond its bound.
///
/// Examples
/// --------
/// >>> popsteer.paper.wrap(7.0)
/// 0.7168146928204138
#[pyfunction]
#[pyo3(signature = (angle, /))]
pub(crate) fn wrap(angle: f64) -> Raises<f64> {
    Ok(math::wrap(checked("angle", angle, -MAX_YAW, MAX_YAW)?))
}

/// Limit a number to a range.
///
/// Parameters
/// ----------
/// value : float
///     The number.
/// low, high : float
///     Ends of the range, ``low <= high``.
///
/// Returns
/// -------
/// float
///     `low`, `value` or `high`.
///
/// Examples
/// --------
/// >>> popsteer.paper.saturate(3.0, -1.0, 1.0)
/// 1.0
#[pyfunction]
#[pyo3(signature = (value, low, high, /))]
pub(crate) fn saturate(value: f64, low: f64, high: f64) -> f64 {
    math::saturate(value, low, high)
}

/// Measure the Euclidean distance of two points, the paper's Equation 4.
///
/// Parameters
/// ----------
/// a, b : tuple of float
///     Points (x, y) [m], within 1e9.
///
/// Returns
/// -------
/// float
///     Their distance [m].
///
/// Raises
/// ------
/// InputError
///     If a coordinate is not finite or beyond its bound.
///
/// Examples
/// --------
/// >>> popsteer.paper.get_distance((0.0, 0.0), (3.0, 4.0))
/// 5.0
#[pyfunction]
#[pyo3(signature = (a, b, /))]
pub(crate) fn get_distance(a: (f64, f64), b: (f64, f64)) -> Raises<f64> {
    let (a, b) = (checked_point(a.0, a.1)?, checked_point(b.0, b.1)?);
    Ok(geometry::get_distance(a, b))
}

fn checked_vehicle(
    x: f64,
    y: f64,
    yaw: f64,
    speed: f64,
    steer: f64,
    dt: f64,
) -> Result<VehicleState, InputError> {
    let vehicle = VehicleState { x, y, yaw, speed }.checked()?;
    checked("steer", steer, -PI, PI)?;
    checked_dt(dt)?;
    Ok(vehicle)
}

/// Predict the vehicle's location one interval ahead, as POP does (the paper's Equation 6).
///
/// ``x + cos(yaw + steer) dt speed``, ``y + sin(yaw + steer) dt speed``.
///
/// Parameters
/// ----------
/// x, y : float
///     Position [m].
/// yaw : float
///     Heading [rad].
/// speed : float
///     Speed [m/s].
/// steer : float
///     Steering angle [rad].
/// dt : float
///     Interval [s].
///
/// Returns
/// -------
/// tuple of float
///     Predicted (x, y) [m].
///
/// Raises
/// ------
/// InputError
///     If a number is not finite or beyond its bound.
///
/// Examples
/// --------
/// >>> popsteer.paper.get_predicted_location(0.0, 0.0, 0.0, 10.0, 0.0, 0.05)
/// (0.5, 0.0)
#[pyfunction]
#[pyo3(signature = (x, y, yaw, speed, steer, dt, /))]
pub(crate) fn get_predicted_location(
    x: f64,
    y: f64,
    yaw: f64,
    speed: f64,
    steer: f64,
    dt: f64,
) -> Raises<(f64, f64)> {
    let vehicle = checked_vehicle(x, y, yaw, speed, steer, dt)?;
    let location = bicycle::get_predicted_location(vehicle, steer, dt);
    Ok((location.x, location.y))
}

/// Apply the paper's state-transition equation whole (Equation 6).
///
/// As printed: the control adds to speed and yaw rate without ``dt``.
///
/// Parameters
/// ----------
/// state : tuple of float
///     (x, y, yaw, speed, yaw rate) [m, m, rad, m/s, rad/s].
/// control : tuple of float
///     (longitudinal, lateral) control, added to speed and yaw rate.
/// steer : float
///     Steering angle [rad] in the direction of travel, ``yaw + steer``.
/// dt : float
///     Interval [s].
///
/// Returns
/// -------
/// tuple of float
///     The state one interval later.
///
/// Raises
/// ------
/// InputError
///     If a number is not finite or beyond its bound.
///
/// Examples
/// --------
/// >>> popsteer.paper.state_transition((0.0, 0.0, 0.0, 10.0, 0.1), (0.5, 0.0), 0.0, 0.5)
/// (5.0, 0.0, 0.05, 10.5, 0.1)
#[pyfunction]
#[pyo3(signature = (state, control, steer, dt, /))]
pub(crate) fn state_transition(
    state: (f64, f64, f64, f64, f64),
    control: (f64, f64),
    steer: f64,
    dt: f64,
) -> Raises<(f64, f64, f64, f64, f64)> {
    let (x, y, yaw, speed, yaw_rate) = state;
    checked_vehicle(x, y, yaw, speed, steer, dt)?;
    for (field, value) in [
        ("yaw_rate", yaw_rate),
        ("longitudinal", control.0),
        ("lateral", control.1),
    ] {
        checked(field, value, -1e6, 1e6)?;
    }
    let next = bicycle::state_transition(
        [x, y, yaw, speed, yaw_rate].into(),
        [control.0, control.1].into(),
        steer,
        dt,
    );
    let [x, y, yaw, speed, yaw_rate] = next.into();
    Ok((x, y, yaw, speed, yaw_rate))
}

/// Move the kinematic bicycle about its rear axle by one interval.
///
/// ``yaw rate = speed tan(steer) / wheelbase``; the position moves along the heading of
/// mid-step, the speed changes at the end.
///
/// Parameters
/// ----------
/// x, y : float
///     Position of the rear axle [m].
/// yaw : float
///     Heading [rad].
/// speed : float
///     Speed [m/s].
/// steer : float
///     Steering angle [rad].
/// acceleration : float
///     Acceleration [m/s^2].
/// wheelbase : float
///     Distance of the axles [m].
/// dt : float
///     Interval [s].
///
/// Returns
/// -------
/// tuple of float
///     (x, y, yaw, speed) one interval later.
///
/// Raises
/// ------
/// InputError
///     If a number is not finite or beyond its bound.
///
/// Examples
/// --------
/// >>> popsteer.paper.kinematic_bicycle(0.0, 0.0, 0.0, 10.0, 0.0, 1.0, 3.0, 0.5)
/// (5.0, 0.0, 0.0, 10.5)
#[pyfunction]
#[pyo3(signature = (x, y, yaw, speed, steer, acceleration, wheelbase, dt, /))]
pub(crate) fn kinematic_bicycle(
    x: f64,
    y: f64,
    yaw: f64,
    speed: f64,
    steer: f64,
    acceleration: f64,
    wheelbase: f64,
    dt: f64,
) -> Raises<(f64, f64, f64, f64)> {
    let vehicle = checked_vehicle(x, y, yaw, speed, steer, dt)?;
    checked("acceleration", acceleration, -1e6, 1e6)?;
    checked("wheelbase", wheelbase, 1e-3, 1e3)?;
    let next = bicycle::kinematic_bicycle(vehicle, steer, acceleration, wheelbase, dt);
    Ok((next.x, next.y, next.yaw, next.speed))
}
