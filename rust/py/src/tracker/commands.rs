//! What a step of a batch answers.

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use popsteer_core::Command;
use popsteer_sim::batch::CHUNK;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use rayon::prelude::*;

use crate::params::NewArgs;

type Column = Py<PyArray1<f64>>;

/// A class of columns, one entry a vehicle. The text of each is its documentation in the class and
/// on the attribute.
macro_rules! columns {
    (
        $(#[doc = $about:literal])+
        $class:ident named $name:literal,
        $($field:ident: $kind:ty, $words:literal, $text:literal;)+
        @examples { $(#[doc = $example:literal])+ }
    ) => {
        $(#[doc = $about])+
        ///
        /// Parameters
        /// ----------
        $(
            #[doc = concat!(stringify!($field), " : ", $words)]
            #[doc = concat!("    ", $text)]
        )+
        ///
        /// Examples
        /// --------
        $(#[doc = $example])+
        #[pyclass(frozen, name = $name, module = "popsteer")]
        #[derive(Debug)]
        pub(crate) struct $class {
            $(
                #[doc = $text]
                #[pyo3(get)]
                $field: $kind,
            )+
        }

        #[pymethods]
        impl $class {
            #[new]
            #[pyo3(signature = (*, $($field),+))]
            fn made_of(py: Python<'_>, $($field: $kind),+) -> PyResult<Self> {
                let made = Self { $($field),+ };
                let count = made.count(py);
                let equal = $(made.$field.bind(py).shape().first() == Some(&count))&&+;
                if equal && made.target.bind(py).shape() == [count, 2] {
                    return Ok(made);
                }
                Err(PyValueError::new_err(concat!(
                    "the columns of a ",
                    $name,
                    " must be equally long, and the target of shape (N, 2)"
                )))
            }

            fn __len__(&self, py: Python<'_>) -> usize {
                self.count(py)
            }

            fn __repr__(&self, py: Python<'_>) -> String {
                format!("<{} of {} vehicles>", $name, self.count(py))
            }

            fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<NewArgs<'py>> {
                let columns = PyDict::new(py);
                $(columns.set_item(stringify!($field), &self.$field)?;)+
                Ok((PyTuple::empty(py), columns))
            }
        }
    };
}

columns! {
    /// What one step of a batch answers: `Command` in columns, an entry a vehicle.
    PyCommandBatch named "CommandBatch",
    steer: Column, "ndarray of shape (N,)",
        "Angles to command [rad], positive to the left.";
    cross_track_error: Column, "ndarray of shape (N,)",
        "Offsets of the tracked points from the path [m], positive left of it.";
    heading_error: Column, "ndarray of shape (N,)",
        "Yaw less direction of the path [rad], in [-pi, pi].";
    predicted_cross_track_error: Column, "ndarray of shape (N,)",
        "Cross-track errors of the vehicles as they will be when the commands reach the wheels [m].";
    predicted_heading_error: Column, "ndarray of shape (N,)",
        "Heading errors of those [rad].";
    target: Py<PyArray2<f64>>, "ndarray of shape (N, 2)",
        "The points aimed at, (x, y) [m].";
    reverse: Py<PyArray1<bool>>, "ndarray of shape (N,) of bool",
        "Whether the path is driven backwards there.";
    reference_speed: Column, "ndarray of shape (N,)",
        "The paths' speeds beside the rear axles [m/s]; NaN where a path has no speeds.";
    distance_to_stop: Column, "ndarray of shape (N,)",
        "Distances along the paths to the next cusp, or to the end [m]; inf where there is neither.";
    status: Py<PyArray1<u32>>, "ndarray of shape (N,) of uint32",
        "How the steps went, as the bits of `Status`.";
    @examples {
        /// >>> import numpy as np
        /// >>> path = popsteer.Path([(0.0, 0.0), (100.0, 0.0)])
        /// >>> batch = popsteer.Batch(popsteer.Stanley(path), 2)
        /// >>> x, y = np.array([5.0, 99.0]), np.array([0.5, -0.5])
        /// >>> commands = batch.step(x, y, np.zeros(2), np.full(2, 5.0), 0.05)
        /// >>> commands.steer.round(4), (commands.status & popsteer.Status.END_OF_PATH) > 0
        /// (array([-0.0997,  0.0997]), array([False,  True]))
    }
}

impl PyCommandBatch {
    fn count(&self, py: Python<'_>) -> usize {
        self.steer.bind(py).len()
    }

    /// The commands in columns.
    pub(crate) fn new(py: Python<'_>, columns: Columns) -> PyResult<Self> {
        let [
            steer,
            cross_track_error,
            heading_error,
            predicted_cross_track_error,
            predicted_heading_error,
            reference_speed,
            distance_to_stop,
        ] = columns
            .numbers
            .map(|column| PyArray1::from_vec(py, column).unbind());
        let target = PyArray1::from_vec(py, columns.targets.into_flattened());
        Ok(Self {
            target: target.reshape([columns.status.len(), 2])?.unbind(),
            reverse: PyArray1::from_vec(py, columns.reverse).unbind(),
            status: PyArray1::from_vec(py, columns.status).unbind(),
            steer,
            cross_track_error,
            heading_error,
            predicted_cross_track_error,
            predicted_heading_error,
            reference_speed,
            distance_to_stop,
        })
    }
}

/// The fields of commands, each in a column.
#[derive(Debug, Default)]
pub(crate) struct Columns {
    numbers: [Vec<f64>; 7],
    targets: Vec<[f64; 2]>,
    reverse: Vec<bool>,
    status: Vec<u32>,
}

impl Columns {
    /// Of all of a batch, on the threads of the present pool if those have stepped it.
    pub(crate) fn of(commands: &[Command]) -> Self {
        const NUMBERS: [fn(&Command) -> f64; 7] = [
            |command| command.steer,
            |command| command.cross_track_error,
            |command| command.heading_error,
            |command| command.predicted_cross_track_error,
            |command| command.predicted_heading_error,
            |command| command.reference_speed.unwrap_or(f64::NAN),
            |command| command.distance_to_stop,
        ];
        Self {
            numbers: NUMBERS.map(|field| gather(commands, field)),
            targets: gather(commands, |command| [command.target.x, command.target.y]),
            reverse: gather(commands, |command| command.reverse),
            status: gather(commands, |command| command.status.bits()),
        }
    }
}

/// This field of all commands.
fn gather<T: Send>(commands: &[Command], field: fn(&Command) -> T) -> Vec<T> {
    if commands.len() <= CHUNK {
        commands.iter().map(field).collect()
    } else {
        let commands = commands.par_iter().with_min_len(CHUNK);
        commands.map(field).collect()
    }
}
