//! What the monitor remembers: the turns of the last second, and what is known of the noise and of
//! the steering offset.

use crate::bounds::MAX_YAW;
use crate::error::{InputError, input_in_range};
use crate::math::{larger, saturate, smaller, sqrt};
use crate::vehicle::estimator::Estimator;
use crate::vehicle::kalman::{Change, Walk};
use crate::vehicle::{Fault, Vehicle};
use nalgebra::SVector;

/// The monitor's state; the turns are sums with exponential forgetting.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MonitorState {
    /// Angle of the wheels by the vehicle's parameters [rad], where nothing else models them.
    pub wheel: f64,
    /// The yaw last measured [rad]; None if the motion since shows nothing.
    pub yaw: Option<f64>,
    /// The turn measured in the last period less the one expected [rad]; None before there was one.
    pub residual: Option<f64>,
    /// Turns measured [rad].
    pub measured: f64,
    /// Turns expected of the commands [rad].
    pub expected: f64,
    /// The same of a slower response [rad].
    pub delayed: f64,
    /// The turning rate of the slower response [rad/s].
    pub rate: f64,
    /// The turning rate measured, a mean over [`YAW_RATE_TIME`](Self::YAW_RATE_TIME) [rad/s].
    pub yaw_rate: f64,
    /// Turn by a radian of steering offset [rad]: negative where the vehicle drove backwards.
    pub reach: f64,
    /// Turn by the tangent of the commanded angles beyond that by the angles themselves, which is
    /// how much more than in proportion large angles turn the vehicle, and a part of the turn
    /// against that of the window [rad].
    pub excess: f64,
    /// How long the noise has been measured, up to [`NOISE_TIME`](Self::NOISE_TIME), or 40 periods
    /// [s].
    pub time: f64,
    /// Variance of the noise of the measured yaw [rad^2].
    pub noise: f64,
    /// Turning rates of a radian of steering offset, squared, over the time [1/s].
    pub offset_square: f64,
    /// The same rates times the residuals [rad/s].
    pub offset_sum: f64,
    /// The yaw, and by how much the vehicle lately turned more than its parameters say: what holds
    /// the limit of the lateral acceleration where nothing else is estimated.
    pub gain: Walk<1>,
    /// Remaining time of the alarm [s].
    pub alarm: f64,
    /// Whether the vehicle was within the limit of the deviation.
    pub within: bool,
}

impl MonitorState {
    /// Time over which turns are compared [s].
    const WINDOW: f64 = 1.0;
    /// The slower response lags by so much more than the vehicle's parameters say [s].
    const SLOWER: f64 = 0.1;
    /// A quicker one is ahead by this share of that.
    const QUICKER: f64 = 0.3;
    /// The turning rate by an unknown steering offset before the motion has shown it [rad/s]. A car
    /// whose offset turns it faster is half a metre off its path before any estimate could help.
    const OFFSET_TURN: f64 = 0.25;
    /// How much motion halves what is unknown of it, as `offset_square` [1/s]: 0.06 s at 8 m/s.
    /// Smaller values mistake stuck wheels for a steering offset; larger values mistake a steering
    /// offset for stuck wheels.
    const OFFSET_DOUBT: f64 = 0.5;
    /// The same where nothing estimates the offset, and the vehicle stays beside its path by it: an
    /// angle [rad], and a second at 8 m/s [1/s].
    const LASTING_OFFSET: (f64, f64) = (0.035, 8.0);
    /// Time over which the measured turning rate is a mean [s].
    const YAW_RATE_TIME: f64 = 0.1;
    /// Tolerance of its noise, in standard deviations: being too fast is no fault.
    const RATE_DEVIATIONS: f64 = 3.0;
    /// Time over which the steering offset is estimated [s]: too long for a fault to pass as one.
    const OFFSET_TIME: f64 = 10.0;
    /// How far the wheels may go from a known offset, by play [rad]; half of it once the offset has
    /// been seen for `OFFSET_TIME`.
    const PLAY: f64 = 0.016;
    /// Time over which the noise is measured [s], and the least number of turns: with fewer, in
    /// periods over 50 ms, the turns of a fault would pass as noise.
    pub const NOISE_TIME: f64 = 2.0;
    const NOISE_TURNS: f64 = 40.0;
    /// Standard deviation of the noise before it is measured [rad], and for how long that counts.
    const NOISE_PRIOR: (f64, f64) = (0.005, 0.05);
    /// Tolerance for large angles, as a share of `excess`: at commands that oscillate from lock to
    /// lock, the tangent amplifies every error of the modelled wheels.
    const EXCESS: f64 = 0.5;
    /// Part of a turn against that of the window that counts as excess: where a car brakes from one
    /// bend into the next, its gain changes within the window, and turns to both sides do not cancel
    /// as those that its commands explain.
    const AGAINST: f64 = 0.12;
    /// Standard deviation of the gain where nothing else estimates it, and time in which it is
    /// forgotten [s]. Longer: less noise in the limit of the lateral acceleration; shorter: a steering
    /// offset, which is another gain in the next bend, limits that for less long.
    const GAIN_DOUBT: [f64; 1] = [0.3];
    const GAIN_TIME: f64 = 2.0;
    /// Noise tolerance, in standard deviations.
    const DEVIATIONS: f64 = 5.0;
    /// Nothing is concluded before the noise was measured for so long [s], and in so many turns.
    pub(super) const LEAST_TIME: f64 = 0.2;
    pub(super) const LEAST_TURNS: f64 = 4.0;
    /// Nothing is concluded from a longer period [s]: too much happens in it.
    pub(super) const MAX_PERIOD: f64 = 0.7;
    /// How long the vehicle is implausible after it last was beyond what is explained [s].
    pub const ALARM_TIME: f64 = 2.0;
    /// Bound that no valid input reaches.
    const MAX: f64 = 1e100;
    /// The same for a residual, little enough that the square of a change keeps to that.
    const MAX_RESIDUAL: f64 = 1e49;

    /// The state before the first step, with the wheels at the angle `wheel` [rad].
    pub(crate) fn settled(wheel: f64) -> Self {
        let (deviation, time) = Self::NOISE_PRIOR;
        Self {
            wheel,
            yaw: None,
            residual: None,
            measured: 0.0,
            expected: 0.0,
            delayed: 0.0,
            rate: 0.0,
            yaw_rate: 0.0,
            reach: 0.0,
            excess: 0.0,
            time,
            noise: deviation * deviation,
            offset_square: 0.0,
            offset_sum: 0.0,
            gain: Walk::new([1.0], &Self::GAIN_DOUBT, deviation * deviation),
            alarm: 0.0,
            within: false,
        }
    }

    /// The motion until the next step is not used.
    pub(crate) fn interrupt(&mut self) {
        self.yaw = None;
        self.residual = None;
        self.yaw_rate = 0.0;
        self.measured = 0.0;
        self.expected = 0.0;
        self.delayed = 0.0;
        self.reach = 0.0;
        self.excess = 0.0;
        self.gain.interrupt();
    }

    /// Learns by how much a turn [rad] `measured` within `dt` [s] is more than the one expected at
    /// `rate` [rad/s]; a radian of the wheels turns the vehicle at `share` [rad/s].
    pub(crate) fn observe_gain(&mut self, measured: f64, rate: f64, share: f64, dt: f64) {
        let expected = rate * dt;
        let change = Change {
            measured,
            expected: self.gain.get(0) * expected,
            slopes: SVector::<f64, 1>::new(expected),
            open: Estimator::open_turn(rate, share, dt),
            dt,
        };
        self.gain
            .observe(&change, Self::NOISE_PRIOR.0 * Self::NOISE_PRIOR.0);
        self.gain.forget(dt / Self::GAIN_TIME, &Self::GAIN_DOUBT);
        let (least, most) = Estimator::GAINS;
        self.gain.keep(0, least, most);
    }

    /// Takes in a `turn` [rad] within `dt` [s] in which the commands made the vehicle turn at
    /// `rate` [rad/s], a radian of steering offset at `share` [1/s]; the last command would by
    /// `excess` [rad/s] more than in proportion to its angle.
    #[inline]
    pub(crate) fn observe(&mut self, turn: f64, rate: f64, excess: f64, share: f64, dt: f64) {
        let expected = rate * dt;
        let residual = turn - expected;
        let kept = Self::WINDOW / (Self::WINDOW + dt);
        self.rate += (rate - self.rate) * (dt / (Self::SLOWER + dt));
        self.yaw_rate += (turn - self.yaw_rate * dt) / (Self::YAW_RATE_TIME + dt);
        self.measured = (self.measured + turn) * kept;
        self.expected = (self.expected + expected) * kept;
        self.delayed = (self.delayed + self.rate * dt) * kept;
        self.reach = (self.reach + share * dt) * kept;
        let against = if rate * self.expected < 0.0 {
            Self::AGAINST * rate.abs()
        } else {
            0.0
        };
        self.excess = (self.excess + (excess.abs() + against) * dt) * kept;
        self.observe_noise(residual, dt);
        self.observe_offset(residual, share, dt);
    }

    /// Whether the turns are beyond what is explained by more than `tolerance` [rad]; see
    /// [`unexplained`](Self::unexplained).
    ///
    /// What is expected of the commands is itself explained, so most steps are done with that, the
    /// noise and the excess.
    #[inline]
    pub(crate) fn is_beyond(
        &self,
        tolerance: f64,
        share: f64,
        estimator: Option<&Estimator>,
    ) -> bool {
        let apart = (self.measured - self.expected).abs() - Self::EXCESS * self.excess - tolerance;
        apart > 0.0
            && apart * apart > Self::DEVIATIONS * Self::DEVIATIONS * self.noise
            && self.unexplained_by(share, estimator) > tolerance
    }

    /// [`unexplained`](Self::unexplained), by what is known of gain and offset.
    fn unexplained_by(&self, share: f64, estimator: Option<&Estimator>) -> f64 {
        let Some(estimator) = estimator else {
            return self.unexplained(share, Self::LASTING_OFFSET, Estimator::GAINS);
        };
        let unknown = smaller(Estimator::MAX_STEER_OFFSET, Self::OFFSET_TURN / share.abs());
        self.unexplained(share, (unknown, Self::OFFSET_DOUBT), estimator.gain_range())
    }

    /// How far the turns are beyond what is explained, noise taken off [rad]. A radian of steering
    /// offset turns the vehicle at `share` [1/s], and the commands by `low` to `high` times what is
    /// expected of them; see [`offsets`](Self::offsets) for what is unknown.
    fn unexplained(&self, share: f64, unknown: (f64, f64), (low, high): (f64, f64)) -> f64 {
        let (right, left) = self.offsets(share, unknown);
        let (right, left) = if self.reach < 0.0 {
            (left * self.reach, right * self.reach)
        } else {
            (right * self.reach, left * self.reach)
        };
        let quicker = self.expected + Self::QUICKER * (self.expected - self.delayed);
        let (least, most) = (
            smaller(quicker, self.delayed),
            larger(quicker, self.delayed),
        );
        let below = least_turn(least, right, low, high) - self.measured;
        let above = self.measured + least_turn(-most, -left, low, high);
        larger(below, above) - Self::EXCESS * self.excess - Self::DEVIATIONS * sqrt(self.noise)
    }

    /// The steering offsets [rad] that the motion before the window allows, to the right and to the
    /// left; 0 is among them, since in a bend a wrong gain looks like one. What the wheels do within
    /// the window is no evidence: stuck ones would explain themselves. Nothing known, one of `unknown`
    /// [rad] is allowed, halved by motion of `halved` [1/s].
    fn offsets(&self, share: f64, (unknown, halved): (f64, f64)) -> (f64, f64) {
        let known = larger(self.offset_square - share * self.reach, 0.0) + halved;
        let offset = (self.offset_sum - share * (self.measured - self.expected)) / known;
        let play = Self::PLAY * known / (known + Self::OFFSET_TIME * share * share);
        let doubt = larger(unknown * (halved / known), play);
        let most = Estimator::MAX_STEER_OFFSET;
        let (right, left) = (smaller(offset, 0.0) - doubt, larger(offset, 0.0) + doubt);
        (larger(right, -most), smaller(left, most))
    }

    /// Whether the vehicle turns at `speed` [m/s] faster than its limit of the lateral acceleration
    /// allows, by more than noise.
    ///
    /// White noise of deviation `s` makes the mean turning rate noisy by less than `s` over its
    /// time.
    #[inline]
    pub(super) fn is_too_fast(&self, car: &Vehicle, speed: f64) -> bool {
        let Some(most) = car.max_lateral_acceleration else {
            return false;
        };
        let lateral = (speed * self.yaw_rate).abs();
        lateral > most && {
            let noise = sqrt(self.noise) / Self::YAW_RATE_TIME;
            lateral > most + Self::RATE_DEVIATIONS * noise * speed.abs()
        }
    }

    /// A yaw with white noise of variance `s` makes turns whose differences have `6 s`.
    #[inline]
    fn observe_noise(&mut self, residual: f64, dt: f64) {
        let most = larger(Self::NOISE_TIME, Self::NOISE_TURNS * dt);
        self.time = saturate(self.time + dt, 0.0, most);
        if let Some(last) = self.residual {
            let change = residual - last;
            let weight = if dt < self.time { dt / self.time } else { 1.0 };
            self.noise += (change * change / 6.0 - self.noise) * weight;
        }
        self.residual = Some(residual);
    }

    /// Least squares that forget, for the steering offset: more slowly below the speed where the
    /// estimator does, and not at rest, where nothing is learnt.
    #[inline]
    fn observe_offset(&mut self, residual: f64, share: f64, dt: f64) {
        let moving = smaller(share.abs() / Estimator::SLOW, 1.0);
        let kept = Self::OFFSET_TIME / (Self::OFFSET_TIME + moving * dt);
        self.offset_square = self.offset_square * kept + share * share * dt;
        self.offset_sum = self.offset_sum * kept + share * residual;
    }

    /// What the turns show to be wrong.
    pub(crate) fn fault(&self) -> Option<Fault> {
        (self.alarm > 0.0).then_some(Fault::Steering)
    }

    /// The state itself, where a vehicle could have shown it.
    pub(crate) fn checked(self) -> Result<Self, InputError> {
        let right = core::f64::consts::FRAC_PI_2;
        for (value, low, high) in [
            (self.wheel, -right, right),
            (self.yaw.unwrap_or(0.0), -MAX_YAW, MAX_YAW),
            (
                self.residual.unwrap_or(0.0),
                -Self::MAX_RESIDUAL,
                Self::MAX_RESIDUAL,
            ),
            (self.measured, -Self::MAX, Self::MAX),
            (self.expected, -Self::MAX, Self::MAX),
            (self.delayed, -Self::MAX, Self::MAX),
            (self.rate, -Self::MAX, Self::MAX),
            (self.yaw_rate, -Self::MAX, Self::MAX),
            (self.reach, -Self::MAX, Self::MAX),
            (self.excess, 0.0, Self::MAX),
            (self.time, 0.0, Self::NOISE_TURNS * Self::MAX_PERIOD),
            (self.noise, 0.0, Self::MAX),
            (self.offset_square, 0.0, Self::MAX),
            (self.offset_sum, -Self::MAX, Self::MAX),
            (self.alarm, 0.0, Self::ALARM_TIME),
        ] {
            input_in_range("monitor", value, low, high)?;
        }
        self.gain.checked("monitor")?;
        Ok(self)
    }
}

/// The least turn [rad] of a vehicle of which `turn` is expected, and `aside` more by its steering
/// offset: both times a gain of `low` to `high`, but for an offset that acts alone, whose gain is in
/// it.
fn least_turn(turn: f64, aside: f64, low: f64, high: f64) -> f64 {
    let both = turn + aside;
    if both > 0.0 {
        low * both
    } else {
        both + (high - 1.0) * smaller(turn, 0.0)
    }
}

#[cfg(test)]
mod tests;
