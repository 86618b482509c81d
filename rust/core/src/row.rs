//! Entries of a state that are as many as there are: a sequence as data, without allocation.

use core::fmt;
use core::marker::PhantomData;

use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// At most `N` entries, in order.
#[derive(Clone, Copy)]
pub(crate) struct Row<T, const N: usize> {
    places: [T; N],
    count: usize,
}

impl<T, const N: usize> Row<T, N> {
    pub(crate) fn entries(&self) -> &[T] {
        self.places.get(..self.count).unwrap_or_default()
    }
}

/// Of more than `N` entries the first `N`.
impl<T: Copy + Default, const N: usize> FromIterator<T> for Row<T, N> {
    fn from_iter<I: IntoIterator<Item = T>>(entries: I) -> Self {
        let mut row = Self {
            places: [T::default(); N],
            count: 0,
        };
        for (place, entry) in row.places.iter_mut().zip(entries) {
            *place = entry;
            row.count += 1;
        }
        row
    }
}

impl<T: Serialize, const N: usize> Serialize for Row<T, N> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.entries())
    }
}

impl<'de, T: Copy + Default + Deserialize<'de>, const N: usize> Deserialize<'de> for Row<T, N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(Entries(PhantomData))
    }
}

struct Entries<T, const N: usize>(PhantomData<T>);

impl<'de, T: Copy + Default + Deserialize<'de>, const N: usize> Visitor<'de> for Entries<T, N> {
    type Value = Row<T, N>;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "at most {N} entries")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut given: A) -> Result<Row<T, N>, A::Error> {
        let mut row = Row::from_iter([]);
        while let Some(entry) = given.next_element()? {
            let Some(place) = row.places.get_mut(row.count) else {
                return Err(A::Error::invalid_length(N + 1, &self));
            };
            *place = entry;
            row.count += 1;
        }
        Ok(row)
    }
}
