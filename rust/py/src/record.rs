//! Frozen classes of what is answered and remembered, made from the core's structs: one macro, so
//! that a field has one home.

use popsteer_core::Point;
use pyo3::prelude::*;

use crate::params::Count;

/// A field of a record, as it goes to Python and comes from it.
pub(crate) trait Part: Copy {
    /// What Python sees.
    type Shown;
    fn shown(self) -> Self::Shown;
    fn taken(shown: Self::Shown) -> Self;
    /// The value of the field as an expression.
    fn written(value: &Bound<'_, PyAny>) -> PyResult<String> {
        Ok(value.repr()?.to_string())
    }
}

macro_rules! shown_as_it_is {
    ($($kind:ty),+) => {$(
        impl Part for $kind {
            type Shown = Self;

            fn shown(self) -> Self {
                self
            }

            fn taken(shown: Self) -> Self {
                shown
            }
        }
    )+};
}
shown_as_it_is!(f64, bool, Option<f64>);

impl Part for Point {
    type Shown = (f64, f64);

    fn shown(self) -> (f64, f64) {
        (self.x, self.y)
    }

    fn taken(shown: (f64, f64)) -> Self {
        Self::new(shown.0, shown.1)
    }
}

impl Part for usize {
    type Shown = Count;

    fn shown(self) -> Count {
        crate::params::Field::argument(self)
    }

    fn taken(shown: Count) -> Self {
        shown.saturated()
    }
}

impl Part for Option<usize> {
    type Shown = Option<Count>;

    fn shown(self) -> Option<Count> {
        self.map(Part::shown)
    }

    /// One below 0 is refused as one beyond all waypoints is.
    fn taken(shown: Option<Count>) -> Self {
        shown.map(|count| usize::try_from(count.0).unwrap_or(usize::MAX))
    }
}

/// A frozen, keyword-only class around a struct of the core. Its documentation stands above the
/// class, that of each attribute above its field; a field with a value may be left out.
macro_rules! record {
    (
        $(#[doc = $about:literal])+
        $class:ident($core:ident) named $name:literal,
        $($(#[doc = $text:literal])+ $field:ident: $kind:ty $(= $default:tt)?;)+
        $(@extra { $($extra:item)* })?
    ) => {
        $(#[doc = $about])+
        #[pyclass(frozen, eq, name = $name, module = "popsteer")]
        #[derive(Clone, Debug, PartialEq)]
        pub(crate) struct $class(pub(crate) $core);

        impl $class {
            fn fields<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
                let fields = PyDict::new(py);
                $(fields.set_item(stringify!($field), self.$field())?;)+
                Ok(fields)
            }
        }

        #[pymethods]
        impl $class {
            #[new]
            #[pyo3(signature = (*, $($field $(= $default)?),+))]
            fn new($($field: <$kind as $crate::record::Part>::Shown),+) -> Self {
                Self($core {
                    $($field: $crate::record::Part::taken($field)),+
                })
            }

            $(
                $(#[doc = $text])+
                #[getter]
                fn $field(&self) -> <$kind as $crate::record::Part>::Shown {
                    $crate::record::Part::shown(self.0.$field)
                }
            )+

            fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
                let fields = self.fields(py)?;
                let fields = [$(format!(
                    "{}={}",
                    stringify!($field),
                    <$kind as $crate::record::Part>::written(
                        &fields.as_any().get_item(stringify!($field))?
                    )?
                )),+];
                Ok(format!("{}({})", $name, fields.join(", ")))
            }

            fn __getnewargs_ex__<'py>(
                &self,
                py: Python<'py>,
            ) -> PyResult<(Bound<'py, PyTuple>, Bound<'py, PyDict>)> {
                Ok((PyTuple::empty(py), self.fields(py)?))
            }

            $($($extra)*)?
        }
    };
}
pub(crate) use record;
