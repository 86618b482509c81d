//! A cumulative sum of what is not explained, to either side.
//!
//! ```text
//! over_k  = max(0, over_(k-1)  + x_k - most_k)
//! under_k = max(0, under_(k-1) + least_k - x_k)
//! ```
//!
//! (E. Page, *Continuous inspection schemes*, Biometrika 41, 1954.) `x` is a measured change, and
//! `[least, most]` are the changes that are explained, each model error in them by its name. What is
//! beyond them adds up, what is within takes off, so what began before the fault delays nothing.
//!
//! The change of a level that is measured with white noise of deviation `s` has the noise of both
//! measurements. In the sum all but the first and the last cancel. With `[least, most]` wider by `s` a
//! second, the sum is beyond `8 s` in at most 1 of 4 million steps, at 10 to 100 Hz, where nothing
//! else is wrong ([`DEVIATIONS`](Cusum::DEVIATIONS); a test counts them).
//!
//! Assumed: noise that is white. Noise that wanders adds up.

use crate::error::{InputError, input_in_range};
use crate::math::{larger, saturate};

/// The sums to both sides.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Cusum {
    /// By how much the changes were more than explained.
    pub over: f64,
    /// By how much they were less.
    pub under: f64,
}

impl Cusum {
    /// Beyond so many standard deviations of a measurement's noise a sum is no noise. Larger: faults
    /// are found later. Smaller: at 7, 1 of 50,000 steps is a false alarm.
    pub(crate) const DEVIATIONS: f64 = 8.0;
    /// Bound that no valid input reaches.
    const MAX: f64 = 1e100;

    /// Adds the `change` of a level that is measured with noise of deviation `noise`, in `dt` [s], of
    /// which from `least` to `most` is explained. Returns whether a sum is beyond the noise by more
    /// than `tolerance`; it ends at twice that, so that it falls once its cause is gone.
    #[inline]
    pub(crate) fn add(
        &mut self,
        change: f64,
        (least, most): (f64, f64),
        (noise, dt): (f64, f64),
        tolerance: f64,
    ) -> bool {
        let (allowed, limit) = (noise * dt, Self::limit(tolerance, noise));
        self.over = saturate(self.over + (change - most - allowed), 0.0, 2.0 * limit);
        self.under = saturate(self.under + (least - change - allowed), 0.0, 2.0 * limit);
        self.most() > limit
    }

    /// The larger of both sums.
    #[inline]
    pub fn most(&self) -> f64 {
        larger(self.over, self.under)
    }

    /// What a sum is beyond where it is neither noise nor within a `tolerance`.
    #[inline]
    pub(crate) fn limit(tolerance: f64, noise: f64) -> f64 {
        tolerance + Self::DEVIATIONS * noise
    }

    /// The sums themselves, where changes can have made them.
    pub(crate) fn checked(self, field: &'static str) -> Result<Self, InputError> {
        input_in_range(field, self.over, 0.0, Self::MAX)?;
        input_in_range(field, self.under, 0.0, Self::MAX)?;
        Ok(self)
    }
}

#[cfg(test)]
mod tests;
