//! Whether the vehicle keeps near its path, and whether it answers as its model says.
//!
//! The yaw that was measured over the last second is compared with what the commands explain: the
//! turn that the vehicle's figures expect of them, as far as it goes with a gain that the
//! estimator takes for possible, a steering offset that the motion has shown, and a response that
//! is somewhat quicker or slower. What is beyond that by more than the noise of the measured yaw is
//! not the told vehicle's: the sign of the steering is wrong, the wheels stick, or the commands
//! come later than anybody told.

use super::tracker_state::TrackerState;
use super::{LateralLaw, Status, Tracker};
use crate::error::{ConfigError, InputError, config_in_range, input_in_range};
use crate::limits::MAX_YAW;
use crate::math::{saturate, sqrt, wrap};
use crate::path::follow::Located;
use crate::vehicle::estimator::Estimator;
use crate::vehicle::{InFlight, Vehicle, VehicleState};

/// From where on a controller says that something is wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MonitorParams {
    /// Cross-track error beyond which a vehicle that was nearer before is deviating [m]; half a
    /// wheelbase by default, 1e9 for never.
    pub deviation_limit: Option<f64>,
    /// How far the yaw measured over a second may be from what the commands explain, besides its
    /// noise [rad]; 1e9 for any. Less: sooner found, and sooner a false alarm.
    pub turn_tolerance: f64,
}

impl MonitorParams {
    /// 1.5 m for a vehicle of 3 m, and twice what the plants' own dynamics need.
    pub const DEFAULT: Self = Self {
        deviation_limit: None,
        turn_tolerance: 0.01,
    };

    /// The parameters themselves where each is within its range.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the one that is not.
    pub fn checked(self) -> Result<Self, ConfigError> {
        if let Some(limit) = self.deviation_limit {
            config_in_range("deviation_limit", limit, 0.0, 1e9)?;
        }
        config_in_range("turn_tolerance", self.turn_tolerance, 0.0, 1e9)?;
        Ok(self)
    }
}

impl Default for MonitorParams {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What the monitor remembers; the turns are sums of which the old terms are forgotten.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MonitorState {
    /// Angle of the wheels by the vehicle's own figures [rad].
    pub wheel: f64,
    /// The yaw last measured [rad]; none where the motion since shows nothing.
    pub yaw: Option<f64>,
    /// The turn measured in the last period less the one expected [rad]; none before there was one.
    pub residual: Option<f64>,
    /// Turns measured [rad].
    pub measured: f64,
    /// Turns expected of the commands [rad].
    pub expected: f64,
    /// The same of a slower response [rad].
    pub delayed: f64,
    /// The turning rate of the slower response [rad/s].
    pub rate: f64,
    /// Turns of a radian of steering offset.
    pub reach: f64,
    /// How much more the commands would turn the vehicle than in proportion to their angle [rad].
    pub excess: f64,
    /// How long the noise has been measured, up to [`NOISE_TIME`](Self::NOISE_TIME) [s].
    pub time: f64,
    /// Variance of the noise of the measured yaw [rad^2].
    pub noise: f64,
    /// Turning rates of a radian of steering offset, squared, over the time [1/s].
    pub offset_square: f64,
    /// The same rates times the residuals [rad/s].
    pub offset_sum: f64,
    /// How long the vehicle goes on being implausible [s].
    pub alarm: f64,
    /// Whether the vehicle was within the limit of the deviation.
    pub within: bool,
}

impl MonitorState {
    /// Time over which turns are compared [s].
    const WINDOW: f64 = 1.0;
    /// The slower response lags by so much more than the vehicle's own figures say [s].
    const SLOWER: f64 = 0.1;
    /// A quicker one is ahead by this share of that.
    const QUICKER: f64 = 0.3;
    /// The steering offset that nobody told and the motion has not yet shown [rad].
    const OFFSET: f64 = 0.02;
    /// How much motion halves it, as `offset_square` [1/s]: a quarter of a second at 8 m/s.
    const OFFSET_DOUBT: f64 = 2.0;
    /// Weight of no steering offset in the least squares [1/s]. Smaller values take wheels that
    /// stick for a steering offset; larger ones take a steering offset for wheels that stick.
    const OFFSET_PRIOR: f64 = 8.0;
    /// Time over which the steering offset is estimated [s]: too long for a fault to pass as one.
    const OFFSET_TIME: f64 = 10.0;
    /// Time over which the noise is measured [s].
    pub const NOISE_TIME: f64 = 2.0;
    /// Standard deviation of the noise before it is measured [rad], and for how long that counts.
    const NOISE_PRIOR: (f64, f64) = (0.005, 0.05);
    /// The share of the excess of large angles that is let pass: commands that swing from lock to
    /// lock turn a vehicle by the tangent of angles that no model of its wheels tells well.
    const EXCESS: f64 = 0.5;
    /// How many standard deviations of the noise are let pass.
    const DEVIATIONS: f64 = 5.0;
    /// Nothing is concluded before the noise was measured for so long [s].
    const LEAST_TIME: f64 = 0.2;
    /// Nothing is concluded from a longer period [s]: too much happens in it.
    const MAX_PERIOD: f64 = 0.3;
    /// How long the vehicle is implausible after it last was beyond what is explained [s].
    pub const ALARM_TIME: f64 = 2.0;
    /// More than a number comes to within the bounds of the input.
    const MAX: f64 = 1e100;

    /// Nothing seen yet; the wheels stand at the angle `wheel` [rad].
    fn settled(wheel: f64) -> Self {
        let (deviation, time) = Self::NOISE_PRIOR;
        Self {
            wheel,
            yaw: None,
            residual: None,
            measured: 0.0,
            expected: 0.0,
            delayed: 0.0,
            rate: 0.0,
            reach: 0.0,
            excess: 0.0,
            time,
            noise: deviation * deviation,
            offset_square: 0.0,
            offset_sum: 0.0,
            alarm: 0.0,
            within: false,
        }
    }

    /// The motion until the next step shows nothing.
    pub(super) fn interrupt(&mut self) {
        self.yaw = None;
        self.residual = None;
        self.measured = 0.0;
        self.expected = 0.0;
        self.delayed = 0.0;
        self.reach = 0.0;
        self.excess = 0.0;
    }

    /// Takes in a `turn` [rad] within `dt` [s] in which the commands made the vehicle turn at
    /// `rate` [rad/s], a radian of steering offset at `share` [1/s]; the last command would by
    /// `excess` [rad/s] more than in proportion to its angle.
    #[inline]
    fn observe(&mut self, turn: f64, rate: f64, excess: f64, share: f64, dt: f64) {
        let expected = rate * dt;
        let residual = turn - expected;
        let kept = Self::WINDOW / (Self::WINDOW + dt);
        self.rate += (rate - self.rate) * (dt / (Self::SLOWER + dt));
        self.measured = (self.measured + turn) * kept;
        self.expected = (self.expected + expected) * kept;
        self.delayed = (self.delayed + self.rate * dt) * kept;
        self.reach = (self.reach + share.abs() * dt) * kept;
        self.excess = (self.excess + excess.abs() * dt) * kept;
        self.observe_noise(residual, dt);
        self.observe_offset(residual, share, dt);
    }

    /// Whether the turns are beyond what is explained by more than `tolerance` [rad].
    ///
    /// What is expected of the commands is itself explained, so most steps are done with that.
    #[inline]
    fn is_beyond(&self, tolerance: f64, share: f64) -> bool {
        (self.measured - self.expected).abs() > tolerance && self.unexplained(share) > tolerance
    }

    /// How far the turns are beyond what is explained, noise taken off [rad]; a radian of steering
    /// offset turns the vehicle at `share` [1/s].
    fn unexplained(&self, share: f64) -> f64 {
        let offset = self.offset_sum / (self.offset_square + Self::OFFSET_PRIOR);
        let doubt = Self::OFFSET * Self::OFFSET_DOUBT / (Self::OFFSET_DOUBT + self.offset_square);
        let (right, left) = if offset < 0.0 {
            (offset - doubt, doubt)
        } else {
            (-doubt, offset + doubt)
        };
        let (right, left) = if share < 0.0 {
            (-left, -right)
        } else {
            (right, left)
        };
        let quicker = self.expected + Self::QUICKER * (self.expected - self.delayed);
        let (least, most) = if quicker < self.delayed {
            (quicker, self.delayed)
        } else {
            (self.delayed, quicker)
        };
        let (least, most) = (least + right * self.reach, most + left * self.reach);
        let (low, high) = (Estimator::MIN_GAIN, Estimator::MAX_GAIN);
        let least = least * if least > 0.0 { low } else { high };
        let most = most * if most > 0.0 { high } else { low };
        let (below, above) = (least - self.measured, self.measured - most);
        let beyond = if below > above { below } else { above };
        beyond - Self::EXCESS * self.excess - Self::DEVIATIONS * sqrt(self.noise)
    }

    /// A yaw with white noise of variance `s` makes turns whose differences have `6 s`.
    #[inline]
    fn observe_noise(&mut self, residual: f64, dt: f64) {
        self.time = saturate(self.time + dt, 0.0, Self::NOISE_TIME);
        if let Some(last) = self.residual {
            let change = residual - last;
            let weight = if dt < self.time { dt / self.time } else { 1.0 };
            self.noise += (change * change / 6.0 - self.noise) * weight;
        }
        self.residual = Some(residual);
    }

    /// Least squares that forget, for the steering offset.
    #[inline]
    fn observe_offset(&mut self, residual: f64, share: f64, dt: f64) {
        let kept = Self::OFFSET_TIME / (Self::OFFSET_TIME + dt);
        let most = Estimator::MAX_STEER_OFFSET * share.abs() * dt;
        self.offset_square = self.offset_square * kept + share * share * dt;
        self.offset_sum = self.offset_sum * kept + share * saturate(residual, -most, most);
    }

    /// The state itself, where a vehicle could have shown it.
    pub(super) fn checked(self) -> Result<Self, InputError> {
        let right = core::f64::consts::FRAC_PI_2;
        for (value, low, high) in [
            (self.wheel, -right, right),
            (self.yaw.unwrap_or(0.0), -MAX_YAW, MAX_YAW),
            (self.residual.unwrap_or(0.0), -Self::MAX, Self::MAX),
            (self.measured, -Self::MAX, Self::MAX),
            (self.expected, -Self::MAX, Self::MAX),
            (self.delayed, -Self::MAX, Self::MAX),
            (self.rate, -Self::MAX, Self::MAX),
            (self.reach, 0.0, Self::MAX),
            (self.excess, 0.0, Self::MAX),
            (self.time, 0.0, Self::NOISE_TIME),
            (self.noise, 0.0, Self::MAX),
            (self.offset_square, 0.0, Self::MAX),
            (self.offset_sum, -Self::MAX, Self::MAX),
            (self.alarm, 0.0, Self::ALARM_TIME),
        ] {
            input_in_range("monitor", value, low, high)?;
        }
        Ok(self)
    }
}

/// What is measured at a step.
#[derive(Clone, Copy, Debug)]
struct Measured<'a> {
    /// Where the tracked point of the measured vehicle is.
    here: &'a Located,
    /// The vehicle by the pose of its own point.
    vehicle: VehicleState,
    /// Angle of the modelled wheels [rad]; none where they are not modelled.
    wheel: Option<f64>,
    /// Whether the place on the path was looked for anew.
    is_anew: bool,
    /// Control period [s].
    dt: f64,
}

/// The parameters, and what they come to for a vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Monitor {
    params: MonitorParams,
    deviation_limit: f64,
}

impl Monitor {
    /// # Errors
    ///
    /// [`ConfigError`], naming the parameter that is out of its range.
    fn new(params: MonitorParams, vehicle: &Vehicle) -> Result<Self, ConfigError> {
        params
            .checked()
            .map(|params| Self::unchecked(params, vehicle))
    }

    /// As it is unless it is told otherwise.
    pub(super) fn usual(vehicle: &Vehicle) -> Self {
        Self::unchecked(MonitorParams::DEFAULT, vehicle)
    }

    fn unchecked(params: MonitorParams, vehicle: &Vehicle) -> Self {
        Self {
            params,
            deviation_limit: params.deviation_limit.unwrap_or(0.5 * vehicle.wheelbase),
        }
    }

    /// Compares a step with what was commanded before it, and says what is wrong.
    #[inline]
    fn watch<S>(&self, car: &Vehicle, state: &mut TrackerState<S>, now: &Measured<'_>) -> Status {
        let steer = state.steer;
        let at_rest = || MonitorState::settled(car.at_wheels(steer + car.steer_offset));
        let watched = state.monitor.get_or_insert_with(at_rest);
        let answer = state.answer.as_ref();
        let last = answer.map(|answer| answer.measured.cross_track_error);
        let is_deviating = self.watch_path(watched, now, last);
        let is_implausible = self.watch_turn(watched, car, steer, now);
        Status::DEVIATING.when(is_deviating) | Status::IMPLAUSIBLE.when(is_implausible)
    }

    /// Whether the vehicle is beyond the limit, after it was within. Another path, or another
    /// direction, that begins farther off is another task.
    #[inline]
    fn watch_path(
        &self,
        watched: &mut MonitorState,
        now: &Measured<'_>,
        last: Option<f64>,
    ) -> bool {
        let error = now.here.foot.cross_track_error();
        if let (true, Some(last)) = (now.is_anew || now.here.turned, last)
            && (error - last).abs() > self.deviation_limit
        {
            watched.within = false;
        }
        let is_within = error.abs() <= self.deviation_limit;
        watched.within |= is_within;
        watched.within && !is_within
    }

    /// Whether the vehicle turns otherwise than what was commanded explains, or did lately.
    #[inline]
    fn watch_turn(
        &self,
        watched: &mut MonitorState,
        car: &Vehicle,
        last: f64,
        now: &Measured<'_>,
    ) -> bool {
        let (speed, dt) = (now.vehicle.speed, now.dt);
        let (wheel, mean) = if let Some(wheel) = now.wheel {
            (wheel, 0.5 * (watched.wheel + wheel))
        } else {
            respond(car, watched.wheel, last, dt)
        };
        watched.wheel = wheel;
        let share = speed / car.turning_length(speed);
        let rate = share * tangent(mean);
        let excess = share * (tangent(last) - last);

        if now.here.turned || dt > MonitorState::MAX_PERIOD {
            watched.interrupt();
        }
        watched.alarm = saturate(watched.alarm - dt, 0.0, MonitorState::ALARM_TIME);
        if let Some(yaw) = watched.yaw {
            let turn = wrap(now.vehicle.yaw - yaw);
            watched.observe(turn, rate, excess, share, dt);
            let is_beyond = watched.is_beyond(self.params.turn_tolerance, share);
            if is_beyond && watched.time >= MonitorState::LEAST_TIME {
                watched.alarm = MonitorState::ALARM_TIME;
            }
        } else {
            watched.rate = rate;
        }
        watched.yaw = Some(now.vehicle.yaw);
        watched.alarm > 0.0
    }
}

impl<L: LateralLaw> Tracker<L> {
    /// The same, watching the vehicle so; not at all where that is none.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the parameter that is out of its range.
    pub fn monitored(mut self, params: Option<MonitorParams>) -> Result<Self, ConfigError> {
        self.monitor = match params {
            Some(params) => Some(Monitor::new(params, self.law.vehicle())?),
            None => None,
        };
        Ok(self)
    }

    /// How it watches the vehicle; none where it does not.
    pub fn monitor(&self) -> Option<&MonitorParams> {
        self.monitor.as_ref().map(|monitor| &monitor.params)
    }

    /// Compares the step of a vehicle that is measured at `here` with what was commanded before it,
    /// and says what is wrong.
    #[inline]
    pub(super) fn watch(
        &self,
        state: &mut TrackerState<L::State>,
        here: &Located,
        vehicle: VehicleState,
        is_anew: bool,
        dt: f64,
    ) -> Status {
        let Some(monitor) = &self.monitor else {
            return Status::OK;
        };
        // Where nothing is modelled, what a state of another vehicle brings along does not count.
        let in_flight = state.in_flight.as_ref().filter(|_| self.models);
        let now = Measured {
            here,
            vehicle,
            wheel: in_flight.map(InFlight::wheel),
            is_anew,
            dt,
        };
        monitor.watch(self.law.vehicle(), state, &now)
    }
}

/// The wheels at the angle `wheel` [rad] `dt` [s] later under the angle `command`, and their mean:
/// the vehicle's response with a Pade approximant in place of the exponential. At most 3.3 % of a move
/// is off up to a `dt` of the lag.
#[inline]
fn respond(car: &Vehicle, wheel: f64, command: f64, dt: f64) -> (f64, f64) {
    let gap = car.at_wheels(command + car.steer_offset) - wheel;
    let lag = car.steer_lag;
    let turned = gap * (1.0 - lag * lag / (lag * lag + dt * (lag + 0.5 * dt)));
    if let Some(rate) = car.max_steer_rate
        && turned.abs() > rate * dt
    {
        let turned = (rate * dt).copysign(gap);
        return (wheel + turned, wheel + 0.5 * turned);
    }
    (wheel + turned, wheel + gap - turned * (lag / dt))
}

/// A Pade approximant of the tangent: within 1 % up to 1.25 rad, finite up to a right angle.
#[inline]
fn tangent(angle: f64) -> f64 {
    let square = angle * angle;
    angle * (15.0 - square) / (15.0 - 6.0 * square)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::tan;

    /// Steps of 0.05 s at 8 m/s, in which the vehicle turns by `turn` of what is expected.
    fn beyond(steps: u32, turn: impl Fn(u32, f64) -> f64) -> f64 {
        let mut state = MonitorState::settled(0.0);
        let mut most = f64::NEG_INFINITY;
        for k in 0..steps {
            let rate = 0.3 * crate::math::sin(0.1 * f64::from(k));
            state.observe(turn(k, rate * 0.05), rate, 0.0, 3.0, 0.05);
            let beyond = state.unexplained(3.0);
            assert_eq!(state.is_beyond(0.01, 3.0), beyond > 0.01, "{state:?}");
            if state.time >= MonitorState::LEAST_TIME && beyond > most {
                most = beyond;
            }
        }
        most
    }

    #[test]
    fn test_tangent_is_within_a_hundredth_and_finite_up_to_a_right_angle() {
        for k in 1..=125 {
            let angle = 0.01 * f64::from(k);
            assert!((tangent(angle) / tan(angle) - 1.0).abs() < 0.01, "{angle}");
        }
        let right = tangent(core::f64::consts::FRAC_PI_2);
        assert!(right.is_finite() && right > 10.0);
    }

    #[test]
    fn test_turns_of_another_gain_are_explained_and_other_turns_are_not() {
        for gain in [0.45, 1.0, 2.4] {
            assert!(beyond(200, |_, expected| gain * expected) < 0.0, "{gain}");
        }
        for gain in [-1.0, 0.0, 4.0] {
            assert!(beyond(200, |_, expected| gain * expected) > 0.02, "{gain}");
        }
    }

    #[test]
    fn test_white_noise_is_measured_and_let_pass() {
        // Not white, but as large as noise of 0.02 rad gets at each step.
        let yaw = |k: u32| 0.02 * crate::math::sin(2.4 * f64::from(k * k));
        assert!(beyond(200, |k, expected| expected + yaw(k + 1) - yaw(k)) < 0.0);
    }
}
