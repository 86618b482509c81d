//! What was measured step by step.

use numpy::PyArray1;
use popsteer_sim::Record;
use pyo3::prelude::*;
use pyo3::types::PyDict;

type Column = (&'static str, fn(&Record) -> f64);

const COLUMNS: &[Column] = &[
    ("time", |record| record.time),
    ("x", |record| record.x),
    ("y", |record| record.y),
    ("yaw", |record| record.yaw),
    ("speed", |record| record.speed),
    ("steer", |record| record.steer),
    ("throttle", |record| record.throttle),
    ("brake", |record| record.brake),
    ("reference_x", |record| record.reference.x),
    ("reference_y", |record| record.reference.y),
    ("cross_track_error", |record| record.cross_track_error),
    ("heading_error", |record| record.heading_error),
    ("rear_cross_track_error", |record| {
        record.rear_cross_track_error
    }),
    ("rear_heading_error", |record| record.rear_heading_error),
    ("target_x", |record| record.target.x),
    ("target_y", |record| record.target.y),
];

/// A column for each quantity, an entry for each record.
pub(crate) fn columns_of<'py>(py: Python<'py>, records: &[Record]) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    for (name, column) in COLUMNS {
        columns.set_item(name, PyArray1::from_iter(py, records.iter().map(*column)))?;
    }
    let status = records.iter().map(|record| record.status.bits());
    columns.set_item("status", PyArray1::from_iter(py, status))?;
    Ok(columns)
}
