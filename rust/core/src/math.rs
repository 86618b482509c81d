//! Angles, limits and the float shim.
//!
//! The functions of the platform's mathematics library are bit-equal to `CPython`'s on one
//! machine, which is what lets the pure-Python reference agree to the last bit. `hypot`,
//! `powi`, `mul_add` and `f64::clamp` are not used: the first three round differently, the
//! last keeps a panic path.

pub use core::f64::consts::PI;
use core::f64::consts::TAU;

macro_rules! shim {
    ($($name:ident($($arg:ident),+) = $libm:ident;)+) => {$(
        #[doc = concat!("`", stringify!($name), "` from `std`, or from `libm` without it.")]
        #[inline]
        pub fn $name($($arg: f64),+) -> f64 {
            #[cfg(feature = "std")]
            return f64::$name($($arg),+);
            #[cfg(not(feature = "std"))]
            return libm::$libm($($arg),+);
        }
    )+};
}

shim! {
    sin(x) = sin;
    cos(x) = cos;
    tan(x) = tan;
    acos(x) = acos;
    atan(x) = atan;
    atan2(y, x) = atan2;
    exp(x) = exp;
    sqrt(x) = sqrt;
    powf(x, y) = pow;
}

/// `value` limited to `[low, high]`, for `low <= high` and a `value` that is a number.
///
/// # Examples
///
/// ```
/// assert_eq!(popsteer_core::math::saturate(3.0, -1.0, 1.0), 1.0);
/// ```
#[inline]
pub fn saturate(value: f64, low: f64, high: f64) -> f64 {
    if value < low {
        low
    } else if value > high {
        high
    } else {
        value
    }
}

/// The lesser of two numbers; returns `b` on ties or NaN. It is one instruction, unlike `f64::min`,
/// which has to treat NaN.
#[inline]
pub(crate) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The larger of two numbers, as [`smaller`].
#[inline]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The share that remains after `time` of what fades with a time constant: `exp(-time / time_constant)`,
/// nothing where the time constant is 0.
///
/// # Examples
///
/// ```
/// assert_eq!(popsteer_core::math::decay(0.1, 0.0), 0.0);
/// ```
#[inline]
pub fn decay(time: f64, time_constant: f64) -> f64 {
    if time_constant > 0.0 {
        exp(-time / time_constant)
    } else {
        0.0
    }
}

/// What remains of `value` after whole `period`s, with the sign of `value`: `value % period`, which
/// is exact, and `value` itself where it is shorter than the period.
#[inline]
pub fn remainder(value: f64, period: f64) -> f64 {
    if value.abs() < period {
        value
    } else {
        value % period
    }
}

/// Cosine and sine of `angle`, each within 0.001, in a fifth of their instructions: from the first
/// terms of the series about the right angle on the same side.
#[inline]
pub(crate) fn rough_direction(angle: f64) -> (f64, f64) {
    let angle = wrap(angle);
    let beyond = angle.abs() - 0.5 * PI;
    let square = beyond * beyond;
    let cosine = beyond * (square * (1.0 / 6.0 - square * (1.0 / 120.0 - square / 5040.0)) - 1.0);
    let sine = 1.0 - square * (0.5 - square * (1.0 / 24.0 - square / 720.0));
    (cosine, sine.copysign(angle))
}

/// A Pade approximant of the tangent: within 1 % up to 1.25 rad, finite up to a right angle.
#[inline]
pub(crate) fn rough_tangent(angle: f64) -> f64 {
    let square = angle * angle;
    angle * (15.0 - square) / (15.0 - 6.0 * square)
}

/// `angle` [rad] brought into `[-pi, pi]` by whole turns.
///
/// The remainder is exact, so an angle that needs no turn comes back unchanged, and
/// `wrap(-a) == -wrap(a)` for every `a`.
///
/// # Examples
///
/// ```
/// use popsteer_core::math::{PI, wrap};
/// assert_eq!(wrap(0.5), 0.5);
/// assert!((wrap(1.5 * PI) + 0.5 * PI).abs() < 1e-15);
/// ```
#[inline]
pub fn wrap(angle: f64) -> f64 {
    if (-PI..=PI).contains(&angle) {
        return angle;
    }
    let turned = remainder(angle, TAU);
    if turned > PI {
        turned - TAU
    } else if turned < -PI {
        turned + TAU
    } else {
        turned
    }
}

/// A count as a float; exact below 2^53, as all counts of waypoints and grid points are.
#[inline]
#[expect(
    clippy::as_conversions,
    clippy::cast_precision_loss,
    clippy::cast_possible_wrap,
    reason = "signed conversion is one instruction; no count comes near 2^53"
)]
pub fn from_count(count: usize) -> f64 {
    count as i64 as f64
}

/// The whole part of a float as a count: 0 for a negative one or NaN, saturating above.
#[inline]
#[expect(
    clippy::as_conversions,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the cast saturates, and what is negative is made 0"
)]
pub fn to_count(value: f64) -> usize {
    let whole = value as i64;
    if whole > 0 { whole as usize } else { 0 }
}

/// The least count that is not below a float: 0 for a negative one or NaN, saturating above.
#[inline]
pub fn ceil_to_count(value: f64) -> usize {
    let whole = to_count(value);
    if from_count(whole) < value {
        whole.saturating_add(1)
    } else {
        whole
    }
}
