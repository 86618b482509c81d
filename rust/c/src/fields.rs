//! Structs of the core as C has them: a number that is not given is NaN, a flag is a count.

/// A field of C's struct and the core's field that it stands for.
pub(crate) trait Field<T>: Copy {
    /// The core's.
    fn to_core(self) -> T;
    /// C's.
    fn of(value: T) -> Self;
}

/// Fields of one type in both.
macro_rules! same {
    ($($kind:ty),+) => {$(
        impl Field<$kind> for $kind {
            #[inline]
            fn to_core(self) -> $kind {
                self
            }

            #[inline]
            fn of(value: $kind) -> Self {
                value
            }
        }
    )+};
}
same!(f64, usize, bool);

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

        $crate::fields::answer_fields!($here, $core, { $($field),+ });
    };
}
pub(crate) use same_fields;

/// The conversion of what the core answers, as [`same_fields`].
macro_rules! answer_fields {
    ($here:ident, $core:ty, { $($field:ident),+ $(,)? }) => {
        impl From<$core> for $here {
            #[inline]
            fn from(core: $core) -> Self {
                type Core = $core;
                let Core { $($field),+ } = core;
                Self { $($field: $crate::fields::Field::of($field)),+ }
            }
        }
    };
}
pub(crate) use answer_fields;
