//! Preview POP at a speed: its horizon, the rate of its wheels, and the angle of its approach.

use super::approach::{FULL_RATE, LAGS, MOST_HORIZONS, Straightening, TURNS};
use super::preview_pop::PreviewPop;
use crate::math::sqrt;

impl PreviewPop {
    /// The horizon at a speed [s]. It is longer than the parameter if the vehicle's wheels need
    /// longer to straighten it on its approach to the path.
    #[inline]
    pub(super) fn horizon_at(&self, pace: f64) -> f64 {
        if !self.rate_is_the_vehicles {
            return self.horizon;
        }
        // Half the time in which wheels that turn out and back at their rate turn the vehicle by
        // the approach angle.
        let length = self.vehicle.turning_length(pace);
        let turn = sqrt(self.approach_angle * length / (pace * self.steer_span_rate));
        let needed = LAGS * self.vehicle.steer_lag + TURNS * turn;
        let most = MOST_HORIZONS * self.horizon;
        let needed = if needed < most { needed } else { most };
        if needed > self.horizon {
            needed
        } else {
            self.horizon
        }
    }

    /// The planned rate of the wheels [rad/s], and their travel in a control period `dt` [rad].
    ///
    /// Below `min_speed` the wheels turn in proportion to the distance travelled. With a
    /// `max_steer_rate` they turn at all of it down to [`FULL_RATE`] of `min_speed`. The prediction
    /// assumes at least `min_speed`, so the rate is converted to its time.
    #[inline]
    pub(super) fn rate_and_span(&self, speed: f64, dt: f64) -> (f64, f64) {
        let rate = self.steer_span_rate;
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

    /// The planned change of the tangent of the wheels' angle per radian, at `tangent`. It grows
    /// with the angle. With the vehicle's own rate that is not relied on: the wheels have to be
    /// straight again in time.
    #[inline]
    pub(super) fn steepness(&self, tangent: f64) -> f64 {
        if self.rate_is_the_vehicles {
            1.0
        } else {
            1.0 + tangent * tangent
        }
    }

    /// The heading at which a path is approached that is `error` away [rad]. The neighbourhood of a
    /// vehicle without limits of its own is a choice, and bounds no approach.
    #[inline]
    pub(super) fn approach_angle_at(&self, error: f64, straightening: &Straightening) -> f64 {
        if self.rate_is_the_vehicles || self.vehicle.max_lateral_acceleration.is_some() {
            straightening.steepest(self.approach_angle, error.abs())
        } else {
            self.approach_angle
        }
    }

    /// The largest curvature that the vehicle drives at a speed [1/m].
    #[inline]
    pub(super) fn widest(&self, pace: f64, length: f64) -> f64 {
        let steered = self.max_tangent / length;
        match self.vehicle.max_lateral_acceleration {
            Some(most) if most / (pace * pace) < steered => most / (pace * pace),
            _ => steered,
        }
    }
}
