//! Arrays from Python, one entry a vehicle.

use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::errors::argument_error;

/// `object` as an array of `count` floats; an `InputError` that names `argument` where it is not
/// one, or cannot become one without loss.
pub(crate) fn column<'py>(
    object: &Bound<'py, PyAny>,
    argument: &str,
    count: usize,
) -> PyResult<PyReadonlyArray1<'py, f64>> {
    let py = object.py();
    let wrong_shape = |shape: Bound<'py, PyAny>| {
        argument_error(py, argument, shape, &format!("of shape ({count},)"))
    };
    let array = if let Ok(array) = object.cast::<PyArray1<f64>>() {
        array.clone()
    } else {
        match as_floats(object, argument)?.cast_into::<PyArray1<f64>>() {
            Ok(array) => array,
            Err(error) => return Err(wrong_shape(error.into_inner().getattr("shape")?)),
        }
    };
    let array = array.try_readonly()?;
    if array.as_array().len() != count {
        let shape = PyTuple::new(py, [array.as_array().len()])?;
        return Err(wrong_shape(shape.into_any()));
    }
    Ok(array)
}

/// `object` as an array of float64 of any shape, where numpy calls the conversion safe.
fn as_floats<'py>(object: &Bound<'py, PyAny>, argument: &str) -> PyResult<Bound<'py, PyAny>> {
    let py = object.py();
    let numpy = py.import("numpy")?;
    let array = numpy.call_method1("asarray", (object,)).map_err(|error| {
        let kind = object.get_type().into_any();
        let refused = argument_error(py, argument, kind, "an array of numbers");
        refused.set_cause(py, Some(error));
        refused
    })?;
    let dtype = array.getattr("dtype")?;
    let safe = numpy.call_method1("can_cast", (&dtype, "float64"))?;
    if !safe.is_truthy()? {
        let requirement = "of a dtype that becomes float64 without loss";
        return Err(argument_error(py, argument, dtype, requirement));
    }
    let options = PyDict::new(py);
    options.set_item("copy", false)?;
    array.call_method("astype", ("float64",), Some(&options))
}
