//! What a step of a batch answers.

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use popsteer_core::Command;
use popsteer_sim::batch::CHUNK;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use rayon::prelude::*;

use crate::params::NewArgs;

/// What a column has of each vehicle.
trait Entry: Send + Sized {
    /// The array that has such an entry for each vehicle.
    type Array;

    fn array(py: Python<'_>, entries: Vec<Self>) -> PyResult<Py<Self::Array>>;
}

macro_rules! numbers {
    ($($number:ty),+) => {$(
        impl Entry for $number {
            type Array = PyArray1<$number>;

            fn array(py: Python<'_>, entries: Vec<Self>) -> PyResult<Py<PyArray1<Self>>> {
                Ok(PyArray1::from_vec(py, entries).unbind())
            }
        }
    )+};
}
numbers!(f64, bool, u32);

impl Entry for [f64; 2] {
    type Array = PyArray2<f64>;

    fn array(py: Python<'_>, entries: Vec<Self>) -> PyResult<Py<PyArray2<f64>>> {
        let rows = [entries.len(), 2];
        let numbers = PyArray1::from_vec(py, entries.into_flattened());
        Ok(numbers.reshape(rows)?.unbind())
    }
}

/// A class of columns, one entry a vehicle, and its columns before they are arrays. The text of
/// each is its documentation in the class and on the attribute.
macro_rules! columns {
    (
        $(#[doc = $about:literal])+
        $class:ident named $name:literal, gathered as $columns:ident,
        $($field:ident: $kind:ty = $entry:expr, $words:literal, $text:literal;)+
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
                $field: Py<<$kind as Entry>::Array>,
            )+
        }

        /// The fields of commands, each in a column.
        #[derive(Debug, Default)]
        pub(crate) struct $columns {
            $($field: Vec<$kind>,)+
        }

        impl $columns {
            /// Of all of a batch, on the threads of the present pool if those have stepped it.
            pub(crate) fn of(commands: &[Command]) -> Self {
                Self { $($field: gather(commands, $entry)),+ }
            }

            /// The columns as arrays.
            pub(crate) fn shown(self, py: Python<'_>) -> PyResult<$class> {
                Ok($class { $($field: Entry::array(py, self.$field)?),+ })
            }
        }

        #[pymethods]
        impl $class {
            #[new]
            #[pyo3(signature = (*, $($field),+))]
            fn made_of(
                py: Python<'_>,
                $($field: Py<<$kind as Entry>::Array>),+
            ) -> PyResult<Self> {
                let made = Self { $($field),+ };
                let count = made.__len__(py);
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
                self.steer.bind(py).len()
            }

            fn __repr__(&self, py: Python<'_>) -> String {
                format!("<{} of {} vehicles>", $name, self.__len__(py))
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
    PyCommandBatch named "CommandBatch", gathered as Columns,
    steer: f64 = |command| command.steer, "ndarray of shape (N,)",
        "Angles to command [rad], positive to the left.";
    cross_track_error: f64 = |command| command.cross_track_error, "ndarray of shape (N,)",
        "Offsets of the tracked points from the path [m], positive left of it.";
    heading_error: f64 = |command| command.heading_error, "ndarray of shape (N,)",
        "Yaw less direction of the path [rad], in [-pi, pi].";
    predicted_cross_track_error: f64 = |command| command.predicted_cross_track_error,
        "ndarray of shape (N,)",
        "Cross-track errors of the vehicles as they will be when the commands reach the wheels [m].";
    predicted_heading_error: f64 = |command| command.predicted_heading_error,
        "ndarray of shape (N,)",
        "Heading errors of those [rad].";
    target: [f64; 2] = |command| [command.target.x, command.target.y], "ndarray of shape (N, 2)",
        "The points aimed at, (x, y) [m].";
    reverse: bool = |command| command.reverse, "ndarray of shape (N,) of bool",
        "Whether the path is driven backwards there.";
    reference_speed: f64 = |command| command.reference_speed.unwrap_or(f64::NAN),
        "ndarray of shape (N,)",
        "The paths' speeds beside the rear axles [m/s]; NaN where a path has no speeds.";
    distance_to_stop: f64 = |command| command.distance_to_stop, "ndarray of shape (N,)",
        "Distances along the paths to the next cusp, or to the end [m]; inf where there is neither.";
    status: u32 = |command| command.status.bits(), "ndarray of shape (N,) of uint32",
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

/// This field of all commands.
fn gather<T: Send>(commands: &[Command], field: fn(&Command) -> T) -> Vec<T> {
    if commands.len() <= CHUNK {
        commands.iter().map(field).collect()
    } else {
        let commands = commands.par_iter().with_min_len(CHUNK);
        commands.map(field).collect()
    }
}
