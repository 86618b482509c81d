//! What a drive is not as told: brakes that give less, and a drive that is later.
//!
//! # Equations
//!
//! The [`Observer`](super::disturbance::Observer) knows the drive as it is told. What it is not enters its
//! speed `v` and its disturbance `d` linearly, by biases `b` that stay:
//!
//! ```text
//! b = [ g ]   brakes give 1 + g of what they are commanded:   B = [ drop of the speed by the brakes    ]
//!     [ T ]   the drive begins later by T [s]:                    [ - change of its acceleration       ]
//!     [ L ]   it builds up more slowly by L [s]:                  [ - change of a slower drive's       ]
//! ```
//!
//! With the observer's gains `k` and `l`, its error for a unit of each bias is `V`, and its innovation `r`
//! has the slopes `S`; the biases then follow by recursive least squares:
//!
//! ```text
//! S = V_v + dt V_d + B,   V_v = (1 - k) S,   V_d = V_d - l S
//! s = S^T P S + p,   b = b + P S (r - S^T b) / s,   P = P - P S S^T P / s
//! g = k g,   P_gg = k^2 P_gg + (1 - k^2) P0_gg,   k = exp(-dt / MEMORY)
//! ```
//!
//! where `p` is the variance of the observer's own innovation: `NOISE` planned decelerations, squared, and what
//! its first guess (`START`) and a slope that changes by `SLOPE` leave open; these last for the observer's time
//! constant, and so count as white noise of so many periods. That is the second stage of B. Friedland,
//! *Treatment of bias in recursive filtering*, IEEE Trans. Automatic Control 14, 1969; the observer is the
//! first one, and does not know of it. `g` is an Ornstein-Uhlenbeck process: what a long and slight braking
//! seems to show, drag in bends or an engine's, is none of the brakes and fades, while a hard one shows it anew
//! within tenths of a second. Of the biases only `g` is used, as far as it is [`beyond_doubt`]: commands in
//! flight brake by `1 + g` of what they say, later ones say so much more, and the disturbance is `d + V_d g`.
//! The other two are there so that a drive which is late is not taken for weak brakes (S. F. Schmidt,
//! *Application of state-space methods to navigation problems*, Advances in Control Systems 3, 1966).
//!
//! Assumed: brakes that give no more than they are told, `-LEAST <= g <= 0`; of stronger ones the disturbance has
//! it.

use nalgebra::{SMatrix, SVector};

use crate::error::{InputError, input_in_range, input_within};
use crate::math::{decay, larger, saturate, sqrt};
use crate::vehicle::kalman::{MAX, OUTLIER, beyond_doubt, check_covariance, put_right};

/// Standard deviations before anything was seen: of `g`; of `T` and `L` [s], and that share of the drive's delay
/// and lag. More of the first: weak brakes are known sooner, and more is taken for them.
const PRIOR: (f64, (f64, f64)) = (0.2, (0.1, 0.25));
/// What the observer's first speed and disturbance are off by, in planned decelerations: what was commanded
/// before the first step, and the slope there, are not known.
const START: (f64, f64) = (0.1, 0.33);
/// What one speed leaves open, in planned decelerations [s]: noise, and steps of a period.
pub(super) const NOISE: f64 = 0.01;
/// How much a slope changes the disturbance within a second, in planned decelerations. More: weak brakes are
/// known later. Less: what changes the speed otherwise is taken for them.
const SLOPE: f64 = 0.005;
/// For how long what was found of the brakes is believed [s]. More: drag in bends is taken for weak brakes.
/// Less: a long braking loses what it found.
const MEMORY: f64 = 5.0;
/// By how much less brakes are believed to give, at most.
const LEAST: f64 = 0.5;

/// What is known of the biases.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Bias {
    /// `V_v`: [m/s] for a unit of each.
    pub speed: SVector<f64, 3>,
    /// `V_d`: [m/s²] for a unit of each.
    pub push: SVector<f64, 3>,
    /// `b`.
    pub mean: SVector<f64, 3>,
    /// `P`.
    pub covariance: SMatrix<f64, 3, 3>,
    /// Covariance of the observer's own speed and disturbance: of the speed, of both, of the disturbance.
    pub own: (f64, f64, f64),
}

/// What the observer did in a period.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corrected {
    /// Its innovation [m/s].
    pub error: f64,
    /// The change of the speed by the brakes [m/s].
    pub braked: f64,
    /// The changes of what the drive gives, and of what a slower one would [m/s²].
    pub changed: (f64, f64),
    /// The gains, of the speed and of the disturbance [1/s].
    pub gains: (f64, f64),
    /// The period [s].
    pub dt: f64,
}

impl Bias {
    /// Of a drive that answers within `response` [s] and plans with the deceleration `braking` [m/s²], before
    /// anything was seen.
    pub fn new(response: f64, braking: f64) -> Self {
        let late = PRIOR.1.0 + PRIOR.1.1 * response;
        let prior = SVector::from([PRIOR.0, late, late]);
        let (speed, push) = (START.0 * braking, START.1 * braking);
        Self {
            speed: SVector::zeros(),
            push: SVector::zeros(),
            mean: SVector::zeros(),
            covariance: SMatrix::from_diagonal(&prior.component_mul(&prior)),
            own: (speed * speed, 0.0, push * push),
        }
    }

    /// Takes in what the observer of such a drive, with the time constant `time` [s], did.
    pub(super) fn observe(&mut self, step: &Corrected, (response, braking, time): (f64, f64, f64)) {
        let (k, l) = step.gains;
        let open = self.own_variance(step, braking, time);
        let inputs = [step.braked, -step.changed.0, -step.changed.1];
        let slopes = self.speed + self.push * step.dt + SVector::from(inputs);
        self.speed = slopes * (1.0 - k);
        self.push -= slopes * l;
        let cross = self.covariance * slopes;
        let total = slopes.dot(&cross) + open;
        let most = OUTLIER * sqrt(total);
        let error = saturate(step.error - slopes.dot(&self.mean), -most, most);
        self.mean += cross * (error / total);
        self.mean.x = saturate(self.mean.x, -LEAST, 0.0);
        self.covariance -= cross * (cross.transpose() / total);
        self.fade(step.dt);
        put_right(&mut self.covariance);
        // A state that was brought along need not be one.
        if self.check().is_err() {
            *self = Self::new(response, braking);
        }
    }

    /// `p`, and the covariance of the observer's own speed and disturbance after its correction (in the form
    /// of P. Joseph, which holds for any gains).
    fn own_variance(&mut self, step: &Corrected, braking: f64, time: f64) -> f64 {
        let (dt, (k, l)) = (step.dt, step.gains);
        let (noise, slope) = (NOISE * braking, SLOPE * braking);
        let (noise, slope) = (noise * noise, slope * slope);
        let (v, both, d) = self.own;
        let (v, both, d) = (
            v + dt * (2.0 * both + dt * d),
            both + dt * d,
            d + slope * dt,
        );
        let kept = 1.0 - k;
        self.own = (
            kept * kept * v + k * k * noise,
            kept * (both - l * v) + k * l * noise,
            d - 2.0 * l * both + l * l * (v + noise),
        );
        v * larger(time / dt, 1.0) + noise
    }

    /// `dt` [s] later the brakes are less certainly what they were.
    fn fade(&mut self, dt: f64) {
        let kept = decay(dt, MEMORY);
        let shares = SVector::from([kept, 1.0, 1.0]);
        self.mean.component_mul_assign(&shares);
        self.covariance
            .component_mul_assign(&(shares * shares.transpose()));
        self.covariance.m11 += (1.0 - kept * kept) * PRIOR.0 * PRIOR.0;
    }

    /// What the brakes give of what they are commanded.
    pub(super) fn brakes(&self) -> f64 {
        1.0 + beyond_doubt(self.mean.x, self.covariance.m11)
    }

    /// Where the observer begins anew, what was learnt stays.
    pub(super) fn rest(mut self) -> Self {
        self.speed = SVector::zeros();
        self.push = SVector::zeros();
        self
    }

    /// Whether this is what can have been found.
    ///
    /// # Errors
    ///
    /// [`InputError`] where a number is not.
    pub(super) fn check(&self) -> Result<(), InputError> {
        const FIELD: &str = "observer.bias";
        let vectors = self.speed.iter().chain(&self.push).chain(&self.mean);
        let (speed, both, push) = self.own;
        for &number in vectors.chain([&both]) {
            input_within(FIELD, number, MAX)?;
        }
        input_in_range(FIELD, self.mean.x, -LEAST, 0.0)?;
        for variance in [speed, push] {
            input_in_range(FIELD, variance, 0.0, MAX)?;
        }
        check_covariance(FIELD, &self.covariance)
    }
}
