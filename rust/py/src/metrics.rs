//! A run's metrics by their names, and what was measured step by step.

use numpy::PyArray1;
use popsteer_sim::{Metrics, Record};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};

/// A figure: its name, and where it is.
pub(crate) type Figure = (&'static str, fn(&Metrics) -> f64);

/// The statistics of one error.
macro_rules! stats {
    ($prefix:literal, $name:literal, $point:ident.$error:ident) => {
        [
            (concat!($prefix, "mean_abs_", $name), |run| {
                run.$point.$error.mean_abs
            }),
            (concat!($prefix, "rms_", $name), |run| run.$point.$error.rms),
            (concat!($prefix, "max_abs_", $name), |run| {
                run.$point.$error.max_abs
            }),
        ]
    };
}

/// Every figure that is a number with a unit; beside them stand `steps`, `finished` and
/// `faults`.
#[rustfmt::skip] // a line each
pub(crate) fn figures() -> impl Iterator<Item = Figure> {
    let errors: [[Figure; 3]; 8] = [
        stats!("", "cross_track_error", reference.cross_track),
        stats!("", "heading_error", reference.heading),
        stats!("settled_", "cross_track_error", reference.settled_cross_track),
        stats!("settled_", "heading_error", reference.settled_heading),
        stats!("rear_axle_", "cross_track_error", rear_axle.cross_track),
        stats!("rear_axle_", "heading_error", rear_axle.heading),
        stats!("rear_axle_settled_", "cross_track_error", rear_axle.settled_cross_track),
        stats!("rear_axle_settled_", "heading_error", rear_axle.settled_heading),
    ];
    let others: [Figure; 4] = [
        ("max_abs_steer", |metrics| metrics.max_abs_steer),
        ("rms_steer_rate", |metrics| metrics.rms_steer_rate),
        ("mean_speed", |metrics| metrics.mean_speed),
        ("time", |metrics| metrics.time),
    ];
    errors.into_iter().flatten().chain(others)
}

/// All metrics of a run.
pub(crate) fn by_name<'py>(py: Python<'py>, metrics: &Metrics) -> PyResult<Bound<'py, PyDict>> {
    let named = figures().map(|(name, figure)| (name, figure(metrics)));
    let fields = named.into_py_dict(py)?;
    fields.set_item("steps", metrics.steps)?;
    fields.set_item("finished", metrics.finished)?;
    fields.set_item("faults", metrics.faults.bits())?;
    Ok(fields)
}

/// A column for each quantity, an entry for each record.
pub(crate) fn columns_of<'py>(py: Python<'py>, records: &[Record]) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    for (name, column) in Record::COLUMNS {
        columns.set_item(name, PyArray1::from_iter(py, records.iter().map(column)))?;
    }
    let status = records.iter().map(|record| record.status.bits());
    columns.set_item("status", PyArray1::from_iter(py, status))?;
    Ok(columns)
}
