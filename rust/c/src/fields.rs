//! Structs of the core as C has them: a number that is not given is NaN, a flag is a count.

/// A field of C's struct and the core's field that it stands for.
pub(crate) trait Field<T>: Copy {
    /// The core's.
    fn to_core(self) -> T;
    /// C's.
    fn of(value: T) -> Self;
}

impl Field<f64> for f64 {
    #[inline]
    fn to_core(self) -> f64 {
        self
    }

    #[inline]
    fn of(value: f64) -> Self {
        value
    }
}

impl Field<Option<f64>> for f64 {
    #[inline]
    fn to_core(self) -> Option<f64> {
        (!self.is_nan()).then_some(self)
    }

    #[inline]
    fn of(value: Option<f64>) -> Self {
        value.unwrap_or(f64::NAN)
    }
}

impl Field<usize> for usize {
    fn to_core(self) -> usize {
        self
    }

    fn of(value: usize) -> Self {
        value
    }
}

/// Not a bool: what C left there need be neither 0 nor 1.
impl Field<bool> for u32 {
    fn to_core(self) -> bool {
        self != 0
    }

    fn of(value: bool) -> Self {
        Self::from(value)
    }
}

/// C's type of a parameter of the core's `params!`.
macro_rules! c_type {
    (usize) => {
        usize
    };
    (bool) => {
        u32
    };
    ($number:ident) => {
        f64
    };
}
pub(crate) use c_type;

/// Conversions both ways between a struct of C and one of the core with the same fields. A field
/// that only one of them has does not compile.
macro_rules! same_fields {
    ($here:ident, $core:ty, { $($field:ident),+ $(,)? }) => {
        impl From<$here> for $core {
            #[inline]
            fn from(here: $here) -> Self {
                Self { $($field: $crate::fields::Field::to_core(here.$field)),+ }
            }
        }

        impl From<$core> for $here {
            #[inline]
            fn from(core: $core) -> Self {
                Self { $($field: $crate::fields::Field::of(core.$field)),+ }
            }
        }
    };
}
pub(crate) use same_fields;
