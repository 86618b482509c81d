//! States of the core as `popsteer.State`, and back, by the names that serde derives.

use std::fmt::{self, Display};

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::tuple::BoundTupleIterator;
use pyo3::types::{PyBool, PyDict, PyFloat, PyTuple, PyType};
use serde::de::value::StrDeserializer;
use serde::de::{
    DeserializeOwned, DeserializeSeed, IntoDeserializer, MapAccess, SeqAccess, Visitor,
};
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
    if !given
        .as_ref()
        .is_some_and(|given| given.eq(controller).unwrap_or(false))
    {
        let given = given.unwrap_or_else(|| py.None().into_bound(py));
        return Err(argument_error(
            py,
            CONTROLLER,
            given,
            &format!("'{controller}'"),
        ));
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

/// Why a value does not go over.
#[derive(Debug)]
pub(crate) enum Refusal {
    /// Python's own error.
    Raised(PyErr),
    /// A field, innermost first, that has not what is required.
    Field {
        path: Vec<String>,
        value: Option<Py<PyAny>>,
        requirement: String,
    },
}

impl Refusal {
    fn of(requirement: impl Display) -> Self {
        let requirement = requirement.to_string();
        Self::Field {
            path: Vec::new(),
            value: None,
            requirement,
        }
    }

    /// The same of `value`, which stands at `place`.
    fn at(mut self, place: String, given: &Bound<'_, PyAny>) -> Self {
        if let Self::Field { path, value, .. } = &mut self {
            path.push(place);
            value.get_or_insert_with(|| given.clone().unbind());
        }
        self
    }

    fn raised(self, py: Python<'_>) -> PyErr {
        match self {
            Self::Raised(error) => error,
            Self::Field {
                path,
                value,
                requirement,
            } => {
                let mut field = String::new();
                for place in path.iter().rev() {
                    if !field.is_empty() && !place.starts_with('[') {
                        field.push('.');
                    }
                    field.push_str(place);
                }
                if field.is_empty() {
                    field.push_str("state");
                }
                let value = value.unwrap_or_else(|| py.None()).into_bound(py);
                argument_error(py, &field, value, &requirement)
            }
        }
    }
}

impl Display for Refusal {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Raised(error) => error.fmt(formatter),
            Self::Field { requirement, .. } => formatter.write_str(requirement),
        }
    }
}

impl std::error::Error for Refusal {}

impl From<PyErr> for Refusal {
    fn from(error: PyErr) -> Self {
        Self::Raised(error)
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
        serialize_unit_variant(&str, u32, &str) -> Ok;
        serialize_tuple_struct(&str, usize) -> SerializeTupleStruct;
        serialize_tuple_variant(&str, u32, &str, usize) -> SerializeTupleVariant;
        serialize_map(Option<usize>) -> SerializeMap;
        serialize_struct_variant(&str, u32, &str, usize) -> SerializeStructVariant;
    }
}

/// A tuple in the making.
struct Entries<'py>(ToPython<'py>, Vec<Bound<'py, PyAny>>);

impl<'py> SerializeSeq for Entries<'py> {
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

impl<'py> SerializeTuple for Entries<'py> {
    type Ok = Bound<'py, PyAny>;
    type Error = Refusal;

    fn serialize_element<T: Serialize + ?Sized>(&mut self, entry: &T) -> Result<(), Refusal> {
        SerializeSeq::serialize_element(self, entry)
    }

    fn end(self) -> Made<'py> {
        SerializeSeq::end(self)
    }
}

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

impl<'de> Deserializer<'de> for Given<'_> {
    type Error = Refusal;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Refusal> {
        Err(Refusal::of("of another kind"))
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        match self.0.extract() {
            Ok(value) => visitor.visit_bool(value),
            Err(_) => Err(Refusal::of("True or False")),
        }
    }

    fn deserialize_u64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        match self.0.extract() {
            Ok(value) => visitor.visit_u64(value),
            Err(_) => Err(Refusal::of("a whole number from 0 to 2**64 - 1")),
        }
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        match self.0.extract() {
            Ok(value) => visitor.visit_f64(value),
            Err(_) => Err(Refusal::of("a number")),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        if self.0.is_none() {
            visitor.visit_none()
        } else {
            visitor.visit_some(self)
        }
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        let entries = self
            .0
            .cast::<PyTuple>()
            .map_err(|_| Refusal::of("a tuple"))?;
        let mut entries = Places(entries.iter(), 0);
        let value = visitor.visit_seq(&mut entries)?;
        if entries.0.len() == 0 {
            Ok(value)
        } else {
            Err(Refusal::of(format!("a tuple of {}", entries.1)))
        }
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
        let values = values.collect::<PyResult<Option<Vec<_>>>>()?;
        match values {
            Some(values) if given.len() == fields.len() => {
                visitor.visit_map(Named(fields.iter().zip(values), None))
            }
            _ => Err(required()),
        }
    }

    forward_to_deserialize_any! {
        i8 i16 i32 i64 u8 u16 u32 f32 char str string bytes byte_buf unit unit_struct tuple_struct
        map enum identifier ignored_any
    }
}

/// The entries of a tuple, and how many have been taken.
struct Places<'py>(BoundTupleIterator<'py>, usize);

impl<'de> SeqAccess<'de> for &mut Places<'_> {
    type Error = Refusal;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Refusal> {
        let Some(entry) = self.0.next() else {
            return Ok(None);
        };
        let place = self.1;
        self.1 += 1;
        let value = seed.deserialize(Given(entry.clone()));
        value
            .map(Some)
            .map_err(|error| error.at(format!("[{place}]"), &entry))
    }
}

/// The fields of a struct, and the one whose value is next.
struct Named<'py, I>(I, Option<(&'static str, Bound<'py, PyAny>)>);

impl<'de, 'py, I> MapAccess<'de> for Named<'py, I>
where
    I: Iterator<Item = (&'static &'static str, Bound<'py, PyAny>)>,
{
    type Error = Refusal;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, Refusal> {
        let Some((&field, value)) = self.0.next() else {
            return Ok(None);
        };
        self.1 = Some((field, value));
        let name: StrDeserializer<'_, Refusal> = field.into_deserializer();
        seed.deserialize(name).map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Refusal> {
        let Some((field, value)) = self.1.take() else {
            return Err(Refusal::of("read name by name"));
        };
        let read = seed.deserialize(Given(value.clone()));
        read.map_err(|error| error.at(field.to_owned(), &value))
    }
}
