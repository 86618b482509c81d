//! What the monitor remembers: how far the turns were from what is explained, and their noise.

use super::course::Course;
use crate::bounds::MAX_YAW;
use crate::error::{InputError, input_in_range};
use crate::math::{larger, saturate, smaller};
use crate::vehicle::cusum::Cusum;
use crate::vehicle::estimator::Estimator;
use crate::vehicle::kalman::{Change, Walk};
use crate::vehicle::noise::Noise;
use crate::vehicle::{Fault, Vehicle};
use nalgebra::SVector;

/// The monitor's state.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MonitorState {
    /// Angle of the wheels by the vehicle's parameters [rad], where nothing else models them.
    pub wheel: f64,
    /// The yaw last measured [rad]; None if the motion since shows nothing.
    pub yaw: Option<f64>,
    /// The turns beyond what is explained [rad].
    pub turned: Cusum,
    /// The least and the largest turning rate of slower responses [rad/s]: play delays wheels that go to
    /// and fro by more or less of what is estimated as a longer dead time.
    pub rates: (f64, f64),
    /// By how much a longer dead time is believed [s].
    pub later: f64,
    /// Gain and steering offset [rad] that are believed, each with what is not known of it. The
    /// estimates follow what the wheels do now, which stuck ones would explain by themselves.
    pub known: [(f64, f64); 2],
    /// The turning rate measured, a mean over [`YAW_RATE_TIME`](Self::YAW_RATE_TIME) [rad/s].
    pub yaw_rate: f64,
    /// The noise of the measured yaw [rad].
    pub noise: Noise,
    /// The yaw, and by how much the vehicle lately turned more than its parameters say: what holds
    /// the limit of the lateral acceleration where nothing else is estimated.
    pub gain: Walk<1>,
    /// Which signal the turns blame.
    pub course: Course,
    /// Whether it is the heading.
    pub heading: bool,
    /// Remaining time of the alarm [s].
    pub alarm: f64,
    /// Whether the vehicle was within the limit of the deviation.
    pub within: bool,
}

/// What the commands make of a vehicle in a period.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expected {
    /// The turning rate by the modelled wheels [rad/s].
    pub(super) rate: f64,
    /// By a radian of steering offset [1/s]: negative where the vehicle drives backwards.
    pub(super) share: f64,
    /// In what time [s].
    pub(super) dt: f64,
}

impl MonitorState {
    /// A slower response lags by so much more than the vehicle's parameters say [s].
    const SLOWER: f64 = 0.1;
    /// A quicker one is ahead by this share of that.
    const QUICKER: f64 = 0.3;
    /// Time in which an estimated gain or offset comes to be believed [s]. Shorter: stuck wheels pass
    /// as another gain or offset; longer: one that is found passes as stuck wheels.
    const BELIEF_TIME: f64 = 1.5;
    /// The same of a longer dead time [s]. Shorter: wheels that stick pass as late ones; longer: wheels with
    /// play that go to and fro pass as stuck.
    const LATER_TIME: f64 = 9.0;
    /// How far the gain of a turn may be from that, as a share of it: tyres and speed.
    const GAIN_SPREAD: f64 = 0.15;
    /// The turning rate by an offset before the motion has shown it [rad/s]: a car whose offset turns
    /// it faster is half a metre off its path before any estimate could help.
    const OFFSET_TURN: f64 = 0.25;
    /// The steering offset that a vehicle may have where nothing estimates it [rad].
    const LASTING_OFFSET: f64 = 0.035;
    /// How far the wheels may go from a known offset, by play [rad].
    const PLAY: f64 = 0.012;
    /// Time over which the measured turning rate is a mean [s].
    const YAW_RATE_TIME: f64 = 0.1;
    /// Tolerance of its noise, in standard deviations: being too fast is no fault.
    const RATE_DEVIATIONS: f64 = 3.0;
    /// Standard deviation of the noise before it is measured [rad].
    const NOISE: f64 = 0.002;
    /// Standard deviation of the gain where nothing else estimates it, and time in which it is
    /// forgotten [s]. Longer: less noise in the limit of the lateral acceleration; shorter: a steering
    /// offset, which is another gain in the next bend, limits that for less long.
    const GAIN_DOUBT: [f64; 1] = [0.3];
    const GAIN_TIME: f64 = 2.0;
    /// Nothing is concluded from a longer period [s]: too much happens in it.
    pub(super) const MAX_PERIOD: f64 = 0.7;
    /// How long the vehicle is implausible after it last was beyond what is explained [s].
    pub const ALARM_TIME: f64 = 2.0;
    /// Bound that no valid input reaches.
    const MAX: f64 = 1e100;

    /// The state before the first step, with the wheels at the angle `wheel` [rad].
    pub(crate) fn settled(wheel: f64) -> Self {
        Self {
            wheel,
            yaw: None,
            turned: Cusum::default(),
            rates: (0.0, 0.0),
            later: 0.0,
            known: Estimator::default().known_turning(),
            yaw_rate: 0.0,
            noise: Noise::new(Self::NOISE),
            gain: Walk::new([1.0], &Self::GAIN_DOUBT, Estimator::YAW_NOISE),
            course: Course::default(),
            heading: false,
            alarm: 0.0,
            within: false,
        }
    }

    /// The motion until the next step is not used.
    pub(crate) fn interrupt(&mut self) {
        self.yaw = None;
        self.noise.last = None;
        self.yaw_rate = 0.0;
        self.turned = Cusum::default();
        self.course = Course::default();
        self.gain.interrupt();
    }

    /// Learns by how much a turn [rad] `measured` is more than the one `expected`.
    pub(super) fn observe_gain(&mut self, measured: f64, expected: Expected) {
        let Expected { rate, share, dt } = expected;
        let expected = rate * dt;
        let change = Change {
            measured,
            expected: self.gain.get(0) * expected,
            slopes: SVector::<f64, 1>::new(expected),
            open: Estimator::open_turn(rate, share, dt),
            noise: self.gain.noise.variance,
            dt,
        };
        self.gain.observe(&change, Estimator::YAW_NOISE);
        self.gain.forget(dt / Self::GAIN_TIME, &Self::GAIN_DOUBT);
        let (least, most) = Estimator::GAINS;
        self.gain.keep(0, least, most);
    }

    /// Takes in a `turn` [rad] where one is `expected`, of a vehicle whose gain and offset the
    /// `estimator` knows, or none. Returns whether the turns are beyond what is explained by more
    /// than noise and `tolerance` [rad]; the sum begins anew then.
    #[inline]
    pub(super) fn observe(
        &mut self,
        turn: f64,
        expected: Expected,
        tolerance: f64,
        estimator: Option<&Estimator>,
    ) -> bool {
        let Expected { rate, share, dt } = expected;
        self.noise.observe(turn - rate * dt, dt);
        self.yaw_rate += (turn - self.yaw_rate * dt) / (Self::YAW_RATE_TIME + dt);
        let later = estimator.map_or(0.0, |known| known.estimate.longer_dead_time);
        self.later += (later.abs() - self.later) * (dt / (Self::LATER_TIME + dt));
        let time = self.slowest();
        let after = |rates: f64| rates + (rate - rates) * (dt / (time + dt));
        self.rates = (
            smaller(rate, after(self.rates.0)),
            larger(rate, after(self.rates.1)),
        );
        let (least, most) = self.explained(rate, share, estimator);
        if let Some(estimator) = estimator {
            let followed = dt / (Self::BELIEF_TIME + dt);
            for (known, found) in self.known.iter_mut().zip(estimator.known_turning()) {
                known.0 += (found.0 - known.0) * followed;
                known.1 += (found.1 - known.1) * followed;
            }
        }
        let (explained, noise) = ((least * dt, most * dt), (self.noise.at_most(), dt));
        let alarms = self.turned.add(turn, explained, noise, tolerance);
        if alarms {
            self.turned = Cusum::default();
        }
        alarms
    }

    /// Notes by a `turn` [rad] where another was `expected`, and by how far the vehicle moved `aside` of its
    /// heading on its `travel` [m], which signal an alarm would blame; `noise` is the position's [m].
    #[cold]
    pub(super) fn blame(
        &mut self,
        (turn, expected): (f64, f64),
        (travel, aside): (f64, f64),
        noise: f64,
        alarms: bool,
    ) {
        self.course.add(expected - turn, travel, aside);
        if alarms {
            let was_noisy = self.noise.deviation() > 0.0;
            self.heading = turn.abs() <= 0.0 && self.course.blames_heading(noise, was_noisy);
            self.course = Course::default();
        }
    }

    /// By how much the slowest response lags that is explained [s].
    #[inline]
    fn slowest(&self) -> f64 {
        Self::SLOWER + self.later
    }

    /// The least and the largest turning rate [rad/s] that commands explain by which a vehicle turns
    /// at `rate` [rad/s], and by a radian of steering offset at `share` [1/s].
    #[inline]
    fn explained(&self, rate: f64, share: f64, estimator: Option<&Estimator>) -> (f64, f64) {
        let (least, most) = Estimator::GAINS;
        let ((right, left), (low, high), later) = if let Some(estimator) = estimator {
            let [(gain, spread), (offset, doubt)] = self.known;
            let spread = spread + Self::GAIN_SPREAD * gain;
            let doubt = smaller(doubt, Self::OFFSET_TURN / share.abs()) + Self::PLAY;
            // As told, too: in a bend a wrong gain looks like an offset, and an offset like a gain.
            let offsets = (smaller(offset, 0.0) - doubt, larger(offset, 0.0) + doubt);
            let gains = (
                saturate(gain - spread, least, 1.0),
                saturate(gain + spread, 1.0, most),
            );
            (offsets, gains, estimator.estimate.longer_dead_time)
        } else {
            let offset = Self::LASTING_OFFSET;
            ((-offset, offset), (least, most), 0.0)
        };
        let (least_aside, most_aside) = if share < 0.0 {
            (left * share, right * share)
        } else {
            (right * share, left * share)
        };
        // A dead time that is found to be longer may be as told, too.
        let early = larger(later, 0.0);
        let ahead = (Self::QUICKER * Self::SLOWER + early) / self.slowest();
        let (least, most) = self.rates;
        let (least, most) = (least - ahead * (most - rate), most + ahead * (rate - least));
        (
            least_turn(least, least_aside, low, high),
            -least_turn(-most, -most_aside, low, high),
        )
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
            let noise = self.noise.deviation() / Self::YAW_RATE_TIME;
            lateral > most + Self::RATE_DEVIATIONS * noise * speed.abs()
        }
    }

    /// What the turns show to be wrong.
    pub(crate) fn fault(&self) -> Option<Fault> {
        (self.alarm > 0.0).then_some(if self.heading {
            Fault::Heading
        } else {
            Fault::Steering
        })
    }

    /// The state itself, where a vehicle could have shown it.
    pub(crate) fn checked(self) -> Result<Self, InputError> {
        let right = core::f64::consts::FRAC_PI_2;
        for (value, low, high) in [
            (self.wheel, -right, right),
            (self.yaw.unwrap_or(0.0), -MAX_YAW, MAX_YAW),
            (self.rates.0, -Self::MAX, Self::MAX),
            (self.rates.1, -Self::MAX, Self::MAX),
            (self.later, 0.0, Self::MAX),
            (self.known[0].0, 0.0, Estimator::MAX_GAIN),
            (self.known[0].1, 0.0, Self::MAX),
            (self.known[1].0, -1.0, 1.0),
            (self.known[1].1, 0.0, Self::MAX),
            (self.yaw_rate, -Self::MAX, Self::MAX),
            (self.course.turn, -Self::MAX, Self::MAX),
            (self.course.aside, -Self::MAX, Self::MAX),
            (self.course.commanded, -Self::MAX, Self::MAX),
            (self.alarm, 0.0, Self::ALARM_TIME),
        ] {
            input_in_range("monitor", value, low, high)?;
        }
        self.turned.checked("monitor")?;
        self.noise.checked("monitor")?;
        let (least, most) = Estimator::GAINS;
        input_in_range("monitor", self.gain.get(0), least, most)?;
        self.gain.checked("monitor")?;
        Ok(self)
    }
}

/// The least turn [rad], or rate of it, of a vehicle of which `turn` is expected, and `aside` more by its steering
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
