//! Parameter classes, made from the core's structs: one macro, so that a field has one home.

use popsteer_core::error::{InputError, Requirement};
use popsteer_core::{ConfigError, Point};
use pyo3::exceptions::PyOverflowError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// A number from Python. A whole number beyond all floats becomes infinite, and the core refuses it
/// by name like any other that is out of range.
#[derive(Clone, Copy, Debug, IntoPyObject, PartialEq)]
pub(crate) struct Number(pub(crate) f64);

impl<'py> FromPyObject<'_, 'py> for Number {
    type Error = PyErr;

    #[inline]
    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        match object.extract::<f64>() {
            Ok(number) => Ok(Self(number)),
            Err(error) => Self::beyond(object, error),
        }
    }
}

impl Number {
    #[cold]
    fn beyond(object: Borrowed<'_, '_, PyAny>, error: PyErr) -> PyResult<Self> {
        if error.is_instance_of::<PyOverflowError>(object.py()) {
            let infinite = f64::INFINITY;
            return Ok(Self(if object.lt(0)? { -infinite } else { infinite }));
        }
        Err(error)
    }
}

/// A whole number from Python, of any size: one that does not fit becomes the nearest that does,
/// and the core refuses it by name.
#[derive(Clone, Copy, Debug, Default, IntoPyObject, PartialEq)]
pub(crate) struct Count(pub(crate) i64);

impl<'py> FromPyObject<'_, 'py> for Count {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        match object.extract::<i64>() {
            Ok(count) => Ok(Self(count)),
            Err(error) if error.is_instance_of::<PyOverflowError>(object.py()) => {
                Ok(Self(if object.lt(0)? { i64::MIN } else { i64::MAX }))
            }
            Err(error) => Err(error),
        }
    }
}

impl Count {
    /// The nearest count that the core can hold: 0 for a negative one.
    pub(crate) fn saturated(self) -> usize {
        usize::try_from(self.0.max(0)).unwrap_or(usize::MAX)
    }

    /// The place of one of `count` things.
    pub(crate) fn below(self, count: usize, field: &'static str) -> Result<usize, InputError> {
        let place = usize::try_from(self.0).ok().filter(|&place| place < count);
        place.ok_or(InputError {
            field,
            value: self.shown(),
            requirement: Requirement::Below(count),
        })
    }

    /// The count as an error shows it.
    #[expect(
        clippy::cast_precision_loss,
        reason = "it is out of range, and only shown"
    )]
    pub(crate) fn shown(self) -> f64 {
        self.0 as f64
    }
}

/// A [`Number`] as the core has it, for an argument whose default a signature shows.
pub(crate) fn number(object: &Bound<'_, PyAny>) -> PyResult<f64> {
    object.extract().map(|Number(number)| number)
}

/// A [`Count`] as the core has it, likewise.
pub(crate) fn count(object: &Bound<'_, PyAny>) -> PyResult<usize> {
    object.extract().map(Count::saturated)
}

/// How a field of the core comes from Python, and goes back.
pub(crate) trait Field: Copy {
    /// The type of the argument.
    type Argument: Copy;
    /// The core's value, the nearest one where the argument cannot be represented.
    fn from_argument(argument: Self::Argument) -> Self;
    /// The argument that stands for the core's value.
    fn argument(self) -> Self::Argument;
    /// The argument as an error shows it, where `from_argument` had to change it.
    fn changed(_argument: Self::Argument) -> Option<f64> {
        None
    }
    /// The argument in an expression that makes an equal object.
    fn written(argument: &Bound<'_, PyAny>) -> PyResult<String> {
        Ok(argument.repr()?.to_string())
    }
}

/// [`Field`] for a type, by what it is in terms of its argument, and the other way round.
macro_rules! field {
    ($field:ty, $given:ident: $argument:ty => $from:expr, $value:ident => $to:expr) => {
        impl Field for $field {
            type Argument = $argument;

            fn from_argument($given: $argument) -> Self {
                $from
            }

            fn argument(self) -> $argument {
                let $value = self;
                $to
            }
        }
    };
}
field!(f64, given: Number => given.0, value => Number(value));
field!(Option<f64>, given: Option<Number> => given.map(|given| given.0), value => value.map(Number));
field!(bool, given: bool => given, value => value);
field!(Point, given: (f64, f64) => Self::new(given.0, given.1), value => (value.x, value.y));

impl Field for usize {
    type Argument = Count;

    fn from_argument(argument: Count) -> usize {
        argument.saturated()
    }

    fn argument(self) -> Count {
        Count(i64::try_from(self).unwrap_or(i64::MAX))
    }

    fn changed(argument: Count) -> Option<f64> {
        (argument.0 < 0).then(|| argument.shown())
    }
}

/// `error` with the value as Python gave it.
pub(crate) fn as_given(mut error: ConfigError, given: &[(&str, Option<f64>)]) -> ConfigError {
    for (field, value) in given {
        if let (true, Some(value)) = (*field == error.field, value) {
            error.value = *value;
        }
    }
    error
}

/// The Rust type of a parameter of the core's `params!`.
macro_rules! kind {
    (Scaled) => { Option<f64> };
    ($kind:ty) => { $kind };
}
pub(crate) use kind;

/// What a parameter's documentation says of its type.
macro_rules! words {
    (f64, $default:expr) => {
        concat!("float, default ", stringify!($default))
    };
    (usize, $default:expr) => {
        concat!("int, default ", stringify!($default))
    };
    (bool, $default:expr) => {
        "bool, optional"
    };
    ($kind:ident, $default:expr) => {
        "float or None, optional"
    };
}
pub(crate) use words;

/// What a parameter's documentation says of a default that scales with the vehicle.
macro_rules! scaled {
    (Scaled, $default:expr) => {
        concat!(" By default `", stringify!($default), "`.")
    };
    ($kind:ident, $default:expr) => {
        ""
    };
}
pub(crate) use scaled;

/// A frozen, keyword-only class around a struct of the core that `params!` declares: the macro of
/// its name gives the fields.
///
/// The text of each field is its documentation in the class and on the attribute. `@of vehicle`
/// takes a vehicle before the parameters, `$usual` by default, and hashes. The signature with its defaults is
/// made in Python, by `popsteer.params_file`.
macro_rules! params {
    (
        {
            $(#[doc = $about:literal])+
            $class:ident($core:ident) named $name:literal in $module:literal;
            $(@of $vehicle:ident: $whole:ident by default $usual:expr, $whose:literal;)?
            $(@examples { $(#[doc = $example:literal])+ })?
            $(@extra { $($extra:item)* })?
        }
        $(
            $(#[doc = $text:literal])+
            $field:ident: $kind:ident $(<$of:ty>)? = $default:expr $(, in [$low:expr, $high:expr])?;
        )+
    ) => {
        $(#[doc = $about])+
        ///
        /// Parameters
        /// ----------
        $(
            #[doc = concat!(stringify!($vehicle), " : Vehicle, optional")]
            #[doc = concat!("    What it is; by default ", $whose, ".")]
        )?
        $(
            #[doc = concat!(stringify!($field), " : ", $crate::params::words!($kind, $default))]
            #[doc = concat!(
                "   ", $($text,)+ $crate::params::scaled!($kind, $default)
                $(, " In [", stringify!($low), ", ", stringify!($high), "].")?
            )]
        )+
        ///
        /// Raises
        /// ------
        /// ConfigError
        ///     If a parameter is out of its range; names it and its value.
        $(
            ///
            /// Examples
            /// --------
            $(#[doc = $example])+
        )?
        #[pyclass(frozen, eq, name = $name, module = $module)]
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub(crate) struct $class(pub(crate) $core);

        #[pymethods]
        impl $class {
            #[new]
            #[pyo3(signature = (
                $($vehicle=None,)? *,
                $($field = $crate::params::Field::argument($core::DEFAULT.$field)),+
            ))]
            fn new(
                $($vehicle: Option<Py<$whole>>,)?
                $($field: <$crate::params::kind!($kind$(<$of>)?) as $crate::params::Field>::Argument),+
            ) -> $crate::errors::Raises<Self> {
                let given = [$((
                    stringify!($field),
                    <$crate::params::kind!($kind$(<$of>)?) as $crate::params::Field>::changed($field),
                )),+];
                let params = $core {
                    $($vehicle: $vehicle.map_or($usual, |vehicle| vehicle.get().0),)?
                    $($field: $crate::params::Field::from_argument($field)),+
                };
                let checked = params.checked();
                Ok(Self(checked.map_err(|error| $crate::params::as_given(error, &given))?))
            }

            $(
                /// What it is.
                #[getter]
                fn $vehicle(&self) -> $whole {
                    $whole(self.0.$vehicle)
                }

                fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
                    $crate::params::hash(&self.as_dict(py)?)
                }
            )?

            $(
                $(#[doc = $text])+
                #[getter]
                fn $field(
                    &self,
                ) -> <$crate::params::kind!($kind$(<$of>)?) as $crate::params::Field>::Argument {
                    $crate::params::Field::argument(self.0.$field)
                }
            )+

            /// The parameters by name, as a new ``dict``.
            fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, pyo3::types::PyDict>> {
                let fields = pyo3::types::PyDict::new(py);
                $(fields.set_item(stringify!($vehicle), self.$vehicle())?;)?
                $(fields.set_item(stringify!($field), self.$field())?;)+
                Ok(fields)
            }

            /// The same but for the parameters given by name.
            #[pyo3(signature = (**changes))]
            fn replace<'py>(
                &self,
                py: Python<'py>,
                changes: Option<&Bound<'py, pyo3::types::PyDict>>,
            ) -> PyResult<Bound<'py, PyAny>> {
                let fields = self.as_dict(py)?;
                if let Some(changes) = changes {
                    fields.update(changes.as_mapping())?;
                }
                py.get_type::<Self>().call((), Some(&fields))
            }

            fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
                $crate::params::repr($name, &self.as_dict(py)?)
            }

            fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<$crate::params::NewArgs<'py>> {
                Ok((pyo3::types::PyTuple::empty(py), self.as_dict(py)?))
            }

            $($($extra)*)?
        }
    };
}
pub(crate) use params;

/// `name(field=value, ...)`.
pub(crate) fn repr(name: &str, fields: &Bound<'_, PyDict>) -> PyResult<String> {
    let mut shown = Vec::with_capacity(fields.len());
    for (field, value) in fields.iter() {
        shown.push(format!("{field}={}", value.repr()?));
    }
    Ok(format!("{name}({})", shown.join(", ")))
}

/// What makes an equal object: arguments in order, and arguments by name.
pub(crate) type NewArgs<'py> = (Bound<'py, PyTuple>, Bound<'py, PyDict>);

/// One hash for equal fields: Python hashes 0.0 and -0.0 alike.
pub(crate) fn hash(fields: &Bound<'_, PyDict>) -> PyResult<isize> {
    PyTuple::new(fields.py(), fields.values())?.hash()
}
