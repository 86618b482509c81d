//! The core's errors as the Python classes of `popsteer.errors`, which word them.

use numpy::AsSliceError;
use popsteer_core::error::{ConfigError, InputError, PathError, Requirement};
use popsteer_sim::simulation::SimulationError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

static MODULE: PyOnceLock<Py<PyModule>> = PyOnceLock::new();

pub(crate) fn module(py: Python<'_>) -> PyResult<&Bound<'_, PyModule>> {
    let module = MODULE.get_or_try_init(py, || py.import("popsteer.errors").map(Bound::unbind))?;
    Ok(module.bind(py))
}

/// The requirement in the words of `popsteer.errors`.
fn worded(py: Python<'_>, requirement: Requirement) -> PyResult<Bound<'_, PyAny>> {
    let module = module(py)?;
    match requirement {
        Requirement::InRange(low, high) => module.call_method1("in_range", (low, high)),
        Requirement::CountInRange(low, high) => module.call_method1("count_in_range", (low, high)),
        Requirement::OddInRange(low, high) => module.call_method1("odd_in_range", (low, high)),
        Requirement::Below(count) => module.call_method1("below", (count,)),
    }
}

/// The refused value: an `int` where a count is asked for.
#[expect(
    clippy::cast_possible_truncation,
    reason = "counts come from 64-bit integers"
)]
fn shown(py: Python<'_>, value: f64, requirement: Requirement) -> PyResult<Bound<'_, PyAny>> {
    Ok(match requirement {
        Requirement::InRange(..) => value.into_pyobject(py)?.into_any(),
        _ => (value as i64).into_pyobject(py)?.into_any(),
    })
}

/// The exception that `make` makes of the class `name`, or what it raises.
fn made<'py>(
    py: Python<'py>,
    name: &str,
    make: impl FnOnce(Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>>,
) -> PyErr {
    let class = module(py).and_then(|module| module.getattr(name));
    class
        .and_then(make)
        .map_or_else(|error| error, PyErr::from_value)
}

/// An error of class `name` about one field.
fn field_error(
    py: Python<'_>,
    name: &str,
    field: &str,
    value: f64,
    requirement: Requirement,
) -> PyErr {
    made(py, name, |class| {
        let words = worded(py, requirement)?;
        class.call1((field, shown(py, value, requirement)?, words))
    })
}

/// An `InputError` about one of the entries of an argument: of `speed`, `speed[3]`.
pub(crate) fn entry_error(py: Python<'_>, entry: usize, error: InputError) -> PyErr {
    let field = format!("{}[{entry}]", error.field);
    field_error(py, "InputError", &field, error.value, error.requirement)
}

/// An `InputError` about an argument as a whole.
pub(crate) fn argument_error<'py>(
    py: Python<'py>,
    argument: &str,
    value: Bound<'py, PyAny>,
    requirement: &str,
) -> PyErr {
    made(py, "InputError", |class| {
        class.call1((argument, value, requirement))
    })
}

/// A Python exception: what `?` makes of the core's errors and of Python's own.
pub(crate) struct Raised(PyErr);

/// What may be refused.
pub(crate) type Raises<T> = Result<T, Raised>;

impl From<PyErr> for Raised {
    fn from(error: PyErr) -> Self {
        Self(error)
    }
}

impl From<Raised> for PyErr {
    fn from(Raised(error): Raised) -> Self {
        error
    }
}

impl From<AsSliceError> for Raised {
    fn from(error: AsSliceError) -> Self {
        Self(error.into())
    }
}

/// `?` for an error of the core about one field.
macro_rules! raised {
    ($($error:ident),+) => {$(
        impl From<$error> for Raised {
            #[cold]
            fn from(error: $error) -> Self {
                let name = stringify!($error);
                Python::attach(|py| {
                    Self(field_error(py, name, error.field, error.value, error.requirement))
                })
            }
        }
    )+};
}
raised!(ConfigError, InputError);

impl From<SimulationError> for Raised {
    #[cold]
    fn from(error: SimulationError) -> Self {
        match error {
            SimulationError::Config(error) => error.into(),
            SimulationError::Input(error) => error.into(),
            SimulationError::NoReverse { .. } => {
                Python::attach(|py| Self(path_error(py, error.to_string())))
            }
        }
    }
}

impl From<PathError> for Raised {
    #[cold]
    fn from(error: PathError) -> Self {
        Python::attach(|py| Self(waypoint_error(py, error)))
    }
}

fn waypoint_error(py: Python<'_>, error: PathError) -> PyErr {
    made(py, "PathError", |class| match error {
        PathError::TooFewWaypoints { count, least } => {
            class.call_method1("too_few_waypoints", (count, least))
        }
        PathError::LengthMismatch {
            field,
            length,
            waypoints,
        } => class.call_method1("length_mismatch", (field, length, waypoints)),
        PathError::OutOfRange {
            field,
            index,
            value,
            requirement,
        } => {
            let words = worded(py, requirement)?;
            class.call_method1("out_of_range", (field, index, value, words))
        }
        PathError::Coinciding { index, next } => class.call_method1("coinciding", (index, next)),
        PathError::Contradicting { index, .. }
        | PathError::Fold { index }
        | PathError::Gap { index, .. } => class.call1((error.to_string(), index)),
        PathError::Unordered { .. } => class.call1((error.to_string(),)),
        PathError::GridTooLarge { points, most } => {
            class.call_method1("grid_too_large", (points, most))
        }
    })
}

/// A `PathError` with this message.
pub(crate) fn path_error(py: Python<'_>, message: String) -> PyErr {
    made(py, "PathError", |class| class.call1((message,)))
}

/// A `ConfigError` about a name that is not known.
pub(crate) fn unknown(py: Python<'_>, what: &str, name: &str, known: &[&str]) -> PyErr {
    made(py, "ConfigError", |class| {
        class.call_method1("unknown", (what, name, known.to_vec()))
    })
}
