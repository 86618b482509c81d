//! The wheels along a log, for the identification.

use numpy::{PyArray1, PyReadonlyArray1};
use popsteer_core::vehicle::Vehicle;
use popsteer_sim::behind_play;
use pyo3::prelude::*;

/// The wheels' angles [rad] at the beginnings of `commands` [rad] that last for `steps` [s], the
/// last one for ever: a response of `lag` [s], limited to `rate` [rad/s]. They begin at the first.
#[pyfunction(name = "_wheel_angles")]
pub(crate) fn wheel_angles<'py>(
    py: Python<'py>,
    steps: PyReadonlyArray1<'_, f64>,
    commands: PyReadonlyArray1<'_, f64>,
    lag: f64,
    rate: Option<f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let vehicle = Vehicle {
        steer_lag: lag,
        max_steer_rate: rate,
        ..Vehicle::DEFAULT
    };
    let (steps, commands) = (steps.as_slice()?, commands.as_slice()?);
    let mut angle = commands.first().copied().unwrap_or(0.0);
    let turned = steps.iter().zip(commands).map(|(&step, &command)| {
        angle = vehicle.turn_wheel(angle, command, step).wheel;
        angle
    });
    let angles = commands.iter().take(1).copied().chain(turned).collect();
    Ok(PyArray1::from_vec(py, angles))
}

/// The angles [rad] behind `play` [rad] of a steering that goes through the angles `steering`.
#[pyfunction(name = "_behind_play")]
pub(crate) fn wheels_behind_play<'py>(
    py: Python<'py>,
    steering: PyReadonlyArray1<'_, f64>,
    play: f64,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let steering = steering.as_slice()?;
    let mut wheel = steering.first().copied().unwrap_or(0.0);
    let angles = steering.iter().map(|&angle| {
        wheel = behind_play(wheel, angle, play);
        wheel
    });
    Ok(PyArray1::from_vec(py, angles.collect()))
}
