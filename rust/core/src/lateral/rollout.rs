//! POP's prediction over a horizon: a bicycle with a steering lag, where the paper's is a point
//! over one step.

use crate::Point;
use crate::error::{ConfigError, config_in_range};
use crate::math::{cos, decay, sin};
use crate::path::view::get_distance;
use crate::vehicle::VehicleState;
use crate::vehicle::predict::{kinematic_bicycle, steps};

/// What is predicted, and how far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// How long the prediction looks ahead [s].
    pub horizon: f64,
    /// Distance of the axles [m].
    pub wheelbase: f64,
    /// Understeer [s^2/m]: `yaw rate = speed tan(steer) / (wheelbase + understeer speed^2)`.
    pub understeer: f64,
    /// Time constant with which the wheels follow their command [s].
    pub steer_lag: f64,
    /// How far ahead of the rear axle the point lies that is to come near the target [m].
    pub reference_offset: f64,
}

/// The model at the origin, about to be rolled forward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rollout {
    count: usize,
    period: f64,
    kept: f64,
    length: f64,
    reference_offset: f64,
    vehicle: VehicleState,
    wheel: f64,
}

impl Model {
    /// The same with its own numbers checked; wheelbase and offset are those of a checked body.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the parameter that is out of its range.
    pub fn checked(self) -> Result<Self, ConfigError> {
        config_in_range("horizon", self.horizon, 1e-3, 100.0)?;
        config_in_range("understeer", self.understeer, 0.0, 1e3)?;
        config_in_range("steer_lag", self.steer_lag, 0.0, 10.0)?;
        Ok(self)
    }

    /// The wheels from `wheel` after `dt` [s] of the command `steer` [rad].
    #[inline]
    pub fn follow(&self, wheel: f64, steer: f64, dt: f64) -> f64 {
        steer + (wheel - steer) * decay(dt, self.steer_lag)
    }

    /// The model with its reference point at the origin, along `yaw` [rad] at `speed` [m/s], the
    /// wheels at the angle `wheel` [rad]; in steps of `dt` [s], the control period, or longer.
    #[inline]
    pub fn rollout(&self, yaw: f64, speed: f64, wheel: f64, dt: f64) -> Rollout {
        let (count, period) = steps(self.horizon, dt);
        Rollout {
            count,
            period,
            kept: decay(period, self.steer_lag),
            length: self.wheelbase + self.understeer * speed * speed,
            reference_offset: self.reference_offset,
            vehicle: VehicleState {
                x: -self.reference_offset * cos(yaw),
                y: -self.reference_offset * sin(yaw),
                yaw,
                speed,
            },
            wheel,
        }
    }
}

impl Rollout {
    /// How near to `target` the reference point comes in any of the steps under `steer` [m].
    #[inline]
    pub fn get_least_distance(&self, steer: f64, target: Point) -> f64 {
        let (mut vehicle, mut wheel) = (self.vehicle, self.wheel);
        let mut least = f64::INFINITY;
        for _ in 0..self.count {
            wheel = steer + (wheel - steer) * self.kept;
            vehicle = kinematic_bicycle(vehicle, wheel, 0.0, self.length, self.period);
            let reference = Point::new(
                vehicle.x + self.reference_offset * cos(vehicle.yaw),
                vehicle.y + self.reference_offset * sin(vehicle.yaw),
            );
            let distance = get_distance(reference, target);
            if distance < least {
                least = distance;
            }
        }
        least
    }

    /// About how much the distances of candidates `span` [rad] apart differ [m].
    #[inline]
    pub fn spread(&self, span: f64) -> f64 {
        let reach = crate::math::from_count(self.count) * self.period * self.vehicle.speed;
        let turn = reach * span / self.length;
        reach * turn * turn
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::atan;

    const MODEL: Model = Model {
        horizon: 1.0,
        wheelbase: 3.0,
        understeer: 0.0,
        steer_lag: 0.0,
        reference_offset: 0.0,
    };

    #[test]
    fn test_rollout_of_settled_wheels_drives_its_circle() {
        // A quarter of a circle of 10 m radius in a second.
        let steer = atan(0.3);
        let rollout = MODEL.rollout(0.0, 5.0 * core::f64::consts::PI, steer, 0.05);
        assert!(rollout.get_least_distance(steer, Point::new(10.0, 10.0)) < 0.01);
        // Half way there it comes nearest to the corner that the arc cuts.
        let corner = Point::new(10.0, 0.0);
        let cut = 10.0 * (core::f64::consts::SQRT_2 - 1.0);
        assert!((rollout.get_least_distance(steer, corner) - cut).abs() < 0.02);
    }

    #[test]
    fn test_rollout_with_a_lag_turns_later() {
        let lagging = Model {
            steer_lag: 0.2,
            ..MODEL
        };
        let target = Point::new(8.0, 6.0);
        let at_once = MODEL.rollout(0.0, 10.0, 0.0, 0.05);
        let later = lagging.rollout(0.0, 10.0, 0.0, 0.05);
        assert!(later.get_least_distance(0.3, target) > at_once.get_least_distance(0.3, target));
    }
}
