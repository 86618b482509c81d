//! Frozen classes of what is answered and remembered, made from the core's structs: one macro, so
//! that a field has one home.

/// A frozen, keyword-only class around a struct of the core.
///
/// The text of each field is its documentation in the class and on the attribute. A field with a
/// value may be left out; `$shown` is the signature then, which a test holds against the real
/// defaults, and the class gives its fields by name.
macro_rules! record {
    (
        $(#[doc = $about:literal])+
        $class:ident($core:ident) named $name:literal,
        $($field:ident: $kind:ty $(= $default:tt)?, $words:literal, $text:literal;)+
        $(@shown as $shown:literal, with $as_dict:ident;)?
        $(@examples { $(#[doc = $example:literal])+ })?
    ) => {
        $(#[doc = $about])+
        ///
        /// Parameters
        /// ----------
        $(
            #[doc = concat!(stringify!($field), " : ", $words)]
            #[doc = concat!("    ", $text)]
        )+
        $(
            ///
            /// Examples
            /// --------
            $(#[doc = $example])+
        )?
        #[pyclass(frozen, eq, name = $name, module = "popsteer")]
        #[derive(Clone, Debug, PartialEq)]
        pub(crate) struct $class(pub(crate) $core);

        impl $class {
            fn fields<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, pyo3::types::PyDict>> {
                let fields = pyo3::types::PyDict::new(py);
                $(fields.set_item(stringify!($field), self.$field())?;)+
                Ok(fields)
            }
        }

        #[pymethods]
        impl $class {
            #[new]
            #[pyo3(
                signature = (*, $($field $(= <$kind as $crate::params::Field>::argument($default))?),+)
                $(, text_signature = $shown)?
            )]
            fn new($($field: <$kind as $crate::params::Field>::Argument),+) -> Self {
                Self($core {
                    $($field: $crate::params::Field::from_argument($field)),+
                })
            }

            $(
                #[doc = $text]
                #[getter]
                fn $field(&self) -> <$kind as $crate::params::Field>::Argument {
                    $crate::params::Field::argument(self.0.$field)
                }
            )+

            $(
                /// The fields by name, as a new ``dict``.
                fn $as_dict<'py>(
                    &self,
                    py: Python<'py>,
                ) -> PyResult<Bound<'py, pyo3::types::PyDict>> {
                    self.fields(py)
                }
            )?

            fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
                let fields = self.fields(py)?;
                let fields = [$(format!(
                    "{}={}",
                    stringify!($field),
                    <$kind as $crate::params::Field>::written(
                        &fields.as_any().get_item(stringify!($field))?
                    )?
                )),+];
                Ok(format!("{}({})", $name, fields.join(", ")))
            }

            fn __getnewargs_ex__<'py>(
                &self,
                py: Python<'py>,
            ) -> PyResult<$crate::params::NewArgs<'py>> {
                Ok((pyo3::types::PyTuple::empty(py), self.fields(py)?))
            }
        }
    };
}
pub(crate) use record;
