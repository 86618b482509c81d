//! The Kalman filter of all estimates: a level that is measured in noise, and the parameters that
//! its steps depend on.
//!
//! ```text
//! level_k = level_(k-1) + f(theta) + w,   z_k = level_k + n,    w ~ N(0, q),  n ~ N(0, r)
//! ```
//!
//! `z` is a yaw, a position or a speed, `f` the change of it in a period that the parameters `theta`
//! explain, `q` what the model leaves open, `r` the noise of the sensor. With `phi = df/dtheta`, the
//! parameters' covariance `P`, that of the level `p` and that of both `c`:
//!
//! ```text
//! p' = p + 2 phi^T c + phi^T P phi + q,  c' = c + P phi               prediction
//! nu = z - level',  s = p' + r                                        innovation, its variance
//! level = level' + p'/s nu,  theta = theta + c'/s nu                  update
//! p = p' r/s,  c = c' r/s,  P = P - c' c'^T / s
//! P = P + (dt / time) (P - P P0^-1 P)                                 forgetting, or
//! P = min(P + rate^2 dt, P0)                                          drift
//! r = mean of (d_k - d_(k-1))^2 / 6,  d = z_k - z_(k-1) - f           noise, as `noise` has it
//! ```
//!
//! (B. Anderson and J. Moore, *Optimal Filtering*, 1979, sections 3.1 and 8.2: the extended filter.)
//! Forgetting takes information away, `d(P^-1)/dt = -(P^-1 - P0^-1) / time`, down to that of the prior
//! `P0` and no further: the estimate itself stays, so what a vehicle has shown it need not show again
//! (R. Kulhavy and M. Zarrop, *On a general concept of forgetting*, Int. J. Control 58, 1993). But where
//! nothing but the level's noise limits what is seen, forgetting takes seconds to let go of what was known
//! exactly: what changes at once, as an acceleration, drifts as a random walk (Y. Bar-Shalom, X. Li and
//! T. Kirubarajan, *Estimation with Applications to Tracking and Navigation*, 2001, section 6.2). The
//! level being a state of its own, the noise of a pose counts once, though it is in two changes.
//!
//! Assumed: noise that is white from pose to pose. Noise that wanders is taken for motion, as far as
//! `q` does not say otherwise.

use crate::error::{InputError, input_in_range, input_within};
use crate::math::{larger, saturate, smaller, sqrt};
use crate::vehicle::noise::Noise;
use nalgebra::{SMatrix, SVector};

/// An innovation counts as no larger than so many of its standard deviations (P. Huber, *Robust
/// Statistics*, 1981). Larger: a jump of the localisation moves the estimates more; smaller:
/// a vehicle that is not as told is learnt more slowly.
pub(crate) const OUTLIER: f64 = 4.0;
/// Bound that no number of a filter reaches by valid inputs, whose products are finite.
pub(crate) const MAX: f64 = 1e40;

/// The part of an estimate `value` that stands out of its `variance`, `value (1 - variance / value^2)+`
/// (L. Breiman, *Better subset regression using the nonnegative garrote*, Technometrics 37, 1995): an
/// effect that most vehicles hardly have then costs no noise.
#[inline]
pub(crate) fn beyond_doubt(value: f64, variance: f64) -> f64 {
    // Rounding may leave a variance below 0.
    let (square, doubt) = (value * value, larger(variance, 0.0));
    if square > doubt {
        value * (1.0 - doubt / square)
    } else {
        0.0
    }
}

/// Undoes what rounding does to a covariance: an asymmetry, which would grow, and a negative
/// variance of what is known to the last digit, which varies with nothing.
#[inline]
pub(crate) fn put_right<const N: usize>(covariance: &mut SMatrix<f64, N, N>) {
    *covariance = (*covariance + covariance.transpose()) * 0.5;
    for k in 0..N {
        if covariance
            .get((k, k))
            .is_some_and(|variance| *variance <= 0.0)
        {
            covariance.row_mut(k).fill(0.0);
            covariance.column_mut(k).fill(0.0);
        }
    }
}

/// Whether this is the covariance of anything, but for rounding: `P_ij^2 <= P_ii P_jj`.
///
/// # Errors
///
/// [`InputError`], naming `field`.
pub(crate) fn check_covariance<const N: usize>(
    field: &'static str,
    covariance: &SMatrix<f64, N, N>,
) -> Result<(), InputError> {
    let variances = covariance.diagonal();
    for (column, &variance) in covariance.column_iter().zip(&variances) {
        input_in_range(field, variance, 0.0, MAX)?;
        for (&both, other) in column.iter().zip(&variances) {
            input_within(field, both, 1.001 * sqrt(variance * other) + 1e-6)?;
        }
    }
    Ok(())
}

/// A measured change, and what it is expected to be.
#[derive(Clone, Copy, Debug)]
pub struct Change<const N: usize> {
    /// `z_k - z_(k-1)`.
    pub measured: f64,
    /// `f` by the present parameters.
    pub expected: f64,
    /// `phi`.
    pub slopes: SVector<f64, N>,
    /// `q`.
    pub open: f64,
    /// `r`.
    pub noise: f64,
    /// In what time [s].
    pub dt: f64,
}

/// What a measurement tells beyond what was expected.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Innovation {
    /// `nu`.
    pub value: f64,
    /// `s`.
    pub variance: f64,
}

/// A level and `N` parameters, with their covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Walk<const N: usize> {
    /// The level less its last measurement.
    pub level: f64,
    /// `p`.
    pub variance: f64,
    /// `c`.
    pub cross: SVector<f64, N>,
    /// `theta`.
    pub mean: SVector<f64, N>,
    /// `P`.
    pub covariance: SMatrix<f64, N, N>,
    /// What was seen of `r`.
    pub noise: Noise,
}

impl<const N: usize> Walk<N> {
    /// Least variance of the noise, as a share of the first guess: what is computed is rounded.
    const LEAST_NOISE: f64 = 1e-9;

    /// Parameters `mean` with these standard deviations, and noise of this variance until it is seen.
    pub fn new(mean: [f64; N], deviations: &[f64; N], noise: f64) -> Self {
        let deviations = SVector::from(*deviations);
        Self {
            level: 0.0,
            variance: noise,
            cross: SVector::zeros(),
            mean: SVector::from(mean),
            covariance: SMatrix::from_diagonal(&deviations.component_mul(&deviations)),
            noise: Noise::of_variance(noise),
        }
    }

    /// Takes in a `change`; `first` is the variance of the noise before any was seen.
    #[inline]
    pub fn observe(&mut self, change: &Change<N>, first: f64) -> Innovation {
        let Change {
            measured,
            expected,
            slopes,
            open,
            noise,
            dt,
        } = *change;
        let by_slopes = self.covariance * slopes;
        let variance =
            self.variance + 2.0 * slopes.dot(&self.cross) + slopes.dot(&by_slopes) + open;
        let cross = self.cross + by_slopes;
        let total = variance + noise;
        let value = measured - expected - self.level;
        let innovation = Innovation {
            value,
            variance: total,
        };
        // A covariance that a state brought along need not be one.
        if !(variance >= 0.0 && total > 0.0 && total < MAX) {
            self.interrupt();
            return innovation;
        }
        let most = OUTLIER * sqrt(total);
        let counted = saturate(value, -most, most);
        let (share, kept) = (variance / total, noise / total);
        // As if the part that does not count had not been measured: after a jump it is gone.
        self.level = (share - 1.0) * counted;
        self.mean += cross * (counted / total);
        self.variance = variance * kept;
        self.cross = cross * kept;
        self.covariance -= cross * (cross.transpose() / total);
        self.observe_noise(measured - expected, first, dt);
        innovation
    }

    /// Learns the noise.
    #[inline]
    fn observe_noise(&mut self, residual: f64, first: f64, dt: f64) {
        self.noise.observe(residual, dt);
        self.noise.variance = saturate(self.noise.variance, Self::LEAST_NOISE * first, MAX);
    }

    /// Forgets, after each [`observe`](Self::observe), for a `share` of the time constant, with the prior's standard `deviations`.
    #[inline]
    pub fn forget(&mut self, share: f64, deviations: &[f64; N]) {
        let (mut shown, mut trace) = (SMatrix::<f64, N, N>::zeros(), 1.0);
        let variances = self.covariance.diagonal();
        for ((column, deviation), variance) in
            (self.covariance.column_iter().zip(deviations)).zip(&variances)
        {
            let prior = deviation * deviation;
            shown += column * (column.transpose() / prior);
            trace += variance / prior;
        }
        // No eigenvalue of `P P0^-1` is larger than its trace: nothing becomes negative.
        let share = smaller(share, 1.0 / trace);
        self.covariance += (self.covariance - shown) * share;
        put_right(&mut self.covariance);
    }

    /// Lets the parameters change within `dt` [s], after each [`observe`](Self::observe), by random walks
    /// of these `rates` (standard deviations after 1 s), up to what the prior's `deviations` leave open.
    #[inline]
    pub fn drift(&mut self, dt: f64, rates: &[f64; N], deviations: &[f64; N]) {
        for (k, (rate, deviation)) in rates.iter().zip(deviations).enumerate() {
            if let Some(variance) = self.covariance.get_mut((k, k)) {
                *variance = smaller(*variance + rate * rate * dt, deviation * deviation);
            }
        }
        put_right(&mut self.covariance);
    }

    /// Keeps a parameter within its bounds.
    #[inline]
    pub fn keep(&mut self, parameter: usize, low: f64, high: f64) {
        if let Some(value) = self.mean.get_mut(parameter) {
            *value = saturate(*value, low, high);
        }
    }

    /// Keeps a parameter within its bounds, and moves the others to what they most likely are with it
    /// there, `theta - P e (theta_k - bound) / P_kk` (D. Simon, *Kalman filtering with state
    /// constraints*, IET Control Theory 4, 2010): what it cannot explain is not theirs as if it could.
    #[inline]
    pub fn constrain(&mut self, parameter: usize, low: f64, high: f64) {
        let beyond = self.get(parameter) - saturate(self.get(parameter), low, high);
        let variance = self.covariance.get((parameter, parameter)).copied();
        if let Some(variance) = variance.filter(|v| *v > 0.0 && beyond.abs() > 0.0) {
            self.mean -= self.covariance.column(parameter) * (beyond / variance);
        }
        self.keep(parameter, low, high);
    }

    /// The present value of a parameter; 0 where there is none.
    #[inline]
    pub fn get(&self, parameter: usize) -> f64 {
        self.mean.get(parameter).copied().unwrap_or(0.0)
    }

    /// The variance of the sum of parameters with these `weights`.
    #[inline]
    pub fn variance_of(&self, weights: &SVector<f64, N>) -> f64 {
        weights.dot(&(self.covariance * weights))
    }

    /// The part of the sum of parameters with these `weights` that stands out of what is not known of it,
    /// as [`beyond_doubt`] has it.
    #[inline]
    pub fn beyond_doubt(&self, weights: &SVector<f64, N>) -> f64 {
        beyond_doubt(weights.dot(&self.mean), self.variance_of(weights))
    }

    /// After a gap or a jump: the level begins anew, what was learnt stays.
    pub fn interrupt(&mut self) {
        self.level = 0.0;
        self.variance = self.noise.variance;
        self.cross = SVector::zeros();
        self.noise.last = None;
    }

    /// The filter itself, where its numbers are ones that measurements can have given.
    ///
    /// # Errors
    ///
    /// [`InputError`], naming `field`.
    pub fn checked(self, field: &'static str) -> Result<Self, InputError> {
        let vectors = self.cross.iter().chain(&self.mean);
        for &number in vectors.chain(&self.covariance).chain([&self.level]) {
            input_within(field, number, MAX)?;
        }
        check_covariance(field, &self.covariance)?;
        input_in_range(field, self.variance, 0.0, MAX)?;
        self.noise.checked(field)?;
        Ok(self)
    }
}
