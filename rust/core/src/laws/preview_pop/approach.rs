//! How preview POP approaches a path: no steeper than the vehicle can straighten before it gets
//! there. For that the horizon is long enough, and the wheels turn at a rate that they keep.

use crate::math::{larger, smaller, sqrt};
use crate::vehicle::Vehicle;

/// The least horizon of a vehicle with a `max_steer_rate` is
///
/// ```text
/// LAGS steer_lag + TURNS sqrt(approach_angle length / (speed rate))
/// ```
///
/// where the root is half the time in which wheels that turn out and back at their rate turn the
/// vehicle by the approach angle. With fewer lags, wheels of 0.2 rad/s with 0.3 s of lag oscillate
/// about a straight.
const LAGS: f64 = 3.0;

/// 2 would be all of the time of that turn; less suffices, because the vehicle does not turn that
/// far at once.
const TURNS: f64 = 1.5;

/// The horizon of a vehicle that needs longer than this for its wheelbase [s] is as much longer. Larger: one
/// that creeps does not see that it gets back to its path, and turns its wheels late for a bend.
const WHEELBASE_TIME: f64 = 0.6;

/// Longest horizon, as a multiple of the parameter `horizon`. Larger values make the steps longer
/// and the commands coarser.
const MOST_HORIZONS: f64 = 2.0;

/// Share of `min_speed` above which wheels with a `max_steer_rate` turn at that rate. Smaller: a
/// creeping vehicle joins its path sooner, and turns its wheels more in noise.
pub(super) const FULL_RATE: f64 = 0.5;

/// Reserve of an approach in steering lags: one for the wheels to begin turning back, one to end.
/// With one alone, wheels of 1 rad/s with 0.3 s of lag overshoot a little.
const LAGS_IN_HAND: f64 = 2.0;

/// What limits how soon an approaching vehicle is straight again, per distance travelled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Straightening {
    /// The largest curvature that the vehicle drives [1/m].
    pub(super) curvature: f64,
    /// How fast that changes [1/m²].
    pub(super) rate: f64,
    /// The steering lag, as a distance [m].
    pub(super) lag: f64,
    /// The cross-track error per radian of heading at which the unlimited controller keeps its
    /// heading [m]: close to the path it straightens sooner by itself.
    pub(super) unlimited: f64,
}

impl Straightening {
    /// The steepest heading within `approach_angle` from which the vehicle is straight before it
    /// reaches a path `error` away [rad], the positive root of
    ///
    /// ```text
    /// angle^2 / (2 curvature) + angle (curvature / (2 rate) + 2 lag) = error
    /// ```
    ///
    /// with the distance in brackets at most `unlimited`, so that close to the path the unlimited
    /// controller remains what it is. The first term is the arc of the largest curvature; the
    /// second is the distance in which the wheels turn, and that of their lag. The curvature is at
    /// most the one that they reach while the vehicle turns by the approach angle.
    #[inline]
    pub(super) fn steepest(&self, approach_angle: f64, error: f64) -> f64 {
        let reached = sqrt(approach_angle * self.rate);
        let curvature = smaller(self.curvature, reached);
        let turning = 0.5 * curvature / self.rate + LAGS_IN_HAND * self.lag;
        let turning = smaller(self.unlimited, turning);
        // Written so, no digits cancel.
        let twice = 2.0 * error;
        let angle = twice / (turning + sqrt(turning * turning + twice / curvature));
        smaller(angle, approach_angle)
    }
}

/// What a vehicle and the parameters of preview POP allow an approach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Approach {
    /// Largest rate of the commanded angle [rad/s]: the lesser of `steer_span_rate` and the
    /// vehicle's `max_steer_rate`.
    pub(super) rate: f64,
    /// Whether that is the vehicle's `max_steer_rate`.
    pub(super) rate_is_the_vehicles: bool,
    /// Tangent of the vehicle's `max_steer`.
    pub(super) max_tangent: f64,
    pub(super) horizon: f64,
    /// The parameter `approach_angle` [rad].
    pub(super) angle: f64,
    pub(super) min_speed: f64,
}

impl Approach {
    /// The horizon at a speed [s]. It is longer than the parameter if the vehicle needs longer than
    /// [`WHEELBASE_TIME`], or its wheels longer to straighten it on its approach to the path.
    #[inline]
    pub(super) fn horizon_at(&self, vehicle: &Vehicle, pace: f64) -> f64 {
        let usual = vehicle.wheelbase / WHEELBASE_TIME;
        let mut needed = self.horizon;
        if pace < usual {
            needed *= usual / pace;
        }
        if self.rate_is_the_vehicles {
            let length = vehicle.turning_length(pace);
            let turn = sqrt(self.angle * length / (pace * self.rate));
            needed = larger(needed, LAGS * vehicle.steer_lag + TURNS * turn);
        }
        smaller(needed, MOST_HORIZONS * self.horizon)
    }

    /// The planned rate of the wheels [rad/s], and their travel in a control period `dt` [rad].
    ///
    /// Below `min_speed` the wheels turn in proportion to the distance travelled. Where the rate is
    /// the vehicle's `max_steer_rate`, they turn at the full rate down to [`FULL_RATE`] times
    /// `min_speed`, and in proportion to the distance below. The prediction assumes at least
    /// `min_speed`: it covers a distance sooner than the vehicle, so the planned rate is larger by
    /// the same factor.
    #[inline]
    pub(super) fn rate_and_span(&self, speed: f64, dt: f64) -> (f64, f64) {
        let rate = self.rate;
        if speed >= self.min_speed {
            return (rate, rate * dt);
        }
        let slow = speed / self.min_speed;
        if !self.rate_is_the_vehicles {
            (rate, rate * dt * slow)
        } else if slow < FULL_RATE {
            (rate / FULL_RATE, rate * dt * (slow / FULL_RATE))
        } else {
            (rate / slow, rate * dt)
        }
    }

    /// The heading at which a path `error` [m] away is approached [rad]: `approach_angle` for a
    /// vehicle without limits of its own, because `steer_span_rate` is a choice and does not make
    /// the approach flatter.
    #[inline]
    pub(super) fn angle_at(
        &self,
        vehicle: &Vehicle,
        error: f64,
        straightening: &Straightening,
    ) -> f64 {
        if self.rate_is_the_vehicles || vehicle.max_lateral_acceleration.is_some() {
            straightening.steepest(self.angle, error.abs())
        } else {
            self.angle
        }
    }

    /// The largest curvature that the vehicle drives at a speed [1/m].
    #[inline]
    pub(super) fn widest(&self, vehicle: &Vehicle, pace: f64, length: f64) -> f64 {
        let steered = self.max_tangent / length;
        match vehicle.max_lateral_acceleration {
            Some(most) if most / (pace * pace) < steered => most / (pace * pace),
            _ => steered,
        }
    }
}

#[cfg(test)]
mod tests;
