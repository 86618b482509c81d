//! Waypoints as Python gives them: arrays in, columns out.

use numpy::ndarray::{ArrayView1, ArrayView2};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::path_error;

/// A column for each quantity, as far as it was given.
#[derive(Debug)]
pub(crate) struct Waypoints {
    pub(crate) x: Vec<f64>,
    pub(crate) y: Vec<f64>,
    pub(crate) reverse: Option<Vec<bool>>,
    /// Speed, grade, yaw and curvature.
    pub(crate) others: [Option<Vec<f64>>; 4],
}

impl Waypoints {
    /// Copies arrays of the right shapes, or a `PathError` that says what is wrong with one.
    pub(crate) fn read(
        xy: &Bound<'_, PyAny>,
        reverse: Option<Vec<bool>>,
        [speed, grade, yaw, curvature]: [Option<&Bound<'_, PyAny>>; 4],
    ) -> PyResult<Self> {
        let xy = as_array(xy, "xy", "(N, 2)")?;
        let waypoints = xy
            .cast::<PyArray2<f64>>()
            .ok()
            .filter(|waypoints| waypoints.shape().get(1) == Some(&2))
            .ok_or_else(|| wrong_shape("xy", "(N, 2)", &xy))?
            .try_readonly()?;
        let waypoints: ArrayView2<'_, f64> = waypoints.as_array();
        let (x, y) = (waypoints.column(0).to_vec(), waypoints.column(1).to_vec());
        Ok(Self {
            x,
            y,
            reverse,
            others: [
                column(speed, "speed")?,
                column(grade, "grade")?,
                column(yaw, "yaw")?,
                column(curvature, "curvature")?,
            ],
        })
    }
}

/// A number for each waypoint, where it is given.
fn column(given: Option<&Bound<'_, PyAny>>, name: &str) -> PyResult<Option<Vec<f64>>> {
    let Some(given) = given else {
        return Ok(None);
    };
    let array = as_array(given, name, "(N,)")?;
    let array = array
        .cast::<PyArray1<f64>>()
        .map_err(|_| wrong_shape(name, "(N,)", &array))?
        .try_readonly()?;
    let values: ArrayView1<'_, f64> = array.as_array();
    Ok(Some(values.to_vec()))
}

fn wrong_shape(name: &str, required: &str, array: &Bound<'_, PyAny>) -> PyErr {
    let shape = array.getattr("shape").and_then(|shape| shape.repr());
    shape.map_or_else(
        |error| error,
        |shape| {
            let words = format!("{name} must have shape {required}, got {shape}");
            path_error(array.py(), words)
        },
    )
}

/// `object` as an array of floats, or a `PathError` that says why not.
fn as_array<'py>(
    object: &Bound<'py, PyAny>,
    name: &str,
    shape: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let py = object.py();
    let options = PyDict::new(py);
    options.set_item("dtype", "float64")?;
    py.import("numpy")?
        .call_method("asarray", (object,), Some(&options))
        .map_err(|error| {
            let wanted = format!("{name} must be an array of numbers of shape {shape}");
            path_error(py, format!("{wanted}: {}", error.value(py)))
        })
}
