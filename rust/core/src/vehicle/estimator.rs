//! Estimates what the vehicle's parameters do not say, from its motion. All controllers share it.
//!
//! # Turning gain and steering offset
//!
//! Recursive least squares with exponential forgetting (Åström and Wittenmark, *Adaptive Control*,
//! section 2.2), written with the information matrix M. The turn `y` of the vehicle in one period is
//! modelled as
//!
//! ```text
//! y = gain (a + steer_offset b) = φᵀ θ,    φ = (a, b)ᵀ,    θ = (gain, gain steer_offset)ᵀ
//! ```
//!
//! where `a` is the turn that the vehicle's parameters predict, and `b` its derivative by the
//! steering offset. Each period of length `dt` updates
//!
//! ```text
//! M = λ M + φ φᵀ,    m = λ m + φ y,    λ = exp(-dt / turn_time)
//!
//! M = ⎡ turn_turn    turn_offset   ⎤    m = ⎡ turn_measured   ⎤    W = ⎡ GAIN_PRIOR       0       ⎤
//!     ⎣ turn_offset  offset_offset ⎦        ⎣ offset_measured ⎦        ⎣     0       OFFSET_PRIOR ⎦
//! ```
//!
//! and solves `(M + W) θ = m + W θ_0`. The prior `θ_0 = (1, 0)` with the weights W stands for the
//! vehicle's own parameters; it is not forgotten.
//!
//! # Dead time
//!
//! A normalised gradient step. If the dead time is too short by `t`, the wheels are where the model
//! had them `t` earlier, so the measured turn differs from the expected one by
//!
//! ```text
//! r = y - φᵀ θ = t d,    d = -da/dt
//! ```
//!
//! Each period adds `r d / D` to the estimate, with the forgotten sum `D = λ D + d²` (`change`) and a
//! prior weight in the denominator.
//!
//! # Slip
//!
//! Normalised least mean squares. The slip angle, from the heading to the direction of motion of
//! the no-slip point, is modelled as
//!
//! ```text
//! sample = slip + slip_length k = (c, k) (slip / c, slip_length)ᵀ
//! ```
//!
//! with the curvature `k` of the path and a constant scale `c` (`SLIP_SPLIT` over the wheelbase).
//! With the error `r` of a sample and the share `μ = dt / slip_time`, the step along the regressor
//! `(c, k)`, divided by the square of its length, is
//!
//! ```text
//! slip        = slip + μ r c² / (c² + k²)
//! slip_length = slip_length + μ r k / (c² + k²)
//! ```
//!
//! On a straight only `slip` changes, in a sharp bend mostly `slip_length`. Only a path with both
//! shows which part of the slip grows with the curvature.

use super::wheels::WheelIntegrals;
use super::{AdaptParams, Estimate, Vehicle, VehicleState};
use crate::bounds::{MAX_COORDINATE, MAX_SPEED, MAX_YAW};
use crate::error::{InputError, input_in_range, input_within};
use crate::math::{cos, exp, saturate, sin, smaller, wrap};

/// The estimator's state: sums with exponential forgetting, and the [`Estimate`] they give. The
/// symbols are those of the [module](self).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Estimator {
    /// State of the no-slip point when it was last measured; None if the motion since then must
    /// not be used.
    pub last_measured: Option<VehicleState>,
    /// `M_11`, the sum of `a²` [rad²].
    pub turn_turn: f64,
    /// `M_12` = `M_21`, the sum of `a b` [rad].
    pub turn_offset: f64,
    /// `M_22`, the sum of `b²`.
    pub offset_offset: f64,
    /// `m_1`, the sum of `a y` [rad²].
    pub turn_measured: f64,
    /// `m_2`, the sum of `b y` [rad].
    pub offset_measured: f64,
    /// `a` of the last period [rad].
    pub turn: f64,
    /// `D`, the sum of the squares of `d = -da/dt` [rad²/s²].
    pub change: f64,
    /// The present estimates.
    pub estimate: Estimate,
}

impl Estimator {
    /// Time constant of the estimated acceleration [s].
    const ACCELERATION_TIME: f64 = 0.1;
    /// `W_11`: weight of the gain 1, that of the vehicle's parameters [rad²]. Larger values make the
    /// estimate slower and steadier; 1e-4 weighs as much as one measured turn of 0.6 degrees.
    const GAIN_PRIOR: f64 = 1e-4;
    /// `W_22`: weight of the vehicle's given steering offset. Larger values make the estimate slower
    /// and steadier; 0.1 weighs as much as three periods with `b` = 0.18.
    const OFFSET_PRIOR: f64 = 0.1;
    /// Weight of the vehicle's given dead time, added to `D` [rad²/s²]; it is not forgotten. Larger
    /// values make the estimate slower.
    const CHANGE_PRIOR: f64 = 1e-2;
    /// Least gain: a lesser one would mean that the parameters are those of another vehicle.
    pub const MIN_GAIN: f64 = 0.4;
    /// Largest gain: a larger one would mean that the parameters are those of another vehicle.
    pub const MAX_GAIN: f64 = 2.5;
    /// Bound of the estimated steering offset [rad].
    pub const MAX_STEER_OFFSET: f64 = 0.15;
    /// Bound of the estimated slip [rad].
    pub const MAX_SLIP: f64 = 0.15;
    /// `c` times wheelbase: a slip sample at this curvature updates `slip` and `c` times
    /// `slip_length` equally. A path of much less curvature counts as straight.
    const SLIP_SPLIT: f64 = 0.03;
    /// Shortest distance from which a slip is estimated [m]: over a shorter one, the path's turn
    /// divided by the distance could overflow. The slowest vehicle at its default `min_speed`
    /// travels more in the shortest period.
    const LEAST_TRAVEL: f64 = 1e-9;
    /// Bound of the estimated acceleration, in wheelbases [1/s^2].
    const MAX_ACCELERATION: f64 = 20.0;
    /// Bound of the sums, which no valid input reaches.
    const MAX_SUM: f64 = 1e100;
    /// Bound of a turn, which no valid input reaches; the squares of its changes keep to `MAX_SUM`.
    const MAX_TURN: f64 = 1e30;

    /// Bound of the magnitude of `longer_dead_time` [s].
    #[inline]
    fn most_longer(vehicle: &Vehicle) -> f64 {
        0.5 * vehicle.dead_time
    }

    /// Updates gain, steering offset, dead time and acceleration from the motion in the last `dt`
    /// [s]. `now` is the state of the no-slip point, `wheels` what the wheels did in that time.
    ///
    /// ```text
    /// a = v / L(v) ∫ tan(wheel) dt,    b = v / L(v) ∫ 1 + tan(wheel)² dt
    /// ```
    ///
    /// with the mean speed `v` of the period and the turning length `L`.
    #[inline]
    pub fn observe_turn(
        &mut self,
        params: &AdaptParams,
        vehicle: &Vehicle,
        now: VehicleState,
        wheels: WheelIntegrals,
        dt: f64,
    ) {
        let Some(before) = self.last_measured else {
            self.turn = 0.0;
            return;
        };
        let speed = 0.5 * (before.speed + now.speed);
        let share = speed / vehicle.turning_length(speed);
        let (turn, by_offset) = (share * wheels.turn, share * wheels.slope);
        let estimate = self.estimate;
        self.estimate.acceleration = Self::acceleration(vehicle, &estimate, before, now, dt);
        if params.turn_time > 0.0 {
            let measured = wrap(now.yaw - before.yaw);
            self.fit_turning(params.turn_time, vehicle, turn, by_offset, measured, dt);
        }
        self.turn = turn;
    }

    /// The acceleration as a first-order low-pass filter of the measured one, with the time constant
    /// `ACCELERATION_TIME` [m/s²].
    #[inline]
    fn acceleration(
        vehicle: &Vehicle,
        estimate: &Estimate,
        before: VehicleState,
        now: VehicleState,
        dt: f64,
    ) -> f64 {
        let most = Self::MAX_ACCELERATION * vehicle.wheelbase;
        let gained = (now.speed - before.speed) / dt - estimate.acceleration;
        let weight = 1.0 - exp(-dt / Self::ACCELERATION_TIME);
        saturate(estimate.acceleration + weight * gained, -most, most)
    }

    /// Updates gain, steering offset and dead time from one `measured` turn `y`; `turn` is `a`,
    /// `by_offset` is `b`.
    ///
    /// A measured turn counts as at most `2 (|a| + MAX_STEER_OFFSET |b|)` away from the estimated
    /// one, so a jump of the localisation changes little.
    #[inline]
    fn fit_turning(
        &mut self,
        time: f64,
        vehicle: &Vehicle,
        turn: f64,
        by_offset: f64,
        measured: f64,
        dt: f64,
    ) {
        let expected =
            |estimate: &Estimate| estimate.gain * (turn + estimate.steer_offset * by_offset);
        let most = 2.0 * (turn.abs() + Self::MAX_STEER_OFFSET * by_offset.abs());
        let before = expected(&self.estimate);
        let measured = before + saturate(measured - before, -most, most);
        let kept = exp(-dt / time);
        self.turn_turn = self.turn_turn * kept + turn * turn;
        self.turn_offset = self.turn_offset * kept + turn * by_offset;
        self.offset_offset = self.offset_offset * kept + by_offset * by_offset;
        self.turn_measured = self.turn_measured * kept + turn * measured;
        self.offset_measured = self.offset_measured * kept + by_offset * measured;

        if let Some(fitted) = self.fitted_gain() {
            // Without a dead time nothing is predicted, and feedback corrects a wrong gain. There
            // an estimate, which a wrong `steer_lag` disturbs, would only cost gain margin.
            let gain = if vehicle.dead_time > 0.0 { fitted } else { 1.0 };
            // The second row of the equations for this gain, which may be 1 or clamped:
            // M_12 gain + (M_22 + W_22) gain steer_offset = m_2.
            let offset = (self.offset_measured - self.turn_offset * gain)
                / (self.offset_offset + Self::OFFSET_PRIOR)
                / gain;
            self.estimate.gain = gain;
            let most = Self::MAX_STEER_OFFSET;
            self.estimate.steer_offset = saturate(offset, -most, most);
        }

        // d, r and the step r d / (D + prior), each bounded: no period shows a dead time that is
        // off by more than the longest allowed, or changes it by more than its own length.
        let change = (self.turn - turn) / dt;
        let most_longer = Self::most_longer(vehicle);
        let residual = measured - expected(&self.estimate);
        let most = change.abs() * most_longer;
        self.change = self.change * kept + change * change;
        let residual = saturate(residual, -most, most);
        let correction = residual * change / (self.change + Self::CHANGE_PRIOR);
        let correction = saturate(correction, -dt, dt);
        let longer = self.estimate.longer_dead_time + correction;
        self.estimate.longer_dead_time = saturate(longer, -most_longer, most_longer);
    }

    /// The gain `θ_1` of the normal equations `(M + W) θ = m + W θ_0`, by Cramer's rule; None where
    /// rounding leaves no positive determinant. Two equations are solved in closed form: nalgebra's
    /// solvers need `std` or `libm`.
    #[inline]
    fn fitted_gain(&self) -> Option<f64> {
        let (aa, ab, bb) = (
            self.turn_turn + Self::GAIN_PRIOR,
            self.turn_offset,
            self.offset_offset + Self::OFFSET_PRIOR,
        );
        let (ay, by) = (self.turn_measured + Self::GAIN_PRIOR, self.offset_measured);
        let determinant = aa * bb - ab * ab;
        let gain = (ay * bb - ab * by) / determinant;
        (determinant > 0.0).then(|| saturate(gain, Self::MIN_GAIN, Self::MAX_GAIN))
    }

    /// The present estimates, with the fitted gain also where controllers use 1.
    pub fn known(&self) -> Estimate {
        Estimate {
            gain: self.fitted_gain().unwrap_or(self.estimate.gain),
            ..self.estimate
        }
    }

    /// Updates the slip from the motion of the no-slip point in the last `dt` [s].
    ///
    /// The sample is the displacement across the heading in the middle of the period, over the
    /// distance travelled. `curvature` gives `k`, the path's mean curvature [1/m] over a distance
    /// travelled [m]. Its sign is that of the steering angle: where the path is driven backwards,
    /// opposite to the path's own. The vehicle's curvature would not do: the vehicle steers by the
    /// measured position, so its curvature is correlated with the noise of the sample.
    #[inline]
    pub fn observe_slip(
        &mut self,
        params: &AdaptParams,
        vehicle: &Vehicle,
        now: VehicleState,
        curvature: impl FnOnce(f64) -> f64,
        dt: f64,
    ) {
        let (Some(before), true) = (self.last_measured, params.slip_time > 0.0) else {
            return;
        };
        let pace = params.resolved(vehicle).min_speed;
        let speed = 0.5 * (before.speed + now.speed);
        let travel = speed * dt;
        if speed.abs() < pace || travel.abs() < Self::LEAST_TRAVEL {
            return;
        }
        let direction = before.yaw + 0.5 * wrap(now.yaw - before.yaw);
        let aside = (now.y - before.y) * cos(direction) - (now.x - before.x) * sin(direction);
        let bend = curvature(travel);
        let sample = saturate(aside / travel, -4.0 * Self::MAX_SLIP, 4.0 * Self::MAX_SLIP);
        let split = Self::SLIP_SPLIT / vehicle.wheelbase;
        let estimate = &mut self.estimate;
        let missed = sample - (estimate.slip + estimate.slip_length * bend);
        let share = smaller(dt / params.slip_time, 1.0);
        let step = share * missed / (split * split + bend * bend);
        let (slip, most) = (estimate.slip + step * (split * split), Self::MAX_SLIP);
        estimate.slip = saturate(slip, -most, most);
        let (length, most) = (estimate.slip_length + step * bend, vehicle.wheelbase);
        estimate.slip_length = saturate(length, -most, most);
    }

    /// Returns the estimator if it is one that `vehicle` could have.
    ///
    /// # Errors
    ///
    /// [`InputError`], naming the field that is not.
    pub fn checked(self, vehicle: &Vehicle) -> Result<Self, InputError> {
        if let Some(last_measured) = self.last_measured {
            input_within("last_measured", last_measured.x, 2.0 * MAX_COORDINATE)?;
            input_within("last_measured", last_measured.y, 2.0 * MAX_COORDINATE)?;
            input_within("last_measured", last_measured.yaw, MAX_YAW)?;
            input_within("last_measured", last_measured.speed, MAX_SPEED)?;
        }
        for (field, value, low) in [
            ("turn_turn", self.turn_turn, 0.0),
            ("turn_offset", self.turn_offset, -Self::MAX_SUM),
            ("offset_offset", self.offset_offset, 0.0),
            ("turn_measured", self.turn_measured, -Self::MAX_SUM),
            ("offset_measured", self.offset_measured, -Self::MAX_SUM),
            ("change", self.change, 0.0),
        ] {
            input_in_range(field, value, low, Self::MAX_SUM)?;
        }
        input_within("turn", self.turn, Self::MAX_TURN)?;
        let estimate = self.estimate;
        let longer = Self::most_longer(vehicle);
        let acceleration = Self::MAX_ACCELERATION * vehicle.wheelbase;
        let offset = Self::MAX_STEER_OFFSET;
        input_in_range("gain", estimate.gain, Self::MIN_GAIN, Self::MAX_GAIN)?;
        for (field, value, most) in [
            ("steer_offset", estimate.steer_offset, offset),
            ("longer_dead_time", estimate.longer_dead_time, longer),
            ("slip", estimate.slip, Self::MAX_SLIP),
            ("slip_length", estimate.slip_length, vehicle.wheelbase),
            ("acceleration", estimate.acceleration, acceleration),
        ] {
            input_within(field, value, most)?;
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests;
