//! What was measured step by step, and what else a simulation that is taken apart goes into.

use numpy::{PyArray1, PyReadonlyArray1};
use popsteer_sim::{Record, Saved};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::path::PyPath;
use crate::settings::PySettings;

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

/// Path, plant, start, tracked point and settings of a simulation that was taken apart.
pub(crate) type Begin<'py> = (
    Py<PyPath>,
    Bound<'py, PyAny>,
    (f64, f64, f64, f64),
    f64,
    Py<PySettings>,
);

/// Its numbers, its commands in flight, its records, and what kept the plant from going on.
type Kept<Floats> = (Floats, Vec<(f64, f64)>, Floats, Option<String>);

/// The same as it comes from Python.
pub(crate) type SavedState<'py> = Kept<PyReadonlyArray1<'py, f64>>;

/// What a simulation saved, as it goes to Python.
pub(crate) fn taken_apart(
    py: Python<'_>,
    saved: Saved,
    limit: Option<String>,
) -> Kept<Bound<'_, PyArray1<f64>>> {
    let records = saved.records.iter().flat_map(Record::numbers).collect();
    let numbers = PyArray1::from_vec(py, saved.numbers);
    (
        numbers,
        saved.commands,
        PyArray1::from_vec(py, records),
        limit,
    )
}

/// What a simulation saved, and what kept its plant from going on.
pub(crate) fn put_together(state: SavedState<'_>) -> PyResult<(Saved, Option<String>)> {
    let (numbers, commands, records, limit) = state;
    let (records, _) = records.as_slice()?.as_chunks();
    let saved = Saved {
        numbers: numbers.as_slice()?.to_vec(),
        commands,
        records: records.iter().copied().map(Record::of).collect(),
    };
    Ok((saved, limit))
}
