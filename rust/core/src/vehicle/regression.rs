//! Least squares that forget, for what turns and sideways motions tell of a vehicle.
//!
//! In a period, regressors `phi` and a measured change `y` of a yaw or of a position belong together
//! by `y = phi^T theta + noise`. The noise `n` of the pose itself is in such a change twice, as
//! `n_k - n_(k-1)`, so successive changes have correlated noise, and a fit of them would weigh it
//! wrongly. In a sum of changes all but the last `n` cancel. So the sums over the last [`SPAN`]
//! seconds are fitted, in which the noise is nearly white:
//!
//! ```text
//! Phi = rho Phi + phi,   Y = rho Y + y,                      rho    = exp(-dt / SPAN)
//! M   = lambda M + dt Phi Phi^T,   m = lambda m + dt Phi Y,  lambda = exp(-dt / time)
//! (M + W) theta = m + W theta_0
//! ```
//!
//! (Astrom and Wittenmark, *Adaptive Control*, section 2.2, in the form of the information matrix).
//! Weighed with `dt`, what is learnt in a second does not depend on the control period. The prior
//! `theta_0` with its weights `W = diag(w_i)` is not forgotten. `w_i` grows with the variance `s` of
//! the noise, so that noise alone does not move an estimate beyond the doubt `sigma_i` in it:
//!
//! ```text
//! w_i = least_i + s (SPAN / 2) / sigma_i^2          SPAN / 2: integral of rho^2 over all times
//! s   = mean of (r_k - r_(k-1))^2 / 2               r = Y - Phi^T theta
//! ```
//!
//! Assumed: noise that is white from pose to pose. Noise that wanders more slowly than [`SPAN`] is
//! taken for the vehicle's own motion.

use crate::bounds::MAX_DT;
use crate::error::{InputError, input_in_range, input_within};
use crate::math::{exp, saturate};
use nalgebra::{SMatrix, SVector};

/// Time over which changes are summed [s]. Longer: noise counts less; shorter: a change of the
/// vehicle is seen sooner.
pub const SPAN: f64 = 2.0;

/// Solves `[aa ab; ab bb] (a, b) = (x, y)`; 0 where rounding leaves nothing to solve.
#[inline]
pub fn solve(aa: f64, ab: f64, bb: f64, x: f64, y: f64) -> (f64, f64) {
    let determinant = aa * bb - ab * ab;
    if determinant > 0.0 {
        (
            (x * bb - y * ab) / determinant,
            (y * aa - x * ab) / determinant,
        )
    } else {
        (0.0, 0.0)
    }
}

/// Sums of `N` regressors and of what they explain.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Regression<const N: usize> {
    /// `Phi`, the regressors of the last seconds.
    pub regressors: SVector<f64, N>,
    /// `Y`, what was measured in that time.
    pub measured: f64,
    /// `M`.
    pub information: SMatrix<f64, N, N>,
    /// `m`.
    pub moment: SVector<f64, N>,
    /// `Y - Phi^T theta` of the last period.
    pub residual: f64,
    /// Variance of the noise.
    pub noise: f64,
    /// How long the noise was observed [s], up to 5 s.
    pub noise_time: f64,
}

impl<const N: usize> Regression<N> {
    /// Time constant of the noise's estimate [s].
    const NOISE_TIME: f64 = 5.0;
    /// For how long the first guess of the noise counts [s].
    const FIRST_TIME: f64 = 0.2;
    /// Bounds of the sums, of their squares and of what is left, which no valid input reaches:
    /// their products are finite.
    const MAX_SUM: f64 = 1e40;
    const MAX_SQUARE: f64 = 1e90;
    const MAX_RESIDUAL: f64 = 1e45;

    /// Nothing measured yet; noise of this variance is expected at first.
    pub fn new(noise: f64) -> Self {
        Self {
            regressors: SVector::zeros(),
            measured: 0.0,
            information: SMatrix::zeros(),
            moment: SVector::zeros(),
            residual: 0.0,
            noise,
            noise_time: Self::FIRST_TIME,
        }
    }

    /// Takes in the `regressors` and the `measured` change of a period of `dt` [s], and forgets what
    /// is older than `time` [s].
    #[inline]
    pub fn observe(&mut self, regressors: SVector<f64, N>, measured: f64, time: f64, dt: f64) {
        let kept = exp(-dt / SPAN);
        self.regressors = self.regressors * kept + regressors;
        self.measured = self.measured * kept + measured;
        let kept = exp(-dt / time);
        let weighed = self.regressors * dt;
        self.information = self.information * kept + weighed * self.regressors.transpose();
        self.moment = self.moment * kept + weighed * self.measured;
    }

    /// Learns the noise from the residuals of `theta`: the difference of two with white noise of
    /// variance `s` has `2 s`. What changes slowly, as by a wrong `theta`, counts little.
    #[inline]
    pub fn observe_noise(&mut self, theta: SVector<f64, N>, dt: f64) {
        let residual = self.measured - self.regressors.dot(&theta);
        let change = residual - self.residual;
        self.residual = residual;
        self.noise_time = saturate(self.noise_time + dt, 0.0, Self::NOISE_TIME);
        let weight = if dt < self.noise_time {
            dt / self.noise_time
        } else {
            1.0
        };
        self.noise += (0.5 * change * change - self.noise) * weight;
    }

    /// Variance of the noise; 0 before any was seen.
    #[inline]
    pub fn seen_noise(&self) -> f64 {
        if self.noise_time > Self::FIRST_TIME {
            self.noise
        } else {
            0.0
        }
    }

    /// `w_i`: weight of the given value, for a parameter with the standard deviation `doubt`.
    #[inline]
    pub fn prior(&self, least: f64, doubt: f64) -> f64 {
        // The noise of the pose that a sum began with stays in it as long as the sum does.
        least + self.noise * (0.5 * SPAN) / (doubt * doubt)
    }

    /// After a gap or a jump: the sums of changes begin anew, what was learnt stays.
    pub fn interrupt(&mut self) {
        self.regressors = SVector::zeros();
        self.measured = 0.0;
        self.residual = 0.0;
    }

    /// The regression itself, where its numbers are ones that measurements can have given.
    ///
    /// # Errors
    ///
    /// [`InputError`], naming `field`.
    pub fn checked(self, field: &'static str) -> Result<Self, InputError> {
        for &sum in self.regressors.iter().chain([&self.measured]) {
            input_within(field, sum, Self::MAX_SUM)?;
        }
        for &product in self.information.iter().chain(self.moment.iter()) {
            input_within(field, product, Self::MAX_SQUARE)?;
        }
        for &square in self.information.diagonal().iter().chain([&self.noise]) {
            input_in_range(field, square, 0.0, Self::MAX_SQUARE)?;
        }
        input_within(field, self.residual, Self::MAX_RESIDUAL)?;
        input_in_range(field, self.noise_time, 0.0, MAX_DT)?;
        Ok(self)
    }
}
