//! States of the core as `popsteer.State`, and back, by the names that serde derives.

use std::fmt::{self, Display};

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyBool, PyDict, PyFloat, PyString, PyTuple, PyType};
use serde::de::{DeserializeOwned, DeserializeSeed, IntoDeserializer, SeqAccess, Visitor};
use serde::ser::{Impossible, SerializeSeq, SerializeStruct, SerializeTuple};
use serde::{Deserializer, Serialize, Serializer, forward_to_deserialize_any};

use crate::errors::argument_error;

static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// The field that names the controller.
const CONTROLLER: &str = "controller";

/// The `popsteer.State` of a controller of this name.
pub(crate) fn shown<'py>(
    py: Python<'py>,
    controller: &str,
    state: &impl Serialize,
) -> PyResult<Bound<'py, PyAny>> {
    let fields = PyDict::new(py);
    fields.set_item(CONTROLLER, controller)?;
    fields.update(data(state, py)?.cast::<PyDict>()?.as_mapping())?;
    let class = CLASS.import(py, "popsteer.state", "State")?;
    class.call((), Some(&fields))
}

/// What a `popsteer.State` of a controller of this name shows; whether the controller could have it
/// is not checked.
pub(crate) fn restored<S: DeserializeOwned>(
    controller: &str,
    state: &Bound<'_, PyAny>,
) -> PyResult<S> {
    let py = state.py();
    if !state.is_instance(CLASS.import(py, "popsteer.state", "State")?)? {
        let words = format!("state must be a popsteer.State, got {}", state.get_type());
        return Err(PyTypeError::new_err(words));
    }
    let fields = state.call_method0("as_dict")?.cast_into::<PyDict>()?;
    let given = fields.get_item(CONTROLLER)?;
    let given = given.unwrap_or_else(|| py.None().into_bound(py));
    if !given.eq(controller).unwrap_or(false) {
        let wanted = format!("'{controller}'");
        return Err(argument_error(py, CONTROLLER, given, &wanted));
    }
    fields.del_item(CONTROLLER)?;
    of_data(fields.into_any())
}

/// Numbers, tuples, and a `dict` for each struct.
pub(crate) fn data<'py>(value: &impl Serialize, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
    let made = value.serialize(ToPython(py));
    made.map_err(|error| error.raised(py))
}

/// What [`data`] has made.
pub(crate) fn of_data<S: DeserializeOwned>(data: Bound<'_, PyAny>) -> PyResult<S> {
    let py = data.py();
    S::deserialize(Given(data)).map_err(|error| error.raised(py))
}

/// Why a value does not go over: it is not what is required.
#[derive(Debug)]
pub(crate) struct Refusal {
    /// The field, innermost part first.
    path: Vec<String>,
    value: Option<Py<PyAny>>,
    requirement: String,
}

impl Refusal {
    fn of(requirement: impl Display) -> Self {
        Self {
            path: Vec::new(),
            value: None,
            requirement: requirement.to_string(),
        }
    }

    /// The same of `value`, which stands at `place`.
    fn at(mut self, place: String, value: &Bound<'_, PyAny>) -> Self {
        self.path.push(place);
        self.value.get_or_insert_with(|| value.clone().unbind());
        self
    }

    fn raised(self, py: Python<'_>) -> PyErr {
        let mut field = String::new();
        for place in self.path.iter().rev() {
            if !field.is_empty() && !place.starts_with('[') {
                field.push('.');
            }
            field.push_str(place);
        }
        if field.is_empty() {
            field.push_str("state");
        }
        let value = self.value.into_pyobject(py);
        value.map_or_else(PyErr::from, |value| {
            argument_error(py, &field, value, &self.requirement)
        })
    }
}

impl Display for Refusal {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.requirement)
    }
}

impl std::error::Error for Refusal {}

impl From<PyErr> for Refusal {
    fn from(error: PyErr) -> Self {
        Self::of(error)
    }
}

impl serde::ser::Error for Refusal {
    fn custom<T: Display>(message: T) -> Self {
        Self::of(message)
    }
}

impl serde::de::Error for Refusal {
    fn custom<T: Display>(message: T) -> Self {
        Self::of(message)
    }

    fn invalid_length(_: usize, expected: &dyn serde::de::Expected) -> Self {
        Self::of(expected)
    }
}

/// Makes a number, a tuple or a `dict` of what states are made of.
#[derive(Clone, Copy)]
struct ToPython<'py>(Python<'py>);

type Made<'py> = Result<Bound<'py, PyAny>, Refusal>;

/// Refuses the kinds of values that no state has.
macro_rules! refuse {
    ($($method:ident($($argument:ty),*) -> $made:ident;)+) => {$(
        fn $method(self, $(_: $argument),*) -> Result<Self::$made, Refusal> {
            Err(Refusal::of(concat!("of another kind: ", stringify!($method))))
        }
    )+};
}

impl<'py> Serializer for ToPython<'py> {
    type Ok = Bound<'py, PyAny>;
    type Error = Refusal;
    type SerializeSeq = Entries<'py>;
    type SerializeTuple = Entries<'py>;
    type SerializeTupleStruct = Impossible<Self::Ok, Refusal>;
    type SerializeTupleVariant = Impossible<Self::Ok, Refusal>;
    type SerializeMap = Impossible<Self::Ok, Refusal>;
    type SerializeStruct = Fields<'py>;
    type SerializeStructVariant = Impossible<Self::Ok, Refusal>;

    fn serialize_bool(self, value: bool) -> Made<'py> {
        Ok(PyBool::new(self.0, value).to_owned().into_any())
    }

    fn serialize_u64(self, value: u64) -> Made<'py> {
        let Ok(made) = value.into_pyobject(self.0);
        Ok(made.into_any())
    }

    fn serialize_f64(self, value: f64) -> Made<'py> {
        Ok(PyFloat::new(self.0, value).into_any())
    }

    fn serialize_none(self) -> Made<'py> {
        Ok(self.0.None().into_bound(self.0))
    }

    fn serialize_unit_variant(self, _: &str, _: u32, name: &str) -> Made<'py> {
        Ok(PyString::new(self.0, name).into_any())
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Made<'py> {
        value.serialize(self)
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, _: &str, value: &T) -> Made<'py> {
        value.serialize(self)
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<Entries<'py>, Refusal> {
        Ok(Entries(self, Vec::new()))
    }

    fn serialize_tuple(self, _: usize) -> Result<Entries<'py>, Refusal> {
        Ok(Entries(self, Vec::new()))
    }

    fn serialize_struct(self, _: &str, _: usize) -> Result<Fields<'py>, Refusal> {
        Ok(Fields(self, PyDict::new(self.0)))
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &str,
        _: u32,
        _: &str,
        _: &T,
    ) -> Made<'py> {
        Err(Refusal::of("of another kind: a variant"))
    }

    refuse! {
        serialize_i8(i8) -> Ok;
        serialize_i16(i16) -> Ok;
        serialize_i32(i32) -> Ok;
        serialize_i64(i64) -> Ok;
        serialize_u8(u8) -> Ok;
        serialize_u16(u16) -> Ok;
        serialize_u32(u32) -> Ok;
        serialize_f32(f32) -> Ok;
        serialize_char(char) -> Ok;
        serialize_str(&str) -> Ok;
        serialize_bytes(&[u8]) -> Ok;
        serialize_unit() -> Ok;
        serialize_unit_struct(&str) -> Ok;
        serialize_tuple_struct(&str, usize) -> SerializeTupleStruct;
        serialize_tuple_variant(&str, u32, &str, usize) -> SerializeTupleVariant;
        serialize_map(Option<usize>) -> SerializeMap;
        serialize_struct_variant(&str, u32, &str, usize) -> SerializeStructVariant;
    }
}

/// A tuple in the making.
struct Entries<'py>(ToPython<'py>, Vec<Bound<'py, PyAny>>);

macro_rules! entries {
    ($($kind:ident),+) => {$(
        impl<'py> $kind for Entries<'py> {
            type Ok = Bound<'py, PyAny>;
            type Error = Refusal;

            fn serialize_element<T: Serialize + ?Sized>(&mut self, entry: &T) -> Result<(), Refusal> {
                self.1.push(entry.serialize(self.0)?);
                Ok(())
            }

            fn end(self) -> Made<'py> {
                Ok(PyTuple::new(self.0.0, self.1)?.into_any())
            }
        }
    )+};
}
entries!(SerializeSeq, SerializeTuple);

/// A `dict` in the making.
struct Fields<'py>(ToPython<'py>, Bound<'py, PyDict>);

impl<'py> SerializeStruct for Fields<'py> {
    type Ok = Bound<'py, PyAny>;
    type Error = Refusal;

    fn serialize_field<T: Serialize + ?Sized>(
        &mut self,
        field: &'static str,
        value: &T,
    ) -> Result<(), Refusal> {
        Ok(self.1.set_item(field, value.serialize(self.0)?)?)
    }

    fn end(self) -> Made<'py> {
        Ok(self.1.into_any())
    }
}

/// What Python gives: numbers, tuples, and the `dict` of a struct, with all fields and no others.
struct Given<'py>(Bound<'py, PyAny>);

impl<'py> Given<'py> {
    fn extracted<T: FromPyObjectOwned<'py>>(&self, requirement: &str) -> Result<T, Refusal> {
        self.0.extract().map_err(|_| Refusal::of(requirement))
    }
}

impl<'de> Deserializer<'de> for Given<'_> {
    type Error = Refusal;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Refusal> {
        Err(Refusal::of("of another kind"))
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        visitor.visit_bool(self.extracted("True or False")?)
    }

    fn deserialize_u64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        visitor.visit_u64(self.extracted("a whole number from 0 to 2**64 - 1")?)
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        visitor.visit_f64(self.extracted("a number")?)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        if self.0.is_none() {
            visitor.visit_none()
        } else {
            visitor.visit_some(self)
        }
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        let entries = self.0.cast::<PyTuple>();
        let entries = entries.map_err(|_| Refusal::of("a tuple"))?.iter();
        let places = (0..).map(|place| format!("[{place}]"));
        visitor.visit_seq(Parts(places.zip(entries)))
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        count: usize,
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        match self.0.len() {
            Ok(given) if given != count => Err(Refusal::of(format!("a tuple of {count}"))),
            _ => self.deserialize_seq(visitor),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        let required = || Refusal::of(format!("a State of {}", fields.join(", ")));
        let given = self.0.cast::<PyDict>().map_err(|_| required())?;
        let values = fields.iter().map(|field| given.get_item(field));
        match values.collect::<PyResult<Option<Vec<_>>>>()? {
            Some(values) if given.len() == fields.len() => {
                let names = fields.iter().map(|&field| field.to_owned());
                visitor.visit_seq(Parts(names.zip(values)))
            }
            _ => Err(required()),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        names: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        let requirement = format!("one of {}", names.join(", "));
        let name: String = self.extracted(&requirement)?;
        let read = visitor.visit_enum(IntoDeserializer::<Refusal>::into_deserializer(name));
        read.map_err(|_| Refusal::of(requirement))
    }

    forward_to_deserialize_any! {
        i8 i16 i32 i64 u8 u16 u32 f32 char str string bytes byte_buf unit unit_struct tuple_struct
        map identifier ignored_any
    }
}

/// The entries of a tuple or the fields of a struct in order, each with its place.
struct Parts<I>(I);

impl<'de, 'py, I: Iterator<Item = (String, Bound<'py, PyAny>)>> SeqAccess<'de> for Parts<I> {
    type Error = Refusal;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Refusal> {
        let Some((place, part)) = self.0.next() else {
            return Ok(None);
        };
        let read = seed.deserialize(Given(part.clone()));
        read.map(Some).map_err(|error| error.at(place, &part))
    }
}
