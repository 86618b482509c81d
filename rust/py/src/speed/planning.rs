//! Planning for `popsteer.planning`, which checks shapes and words the results.

use std::sync::Arc;

use numpy::{AsSliceError, PyArray1, PyReadonlyArray1};
use popsteer_core::error::config_in_range;
use popsteer_core::speed::{
    Course, Limit, OverSpeed, SpeedLimits, defaults, path_curvature as curvature_of,
    plan_speeds as plan,
};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};

use crate::errors::Raises;
use crate::path::PyPath;
use crate::vehicle::PyVehicle;

type Floats<'py> = PyReadonlyArray1<'py, f64>;
type Planned<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<u8>>);

/// Curvature at each waypoint of a path [1/m], smoothed over a length [m].
#[pyfunction(name = "_path_curvature")]
pub(crate) fn path_curvature<'py>(
    py: Python<'py>,
    path: &PyPath,
    smoothing_length: f64,
) -> Raises<Bound<'py, PyArray1<f64>>> {
    let length = config_in_range("smoothing_length", smoothing_length, 1e-3, 1e3)?;
    Ok(PyArray1::from_vec(py, curvature_of(&path.0.view(), length)))
}

/// A path with other reference speeds [m/s], and all else as it is.
#[pyfunction(name = "_with_speed")]
pub(crate) fn with_speed(path: &PyPath, speed: Floats<'_>) -> Raises<PyPath> {
    let found = path.0.with_speed(speed.as_slice()?)?;
    Ok(PyPath::new(Arc::new(found)))
}

/// At which waypoints of a path the vehicle changes its direction.
#[pyfunction(name = "_path_cusps")]
pub(crate) fn path_cusps<'py>(py: Python<'py>, path: &PyPath) -> Bound<'py, PyArray1<bool>> {
    PyArray1::from_vec(py, path.0.view().cusps())
}

/// The limits of the speed that stand for those that neither plan nor vehicle has, by name; the
/// deceleration of a stop without a plan, the share of the lateral acceleration for bends, and the
/// smoothing lengths in wheelbases.
pub(crate) fn speed_defaults(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    [
        ("max_speed", defaults::MAX_SPEED),
        (
            "max_lateral_acceleration",
            defaults::MAX_LATERAL_ACCELERATION,
        ),
        ("max_acceleration", defaults::MAX_ACCELERATION),
        ("max_deceleration", defaults::MAX_DECELERATION),
        ("brake_deceleration", defaults::BRAKE_DECELERATION),
        ("stop_deceleration", defaults::STOP_DECELERATION),
        ("least_on_slopes", defaults::LEAST_ON_SLOPES),
        ("gravity", defaults::GRAVITY),
        ("bend_share", defaults::BEND_SHARE),
        ("smoothing", defaults::SMOOTHING),
        ("sharp", defaults::SHARP),
    ]
    .into_py_dict(py)
}

/// Greatest speed at each waypoint [m/s], and the number of what limits it there.
#[pyfunction(name = "_plan_speeds")]
#[pyo3(signature = (
    curvature, spacing, *, sharp, closed, cusps, speed_limits, grade, start_speed, end_speed, max_speed,
    max_lateral_acceleration, acceleration, deceleration, longitudinal_grip, exponent, vehicle
))]
pub(crate) fn plan_speeds<'py>(
    py: Python<'py>,
    curvature: Floats<'py>,
    spacing: Floats<'py>,
    sharp: Floats<'py>,
    closed: bool,
    cusps: Option<PyReadonlyArray1<'py, bool>>,
    speed_limits: Option<Floats<'py>>,
    grade: Option<Floats<'py>>,
    start_speed: Option<f64>,
    end_speed: Option<f64>,
    max_speed: f64,
    max_lateral_acceleration: f64,
    acceleration: (Floats<'py>, Floats<'py>),
    deceleration: (Floats<'py>, Floats<'py>),
    longitudinal_grip: Option<f64>,
    exponent: f64,
    vehicle: &PyVehicle,
) -> Raises<Planned<'py>> {
    let limits = SpeedLimits {
        max_speed,
        max_lateral_acceleration,
        acceleration: over_speed(&acceleration)?,
        deceleration: over_speed(&deceleration)?,
        longitudinal_grip,
        exponent,
        vehicle: vehicle.0,
    };
    let course = Course {
        curvature: curvature.as_slice()?,
        sharp: Some(sharp.as_slice()?),
        spacing: spacing.as_slice()?,
        closed,
        cusps: cusps.as_ref().map(PyReadonlyArray1::as_slice).transpose()?,
        speed_limits: speed_limits.as_ref().map(Floats::as_slice).transpose()?,
        grade: grade.as_ref().map(Floats::as_slice).transpose()?,
        start_speed,
        end_speed,
    };
    let mut speed = vec![0.0; course.curvature.len()];
    let mut limit = vec![Limit::default(); course.curvature.len()];
    plan(&course, &limits, &mut speed, &mut limit)?;
    let codes = limit.into_iter().map(Limit::code).collect();
    Ok((PyArray1::from_vec(py, speed), PyArray1::from_vec(py, codes)))
}

fn over_speed<'a>(table: &'a (Floats<'_>, Floats<'_>)) -> Result<OverSpeed<'a>, AsSliceError> {
    Ok(OverSpeed {
        speeds: table.0.as_slice()?,
        values: table.1.as_slice()?,
    })
}
