//! What a controller was told to do in some respect: as always, so, or not at all.

use pyo3::PyClass;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

/// "auto", parameters of the class `P`, or None.
#[derive(Debug)]
pub(crate) enum Choice<P> {
    /// "auto": as controllers of its kind do.
    Usual,
    /// So, or not at all.
    Given(Option<Py<P>>),
}

/// Parameters that an argument of all controllers takes, besides "auto" and None.
pub(crate) trait Chosen: PyClass {
    /// What the argument has to be, by its name.
    const REQUIRED: &'static str;
}

impl<'py, P: Chosen> FromPyObject<'_, 'py> for Choice<P> {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if object.cast::<PyString>().is_ok_and(|text| text == "auto") {
            return Ok(Self::Usual);
        }
        let given = object.extract().map_err(|_| {
            let given = object.get_type();
            PyTypeError::new_err(format!("{}, got {given}", P::REQUIRED))
        })?;
        Ok(Self::Given(given))
    }
}

impl<P: PyClass + Into<PyClassInitializer<P>>> Choice<P> {
    /// What it comes to where "auto" is `usual`.
    pub(crate) fn or(&self, py: Python<'_>, usual: Option<P>) -> PyResult<Option<Py<P>>> {
        match self {
            Self::Given(given) => Ok(given.as_ref().map(|params| params.clone_ref(py))),
            Self::Usual => usual.map(|usual| Py::new(py, usual)).transpose(),
        }
    }

    /// The argument `name` as a `repr` shows it: nothing of "auto".
    pub(crate) fn repr(&self, py: Python<'_>, name: &str) -> PyResult<String> {
        match self {
            Self::Usual => Ok(String::new()),
            Self::Given(given) => Ok(format!(", {name}={}", given.into_pyobject(py)?.repr()?)),
        }
    }

    /// Puts the argument `name` among the options that make an equal controller.
    pub(crate) fn put(&self, options: &Bound<'_, PyDict>, name: &str) -> PyResult<()> {
        match self {
            Self::Usual => Ok(()),
            Self::Given(given) => options.set_item(name, given),
        }
    }
}
