//! How parameters are declared: once, each with its default, its range, its unit and its text.
//!
//! [`params!`](crate::params!) makes the struct with its defaults and its checks. Everything else
//! that has the parameters, the Python classes, C's structs, stubs and tables in pages, is made from
//! the declaration: by the macro of the struct's name, or from `fields()` at build time.

use core::fmt;

use crate::error::{ConfigError, Requirement, in_range};
use crate::math::from_count;

/// A parameter as it was declared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    /// Its name.
    pub name: &'static str,
    /// What it is, with its unit in brackets.
    pub text: &'static str,
    /// Its default.
    pub default: Value,
    /// Whether it may be [`Value::Absent`].
    pub optional: bool,
    /// The default as it was written: a formula where it scales with the vehicle.
    pub written: &'static str,
    /// Its range; none for a flag.
    pub requirement: Option<Requirement>,
}

impl Field {
    /// Its unit; none where it has none.
    pub fn unit(&self) -> Option<&'static str> {
        Some(self.text.split_once('[')?.1.split_once(']')?.0)
    }

    /// Its formula, for a comment: choices that Rust writes with braces or calls in words, degrees
    /// as such.
    pub fn formula(&self) -> impl fmt::Display {
        Formula(self.written, self.unit())
    }
}

struct Formula(&'static str, Option<&'static str>);

impl fmt::Display for Formula {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some((value, other)) = self.0.split_once(".unwrap_or(") {
            let other = other.strip_suffix(')').unwrap_or(other);
            return match value.rsplit_once(' ') {
                Some((_, name)) => write!(
                    out,
                    "`{value}`, with `{other}` for a `{name}` that is not given"
                ),
                None => match other.strip_suffix(" * (PI / 180.0)") {
                    Some(degrees) => {
                        let degrees = degrees.strip_suffix(".0").unwrap_or(degrees);
                        let each = match self.1 {
                            Some("rad/s") => " a second",
                            _ => "",
                        };
                        write!(
                            out,
                            "`{value}`, or {degrees} degrees{each} where that is not given"
                        )
                    }
                    None => write!(out, "`{value}`, or `{other}` where that is not given"),
                },
            };
        }
        let choice = self.0.split_once("if ").and_then(|(before, rest)| {
            let (condition, rest) = rest.split_once(" { ")?;
            let (one, rest) = rest.split_once(" } else { ")?;
            Some((before, condition, one, rest.strip_suffix(" }")?))
        });
        match choice {
            Some((before, condition, one, other)) => {
                write!(out, "`{before}{one}` with ")?;
                for (index, met) in condition.split(" || ").enumerate() {
                    let or = if index == 0 { "" } else { " or " };
                    let name = met.strip_suffix(".is_some()").unwrap_or(met);
                    write!(out, "{or}`{name}`")?;
                }
                write!(out, ", else `{before}{other}`")
            }
            None => write!(out, "`{}`", self.0),
        }
    }
}

/// The value of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// Not given.
    Absent,
    /// A number.
    Number(f64),
    /// A count.
    Count(usize),
    /// True or false.
    Flag(bool),
}

impl Value {
    /// Refuses a value that `requirement` does not allow; what is absent is allowed.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming `field`.
    pub fn checked(
        self,
        field: &'static str,
        requirement: Option<Requirement>,
    ) -> Result<(), ConfigError> {
        let (value, met) = match (self, requirement) {
            (Self::Number(value), Some(Requirement::InRange(low, high))) => {
                (value, in_range(value, low, high))
            }
            (Self::Count(count), Some(Requirement::CountInRange(low, high))) => {
                (from_count(count), low <= count && count <= high)
            }
            (Self::Count(count), Some(Requirement::OddInRange(low, high))) => (
                from_count(count),
                low <= count && count <= high && !count.is_multiple_of(2),
            ),
            _ => return Ok(()),
        };
        match requirement {
            Some(requirement) if !met => Err(ConfigError {
                field,
                value,
                requirement,
            }),
            _ => Ok(()),
        }
    }
}

/// What a parameter can be.
pub trait Parameter: Copy {
    /// Whether it may be absent.
    const OPTIONAL: bool = false;

    /// Its value.
    fn value(self) -> Value;
}

impl Parameter for f64 {
    fn value(self) -> Value {
        Value::Number(self)
    }
}

impl Parameter for Option<f64> {
    const OPTIONAL: bool = true;

    fn value(self) -> Value {
        self.map_or(Value::Absent, Value::Number)
    }
}

impl Parameter for usize {
    fn value(self) -> Value {
        Value::Count(self)
    }
}

impl Parameter for bool {
    fn value(self) -> Value {
        Value::Flag(self)
    }
}

/// Declares a struct of parameters.
///
/// ```
/// popsteer_core::params! {
///     /// Parameters of a wiper.
///     pub struct WiperParams {
///         /// Sweeps in a second [1/s].
///         rate: f64 = 0.5, in [0.0, 2.0];
///         /// The longest pause [s]; absent for none.
///         pause: Option<f64> = None, in [0.1, 60.0];
///         /// Number of blades, odd.
///         blades: usize = 1, in odd [1, 5];
///         /// Whether it squirts.
///         squirts: bool = false;
///     }
/// }
/// let bad = WiperParams { rate: -1.0, ..WiperParams::DEFAULT };
/// assert_eq!(bad.checked().unwrap_err().to_string(), "rate must be in [0.0, 2.0], got -1.0");
/// ```
///
/// The struct has `DEFAULT`, `checked`, which names a field that is out of its range, and `fields`.
/// A text is one for all languages: it ends without the default and the range, which are added.
///
/// With `pub struct PidParams<Scaled> of Vehicle(wheelbase)` a field of type `Scaled` is a number
/// that may be left out: it then follows from the named fields of the vehicle by its default, a
/// formula. `resolved` fills these in; its result has plain numbers.
///
/// After the struct, `with vehicle: Vehicle = Vehicle::DEFAULT;` adds a field that is no parameter
/// itself, and is checked first. A range may name other fields.
///
/// A macro of the struct's name hands the declared fields to the macro that it is given:
/// `WiperParams! { each { before } }` is `each! { { before } { /// text... } name type = default;
/// ... }`.
#[macro_export]
macro_rules! params {
    (
        $(#[doc = $about:literal])+
        pub struct $name:ident { $($fields:tt)+ }
        $(with $whole:ident: $type:ident = $usual:expr;)?
    ) => {
        $crate::params! { @struct [$($about)+] $name [] [$($whole $type $usual)?] { $($fields)+ } }
    };
    (
        $(#[doc = $about:literal])+
        pub struct $name:ident<$scaled:ident> of $whole:ident $car:tt { $($fields:tt)+ }
    ) => {
        $crate::params! { @struct [$($about)+] $name [$scaled] [] { $($fields)+ } }
        $crate::params! { @resolved $name $whole $car { $($fields)+ } }
    };
    (@struct [$($about:literal)+] $name:ident [$($scaled:ident)?]
        [$($whole:ident $type:ident $usual:expr)?]
    {$(
        $(#[doc = $text:literal])+
        $field:ident: $kind:ident $(<$of:ty>)? = $default:expr
        $(, in $($odd:ident)? [$low:expr, $high:expr])?;
    )+}) => {
        $(#[doc = $about])+
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name$(<$scaled = Option<f64>>)? {
            $(
                /// What it is.
                pub $whole: $type,
            )?
            $(
            $(#[doc = $text])+
            #[doc = concat!(
                "\n\nDefault `", stringify!($default), "`"
                $(, ", in `[", stringify!($low), ", ", stringify!($high), "]`")?, "."
            )]
            pub $field: $kind$(<$of>)?,
            )+
        }

        impl $name {
            /// The defaults.
            pub const DEFAULT: Self = Self {
                $($whole: $usual,)?
                $($field: $crate::params!(@default $kind $default)),+
            };

            /// The parameters as they were declared.
            pub fn fields() -> [$crate::params::Field; [$(stringify!($field)),+].len()] {
                let Self { $($field,)+ .. } = Self::DEFAULT;
                [$($crate::params::Field {
                    name: stringify!($field),
                    text: concat!($($text),+).trim_ascii(),
                    default: $crate::params::Parameter::value($field),
                    optional: $crate::params!(@type $kind$(<$of>)?),
                    written: stringify!($default),
                    requirement: $crate::params!(@required $kind $($($odd)? [$low, $high])?),
                }),+]
            }
        }

        impl Default for $name {
            fn default() -> Self {
                Self::DEFAULT
            }
        }

        impl$(<$scaled: $crate::params::Parameter>)? $name$(<$scaled>)? {
            /// The parameters themselves if each is within its range.
            ///
            /// # Errors
            ///
            #[doc = "[`ConfigError`](popsteer_core::ConfigError), naming the one that is not."]
            pub fn checked(self) -> Result<Self, $crate::error::ConfigError> {
                $(self.$whole.checked()?;)?
                let Self { $($field,)+ .. } = self;
                $(
                    $crate::params::Parameter::value($field).checked(
                        stringify!($field),
                        $crate::params!(@required $kind $($($odd)? [$low, $high])?),
                    )?;
                )+
                Ok(self)
            }
        }

        #[doc(hidden)]
        #[macro_export]
        macro_rules! $name {
            ($callback:ident $before:tt) => {
                $callback! { $before $(
                    $(#[doc = $text])+ $field: $kind$(<$of>)? = $default
                    $(, in [$low, $high])?;
                )+ }
            };
        }
    };
    (@resolved $name:ident $whole:ident ($($car:ident),+) {$(
        $(#[doc = $text:literal])+
        $field:ident: $kind:ident $(<$of:ty>)? = $default:expr
        $(, in $($odd:ident)? [$low:expr, $high:expr])?;
    )+}) => {
        impl $name {
            /// The parameters with the defaults that scale with `vehicle` filled in.
            pub fn resolved(self, vehicle: &$whole) -> $name<f64> {
                $(let $car = vehicle.$car;)+
                $name { $($field: $crate::params!(@or $kind self.$field, $default)),+ }
            }
        }

        impl From<$name<f64>> for $name {
            fn from(resolved: $name<f64>) -> Self {
                Self { $($field: $crate::params!(@given $kind resolved.$field)),+ }
            }
        }
    };
    (@default Scaled $default:expr) => { None };
    (@default $kind:ident $default:expr) => { $default };
    (@or Scaled $given:expr, $default:expr) => { $given.unwrap_or($default) };
    (@or $kind:ident $given:expr, $default:expr) => { $given };
    (@given Scaled $number:expr) => { Some($number) };
    (@given $kind:ident $value:expr) => { $value };
    (@type Scaled) => { true };
    (@type $kind:ty) => { <$kind as $crate::params::Parameter>::OPTIONAL };
    (@required $kind:ident) => { None };
    (@required usize [$low:expr, $high:expr]) => {
        Some($crate::error::Requirement::CountInRange($low, $high))
    };
    (@required usize odd [$low:expr, $high:expr]) => {
        Some($crate::error::Requirement::OddInRange($low, $high))
    };
    (@required $kind:ident [$low:expr, $high:expr]) => {
        Some($crate::error::Requirement::InRange($low, $high))
    };
}
