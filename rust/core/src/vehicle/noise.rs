//! The noise of a measured level, by its changes.
//!
//! White noise of variance `r` makes changes `d_k` whose differences have
//!
//! ```text
//! E (d_k - d_(k-1))^2 = 6 r
//! ```
//!
//! so what changes evenly, as by a parameter that is wrong or a fault that begins, counts little.
//!
//! Assumed: noise that is white from sample to sample.

use crate::error::{InputError, input_in_range, input_within};
use crate::math::{larger, saturate, sqrt};

/// What is known of the noise.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Noise {
    /// `r`.
    pub variance: f64,
    /// The last change; None before there was one.
    pub last: Option<f64>,
    /// How long it has been observed, up to [`TIME`](Self::TIME), or 40 periods [s].
    pub time: f64,
}

impl Noise {
    /// Time over which it is a mean [s], and the least number of changes: with fewer, in periods over
    /// 50 ms, those of a fault would pass as noise.
    pub const TIME: f64 = 2.0;
    const COUNT: f64 = 40.0;
    /// How long the first guess counts [s].
    const FIRST_TIME: f64 = 0.05;
    /// It is known after so long [s], and so many changes.
    const KNOWN_TIME: f64 = 0.25;
    const KNOWN_COUNT: f64 = 5.0;
    /// Bound of the time [s].
    const MOST_TIME: f64 = 1e6;
    /// Bounds that no valid input reaches; a change that keeps to the first has a square that keeps to
    /// the second.
    const MAX_CHANGE: f64 = 1e49;
    const MAX: f64 = 1e100;

    /// Noise of this standard `deviation`, until it is seen.
    pub fn new(deviation: f64) -> Self {
        Self {
            variance: deviation * deviation,
            last: None,
            time: Self::FIRST_TIME,
        }
    }

    /// Takes in a `change` within `dt` [s].
    #[inline]
    pub(crate) fn observe(&mut self, change: f64, dt: f64) {
        let most = larger(Self::TIME, Self::COUNT * dt);
        self.time = saturate(self.time + dt, 0.0, most);
        if let Some(last) = self.last {
            self.variance = learnt(self.variance, change - last, dt / self.time);
        }
        self.last = Some(change);
    }

    /// Whether enough has been seen of it, in periods of `dt` [s], to conclude anything.
    #[inline]
    pub(crate) fn is_known(&self, dt: f64) -> bool {
        self.time >= larger(Self::KNOWN_TIME, Self::KNOWN_COUNT * dt)
    }

    /// Its standard deviation.
    #[inline]
    pub(crate) fn deviation(&self) -> f64 {
        sqrt(self.variance)
    }

    /// The noise itself, where changes can have shown it.
    pub(crate) fn checked(self, field: &'static str) -> Result<Self, InputError> {
        input_in_range(field, self.variance, 0.0, Self::MAX)?;
        input_within(field, self.last.unwrap_or(0.0), Self::MAX_CHANGE)?;
        input_in_range(field, self.time, 0.0, Self::MOST_TIME)?;
        Ok(self)
    }
}

/// The variance `r` after changes that are `apart`, which count by their `weight`.
#[inline]
pub(super) fn learnt(variance: f64, apart: f64, weight: f64) -> f64 {
    variance + (apart * apart / 6.0 - variance) * weight
}

#[cfg(test)]
mod tests;
