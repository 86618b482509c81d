//! The trajectory that a controller intends, as arrays.

use numpy::PyArray1;
use popsteer_core::InputError;
use popsteer_core::bounds::MAX_DT;
use popsteer_core::error::{Requirement, input_in_range};
use popsteer_core::math::{from_count, to_count};
use popsteer_core::tracker::Predicted;
use popsteer_core::vehicle::state::checked_dt;
use pyo3::prelude::*;

use crate::errors::argument_error;

/// More instants than this are a mistake.
const MOST: usize = 100_000;

/// Room for the instants of `time` [s], one each `dt` [s].
pub(crate) fn room(time: f64, dt: f64) -> Result<Vec<Predicted>, InputError> {
    input_in_range("time", time, 0.0, MAX_DT)?;
    let dt = checked_dt(dt)?;
    let periods = to_count(time / dt + 0.5);
    if periods > MOST {
        return Err(InputError {
            field: "time / dt",
            value: from_count(periods),
            requirement: Requirement::CountInRange(0, MOST),
        });
    }
    Ok(vec![Predicted::DEFAULT; periods + 1])
}

/// The `popsteer.Prediction` of these instants.
pub(crate) fn shown<'py>(py: Python<'py>, instants: &[Predicted]) -> PyResult<Bound<'py, PyAny>> {
    if instants.is_empty() {
        let none = py.None().into_bound(py);
        let wanted = "known: predict goes on from the last step, take one first";
        return Err(argument_error(py, "state.answer", none, wanted));
    }
    let column = |field: fn(&Predicted) -> f64| PyArray1::from_iter(py, instants.iter().map(field));
    let class = py.import("popsteer.prediction")?.getattr("Prediction")?;
    class.call1((
        column(|instant| instant.time),
        column(|instant| instant.vehicle.x),
        column(|instant| instant.vehicle.y),
        column(|instant| instant.vehicle.yaw),
        column(|instant| instant.vehicle.speed),
        column(|instant| instant.steer),
    ))
}
