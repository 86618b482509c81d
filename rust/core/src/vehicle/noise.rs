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
//! A level that is driven changes by steps, too: a speed, where its acceleration does. A step is in one such
//! difference alone, while those of noise alternate, and
//!
//! ```text
//! E (d_k - d_(k-1)) (d_(k-1) - d_(k-2)) = -4 r
//! ```
//!
//! ([`Jitter`]; the autocovariance of a second difference of white noise, G. Box and G. Jenkins, *Time Series
//! Analysis*, 1970, section 3.3).
//!
//! Of few changes it is a guess. What is judged by it takes it for `1 + (13 / n)^2` times as much after `n` of them
//! ([`Noise::at_most`]): the alarms of a [`Cusum`](crate::vehicle::cusum::Cusum) in the first 200 steps of a drive are
//! then as rare as later, where they were a thousand times as many.
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
    /// Of how many changes it is a mean, the first guess counted in: up to those in [`TIME`](Self::TIME), or
    /// 40.
    pub count: f64,
}

impl Noise {
    /// Time over which it is a mean [s], and the least number of changes: with fewer, in periods over
    /// 50 ms, those of a fault would pass as noise.
    pub const TIME: f64 = 2.0;
    const COUNT: f64 = 40.0;
    /// After so many changes the deviation counts twice. More: faults in the first second are found later. Less:
    /// at 9, five times as many false alarms at a start.
    const DOUBT: f64 = 13.0;
    /// Bounds that no valid input reaches; a change that keeps to the first has a square that keeps to
    /// the second.
    const MAX_CHANGE: f64 = 1e49;
    const MAX: f64 = 1e100;

    /// Noise of this standard `deviation`, until it is seen.
    pub fn new(deviation: f64) -> Self {
        Self::of_variance(deviation * deviation)
    }

    /// Noise of this `variance`, until it is seen.
    pub(crate) fn of_variance(variance: f64) -> Self {
        Self {
            variance,
            last: None,
            count: 1.0,
        }
    }

    /// Takes in a `change` within `dt` [s].
    #[inline]
    pub(crate) fn observe(&mut self, change: f64, dt: f64) {
        self.count = Self::counted(self.count, dt);
        if let Some(last) = self.last {
            let apart = change - last;
            self.variance += (apart * apart / 6.0 - self.variance) * (1.0 / self.count);
        }
        self.last = Some(change);
    }

    /// Of how many changes it is a mean after another within `dt` [s].
    #[inline]
    fn counted(count: f64, dt: f64) -> f64 {
        saturate(count + 1.0, 1.0, larger(Self::TIME / dt, Self::COUNT))
    }

    /// Its standard deviation.
    #[inline]
    pub(crate) fn deviation(&self) -> f64 {
        sqrt(self.variance)
    }

    /// The same with what so few changes leave open of it.
    #[inline]
    pub(crate) fn at_most(&self) -> f64 {
        sqrt(self.variance_at_most())
    }

    /// The square of that.
    #[inline]
    pub(crate) fn variance_at_most(&self) -> f64 {
        let doubt = Self::DOUBT / self.count;
        let times = 1.0 + doubt * doubt;
        self.variance * times * times
    }

    /// The noise itself, where changes can have shown it.
    pub(crate) fn checked(self, field: &'static str) -> Result<Self, InputError> {
        input_in_range(field, self.variance, 0.0, Self::MAX)?;
        input_within(field, self.last.unwrap_or(0.0), Self::MAX_CHANGE)?;
        input_in_range(field, self.count, 1.0, Self::MAX)?;
        Ok(self)
    }
}

/// The noise of a level that is driven: what of its changes alternates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Jitter {
    /// `r`.
    pub variance: f64,
    /// The last change, and the last difference of two; None before there was one.
    pub last: (Option<f64>, Option<f64>),
    /// Of how many products it is a mean: up to those in [`Noise::TIME`], or 40.
    pub count: f64,
    /// In which time the last change was [s].
    pub period: f64,
}

impl Jitter {
    /// A period that is so many times another is a gap: what changed in it is a step of one change alone,
    /// which alternates. Less: periods that differ by half show no noise.
    const GAP: f64 = 4.0;

    /// Takes in a `change` within `dt` [s].
    #[inline]
    pub(crate) fn observe(&mut self, change: f64, dt: f64) {
        if dt > Self::GAP * self.period || self.period > Self::GAP * dt {
            self.last = (None, None);
            self.period = dt;
            return;
        }
        self.period = dt;
        let apart = self.last.0.map(|last| change - last);
        if let (Some(apart), Some(before)) = (apart, self.last.1) {
            self.count = Noise::counted(self.count, dt);
            let found = -0.25 * apart * before;
            let mean = self.variance + (found - self.variance) / self.count;
            self.variance = larger(mean, 0.0);
        }
        self.last = (Some(change), apart);
    }

    /// Its standard deviation.
    #[inline]
    pub(crate) fn deviation(&self) -> f64 {
        sqrt(self.variance)
    }

    /// The noise itself, where changes can have shown it.
    pub(crate) fn checked(self, field: &'static str) -> Result<Self, InputError> {
        input_in_range(field, self.variance, 0.0, Noise::MAX)?;
        let (change, apart) = self.last;
        input_within(field, change.unwrap_or(0.0), Noise::MAX_CHANGE)?;
        input_within(field, apart.unwrap_or(0.0), Noise::MAX_CHANGE)?;
        input_in_range(field, self.count, 0.0, Noise::MAX)?;
        input_in_range(field, self.period, 0.0, Noise::MAX)?;
        Ok(self)
    }
}

#[cfg(test)]
mod tests;
