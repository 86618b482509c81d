//! Estimates what the vehicle's parameters do not say, from its motion. All controllers share it.
//!
//! Two least-squares fits that forget ([`Regression`]), each of `y = φᵀ θ` in every period: `y` is
//! measured, `θ` is looked for.
//!
//! # Turning: gain, steering offset and dead time
//!
//! ```text
//! y = gain (a + t c) + gain steer_offset b - gain t' c
//!
//! φ = (a + t c, b, -c)ᵀ,    θ = (gain, gain steer_offset, gain t')ᵀ
//!
//! a = v / L(v) ∫ tan(wheel) dt,    b = v / L(v) ∫ (1 + tan(wheel)²) dt,
//! c = v / L(v) (tan(wheel at the end) - tan(wheel at the start))
//! ```
//!
//! `y` is the measured turn, `a` the one by the vehicle's parameters, with the mean speed `v` and
//! the turning length `L`. `b` is its derivative by the steering offset. Both the dead time's estimate
//! before this period, `t`, and the one looked for, `t'`, are counted from the dead time given. A dead
//! time that is longer by `t'` shifts the wheels' motion, so that the vehicle turns by `t' c` less in
//! the period. The wheels that `a` is computed with are shifted by `t` already. In the code, `a` of
//! sums and products is the first of φ, `a + t c`, and `c` the third, `-c`.
//!
//! On a straight, an offset and a low gain look alike; in a steady bend they do too, and the dead time
//! does not show. So the
//! gain is fitted first, with the other two almost free: only turns that neither of them explains
//! show it. Then the other two are fitted for that gain. With the sums `M` and `m` of [`Regression`]
//! split into the gain's row and the rest, and the weights `w` and `W` of the priors:
//!
//! ```text
//! M = [aa  r ]    m = [ma]    r = (ab, ac),    B = [bb  bc],    mo = (mb, mc)ᵀ
//!     [rᵀ  B ]        [mo]                         [bc  cc]
//!
//! gain = (ma - r B⁻¹ mo + w) / (aa - r B⁻¹ rᵀ + w)       Schur complement of B; the prior is gain 1
//! (B + W) (steer_offset, t')ᵀ = mo / gain - rᵀ           the last two rows, divided by the gain
//! ```
//!
//! Assumed: the speed signal and the lag are right; a lag that is longer than given is mostly taken
//! for dead time.
//!
//! # Slip
//!
//! ```text
//! y = slip s + compliance s v² k / L,    φ = (s, s v² k / L)ᵀ,    in wheelbases L
//! ```
//!
//! `y` is the motion aside of the heading, `s` the distance, `k` the curvature by the wheels at the
//! start of the period. Tyres slip in proportion to the lateral acceleration `v² k`, so what is
//! learnt at one speed holds at another with the square of the speed; a wrong `no_slip_point`, whose
//! slip does not grow with the speed, is found right at one speed only.
//!
//! `slip` and `compliance` solve `(M + W) θ = m`. Most vehicles hardly slip, and in them the noise of
//! the yaw would cost more than what is learnt. So each counts only as far as it stands out of its
//! noise (L. Breiman's non-negative garrote, *Better subset regression using the nonnegative garrote*,
//! Technometrics 37, 1995, for each by itself; what the two share, `(M + W)₁₂`, is left out of `vᵢ`):
//!
//! ```text
//! θᵢ (1 - vᵢ / θᵢ²)₊,    vᵢ = d / (M + W)ᵢᵢ,    d = (n + (SPAN v / L)² n_yaw) dt
//! ```
//!
//! `d` is the spectral density of the noise in the sums of [`Regression`] at low frequencies. The
//! noise of the position, of variance `n`, is in a sum once. That of the heading, of variance
//! `n_yaw`, moves the vehicle aside in every period, so a sum over [`SPAN`] seconds holds all of its periods.
//!
//! Assumed: both are white. Noise counts once it has been seen: that of the yaw in the turns, so
//! never where those are not fitted (`turn_time = 0`).

use super::regression::{Regression, SPAN, solve};
use super::wheels::WheelIntegrals;
use super::{AdaptParams, Estimate, Vehicle, VehicleState};
use crate::bounds::{MAX_COORDINATE, MAX_SPEED, MAX_YAW};
use crate::error::{InputError, input_in_range, input_within};
use crate::math::{cos, exp, saturate, sin, smaller, sqrt, wrap};
use nalgebra::SVector;

/// The estimator's state: sums with exponential forgetting, and the [`Estimate`] they give.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Estimator {
    /// State of the no-slip point when it was last measured; none if the motion since then must not
    /// be used.
    pub last_measured: Option<VehicleState>,
    /// The measured turns over `φ = (a + t c, b, -c)`.
    pub turning: Regression<3>,
    /// The motions aside of the heading over `φ = (s, s v² k / L)`, in wheelbases.
    pub sliding: Regression<2>,
    /// Slip per lateral acceleration, in wheelbases [rad s^2].
    pub slip_compliance: f64,
    /// The present estimates.
    pub estimate: Estimate,
}

impl Default for Estimator {
    fn default() -> Self {
        Self {
            last_measured: None,
            turning: Regression::new(Self::FIRST_YAW_NOISE),
            sliding: Regression::new(Self::FIRST_POSITION_NOISE),
            slip_compliance: 0.0,
            estimate: Estimate::DEFAULT,
        }
    }
}

impl Estimator {
    /// Variances of the noise before any was seen: of the yaw [rad^2], and of the position in
    /// wheelbases.
    const FIRST_YAW_NOISE: f64 = 2.5e-5;
    const FIRST_POSITION_NOISE: f64 = 1.4e-5;
    /// Below so many wheelbases a second a vehicle forgets more slowly, at rest not at all.
    pub(crate) const SLOW: f64 = 0.2;
    /// Time constant of the estimated acceleration [s].
    const ACCELERATION_TIME: f64 = 0.1;
    /// Weights of the gain 1 [rad^2 s], of the given steering offset [s] and of the given dead time
    /// [rad^2/s]: not forgotten. Larger values make the estimates slower and steadier.
    const GAIN_PRIOR: f64 = 3e-3;
    const OFFSET_PRIOR: f64 = 1.0;
    const DELAY_PRIOR: f64 = 2e-3;
    /// How far the gain may be from 1 [-], the offset from the given one [rad], and the dead time
    /// from the given one [s]: standard deviations. The noisier the yaw, the more they weigh
    /// ([`Regression::prior`]).
    const GAIN_DOUBT: f64 = 0.1;
    const OFFSET_DOUBT: f64 = 0.03;
    const DELAY_DOUBT: f64 = 0.1;
    /// Share of their weights that offset and dead time have where they are free: what keeps a
    /// vehicle that has not turned yet from a division by 0.
    const FREE: f64 = 1e-3;
    /// Weights of no slip [s] and of no slip by the lateral acceleration [1/s^3], in wheelbases.
    const SLIP_PRIOR: f64 = 0.25;
    const COMPLIANCE_PRIOR: f64 = 0.04;
    /// Standard deviations of the slip [rad] and, in wheelbases, of the slip per curvature.
    const SLIP_DOUBT: f64 = 0.02;
    const LENGTH_DOUBT: f64 = 0.1;
    /// A measured change counts as no farther from the expected one than so many standard deviations
    /// of the noise, and so many times the largest turn or slip that the estimates could explain. A
    /// jump of the localisation then changes little.
    const OUTLIER: f64 = 6.0;
    const MOST_TURNS: f64 = 2.0;
    const MOST_SLIPS: f64 = 4.0;
    /// How fast the dead time changes [s/s]. Faster: one that nobody told costs less; slower: wheels
    /// that stick are not taken for late ones before the monitor sees them.
    const DELAY_RATE: f64 = 0.2;
    /// Shortest dead time that counts where none was given [s].
    const LEAST_DEAD_TIME: f64 = 0.005;
    /// How much longer than given the dead time may turn out [s].
    pub const MAX_LONGER: f64 = 0.25;
    /// Least gain: a lesser one would mean that the parameters are those of another vehicle.
    pub const MIN_GAIN: f64 = 0.4;
    /// Largest gain: a larger one would mean that the parameters are those of another vehicle.
    pub const MAX_GAIN: f64 = 2.5;
    /// The gains of a vehicle of which nothing is known.
    pub(crate) const GAINS: (f64, f64) = (Self::MIN_GAIN, Self::MAX_GAIN);
    /// How far the gain of a turn may be from the estimated one, as a share of it: tyres and speed.
    const GAIN_SPREAD: f64 = 0.25;
    /// Bound of the estimated steering offset [rad].
    pub const MAX_STEER_OFFSET: f64 = 0.15;
    /// Bound of the estimated slip [rad].
    pub const MAX_SLIP: f64 = 0.15;
    /// Shortest distance from which a slip is estimated [m]: over a shorter one, the path's turn
    /// divided by the distance could overflow. The slowest vehicle at its default `min_speed`
    /// travels more in the shortest period.
    const LEAST_TRAVEL: f64 = 1e-9;
    /// Bound of the estimated acceleration, in wheelbases [1/s^2].
    const MAX_ACCELERATION: f64 = 20.0;
    /// Bound of the slip per lateral acceleration, which no valid input reaches.
    const MAX_COMPLIANCE: f64 = 1e30;

    /// Bounds of `longer_dead_time` [s]: from no dead time to [`Self::MAX_LONGER`] more.
    #[inline]
    fn longer_range(vehicle: &Vehicle) -> (f64, f64) {
        (-vehicle.dead_time, Self::MAX_LONGER)
    }

    /// Updates gain, steering offset, dead time and acceleration from the motion in the last `dt`
    /// [s]. `now` is the state of the no-slip point, `reached` what the wheels did in that time.
    #[inline]
    pub fn observe_turn(
        &mut self,
        params: &AdaptParams,
        vehicle: &Vehicle,
        now: VehicleState,
        reached: WheelIntegrals,
        dt: f64,
    ) {
        let Some(before) = self.last_measured else {
            self.turning.interrupt();
            self.sliding.interrupt();
            // Of an acceleration that is measured no more less and less is believed.
            self.estimate.acceleration *= exp(-dt / Self::ACCELERATION_TIME);
            return;
        };
        let speed = 0.5 * (before.speed + now.speed);
        let share = speed / vehicle.turning_length(speed);
        let reached = WheelIntegrals {
            turn: share * reached.turn,
            slope: share * reached.slope,
            change: share * reached.change,
        };
        let estimate = self.estimate;
        self.find_slip_length(vehicle, now.speed);
        self.estimate.acceleration = Self::acceleration(vehicle, &estimate, before, now, dt);
        if params.turn_time > 0.0 {
            // What a vehicle has shown is not to be forgotten while it stands and shows nothing.
            let moving = smaller(speed.abs() / (Self::SLOW * vehicle.wheelbase), 1.0);
            let measured = wrap(now.yaw - before.yaw);
            self.fit_turning(params.turn_time / moving, vehicle, reached, measured, dt);
        }
    }

    #[inline]
    fn acceleration(
        vehicle: &Vehicle,
        estimate: &Estimate,
        before: VehicleState,
        now: VehicleState,
        dt: f64,
    ) -> f64 {
        let most = Self::MAX_ACCELERATION * vehicle.wheelbase;
        let innovation = (now.speed - before.speed) / dt - estimate.acceleration;
        let weight = 1.0 - exp(-dt / Self::ACCELERATION_TIME);
        saturate(estimate.acceleration + weight * innovation, -most, most)
    }

    /// Updates gain, steering offset and dead time from one `measured` turn [rad].
    ///
    /// In `reached`, `turn` is `a`, `slope` is `b` and `change` is `c`.
    #[inline]
    fn fit_turning(
        &mut self,
        time: f64,
        vehicle: &Vehicle,
        reached: WheelIntegrals,
        measured: f64,
        dt: f64,
    ) {
        let Estimate {
            gain,
            steer_offset,
            longer_dead_time: longer,
            ..
        } = self.estimate;
        let WheelIntegrals {
            turn,
            slope,
            change,
        } = reached;
        let expected = gain * (turn + steer_offset * slope);
        let most = Self::MOST_TURNS * (turn.abs() + Self::MAX_STEER_OFFSET * slope.abs())
            + Self::OUTLIER * sqrt(self.turning.noise);
        let measured = expected + saturate(measured - expected, -most, most);
        // φ: the wheels are those of the present estimate `t = longer`; with the given dead time they
        // would have turned the vehicle by `t c` more.
        let regressors = SVector::<f64, 3>::new(turn + longer * change, slope, -change);
        self.turning.observe(regressors, measured, time, dt);

        let fitted_gain = self.fitted_gain();
        let (offset, fitted) = self.fitted_others(fitted_gain);
        let most = Self::MAX_STEER_OFFSET;
        self.estimate.gain = fitted_gain;
        self.estimate.steer_offset = saturate(offset, -most, most);
        // A vehicle that was given without a dead time is predicted only where it shows one.
        let is_none = vehicle.dead_time <= 0.0 && fitted < Self::LEAST_DEAD_TIME;
        let fitted = if is_none { 0.0 } else { fitted };
        let most = Self::DELAY_RATE * dt;
        let fitted = saturate(fitted, longer - most, longer + most);
        let (least, most) = Self::longer_range(vehicle);
        self.estimate.longer_dead_time = saturate(fitted, least, most);
        let estimate = &self.estimate;
        let found = SVector::<f64, 3>::new(1.0, estimate.steer_offset, estimate.longer_dead_time);
        self.turning.observe_noise(found * fitted_gain, dt);
    }

    /// The gain that explains the turns best with offset and dead time almost free.
    #[inline]
    fn fitted_gain(&self) -> f64 {
        let (square, product, prior) = self.gain_sums();
        saturate(
            (product + prior) / (square + prior),
            Self::MIN_GAIN,
            Self::MAX_GAIN,
        )
    }

    /// The gains between which a turn may be: that of the parameters, the estimated one with its
    /// spread, and as much of all of [`GAINS`](Self::GAINS) as the turns so far do not show.
    pub(crate) fn gain_range(&self) -> (f64, f64) {
        let (square, _, prior) = self.gain_sums();
        let (least, most) = Self::GAINS;
        let (unknown, gain) = (prior / (square + prior), self.estimate.gain);
        let spread = Self::GAIN_SPREAD * gain;
        (
            saturate(gain - spread - (1.0 - least) * unknown, least, 1.0),
            saturate(gain + spread + (most - 1.0) * unknown, 1.0, most),
        )
    }

    /// `aa - r B⁻¹ rᵀ`, `ma - r B⁻¹ mo` and `w`.
    #[inline]
    fn gain_sums(&self) -> (f64, f64, f64) {
        let (m, y) = (&self.turning.information, &self.turning.moment);
        let (ab, ac, bb, bc, cc) = (m.m12, m.m13, m.m22, m.m23, m.m33);
        let bb = bb + Self::FREE * Self::OFFSET_PRIOR;
        let cc = cc + Self::FREE * Self::DELAY_PRIOR;
        // r B⁻¹; as B is symmetric, (r B⁻¹)ᵀ solves B x = rᵀ.
        let (by_b, by_c) = solve(bb, bc, cc, ab, ac);
        let square = m.m11 - by_b * ab - by_c * ac;
        let product = y.x - by_b * y.y - by_c * y.z;
        // A sum of squares: only rounding makes it negative.
        let square = if square > 0.0 { square } else { 0.0 };
        let prior = self.turning.prior(Self::GAIN_PRIOR, Self::GAIN_DOUBT);
        (square, product, prior)
    }

    /// The steering offset [rad] and `t'` [s] that explain the turns best with this gain.
    #[inline]
    fn fitted_others(&self, gain: f64) -> (f64, f64) {
        let (m, y) = (&self.turning.information, &self.turning.moment);
        let bb = m.m22 + self.turning.prior(Self::OFFSET_PRIOR, Self::OFFSET_DOUBT);
        let cc = m.m33 + self.turning.prior(Self::DELAY_PRIOR, Self::DELAY_DOUBT);
        solve(bb, m.m23, cc, y.y / gain - m.m12, y.z / gain - m.m13)
    }

    /// Updates the slip from the motion of the no-slip point in the last `dt` [s].
    ///
    /// `bend` is the vehicle's curvature [1/m] by the angle of its wheels when the period began.
    /// That angle answers earlier poses, so its noise is independent of that of this sample; the
    /// path's curvature would be noisy wherever its waypoints are.
    #[inline]
    pub fn observe_slip(
        &mut self,
        params: &AdaptParams,
        vehicle: &Vehicle,
        now: VehicleState,
        bend: f64,
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
        // The heading in the middle of the period; `aside` is the motion across it, to the left.
        let direction = before.yaw + 0.5 * wrap(now.yaw - before.yaw);
        let aside = (now.y - before.y) * cos(direction) - (now.x - before.x) * sin(direction);
        let most = Self::MOST_SLIPS * Self::MAX_SLIP * travel.abs()
            + Self::OUTLIER * sqrt(self.sliding.noise) * vehicle.wheelbase;
        let aside = saturate(aside, -most, most) / vehicle.wheelbase;
        // s in wheelbases, so that vehicles of every size learn alike, and v² / L.
        let (distance, square) = (
            travel / vehicle.wheelbase,
            speed * speed / vehicle.wheelbase,
        );
        let regressors = SVector::<f64, 2>::new(distance, distance * square * bend);
        self.sliding
            .observe(regressors, aside, params.slip_time, dt);
        let (m, y) = (&self.sliding.information, &self.sliding.moment);
        // That of the compliance: slip per curvature is compliance times v² / L.
        let doubt = Self::LENGTH_DOUBT * vehicle.wheelbase / square;
        let aa = m.m11 + self.sliding.prior(Self::SLIP_PRIOR, Self::SLIP_DOUBT);
        let bb = m.m22 + self.sliding.prior(Self::COMPLIANCE_PRIOR, doubt);
        let (slip, compliance) = solve(aa, m.m12, bb, y.x, y.y);
        let noise = self.sliding_noise(travel / vehicle.wheelbase, dt);
        let bounded = |slip, compliance| {
            let most = vehicle.wheelbase / square;
            (
                saturate(slip, -Self::MAX_SLIP, Self::MAX_SLIP),
                saturate(compliance, -most, most),
            )
        };
        let (slip_found, compliance_found) = bounded(slip, compliance);
        let found = SVector::<f64, 2>::new(slip_found, compliance_found);
        (self.estimate.slip, self.slip_compliance) = bounded(
            beyond_noise(slip, noise / aa),
            beyond_noise(compliance, noise / bb),
        );
        self.sliding.observe_noise(found, dt);
        self.find_slip_length(vehicle, now.speed);
    }

    /// `d`: spectral density of the noise in the sums of motions aside, after a period of `dt` [s] over
    /// the `distance` in wheelbases.
    #[inline]
    fn sliding_noise(&self, distance: f64, dt: f64) -> f64 {
        let reach = distance * (SPAN / dt);
        (self.sliding.seen_noise() + reach * reach * self.turning.seen_noise()) * dt
    }

    /// Slip per curvature at `speed`: `compliance v² / L`, at most a wheelbase.
    #[inline]
    fn find_slip_length(&mut self, vehicle: &Vehicle, speed: f64) {
        let length = self.slip_compliance * (speed * speed / vehicle.wheelbase);
        self.estimate.slip_length = saturate(length, -vehicle.wheelbase, vehicle.wheelbase);
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
        self.turning.checked("turning")?;
        self.sliding.checked("sliding")?;
        input_within(
            "slip_compliance",
            self.slip_compliance,
            Self::MAX_COMPLIANCE,
        )?;
        let estimate = self.estimate;
        let (least, most) = Self::longer_range(vehicle);
        input_in_range("longer_dead_time", estimate.longer_dead_time, least, most)?;
        let acceleration = Self::MAX_ACCELERATION * vehicle.wheelbase;
        let offset = Self::MAX_STEER_OFFSET;
        input_in_range("gain", estimate.gain, Self::MIN_GAIN, Self::MAX_GAIN)?;
        for (field, value, most) in [
            ("steer_offset", estimate.steer_offset, offset),
            ("slip", estimate.slip, Self::MAX_SLIP),
            ("slip_length", estimate.slip_length, vehicle.wheelbase),
            ("acceleration", estimate.acceleration, acceleration),
        ] {
            input_within(field, value, most)?;
        }
        Ok(self)
    }
}

/// The part of an estimate `value` that stands out of noise of this `variance`.
#[inline]
fn beyond_noise(value: f64, variance: f64) -> f64 {
    let square = value * value;
    if square > variance {
        value * (1.0 - variance / square)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests;
